//! Reads a serial line in a thread of its own; connects again, with a growing pause, whenever it is lost.

use std::io::{ErrorKind, Read};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::params::SerialParams;
use crate::serial_line::{LineBuffer, LineError, Reading, parse};

/// Longest wait of one read `[s]`: how long an end of the reader may take.
const READ_WAIT_S: f64 = 0.1;

/// What the line has to say.
#[derive(Debug, Clone, PartialEq)]
pub enum PortEvent {
    /// The device is open.
    Connected,
    /// The device could not be opened or was lost; the next try follows after this time `[s]`.
    Lost {
        /// Why, for people.
        reason: String,
        /// Pause before the next try `[s]`.
        retry_s: f64,
    },
    /// A temperature report.
    Reading(Reading),
    /// A line that is no reading; to be counted.
    Refused(LineError),
}

/// A running reader; dropping it ends the thread.
#[derive(Debug)]
pub struct SerialReader {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl SerialReader {
    /// Starts reading; every event goes to `sink` on the reader's thread.
    ///
    /// # Errors
    /// If no thread can be started.
    pub fn spawn(
        params: SerialParams,
        sink: impl FnMut(PortEvent) + Send + 'static,
    ) -> std::io::Result<Self> {
        let (stop, stopped) = channel();
        let thread =
            std::thread::Builder::new().name("serial".into()).spawn(move || run(&params, &stopped, sink))?;
        Ok(Self { stop: Some(stop), thread: Some(thread) })
    }
}

impl Drop for SerialReader {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            // A reader that panicked has nothing left to end.
            drop(thread.join());
        }
    }
}

fn run(params: &SerialParams, stopped: &Receiver<()>, mut sink: impl FnMut(PortEvent)) {
    let mut retry_s = params.retry_min_s;
    loop {
        let reason = match serialport::new(&params.path, params.baud)
            .timeout(Duration::from_secs_f64(READ_WAIT_S))
            .open()
        {
            Ok(mut port) => {
                sink(PortEvent::Connected);
                retry_s = params.retry_min_s;
                match read(port.as_mut(), stopped, &mut sink) {
                    Some(reason) => reason,
                    None => return,
                }
            }
            Err(error) => error.to_string(),
        };
        sink(PortEvent::Lost { reason, retry_s });
        if stopped.recv_timeout(Duration::from_secs_f64(retry_s)) != Err(RecvTimeoutError::Timeout) {
            return;
        }
        retry_s = (2.0 * retry_s).min(params.retry_max_s);
    }
}

/// Reads until the line is lost, then says why; `None` when the reader is to end.
fn read(
    port: &mut (impl Read + ?Sized),
    stopped: &Receiver<()>,
    sink: &mut impl FnMut(PortEvent),
) -> Option<String> {
    let mut lines = LineBuffer::default();
    let mut bytes = [0_u8; 256];
    loop {
        if stopped.try_recv() != Err(std::sync::mpsc::TryRecvError::Empty) {
            return None;
        }
        match port.read(&mut bytes) {
            Ok(0) => return Some("end of file".into()),
            Ok(count) => lines.push(&bytes[..count], |line| {
                sink(match line.map_or(Err(LineError::Garbage), parse) {
                    Ok(reading) => PortEvent::Reading(reading),
                    Err(error) => PortEvent::Refused(error),
                });
            }),
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {}
            Err(error) => return Some(error.to_string()),
        }
    }
}
