//! P1 to P3 and sound heaters with readings at other rates than 10 Hz, and with most of them, or of the orders, lost.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{Heater, params, params_with};
use models::command::Mode;
use models::units::Seconds;
use safety_supervisor::{Cause, Event, Params, Supervisor};

/// Steps of 20 ms between two readings: 4 Hz, and 50 Hz.
const SLOW: u64 = 13;
const FAST: u64 = 1;
/// 1 Hz: Marlin's own reports.
const SLOWEST: u64 = 50;

/// A telemetry of 4 Hz is late after three periods (S7).
fn slow_params() -> Params {
    params_with("hotend: {degraded_s: 0.3,", "hotend: {degraded_s: 0.8,")
}

/// And one of 1 Hz.
fn slowest_params() -> Params {
    params_with(
        "hotend: {degraded_s: 0.3, pause_s: 1.5, safe_off_s: 3.0}",
        "hotend: {degraded_s: 3.0, pause_s: 4.0, safe_off_s: 5.0}",
    )
}

/// Runs until the heaters are off, at most for `span_s`; after how long, and why. `keeps` says what reaches the supervisor.
fn run(
    heater: &mut Heater,
    supervisor: &mut Supervisor,
    span_s: f64,
    mut keeps: impl FnMut(&Event) -> bool,
) -> Option<(f64, Option<Cause>)> {
    let from_s = heater.now_s;
    while heater.now_s - from_s < span_s {
        for event in heater.step().into_iter().filter(|event| keeps(event)) {
            let output = supervisor.on_event(Seconds(heater.now_s), event);
            if let Some(output) = output.filter(|output| output.permit.mode >= Mode::SafeOff) {
                return Some((heater.now_s - from_s, output.state.cause));
            }
        }
    }
    None
}

#[test]
fn sound_heaters_at_any_rate_do_not_trip() {
    for (ticks, params) in [(SLOW, slow_params()), (FAST, params()), (SLOWEST, slowest_params())] {
        for seed in 0..20 {
            let mut heater = Heater::new(seed).read_every(ticks);
            let mut supervisor = Supervisor::new(params, 1, None);
            for (target_c, fan, flow_mm3_s, span_s) in [
                (215.0, 0.0, 0.0, 120.0),
                (215.0, 1.0, 4.0, 120.0),
                (240.0, 0.0, 8.0, 60.0),
                (0.0, 0.0, 0.0, 200.0),
            ] {
                (heater.target_c, heater.fan, heater.flow_mm3_s) = (target_c, fan, flow_mm3_s);
                let off = run(&mut heater, &mut supervisor, span_s, |_| true);
                assert_eq!(off, None, "every {ticks} ticks, seed {seed}, {target_c} degC");
            }
        }
    }
}

/// The catalogue's limits, and two periods more of slower ones.
#[test]
fn p1_p2_p3_at_any_rate_are_found_in_time() {
    type Fault = (&'static str, fn(&mut Heater), f64);
    let faults: [Fault; 5] = [
        ("stuck on", |heater| heater.stuck_on = true, 5.0),
        ("loose", |heater| heater.gain = 0.2, 8.0),
        ("weak", |heater| heater.gain = 0.5, 15.0),
        ("dead", |heater| heater.gain = 0.0, 5.0),
        ("fell out", |heater| heater.coupling = 0.1, 4.0),
    ];
    for (ticks, params, more_s) in
        [(SLOW, slow_params(), 0.52), (FAST, params(), 0.0), (SLOWEST, slowest_params(), 2.02)]
    {
        for (name, inject, limit_s) in faults {
            for seed in 0..20 {
                let mut heater = Heater::settled(seed, 215.0, 0.0, 3.0).read_every(ticks);
                let mut supervisor = Supervisor::new(params, 1, None);
                assert_eq!(run(&mut heater, &mut supervisor, 60.0, |_| true), None);
                inject(&mut heater);
                let found_s = run(&mut heater, &mut supervisor, 60.0, |_| true).map(|(time_s, _)| time_s);
                assert!(
                    found_s.is_some_and(|time_s| time_s <= limit_s + more_s),
                    "{name} every {ticks} ticks, seed {seed}: {found_s:?}"
                );
            }
        }
    }
}

/// Too many readings for a silence, too few for a balance: what is heated and cannot be judged is switched off.
#[test]
fn p1_a_stream_that_flickers_hides_no_heater_for_long() {
    let mut worst = (0.0_f64, 0.0_f64);
    for lost in [0.8, 0.9, 0.95, 0.97] {
        for seed in 0..20 {
            for of_hotend in [true, false] {
                let mut heater = Heater::settled(seed, 210.0, 0.0, 0.0);
                let mut supervisor = Supervisor::new(params(), 1, None);
                assert_eq!(run(&mut heater, &mut supervisor, 60.0, |_| true), None);
                heater.stuck_on = true;
                let mut random = common::Random(seed);
                let off = run(&mut heater, &mut supervisor, 60.0, |event| {
                    let flickers = if of_hotend {
                        matches!(event, Event::Hotend { .. })
                    } else {
                        matches!(event, Event::Printer(_))
                    };
                    !flickers || random.uniform() >= lost
                });
                let what =
                    format!("{lost} of hot end {of_hotend}, seed {seed}: {off:?}, {} degC", heater.block_c);
                assert!(off.is_some_and(|(time_s, _)| time_s <= 30.0), "{what}");
                assert!(heater.block_c < 285.0, "{what}");
                worst = (worst.0.max(off.map_or(0.0, |(time_s, _)| time_s)), worst.1.max(heater.block_c));
            }
        }
    }
    println!(
        "stuck on behind a stream that flickers: off after {:.1} s, {:.0} degC at most",
        worst.0, worst.1
    );
}

/// With the tenth reading missing, and nothing wrong, nothing happens but that; with most of them missing for long the
/// heaters go off, as nobody would see what they do.
#[test]
fn s7_what_cannot_be_judged_is_told_by_its_name() {
    let mut told = Vec::new();
    for seed in 0..20 {
        let mut heater = Heater::settled(seed, 210.0, 0.0, 0.0);
        let mut supervisor = Supervisor::new(params(), 1, None);
        let mut random = common::Random(seed);
        let off = run(&mut heater, &mut supervisor, 120.0, |event| {
            !matches!(event, Event::Hotend { .. }) || random.uniform() >= 0.1
        });
        assert_eq!(off, None, "seed {seed}");
        let off = run(&mut heater, &mut supervisor, 300.0, |event| {
            !matches!(event, Event::Printer(_)) || random.uniform() >= 0.985
        });
        told.extend(off.and_then(|(_, cause)| cause));
        let idle = Heater::new(seed);
        let mut supervisor = Supervisor::new(params(), 1, None);
        let off = run(&mut { idle }, &mut supervisor, 120.0, |event| {
            !matches!(event, Event::Printer(_)) || random.uniform() >= 0.985
        });
        assert_eq!(off, None, "nothing heats, seed {seed}");
    }
    assert!(
        told.len() >= 18 && told.iter().filter(|cause| **cause == Cause::HotendUnjudged).count() >= 10,
        "{told:?}"
    );
}

/// S4: readings up to ten times as rough as a sound sensor's are noise, at target and idle; what heats behind them is found.
#[test]
fn s4_rough_readings_neither_trip_nor_hide_a_heater() {
    for (noise_k, target_c) in [(0.8, 210.0), (1.5, 210.0), (0.8, 0.0), (1.5, 0.0)] {
        for seed in 0..20 {
            let settled = || Heater::settled(seed, target_c, 0.0, 0.0);
            let mut heater = if target_c > 0.0 { settled() } else { Heater::new(seed) };
            let mut supervisor = Supervisor::new(params(), 1, None);
            assert_eq!(run(&mut heater, &mut supervisor, 30.0, |_| true), None);
            heater.noise_k = noise_k;
            let off = run(&mut heater, &mut supervisor, 60.0, |_| true);
            assert_eq!(off, None, "{noise_k} K at {target_c} degC, seed {seed}");
            heater.stuck_on = true;
            let found_s = run(&mut heater, &mut supervisor, 60.0, |_| true).map(|(time_s, _)| time_s);
            let in_time = found_s.is_some_and(|time_s| time_s <= 12.0);
            assert!(in_time, "{noise_k} K at {target_c} degC, seed {seed}: {found_s:?}");
        }
    }
}
