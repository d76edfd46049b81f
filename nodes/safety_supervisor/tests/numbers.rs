//! Numbers: those that causes rest on, and those of the file, whose ranges stand beside them.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::collections::BTreeMap;

use common::print::Print;
use models::command::{Command, Trims};
use models::units::{Celsius, Seconds};
use safety_supervisor::{Cause, Event, Params};

#[derive(serde::Deserialize)]
struct File {
    #[serde(rename = "ros__parameters")]
    _parameters: Params,
}

const FILE: &str = include_str!("../../../config/safety_supervisor.param.yaml");

/// Value and range of a line `name: value # [unit] in [low, high] ...`.
fn ranged(line: &str) -> Option<(&str, f64, f64)> {
    let (setting, comment) = line.split_once('#')?;
    let value = setting.split_once(": ")?.1.trim();
    value.parse::<f64>().ok()?;
    let (low, high) = comment.split_once("in [")?.1.split_once(']')?.0.split_once(", ")?;
    Some((value, low.parse().ok()?, high.parse().ok()?))
}

/// The file with a line's value replaced is refused.
fn is_refused(line: &str, value: &str, by: f64) -> bool {
    let place = line.find(&format!(": {value}")).unwrap() + 2;
    let by = if value.contains(['.', 'e']) { format!("{by:e}") } else { format!("{by}") };
    let changed = format!("{}{by}{}", &line[..place], &line[place + value.len()..]);
    serde_saphyr::from_str::<BTreeMap<String, File>>(&FILE.replacen(line, &changed, 1)).is_err()
}

#[test]
fn every_number_of_the_file_is_refused_beyond_the_range_that_stands_beside_it() {
    let lines: Vec<_> = FILE.lines().filter_map(|line| ranged(line).map(|range| (line, range))).collect();
    assert!(lines.len() > 150, "{} lines with a range", lines.len());
    for (line, (value, low, high)) in lines {
        let is_whole = !value.contains(['.', 'e']);
        let step = if is_whole { 1.0 } else { 1e-3 * (high - low) };
        assert!(is_refused(line, value, high + step), "above {high}: {line}");
        assert!(is_refused(line, value, low - step), "below {low}: {line}");
        let (nan, place) = (".nan", line.find(&format!(": {value}")).unwrap() + 2);
        let changed = format!("{}{nan}{}", &line[..place], &line[place + value.len()..]);
        let file = FILE.replacen(line, &changed, 1);
        assert!(serde_saphyr::from_str::<BTreeMap<String, File>>(&file).is_err(), "NaN: {line}");
    }
}

/// What the cause in force rests on, for people.
fn told(print: &Print, cause: Cause) -> String {
    assert_eq!(print.output.state.cause, Some(cause));
    print.output.state.evidence.unwrap().to_string()
}

#[test]
fn p4_the_part_fan_is_told_beside_the_speed_that_its_duty_gives() {
    for (fan, text) in [(1.0, "3.0 1/s, limit 16.6 1/s"), (0.5, "3.0 1/s, limit 8.3 1/s")] {
        let mut print = Print::acting();
        (print.report.fan, print.report.part_fan_speed_1_s) = (fan, Some(3.0));
        print.run(6.0);
        assert_eq!(told(&print, Cause::PartFan), text);
    }
}

#[test]
fn c8_a_second_publisher_is_told_by_how_many_commands_were_refused() {
    let mut print = Print::acting();
    for sequence in 1..=3 {
        print.event(Event::Command(Command {
            session: 4,
            sequence,
            validity: Seconds(1.0),
            trims: Trims::NEUTRAL,
        }));
    }
    print.run(0.1);
    assert_eq!(told(&print, Cause::SecondPublisher), "3 commands refused since the start");
}

#[test]
fn p12_a_bed_that_stands_still_is_told_by_how_long() {
    let mut print = Print::acting();
    for step in 0..210_u32 {
        print.report.bed_target = Celsius(60.0);
        print.report.bed_duty = if step % 20 < 10 { 0.3 } else { 0.6 };
        let temp = Celsius(60.0);
        print.event(Event::Bed { stamp: Seconds(print.now()), temp });
        print.run(0.1);
    }
    let text = told(&print, Cause::BedFrozen);
    let still_s: f64 = text.strip_suffix(" s").unwrap().parse().unwrap();
    assert!((8.0..=12.3).contains(&still_s), "{text}");
}

#[test]
fn p6_an_encoder_that_reads_too_much_is_told_in_percent() {
    let mut print = Print::acting();
    print.slip = -0.6;
    print.run(30.0);
    let text = told(&print, Cause::EncoderSurplus);
    assert!(text.ends_with(" % beyond the motor's way, limit 25 %"), "{text}");
}
