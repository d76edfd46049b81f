//! The serial driver on a pseudo-terminal: partial lines, garbage, a lost and a new device.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use std::fs::File;
use std::io::Write;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use filament_encoder::params::SerialParams;
use filament_encoder::serial_line::LineError;
use filament_encoder::serial_port::{PortEvent, SerialReader};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

/// A new device behind `path`; the other end of the line.
fn device(path: &Path) -> File {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&master).unwrap();
    unlockpt(&master).unwrap();
    let name = ptsname(&master, Vec::new()).unwrap();
    drop(std::fs::remove_file(path));
    symlink(name.to_str().unwrap(), path).unwrap();
    File::from(master)
}

/// The next event that is not one more failed try; the bound only ends a test that hangs.
fn next(events: &Receiver<PortEvent>) -> PortEvent {
    events.recv_timeout(Duration::from_secs(20)).unwrap()
}

#[test]
fn lines_arrive_and_a_lost_device_is_opened_again() {
    let path = std::env::temp_dir().join(format!("filament_encoder_pty_{}", std::process::id()));
    let text = format!("{{path: {:?}, baud: 115200, retry_min_s: 0.02, retry_max_s: 0.1}}", path);
    let params: SerialParams = serde_saphyr::from_str(&text).unwrap();
    let mut line = device(&path);
    let (sink, events) = channel();
    let reader = SerialReader::spawn(params, move |event| drop(sink.send(event))).unwrap();

    assert_eq!(next(&events), PortEvent::Connected);
    line.write_all(b"E:1").unwrap();
    line.write_all(b"234\n").unwrap();
    assert_eq!(next(&events), PortEvent::Reading(1234));
    line.write_all(b"E:12x4\n").unwrap();
    assert_eq!(next(&events), PortEvent::Refused(LineError::Garbage));

    drop(line);
    assert!(matches!(next(&events), PortEvent::Lost { .. }));
    let mut line = device(&path);
    while next(&events) != PortEvent::Connected {}
    line.write_all(b"E:1234\r\n").unwrap();
    assert_eq!(next(&events), PortEvent::Reading(1234));

    drop(reader);
    assert!(events.recv().is_err(), "the thread has ended");
    drop(std::fs::remove_file(&path));
}
