//! A hot end that nobody heats, in whatever room, and one whose plug is loose.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{Heater, params, report};
use models::command::{Mode, Trims};
use models::units::{Celsius, Seconds};
use safety_supervisor::{Cause, Event, PrinterReport, Supervisor};

/// The strictest mode within `span_s`, its cause, and when it came; the hot end's reading goes through `falsify` from 60 s on.
fn worst_of(
    mut heater: Heater,
    span_s: f64,
    falsify: impl Fn(u64, f64) -> f64,
) -> (Mode, Option<Cause>, f64) {
    let mut supervisor = Supervisor::new(params(), 1, None);
    let mut worst = (Mode::Init, None, 0.0);
    let mut number = 0;
    while heater.now_s < span_s {
        for mut event in heater.step() {
            if let Event::Hotend { temp, .. } = &mut event {
                number += 1;
                temp.0 = if heater.now_s > 60.0 { falsify(number, temp.0) } else { temp.0 };
            }
            let now = Seconds(heater.now_s);
            let output = supervisor.on_event(now, event);
            if let Some(state) = output.map(|output| output.state).filter(|state| state.mode > worst.0) {
                worst = (state.mode, state.cause, heater.now_s);
            }
        }
    }
    worst
}

/// S4: every other reading, or two of three, are of a plug that opens or of wires that touch.
#[test]
fn s4_a_loose_plug_is_found_in_6_s() {
    for (of, sound) in [(2, 1), (3, 1), (3, 2), (4, 3)] {
        for false_c in [-85.0, -14.0, 330.0, 450.0] {
            let loose = |number: u64, temp_c| if number % of < sound { temp_c } else { false_c };
            let (mode, cause, at_s) = worst_of(Heater::settled(3, 210.0, 1.0, 3.0), 120.0, loose);
            assert!(
                mode >= Mode::Degraded && at_s <= 66.0,
                "{sound} of {of} sound, {false_c} degC: {mode:?} {at_s}"
            );
            assert!(mode > Mode::Degraded || cause == Some(Cause::HotendNoisy), "{cause:?}");
        }
    }
}

/// A reading that repeats itself bit by bit, of a block as warm as its room: no balance knows how warm that is.
#[test]
fn s2_p12_what_rests_in_a_cold_or_warm_room_is_not_frozen() {
    for room_c in [5.0, 15.0, 25.0, 35.0, 50.0] {
        let mut supervisor = Supervisor::new(params(), 1, None);
        for tick in 0..60_000_u32 {
            let now = Seconds(f64::from(tick) * 0.02);
            let idle = PrinterReport { hotend_duty: 0.0, hotend_target: Celsius(0.0), ..report(now.0) };
            let idle = PrinterReport { hotend_sliced_target: Celsius(0.0), bed_duty: 0.0, ..idle };
            let mut events = vec![Event::Printer(PrinterReport { bed_target: Celsius(0.0), ..idle })];
            if tick.is_multiple_of(5) {
                let temp = Celsius(room_c);
                events.extend([Event::Hotend { stamp: now, temp }, Event::Bed { stamp: now, temp }]);
            }
            for event in events.into_iter().chain([Event::Tick { now }]) {
                let output = supervisor.on_event(now, event);
                let mode = output.map_or(Mode::Init, |output| output.state.mode);
                assert!(mode < Mode::SafeOff, "{room_c} degC, {:.1} s", now.0);
            }
        }
    }
}

/// Whether a drift is told of a printer without an encoder whose gear loses half from 120 s on, of which `made_up` is made up for.
fn drifts_behind(seed: u64, made_up: Option<f64>) -> bool {
    let mut supervisor = Supervisor::new(params(), 1, None);
    let mut heater = Heater::settled(seed, 210.0, 0.0, 6.0);
    let mut from_m = None;
    let mut drifted = false;
    while heater.now_s < 400.0 {
        for event in heater.step() {
            let event = match event {
                Event::Printer(report) if heater.now_s > 120.0 => {
                    let laid_m = report.motor_position_m - *from_m.get_or_insert(report.motor_position_m);
                    let motor_position_m = report.motor_position_m + laid_m;
                    Event::Printer(PrinterReport {
                        motor_position_m,
                        trims: Trims { slip: made_up, ..Trims::NEUTRAL },
                        ..report
                    })
                }
                Event::Encoder { .. } => continue,
                event => event,
            };
            let output = supervisor.on_event(Seconds(heater.now_s), event);
            drifted |= output.is_some_and(|output| output.state.cause == Some(Cause::HotendDrift));
        }
    }
    drifted
}

/// S3: what slips takes no heat. Where no encoder counts it, what is made up for is known; unknown, it looks like a drift.
#[test]
fn s3_a_slip_that_is_made_up_for_is_no_drift_without_an_encoder() {
    for seed in 0..4 {
        assert!(!drifts_behind(seed, Some(0.5)), "seed {seed}");
    }
    assert!(
        (0..4).any(|seed| drifts_behind(seed, None)),
        "nothing shows what the heat of twice the feed does"
    );
}
