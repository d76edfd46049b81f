//! The serial driver on a pseudo-terminal: partial lines, garbage, a new device.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use std::io::Write;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use models::units::Celsius;
use runtime::serial::{PortEvent, SerialReader, pty};
use thermistor::serial_line::{LINE_MAX, LineError, Reading, parse};

/// What the node reads in the next line; the bound only ends a test that hangs.
fn next(events: &Receiver<PortEvent>) -> Result<Reading, LineError> {
    loop {
        match events.recv_timeout(Duration::from_secs(20)).unwrap() {
            PortEvent::Line(line) => return parse(&line),
            PortEvent::Overlong => panic!("no line is too long"),
            PortEvent::Connected | PortEvent::Lost { .. } => {}
        }
    }
}

#[test]
fn lines_of_a_device_are_read_also_after_it_was_lost() {
    let path = std::env::temp_dir().join(format!("thermistor_pty_{}", std::process::id()));
    let text = format!("{{path: {:?}, baud: 115200, retry_min_s: 0.02, retry_max_s: 0.1}}", path);
    let params = serde_saphyr::from_str(&text).unwrap();
    let mut line = pty::device(&path).unwrap();
    let (sink, events) = channel();
    let reader = SerialReader::spawn(params, LINE_MAX, move |event| drop(sink.send(event))).unwrap();

    let both = Ok(Reading { hotend: Some(Celsius(21.3)), bed: Some(Celsius(22.0)), nozzle: None });
    line.write_all(b"ok ").unwrap();
    line.write_all(b"T:21.3 /0 B:22.0 /0\n").unwrap();
    assert_eq!(next(&events), both);
    line.write_all(b"T:nan\n").unwrap();
    assert_eq!(next(&events), Err(LineError::Garbage));

    drop(line);
    let mut line = pty::device(&path).unwrap();
    while events.recv_timeout(Duration::from_secs(20)).unwrap() != PortEvent::Connected {}
    line.write_all(b"ok T:21.3 /0 B:22.0 /0\r\n").unwrap();
    assert_eq!(next(&events), both);

    drop(reader);
}
