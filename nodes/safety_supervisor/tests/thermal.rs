//! P1, P2, P3, S1, S2 on a stand-in heater whose constants are up to 10 % off the supervisor's, 20 seeds each.
//!
//! `cargo test -p safety_supervisor --test thermal -- --nocapture` prints the reaction times.
#![allow(clippy::print_stdout, reason = "the reaction times are for people")]

mod common;
#[path = "thermal/missing.rs"]
mod missing;

use common::{Heater, params};
use models::command::Mode;
use models::units::Seconds;
use safety_supervisor::{Cause, Event, Evidence, Operator, Supervisor};

/// Seeds of each case; `SEEDS=400` widens the search for false trips.
fn seeds() -> u64 {
    std::env::var("SEEDS").ok().and_then(|text| text.parse().ok()).unwrap_or(20)
}

struct Loop {
    heater: Heater,
    supervisor: Supervisor,
    mode: Mode,
    cause: Option<Cause>,
    evidence: Option<Evidence>,
    excess_w: (f64, f64),
}

impl Loop {
    fn new(heater: Heater) -> Self {
        let supervisor = Supervisor::new(params(), 1, None);
        Self { heater, supervisor, mode: Mode::Init, cause: None, evidence: None, excess_w: (0.0, 0.0) }
    }

    /// Runs for a while or until a latched mode; returns the time it took to get there.
    fn run(&mut self, span_s: f64) -> Option<f64> {
        let start_s = self.heater.now_s;
        while self.heater.now_s - start_s < span_s {
            for event in self.heater.step() {
                let now = Seconds(self.heater.now_s);
                if let Some(output) = self.supervisor.on_event(now, event) {
                    self.mode = output.permit.mode;
                    self.cause = output.state.cause;
                    self.evidence = output.state.evidence;
                    let excess_w = output.state.hotend_excess_w;
                    self.excess_w = (self.excess_w.0.min(excess_w), self.excess_w.1.max(excess_w));
                }
            }
            if self.mode >= Mode::SafeOff {
                return Some(self.heater.now_s - start_s);
            }
        }
        None
    }
}

/// Reaction times over all seeds to a fault on a heater in a given state; panics on a miss or a wrong cause.
fn reaction(name: &str, start: impl Fn(u64) -> Heater, fault: impl Fn(&mut Heater), causes: &[Cause]) -> f64 {
    let mut times: Vec<f64> = (0..seeds())
        .map(|seed| {
            let mut run = Loop::new(start(seed));
            assert_eq!(
                run.run(60.0 + seed as f64 * 0.137),
                None,
                "{name}, seed {seed}: tripped before: {:?}",
                run.cause
            );
            fault(&mut run.heater);
            let time_s = run.run(60.0).unwrap_or(f64::INFINITY);
            assert!(
                run.cause.is_none_or(|cause| causes.contains(&cause)),
                "{name}, seed {seed}: {:?}",
                run.cause
            );
            if let Some(Evidence { value, limit: Some(limit), .. }) = run.evidence {
                assert!(value / limit >= 1.0, "{name}, seed {seed}: {:?}: {value}, {limit}", run.cause);
            } else {
                assert!(matches!(run.cause, None | Some(Cause::HotendFrozen)), "{name}: {:?}", run.cause);
            }
            time_s
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let (median_s, worst_s) = (times[times.len() / 2], times[times.len() - 1]);
    println!("{name:44} p50 {median_s:6.2} s  worst {worst_s:6.2} s");
    worst_s
}

fn idle(seed: u64) -> Heater {
    Heater::settled(seed, 210.0, 0.0, 0.0)
}

fn printing(seed: u64) -> Heater {
    Heater::settled(seed, 210.0, 1.0, 4.8)
}

fn cold(seed: u64) -> Heater {
    Heater::new(seed)
}

/// P1: 5 s from injection at target or idle, 8 s while printing with fan.
#[test]
fn p1_a_heater_that_heats_unordered_is_cut_off() {
    let stuck = |heater: &mut Heater| heater.stuck_on = true;
    let causes = [Cause::HeaterStuckOn];
    assert!(reaction("P1 stuck on, at target", idle, stuck, &causes) <= 5.0);
    assert!(reaction("P1 stuck on, cold", cold, stuck, &causes) <= 5.0);
    assert!(reaction("P1 stuck on, printing with fan", printing, stuck, &causes) <= 8.0);
}

/// P2: no power is missing of a heater that is off, wherever in its cooling the check starts anew.
#[test]
fn an_acknowledge_while_the_hot_end_cools_holds() {
    for seed in 0..seeds() {
        for off_s in [1.0, 4.0, 20.0] {
            let mut run = Loop::new(printing(seed));
            assert_eq!(run.run(60.0), None, "{:?}", run.cause);
            run.heater.target_c = 0.0;
            run.heater.flow_mm3_s = 0.0;
            assert_eq!(run.run(off_s), None, "{:?}", run.cause);
            for request in [Operator::Stop, Operator::Acknowledge] {
                run.supervisor.on_event(Seconds(run.heater.now_s), Event::Operator(request));
            }
            assert_eq!(run.run(60.0), None, "seed {seed}, {off_s} s: {:?}", run.cause);
        }
    }
}

/// P3: 4 s.
#[test]
fn p3_a_thermistor_that_fell_out_is_told_from_cooling() {
    let causes = [Cause::ThermistorDetached, Cause::HeaterDeficit];
    let fallen = |heater: &mut Heater| heater.coupling = 0.1;
    assert!(reaction("P3 fell out, at target", idle, fallen, &causes) <= 4.0);
    assert!(reaction("P3 fell out, printing", printing, fallen, &causes) <= 4.0);
}

/// S2: 10 s; 3 s (and a sample) with the duty saturated.
#[test]
fn s2_a_frozen_reading_is_seen() {
    // Readings that stand still may look like a deficit before they are known to stand still.
    let causes = [Cause::HotendFrozen, Cause::HeaterDeficit];
    let freeze = |heater: &mut Heater| heater.frozen = true;
    assert!(reaction("S2 frozen, at target", idle, freeze, &causes) <= 10.0);
    assert!(reaction("S2 frozen, printing", printing, freeze, &causes) <= 10.0);
    let cooling = |heater: &mut Heater| (heater.frozen, heater.target_c) = (true, 0.0);
    assert!(reaction("S2 frozen, cool-down", idle, cooling, &causes) <= 10.0);
    let saturated = |heater: &mut Heater| (heater.frozen, heater.target_c) = (true, 215.0);
    assert!(reaction("S2 frozen, heat-up", cold, saturated, &causes) <= 3.2);
}

/// S4: a single spike of any size, every two seconds, is no fault.
#[test]
fn s4_single_spikes_do_not_trip() {
    for seed in 0..seeds() {
        let mut run = Loop::new(printing(seed));
        let size_k = 1.0 + 15.0 * run.heater.random.uniform();
        assert_eq!(run.run(60.0), None);
        for spike in 0..30 {
            run.heater.spike_k = if spike % 2 == 0 { size_k } else { -size_k };
            assert_eq!(run.run(2.0), None, "seed {seed}, {size_k} K: {:?}", run.cause);
        }
    }
}

/// Readings twice as rough make the balance twice as rough: nothing is missing, and what is missing still shows.
#[test]
fn p2_rough_readings_are_no_missing_power() {
    let start = |seed| Heater::settled(seed, 240.0, 0.96, 4.0).with_noise(0.3);
    for seed in 0..seeds() {
        let mut run = Loop::new(start(seed));
        assert_eq!(run.run(1200.0), None, "seed {seed}: {:?} {:?}", run.cause, run.excess_w);
    }
    let dead = |heater: &mut Heater| heater.gain = 0.0;
    assert!(reaction("P2 dead, rough readings", start, dead, &[Cause::HeaterDeficit]) <= 8.0);
}

/// Of readings five times as rough (S4) only large heat means anything: it is still cut off, later.
#[test]
fn p1_heat_that_nobody_ordered_shows_under_rough_readings() {
    let stuck = |heater: &mut Heater| heater.stuck_on = true;
    assert!(
        reaction("P1 stuck on, rough", |seed| idle(seed).with_noise(0.8), stuck, &[Cause::HeaterStuckOn])
            <= 10.0
    );
}

/// Heat-up, fan, flow steps, cool-down and a draught: no trip, whatever the seed.
#[test]
fn nominal_printing_never_trips() {
    let (mut low_w, mut high_w) = (0.0_f64, 0.0_f64);
    for seed in 0..seeds() {
        let mut run = Loop::new(cold(seed));
        let go = |run: &mut Loop, what: &str, span_s: f64| {
            assert_eq!(run.run(span_s), None, "seed {seed}, {what}: {:?} {:?}", run.cause, run.excess_w);
        };
        go(&mut run, "idle", 20.0);
        run.heater.target_c = 215.0;
        go(&mut run, "heat-up", 240.0);
        for cycle in 0..6 {
            run.heater.flow_mm3_s = 10.0;
            go(&mut run, "flow on", 20.0);
            run.heater.fan = f64::from(u8::from(cycle % 2 == 0));
            go(&mut run, "fan", 20.0);
            run.heater.flow_mm3_s = 0.0;
            go(&mut run, "flow off", 20.0);
        }
        for flip in 0..40 {
            run.heater.flow_mm3_s = if flip % 2 == 0 { 8.0 } else { 2.0 };
            go(&mut run, "flow flips", 2.0);
        }
        run.heater.target_c = 230.0;
        go(&mut run, "up 15 K", 60.0);
        run.heater.target_c = 200.0;
        go(&mut run, "down 30 K", 60.0);
        run.heater.fan = 0.0;
        go(&mut run, "fan off", 60.0);
        (run.heater.ambient_c, run.heater.loss_factor) = (15.0, 1.3);
        go(&mut run, "draught", 120.0);
        (run.heater.ambient_c, run.heater.loss_factor) = (25.0, 1.0);
        go(&mut run, "draught over", 120.0);
        run.heater.target_c = 0.0;
        go(&mut run, "cool-down", 300.0);
        run.heater.target_c = 215.0;
        go(&mut run, "heat-up again", 200.0);
        (low_w, high_w) = (low_w.min(run.excess_w.0), high_w.max(run.excess_w.1));
    }
    println!("nominal: excess from {low_w:.1} W to {high_w:.1} W");
}

/// Streams come late and in bunches on a busy machine, each on its own: only stamps tell what belongs together.
#[test]
fn bunched_streams_do_not_trip() {
    for seed in 0..seeds() {
        let mut heater = Heater::new(seed);
        heater.target_c = 215.0;
        let mut supervisor = Supervisor::new(params(), 1, None);
        let mut random = common::Random(seed + 1000);
        // One of the streams stands for up to 0.6 s at a time.
        let (mut held, mut holds_hotend, mut until_s) = (Vec::new(), true, 0.0);
        while heater.now_s < 150.0 {
            let (events, now) = (heater.step(), Seconds(heater.now_s));
            let mut passed: Vec<_> = Vec::new();
            if heater.now_s >= until_s {
                passed.append(&mut held);
                holds_hotend = random.uniform() < 0.5;
                until_s = heater.now_s + 0.6 * random.uniform();
            }
            for event in events {
                let hold = match event {
                    safety_supervisor::Event::Hotend { .. } => holds_hotend,
                    safety_supervisor::Event::Printer(_) => !holds_hotend,
                    _ => false,
                };
                if hold { held.push(event) } else { passed.push(event) }
            }
            for event in passed {
                if let Some(output) = supervisor.on_event(now, event) {
                    let mode = output.permit.mode;
                    assert!(mode < Mode::Paused, "seed {seed} at {now:?}: {:?}", output.state.cause);
                }
            }
        }
    }
}

/// A supervisor that is killed and started again at any moment of a heat-up sees nothing wrong.
#[test]
fn a_restart_in_the_middle_of_a_heat_up_does_not_trip() {
    for seed in 0..seeds() {
        let mut heater = Heater::new(seed);
        heater.target_c = 215.0;
        let mut run = Loop::new(heater);
        for _ in 0..12 {
            assert_eq!(run.run(5.0 + 0.37 * seed as f64), None, "seed {seed}: {:?}", run.cause);
            run.supervisor = Supervisor::new(params(), 2, None);
        }
        assert_eq!(run.run(60.0), None, "seed {seed}: {:?}", run.cause);
    }
}
