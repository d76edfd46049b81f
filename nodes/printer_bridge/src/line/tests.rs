use super::*;
use models::units::Celsius;
use proptest::prelude::*;

fn says(line: &str) -> Says {
    parse(line.as_bytes()).unwrap().says
}

fn temperatures(line: &str) -> Temperatures {
    match says(line) {
        Says::Temperatures(temperatures) => temperatures,
        other => panic!("{line}: {other:?}"),
    }
}

/// Answers to M105, reports of M155 and the waits of M109, of several firmwares.
#[test]
fn temperature_reports() {
    let full = Temperatures {
        hotend: Some(Celsius(210.06)),
        hotend_target: Some(Celsius(210.0)),
        hotend_power: Some(67.0),
        bed: Some(Celsius(59.9)),
        bed_target: Some(Celsius(60.0)),
        bed_power: Some(30.0),
    };
    assert_eq!(temperatures("ok T:210.06 /210.00 B:59.90 /60.00 @:67 B@:30"), full);
    assert_eq!(temperatures(" T:210.06 /210.00 B:59.90 /60.00 T0:1 /2 T1:3 /4 @:67 B@:30 @0:1 W:?"), full);
    assert_eq!(temperatures("T:210.06/210 B:59.9/60 @:67 B@:30"), full);
    assert_eq!(temperatures("ok T:210.06/ 210.00 B: 59.9/ 60.0 @: 67 B@: 30"), full);
    let hotend = Temperatures { hotend: Some(Celsius(21.3)), ..Temperatures::default() };
    assert_eq!(temperatures("T:21.3"), hotend);
    assert_eq!(temperatures("T0:21.3"), hotend);
    assert!(parse(b"ok T:21.30 /0.00 B:22.1 /0 @:64").unwrap().ok);
    assert!(!parse(b"T:21.30 /0.00").unwrap().ok);
}

/// What is no number in the firmware is its reading: it is passed on, for the thermistor node to judge.
#[test]
fn temperatures_that_cannot_be_pass_as_they_are() {
    assert!(temperatures("T:nan /0.00").hotend.unwrap().0.is_nan());
    assert_eq!(temperatures("T:inf /0.00").hotend, Some(Celsius(f64::INFINITY)));
    assert_eq!(temperatures("T:-14.00 /0.00").hotend, Some(Celsius(-14.0)));
    assert_eq!(temperatures("T:999999 /0.00").hotend, Some(Celsius(999_999.0)));
}

#[test]
fn positions_are_metres_of_the_commanded_tool() {
    let Says::Position([x, y, z]) = says("X:100.00 Y:-50.50 Z:0.30 E:12.00 Count X:8000 Y:1 Z:120") else {
        panic!("no position");
    };
    for (value, expected) in [(x, 0.1), (y, -0.0505), (z, 0.0003)] {
        assert!((value - expected).abs() < 1e-12, "{value}");
    }
    assert!(matches!(says("X: 1.00 Y: 2.00 Z: 3.00 E: 0.00"), Says::Position(_)));
    assert_eq!(says("Count X:8000 Y:1 Z:120"), Says::Other, "steps are no position");
}

#[test]
fn words_alone() {
    for (line, expected) in [
        ("ok", Says::Nothing),
        ("ok N12 P15 B3", Says::Other),
        ("start", Says::Start),
        ("wait", Says::Wait),
        ("echo:busy: processing", Says::Busy),
        ("echo: busy: paused for user", Says::Busy),
        ("busy: processing", Says::Busy),
        ("Resend: 12", Says::Resend),
        ("Resend:12", Says::Resend),
        ("rs N12", Says::Resend),
        ("echo:SD card ok", Says::Other),
        ("okay", Says::Other),
        ("// Klipper state: Ready", Says::Other),
        ("echo:Unknown command: \"M155 S1\"", Says::UnknownCommand("M155 S1".into())),
        ("SD printing byte 12/340", Says::Card(Card::Printing { done: 12, total: 340 })),
        ("SD printing byte 0/0", Says::Card(Card::NotPrinting)),
        ("Not SD printing", Says::Card(Card::NotPrinting)),
        ("Done printing file", Says::Card(Card::Done)),
        ("Cap:EMERGENCY_PARSER:1", Says::Capability { name: "EMERGENCY_PARSER".into(), on: true }),
        ("Cap:AUTOREPORT_TEMP:0", Says::Capability { name: "AUTOREPORT_TEMP".into(), on: false }),
    ] {
        assert_eq!(says(line), expected, "{line}");
    }
}

#[test]
fn actions_with_and_without_spaces() {
    for (line, expected) in [
        ("//action:pause", Action::Pause),
        ("// action:pause", Action::Pause),
        ("// action: paused", Action::Pause),
        ("//action:resumed", Action::Resume),
        ("// action:cancel", Action::Cancel),
        ("//action:out_of_filament T0", Action::OutOfFilament),
        ("// action:filament_runout T0", Action::OutOfFilament),
        ("//action:notification hello pause", Action::Other),
        ("//action:", Action::Other),
    ] {
        assert_eq!(says(line), Says::Action(expected), "{line}");
    }
}

#[test]
fn errors_that_stop_the_firmware_are_told_from_others() {
    for (line, expected) in [
        ("Error:Printer halted. kill() called!", true),
        ("Error:Thermal Runaway, system stopped! Heater_ID: 0", true),
        ("Error:Heating failed, system stopped! Heater_ID: bed", true),
        ("Error:0: MAXTEMP triggered", true),
        ("!! Shutdown due to webhooks request", true),
        ("fatal: watchdog", true),
        ("Error:Line Number is not Last Line Number+1, Last Line: 5", false),
        ("Error:checksum mismatch, Last Line: 5", false),
        ("Error:volume.init failed", false),
    ] {
        assert!(matches!(says(line), Says::Error { fatal, .. } if fatal == expected), "{line}");
    }
}

#[test]
fn the_name_of_the_firmware_ends_where_the_next_key_begins() {
    let line =
        "FIRMWARE_NAME:Marlin 2.1.2 (Dec 1 2022 12:00:00) SOURCE_CODE_URL:github.com/x PROTOCOL_VERSION:1.0";
    assert_eq!(says(line), Says::Firmware("Marlin 2.1.2 (Dec 1 2022 12:00:00)".into()));
    assert_eq!(says("FIRMWARE_NAME:"), Says::Firmware(String::new()));
}

#[test]
fn garbage_is_refused() {
    for line in [
        &b"T:2x.3 /0"[..],
        b"ok T:",
        b"T:21.3 /zero",
        b"T:21.3 /0 @:full",
        b"B:1,5",
        b"X:1 Y:2 Z:three",
        b"SD printing byte 12",
        b"SD printing byte -1/5",
        b"SD printing byte 6/5",
        b"Cap:EMERGENCY_PARSER",
        b"Cap:X:2",
    ] {
        assert_eq!(parse(line), Err(LineError::NotNumber), "{}", String::from_utf8_lossy(line));
    }
    assert_eq!(parse(b"T:\xff\xfe20"), Err(LineError::NotText));
}

proptest! {
    #[test]
    fn no_bytes_break_the_reader(line in proptest::collection::vec(any::<u8>(), 0..200)) {
        drop(parse(&line));
    }

    /// Lines out of the words of Marlin, in any order and cut anywhere.
    #[test]
    fn no_words_break_the_reader(
        line in "(ok |echo:|//|Error:|Cap:|T:|B:|@:|X:|Y:|Z:|SD printing byte|FIRMWARE_NAME:|é|/|[-0-9.eNaif]{0,5}| ){0,12}"
    ) {
        drop(parse(line.as_bytes()));
    }

    #[test]
    fn written_temperatures_are_read_back(hotend: f64, target in 0.0..300.0f64, bed in -50.0..200.0f64) {
        let read = temperatures(&format!("ok T:{hotend} /{target} B:{bed} /0 @:0"));
        prop_assert_eq!(read.hotend.unwrap().0.to_bits() , if hotend.is_nan() { read.hotend.unwrap().0.to_bits() } else { hotend.to_bits() });
        prop_assert_eq!(read.hotend.unwrap().0.is_nan(), hotend.is_nan());
        prop_assert_eq!(read.hotend_target, Some(Celsius(target)));
        prop_assert_eq!(read.bed, Some(Celsius(bed)));
    }
}
