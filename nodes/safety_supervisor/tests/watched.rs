//! What nobody tells of: part fan and motor behind a bridge that does not see them, where a dead heater is found all the same;
//! and a tube that was emptied by hand, through which filament is loaded.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{Heater, params};
use models::units::Seconds;
use safety_supervisor::{Cause, Event, Params, PrinterReport, Supervisor};
use serde_json::Value;
use std::cell::Cell;

/// The values of the supervisor in a parameter file.
fn values_of(text: &str) -> Value {
    let file: Value = serde_saphyr::from_str(text).unwrap();
    let (_, node) = file.as_object().unwrap().iter().next().unwrap();
    node["ros__parameters"].clone()
}

/// Lays `over` over `values`, as the loader does.
fn lay_over(values: &mut Value, over: &Value) {
    match over.as_object() {
        Some(over) => over.iter().for_each(|(name, over)| lay_over(&mut values[name], over)),
        None => *values = over.clone(),
    }
}

/// The supervisor's file with `config/hosts/marlin.param.yaml` over it.
fn behind_marlin() -> Params {
    let mut values = values_of(include_str!("../../../config/safety_supervisor.param.yaml"));
    lay_over(&mut values, &values_of(include_str!("../../../config/hosts/marlin.param.yaml")));
    serde_json::from_value(values).unwrap()
}

/// Which fault of a heater is found within so long, and after how long `[s]`; the printer tells of itself what `tell` says.
fn found(
    heater: &mut Heater,
    supervisor: &mut Supervisor,
    for_s: f64,
    tell: impl Fn(f64, PrinterReport) -> PrinterReport,
) -> Option<(Cause, f64)> {
    let start_s = heater.now_s;
    while heater.now_s - start_s < for_s {
        for event in heater.step() {
            let since_s = heater.now_s - start_s;
            let event = match event {
                Event::Encoder { .. } => continue,
                Event::Printer(report) => Event::Printer(tell(since_s, report)),
                event => event,
            };
            let output = supervisor.on_event(Seconds(heater.now_s), event);
            let cause = output.and_then(|output| output.state.cause);
            if let Some(cause @ (Cause::HeaterDeficit | Cause::HeaterStuckOn | Cause::StaleHotend)) = cause {
                return Some((cause, since_s));
            }
        }
    }
    None
}

/// The bridge's states: neither fan nor motor, and the duty as it was with the newest reading.
fn unseen(period_s: f64) -> impl Fn(f64, PrinterReport) -> PrinterReport {
    let told = Cell::new((f64::NEG_INFINITY, 0.0));
    move |_, report| {
        let now_s = report.stamp.0;
        if now_s - told.get().0 >= period_s - 1e-9 {
            told.set((now_s, report.hotend_duty));
        }
        PrinterReport { fan: 0.0, motor_position_m: 0.0, hotend_duty: told.get().1, ..report }
    }
}

/// Steps of 20 ms from reading to reading, and that in seconds: ten a second, and one, as M155 has them at most.
const PACES: [(u64, f64); 2] = [(5, 0.1), (50, 1.0)];

/// The fan goes to full and eight cubic millimetres a second are printed, and nothing tells of it: 20 seeds at each target, with
/// readings of 10 Hz, and of 1 Hz as this line has them at most.
#[test]
fn a_load_that_nobody_tells_of_is_no_weak_heater() {
    let mut found_without = 0;
    for target_c in [200.0, 240.0] {
        for seed in 0..20 {
            let over = PACES.map(|pace| (behind_marlin(), true, pace));
            for (params, shipped, (ticks, period_s)) in over.into_iter().chain([(params(), false, PACES[0])])
            {
                let mut heater = Heater::settled(seed, target_c, 0.0, 0.0).read_every(ticks);
                let mut supervisor = Supervisor::new(params, 1, None);
                assert_eq!(
                    found(&mut heater, &mut supervisor, 60.0, unseen(period_s)),
                    None,
                    "{target_c} degC, seed {seed}"
                );
                (heater.fan, heater.flow_mm3_s) = (1.0, 8.0);
                let told = found(&mut heater, &mut supervisor, 120.0, unseen(period_s));
                assert!(!shipped || told.is_none(), "{target_c} degC, {period_s} s, seed {seed}: {told:?}");
                found_without += usize::from(told.is_some());
            }
        }
    }
    assert!(found_without > 20, "{found_without} of 40: without the file there is something to mend");
}

/// P2: dead 5 s, loose 8 s, and two periods of slow readings and two of a duty that is as slow, with a fan that nobody tells of.
#[test]
fn p2_a_dead_or_loose_heater_is_found_all_the_same() {
    for ((gain, limit_s), (ticks, period_s)) in
        [(0.0, 5.0), (0.2, 8.0)].into_iter().flat_map(|fault| PACES.map(|pace| (fault, pace)))
    {
        for seed in 0..20 {
            let mut heater = Heater::settled(seed, 210.0, 0.0, 0.0).read_every(ticks);
            let limit_s = if ticks > 5 { limit_s + 4.0 * period_s } else { limit_s };
            let mut supervisor = Supervisor::new(behind_marlin(), 1, None);
            assert_eq!(found(&mut heater, &mut supervisor, 60.0, unseen(period_s)), None, "seed {seed}");
            (heater.fan, heater.flow_mm3_s) = (1.0, 4.0);
            assert_eq!(found(&mut heater, &mut supervisor, 90.0, unseen(period_s)), None, "seed {seed}");
            heater.gain = gain;
            let told = found(&mut heater, &mut supervisor, 60.0, unseen(period_s));
            let is_in_time =
                told.is_some_and(|(cause, at_s)| cause == Cause::HeaterDeficit && at_s <= limit_s);
            assert!(is_in_time, "gain {gain}, {period_s} s, seed {seed}: {told:?}");
        }
    }
}

/// 400 mm at 20 to 40 mm/s through a tube that was emptied by hand, or before the supervisor was started: not a degree is
/// taken from the block, and nothing heats it unordered. P1 is found within its 5 s meanwhile.
#[test]
fn filament_through_a_tube_that_nobody_saw_emptied_is_no_stuck_heater() {
    for speed_m_s in [0.02, 0.025, 0.04] {
        for seed in 0..20 {
            let load = |since_s: f64, report: PrinterReport| PrinterReport {
                motor_position_m: (speed_m_s * since_s).min(0.4),
                ..report
            };
            let mut heater = Heater::settled(seed, 210.0, 0.0, 0.0);
            let mut supervisor = Supervisor::new(params(), 1, None);
            assert_eq!(found(&mut heater, &mut supervisor, 30.0, unseen(0.1)), None);
            let told = found(&mut heater, &mut supervisor, 0.4 / speed_m_s, load);
            assert_eq!(told, None, "{speed_m_s} m/s, seed {seed}");

            let mut heater = Heater::settled(seed, 210.0, 0.0, 0.0);
            let mut supervisor = Supervisor::new(params(), 1, None);
            assert_eq!(found(&mut heater, &mut supervisor, 30.0, unseen(0.1)), None);
            heater.stuck_on = true;
            let told = found(&mut heater, &mut supervisor, 0.4 / speed_m_s, load);
            let is_in_time = told.is_some_and(|(cause, at_s)| cause == Cause::HeaterStuckOn && at_s <= 5.0);
            assert!(is_in_time, "{speed_m_s} m/s, seed {seed}: {told:?}");
        }
    }
}
