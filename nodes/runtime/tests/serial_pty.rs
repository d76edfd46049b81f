//! A serial line on a pseudo-terminal: pieces, overlong lines, sending, a lost and a new device.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use models::params::{RawSerialParams, SerialParams};
use runtime::serial::{PortEvent, SerialReader, pty};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

fn params(path: &Path) -> SerialParams {
    let path = path.to_str().unwrap().to_owned();
    RawSerialParams { path, baud: 115_200, retry_min_s: 0.02, retry_max_s: 0.1 }.try_into().unwrap()
}

/// The next event; the bound only ends a test that hangs.
fn next(events: &Receiver<PortEvent>) -> PortEvent {
    events.recv_timeout(Duration::from_secs(20)).unwrap()
}

fn line(text: &str) -> PortEvent {
    PortEvent::Line(text.as_bytes().to_vec())
}

#[test]
fn lines_arrive_and_a_lost_device_is_opened_again() {
    let path = std::env::temp_dir().join(format!("runtime_pty_{}", std::process::id()));
    let mut device = pty::device(&path).unwrap();
    let (sink, events) = channel();
    let reader = SerialReader::spawn(params(&path), 20, move |event| drop(sink.send(event))).unwrap();

    assert_eq!(next(&events), PortEvent::Connected);
    device.write_all(b"one ").unwrap();
    device.write_all(b"line\r\n\xff\n").unwrap();
    assert_eq!(next(&events), line("one line"));
    assert_eq!(next(&events), PortEvent::Line(vec![0xff]));
    device.write_all(b"a line of more than twenty bytes\nnext\n").unwrap();
    assert_eq!(next(&events), PortEvent::Overlong);
    assert_eq!(next(&events), line("next"));

    drop(device);
    let PortEvent::Lost { retry, .. } = next(&events) else { panic!("the device is gone") };
    assert_eq!(retry, Duration::from_secs_f64(0.02));
    let mut device = pty::device(&path).unwrap();
    while next(&events) != PortEvent::Connected {}
    device.write_all(b"again\n").unwrap();
    assert_eq!(next(&events), line("again"));

    drop(reader);
    assert!(events.recv().is_err(), "the thread has ended");
}

/// A command that was meant for the device before must not reach the one after it.
#[test]
fn what_is_sent_arrives_and_what_waits_at_a_loss_never_does() {
    let path = std::env::temp_dir().join(format!("runtime_pty_send_{}", std::process::id()));
    let device = pty::device(&path).unwrap();
    let (sink, events) = channel();
    let reader = SerialReader::spawn(params(&path), 20, move |event| drop(sink.send(event))).unwrap();
    assert_eq!(next(&events), PortEvent::Connected);
    assert!(reader.send("M115"));
    let (mut device, mut sent) = (BufReader::new(device), String::new());
    device.read_line(&mut sent).unwrap();
    assert_eq!(sent, "M115\n");

    drop(device);
    assert!(matches!(next(&events), PortEvent::Lost { .. }));
    assert!(reader.send("stale"), "it waits");
    // One failed try at the least: what waited is gone.
    assert!(matches!(next(&events), PortEvent::Lost { .. }));
    let device = pty::device(&path).unwrap();
    while next(&events) != PortEvent::Connected {}
    assert!(reader.send("fresh"));
    let (mut device, mut sent) = (BufReader::new(device), String::new());
    device.read_line(&mut sent).unwrap();
    assert_eq!(sent, "fresh\n");
}
