//! Laws of every permit, whatever comes in.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::print::Print;
use common::{params, params_with};
use models::command::{Mode, Request, Trims};
use proptest::prelude::*;
use safety_supervisor::{Cause, Event, Latch, Operator, Supervisor, VisionReport, What};
use std::cell::Cell;

fn any_event() -> impl Strategy<Value = (u8, f64)> {
    (0u8..20, prop_oneof![Just(f64::NAN), -20.0..500.0f64, 0.0..2.0f64])
}

/// One event; whether it ended a latch.
fn happen(print: &mut Print, kind: u8, value: f64) -> bool {
    match kind {
        0 => print.hotend = !print.hotend,
        1 => print.temp_c = value,
        2 => print.encoder = !print.encoder,
        3 | 4 => print.wish.flow = value,
        5 => print.wish.speed = value,
        6 => print.slip = if value.is_finite() { value.clamp(0.0, 1.0) } else { 0.0 },
        7 => print.report.hotend_duty = value,
        8 => print.event(Event::Vision(VisionReport {
            usable: true,
            confidence: value,
            defect: None,
            confirmed: false,
            told: true,
            offset_m: Some([value, 0.0]),
        })),
        9 => drop(print.ask(Operator::Resume)),
        10 => drop(print.ask(Operator::Stop)),
        11 => print.printer = !print.printer,
        12 => print.tick += 50,
        13 => {
            // All is well again, and a person believes it.
            (print.hotend, print.encoder, print.printer, print.temp_c, print.slip) =
                (true, true, true, 210.0, 0.0);
            print.report.hotend_duty = 0.4;
            print.run(3.0);
            let granted = print.ask(Operator::Acknowledge) == What::Granted(Operator::Acknowledge);
            _ = print.ask(Operator::Resume);
            return granted;
        }
        _ => print.run(0.1),
    }
    false
}

/// Permits are finite and inside the envelope, a latched mode ends by acknowledge alone, and no permit of a latched mode
/// lets heaters on. That the laws had something to hold against is counted.
#[test]
fn laws_of_the_permit() {
    let [corrected, outside, paused, latched_by_itself, acknowledged] = [const { Cell::new(0_u32) }; 5];
    let note = |count: &Cell<u32>, holds: bool| count.set(count.get() + u32::from(holds));
    let limits = params().limits;
    let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(48) };
    proptest!(config, |(events in prop::collection::vec(any_event(), 1..300), restored in any::<bool>())| {
        let latch = restored.then_some(Latch { estop: false, cause: Cause::HotendRange });
        let supervisor = Supervisor::new(params_with("start_mode: observe", "start_mode: act"), 1, latch);
        let mut print = Print::with(supervisor);
        let mut sequence = 0;
        for (kind, value) in events {
            let before = print.mode();
            let ended = happen(&mut print, kind, value);
            print.step();
            let permit = print.output.permit;
            let clamped = limits.clamp(&permit.trims);
            prop_assert!(clamped.is_ok_and(|clamped| !clamped.changed.any()), "{:?}", permit.trims);
            prop_assert!(permit.sequence > sequence);
            sequence = permit.sequence;
            prop_assert!(before < Mode::SafeOff || permit.mode >= before || ended, "{before:?} {permit:?}");
            prop_assert!(permit.mode < Mode::SafeOff || permit.request >= Request::HeatersOff);
            prop_assert!(permit.mode < Mode::SafeOff || permit.trims == Trims::NEUTRAL);
            prop_assert!(permit.mode != Mode::Paused || permit.request != Request::Run);
            note(&corrected, permit.trims != Trims::NEUTRAL);
            note(&outside, limits.clamp(&print.wish).is_ok_and(|wish| wish.changed.any()));
            note(&paused, permit.mode == Mode::Paused);
            note(&latched_by_itself, before < Mode::SafeOff && permit.mode >= Mode::SafeOff);
            note(&acknowledged, ended);
        }
    });
    let seen = [corrected, outside, paused, latched_by_itself, acknowledged].map(|count| count.get());
    assert!(seen.iter().all(|count| *count >= 20), "too little was tried: {seen:?}");
}
