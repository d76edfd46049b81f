//! When what is asked.

use super::*;

#[test]
fn a_board_is_left_alone_until_it_greets_or_its_time_has_passed() {
    let mut bench = Bench::connected();
    for _ in 0..19 {
        bench.now_s += 0.1;
        assert_eq!(questions(bench.event(Event::Tick)), []);
    }
    bench.now_s = 102.0;
    assert_eq!(questions(bench.event(Event::Tick)), [Question::Firmware]);
    let mut bench = Bench::connected();
    assert_eq!(questions(bench.line("start")), [Question::Firmware]);
}

/// One question at a time; the next after an `ok`, a `wait`, or the time limit, which `busy:` prolongs.
#[test]
fn a_question_waits_for_the_line() {
    let mut bench = Bench::connected();
    bench.line("start");
    bench.now_s += 4.9;
    assert_eq!(questions(bench.line("echo:busy: processing")), []);
    bench.now_s += 4.9;
    assert_eq!(questions(bench.event(Event::Tick)), []);
    bench.now_s += 0.2;
    assert_eq!(questions(bench.event(Event::Tick)), [Question::Firmware], "the first one is lost");
    assert_eq!(bench.marlin.unanswered(), 1);
    assert_eq!(questions(bench.line("wait")), [Question::Temperatures], "nothing is under way");
    assert_eq!(bench.marlin.unanswered(), 1);
}

#[test]
fn reports_are_ordered_once_where_the_firmware_has_them_and_asked_for_otherwise() {
    let mut bench = Bench::found(&["Cap:AUTOREPORT_TEMP:1", "Cap:SDCARD:0"]);
    assert_eq!(questions(&bench.outputs), [Question::Reports(1)]);
    let asked = bench.asked(10.0);
    assert!(!asked.contains(&Question::Reports(1)) && !asked.contains(&Question::Firmware), "{asked:?}");
    assert!(asked.contains(&Question::Temperatures), "reports that do not come are asked for");

    let mut bench = Bench::found(&["Cap:AUTOREPORT_TEMP:0"]);
    let asked = bench.asked(10.0);
    let count = asked.iter().filter(|question| **question == Question::Temperatures).count();
    assert!((9..=10).contains(&count), "one a second: {count}");
}

/// An old Marlin empties its planner for M114: a print must not be marked by a question.
#[test]
fn the_position_is_asked_for_only_where_nothing_is_printed() {
    let mut bench = Bench::found(&["Cap:SDCARD:1"]);
    let asked = bench.asked(3.0);
    assert!(asked.contains(&Question::Card) && !asked.contains(&Question::Position), "unknown: {asked:?}");
    bench.line("Not SD printing");
    assert!(bench.asked(3.0).contains(&Question::Position));
    bench.line("SD printing byte 5/100");
    assert!(!bench.asked(3.0).contains(&Question::Position));
}

#[test]
fn a_firmware_without_a_card_is_not_asked_for_it_and_prints_nothing() {
    let mut bench = Bench::found(&["Cap:SDCARD:0"]);
    assert!(!bench.asked(3.0).contains(&Question::Card));
    assert_eq!(bench.marlin.job().phase(), Some(JobPhase::Idle));
    let mut bench = Bench::found(&[]);
    bench.line("echo:Unknown command: \"M27\"");
    assert!(!bench.asked(3.0).contains(&Question::Card));
    assert_eq!(bench.marlin.job().phase(), Some(JobPhase::Idle));
}
