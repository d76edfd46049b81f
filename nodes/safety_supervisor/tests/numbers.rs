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

/// A number of the file: its line, cut before and after it, and the range that stands in the comment.
struct Number {
    line: usize,
    before: &'static str,
    value: &'static str,
    after: &'static str,
    comment: &'static str,
    low: f64,
    high: f64,
}

impl Number {
    fn is_whole(&self) -> bool {
        !self.value.contains(['.', 'e'])
    }

    /// As the file writes it.
    fn written(&self, value: f64) -> String {
        if self.is_whole() { format!("{value}") } else { format!("{value:e}") }
    }

    /// Just outside of an end of the range.
    fn beyond(&self, end: f64, outwards: f64) -> String {
        let step = if self.is_whole() { 1.0 } else { 1e-6 * if end == 0.0 { 1.0 } else { end.abs() } };
        self.written(end + outwards * step)
    }

    /// What is said of the file with another value in this very line; empty where it is taken.
    fn said_of(&self, value: &str) -> String {
        let changed = format!("{}{value}{}", self.before, self.after);
        let mut lines: Vec<_> = FILE.lines().collect();
        lines[self.line] = &changed;
        let file = serde_saphyr::from_str::<BTreeMap<String, File>>(&lines.join("\n"));
        file.err().map(|error| error.to_string()).unwrap_or_default()
    }

    fn place(&self) -> String {
        format!("line {}: {}{}", self.line + 1, self.before, self.value)
    }
}

/// Range in a comment `[unit] in [low, high] ...`.
fn range(comment: &str) -> Option<(f64, f64)> {
    let (low, high) = comment.split_once("in [")?.1.split_once(']')?.0.split_once(", ")?;
    Some((low.parse().ok()?, high.parse().ok()?))
}

/// Numbers of a line `name: value` or `name: {name: value, ..}`, each with what stands before it. The ages of a map rise:
/// those behind a number are left out, so that its own range alone refuses it.
fn numbers_of(setting: &'static str) -> Vec<(&'static str, &'static str, &'static str)> {
    let after = if setting.contains('{') { "}" } else { "" };
    let starts = setting.match_indices(": ").map(|(at, colon)| at + colon.len());
    let cut = |at: usize| {
        let value = setting[at..].split([',', '}']).next().unwrap_or_default().trim();
        value.parse::<f64>().is_ok().then(|| (&setting[..at], value, after))
    };
    starts.filter_map(cut).collect()
}

/// Every number of the file; the range of those in maps stands above them, beside the name of their block.
fn numbers() -> Vec<Number> {
    let (mut numbers, mut above) = (Vec::new(), "");
    for (line, text) in FILE.lines().enumerate() {
        let (setting, own) = text.split_once('#').unwrap_or((text, ""));
        if setting.trim_end().ends_with(':') {
            above = own;
        }
        let comment = if setting.contains('{') { above } else { own };
        for (before, value, after) in numbers_of(setting) {
            assert!(range(comment).is_some(), "no range: {text}");
            let (low, high) = range(comment).unwrap();
            numbers.push(Number { line, before, value, after, comment, low, high });
        }
    }
    numbers
}

#[test]
fn every_number_of_the_file_is_refused_beyond_the_range_that_stands_beside_it() {
    let numbers = numbers();
    assert_eq!(numbers.iter().filter(|number| number.after.is_empty()).count(), 181);
    assert_eq!(numbers.iter().filter(|number| number.after == "}").count(), 13, "in maps");
    for number in numbers {
        assert_eq!(number.said_of(number.value), "", "as it is: {}", number.place());
        for value in [number.beyond(number.high, 1.0), number.beyond(number.low, -1.0), ".nan".to_owned()] {
            assert_ne!(number.said_of(&value), "", "{value} is taken: {}", number.place());
        }
    }
}

/// The ends are refused for the sake of another number alone: for their order, or where the comment says "at most".
#[test]
fn every_number_of_the_file_is_taken_at_the_ends_of_the_range_that_stands_beside_it() {
    for number in numbers() {
        let own = format!(
            "{} = ",
            number.before.rsplit(['{', ' ']).find_map(|part| part.strip_suffix(':')).unwrap()
        );
        for value in [number.low, number.high].map(|end| number.written(end)) {
            let said = number.said_of(&value);
            let is_of_order = said.contains("must be below") || number.comment.contains("], at most ");
            assert!(!said.contains(&own) || is_of_order, "{said}: {}", number.place());
            assert!(said.is_empty() || said.contains(": must be "), "{said}: {}", number.place());
        }
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
    for step in 0..150_u32 {
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
