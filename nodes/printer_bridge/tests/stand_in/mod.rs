//! A small Marlin on a pseudo-terminal: it answers the bridge's questions, with reports between a question and its `ok`.

use runtime::serial::pty;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// The name it gives itself.
pub(crate) const NAME: &str = "Marlin 2.1.2 (Stand-In)";
const REPORT: &str = " T:199.87 /200.00 B:59.90 /60.00 @:64 B@:30";
/// Time between two reports that were ordered: faster than a Marlin's, a test need not wait for them.
const PERIOD: Duration = Duration::from_millis(50);

enum Input {
    Received(String),
    Say(String),
    Card(Option<(u64, u64)>),
    /// The bridge has closed the line, or the test takes the device away.
    Gone,
}

/// The device; dropping it takes it away.
pub(crate) struct StandIn {
    inputs: Sender<Input>,
    answering: Option<JoinHandle<Vec<String>>>,
}

impl StandIn {
    /// A device behind `path`.
    pub(crate) fn start(path: &Path) -> Self {
        let device = pty::device(path).unwrap();
        let (inputs, taken) = channel();
        let (received, mut lines) = (inputs.clone(), BufReader::new(device.try_clone().unwrap()));
        std::thread::spawn(move || {
            let mut line = String::new();
            // Ends with the first error: that is how a closed line looks.
            while lines.read_line(&mut line).is_ok_and(|count| count > 0) {
                if received.send(Input::Received(line.trim().to_owned())).is_err() {
                    return;
                }
                line.clear();
            }
        });
        let answering = std::thread::spawn(move || answer(device, &taken));
        Self { inputs, answering: Some(answering) }
    }

    /// Says a line by itself.
    pub(crate) fn say(&self, line: &str) {
        self.inputs.send(Input::Say(line.to_owned())).unwrap();
    }

    /// Prints from the card from now on: bytes read, bytes of the file.
    pub(crate) fn print_from_card(&self, bytes: Option<(u64, u64)>) {
        self.inputs.send(Input::Card(bytes)).unwrap();
    }

    /// Takes the device away; every line that it was sent.
    pub(crate) fn end(mut self) -> Vec<String> {
        _ = self.inputs.send(Input::Gone);
        self.answering.take().unwrap().join().unwrap()
    }
}

fn answer(mut device: pty::Device, inputs: &Receiver<Input>) -> Vec<String> {
    let (mut received, mut reports, mut card) = (Vec::new(), false, None);
    loop {
        let text = match inputs.recv_timeout(PERIOD) {
            Ok(Input::Received(line)) => {
                reports |= line.starts_with("M155");
                let text = reply(&line, card);
                received.push(line);
                text
            }
            Ok(Input::Say(line)) => line + "\n",
            Ok(Input::Card(bytes)) => {
                card = bytes;
                String::new()
            }
            Err(RecvTimeoutError::Timeout) if reports => format!("{REPORT}\n"),
            Err(RecvTimeoutError::Timeout) => String::new(),
            Ok(Input::Gone) | Err(RecvTimeoutError::Disconnected) => return received,
        };
        if device.write_all(text.as_bytes()).is_err() {
            return received;
        }
    }
}

fn reply(line: &str, card: Option<(u64, u64)>) -> String {
    match line.split(' ').next().unwrap() {
        "M115" => format!(
            "FIRMWARE_NAME:{NAME} SOURCE_CODE_URL:x PROTOCOL_VERSION:1.0\nCap:AUTOREPORT_TEMP:1\n{REPORT}\nCap:EMERGENCY_PARSER:1\nCap:SDCARD:1\nok\n"
        ),
        "M155" => format!("{REPORT}\nok\n"),
        "M105" => format!("echo:busy: processing\nok{REPORT}\n"),
        "M27" => match card {
            Some((done, total)) => format!("SD printing byte {done}/{total}\n{REPORT}\nok\n"),
            None => "Not SD printing\nok\n".to_owned(),
        },
        "M114" => format!("X:10.00 Y:20.00 Z:0.30 E:1.00 Count X:800 Y:1600 Z:120\n{REPORT}\nok\n"),
        _ => format!("echo:Unknown command: \"{line}\"\nok\n"),
    }
}
