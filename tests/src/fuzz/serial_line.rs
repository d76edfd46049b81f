//! What stands on serial lines and in device files: a thermistor's, an encoder's and an accelerometer's readings, and
//! Marlin's words.

use super::laws::{is_finite, is_one_line};
use super::shipped;
use super::values::Values;
use imu::scan::{Channel, Layout, Storage};
use models::units::Seconds;
use printer_bridge::params::MarlinParams;
use printer_bridge::{Event, Marlin, Output, line};
use runtime::serial::LineBuffer;
use runtime::wire;
use std::sync::LazyLock;

static MARLIN: LazyLock<MarlinParams> = LazyLock::new(|| {
    shipped::parameters("printer_bridge")
        .without(&["frames"])
        .parse::<printer_bridge::Params>()
        .unwrap()
        .marlin
});

/// The first byte says whose line it is, the second how the bytes fall into pieces.
pub fn serial_line(bytes: &[u8]) {
    let mut values = Values::new(bytes);
    let (device, piece) = (values.below(4), 1 + usize::from(values.byte()));
    let stream = values.rest();
    match device {
        0 => lines(stream, piece, thermistor::serial_line::LINE_MAX, |line| {
            if let Some(Ok(reading)) = line.map(thermistor::serial_line::parse) {
                assert!(reading.hotend.is_some() || reading.bed.is_some());
                is_finite(&reading);
            }
        }),
        1 => lines(stream, piece, filament_encoder::serial_line::LINE_MAX, |line| {
            if let Some(Ok(counts)) = line.map(filament_encoder::serial_line::parse) {
                let again = filament_encoder::serial_line::parse(format!("E:{counts}").as_bytes());
                assert_eq!(again, Ok(counts));
            }
        }),
        2 => scan(stream),
        _ => marlin(stream, piece),
    }
}

/// Cuts a stream that comes in pieces into lines.
fn lines(stream: &[u8], piece: usize, longest: usize, mut take: impl FnMut(Option<&[u8]>)) {
    let mut buffer = LineBuffer::new(longest);
    for bytes in stream.chunks(piece) {
        buffer.push(bytes, |line| {
            assert!(line.is_none_or(|line| line.len() <= longest));
            take(line);
        });
    }
}

/// The first line is the type of a channel, the rest are scans of three such channels.
fn scan(stream: &[u8]) {
    let end = stream.iter().position(|byte| *byte == b'\n').unwrap_or(stream.len());
    let Ok(text) = std::str::from_utf8(&stream[..end]) else { return };
    let Ok(storage) = Storage::parse(text) else { return };
    let layout = Layout::new([2, 0, 1].map(|index| Channel { index, storage }));
    let scans = stream[end..].chunks(layout.bytes());
    scans.filter_map(|scan| layout.raw(scan)).for_each(|raw| is_finite(&raw));
}

/// A bridge on a line whose other end is not Marlin, or is broken: it asks what it may ask, and says what every reader takes.
fn marlin(stream: &[u8], piece: usize) {
    let (mut marlin, mut now_s) = (Marlin::new(*MARLIN), 100.0);
    for output in marlin.on_event(Seconds(now_s), Event::Connected) {
        is_sound(&output);
    }
    lines(stream, piece, line::LINE_MAX, |line| {
        let (event, wait_s) = match line {
            None => (Event::Overlong, 0.1),
            Some(b"LOST") => (Event::Lost("unplugged"), 1.0),
            Some(b"FOUND") => (Event::Connected, 1.0),
            Some(line) => (Event::Line(line), f64::from(line[0] % 8) * 0.1),
        };
        for event in [event, Event::Tick] {
            marlin.on_event(Seconds(now_s), event).iter().for_each(is_sound);
            now_s += wait_s;
        }
    });
}

fn is_sound(output: &Output) {
    match output {
        Output::Ask(question) => {
            let line = question.line();
            is_one_line(&line);
            let known = ["M115", "M105", "M27", "M114"].contains(&line.as_str());
            assert!(
                known || line.strip_prefix("M155 S").is_some_and(|period| period.parse::<u8>().is_ok()),
                "{line}"
            );
        }
        Output::State(state) => {
            let read = wire::status_from_wire(&wire::status_to_wire(state));
            assert!(read.is_ok(), "{read:?}: {state:?}");
        }
        Output::Temperatures(_) | Output::Note(_) => {}
    }
}

pub(super) fn seeds() -> Vec<Vec<u8>> {
    let marlin = "start\nMarlin 2.1.2\nFIRMWARE_NAME:Marlin 2.1.2 SOURCE_CODE_URL:x\nCap:AUTOREPORT_TEMP:1\nCap:SDCARD:1\nCap:EMERGENCY_PARSER:0\nok\n T:210.06 /210.00 B:59.9 /60.00 @:67 B@:30\nSD printing byte 123/4567\nX:10.00 Y:20.00 Z:0.20 E:1.50 Count X:800 Y:1600 Z:80\nok\necho:busy: processing\n//action:out_of_filament\n//action:paused\nResend: 12\necho:Unknown command: \"M155 S1\"\nok P15 B3\nLOST\nFOUND\nNot SD printing\nDone printing file\nError:Printer halted. kill() called!\n";
    let front = |device: u8, text: &[u8]| [&[device, 16], text].concat();
    vec![
        front(0, b"ok T:21.30 /0.00 B:22.1 /0 @:64\nT:21.3 B:22.0\necho:busy\n"),
        front(1, b"E:1234\nE: -7\n# encoder 1.0\n"),
        front(2, b"le:s13/16>>0\n\x00\x01\xff\xff\x00\x10\x00\x01\xff\xff\x00\x10"),
        front(2, b"be:u20/32>>12\n\x00\x01\xff\xff\x00\x10\x00\x01\xff\xff\x00\x10"),
        front(3, marlin.as_bytes()),
    ]
}
