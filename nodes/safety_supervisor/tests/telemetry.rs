//! Telemetry that is neither slow alone nor sound: states of slow hosts, coarse converters, stalls, idle behind a flicker.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{Heater, Random, params, params_with};
use models::command::Mode;
use models::units::{Celsius, Seconds};
use safety_supervisor::{Cause, Event, Operator, Params, Supervisor};

struct Bench {
    heater: Heater,
    supervisor: Supervisor,
    states: u64,
    /// One of so many states of 50 Hz is heard.
    states_of: u64,
    /// Step of the converter, 0 for none `[K]`.
    step_k: f64,
    /// Nothing is taken for the first 0.28 s of each so many seconds, and then all at once.
    stalls_each_s: f64,
    held: Vec<Event>,
}

impl Bench {
    fn new(heater: Heater, params: Params) -> Self {
        let supervisor = Supervisor::new(params, 1, None);
        Self {
            heater,
            supervisor,
            states: 0,
            states_of: 1,
            step_k: 0.0,
            stalls_each_s: f64::INFINITY,
            held: Vec::new(),
        }
    }

    fn seen(&mut self, event: Event) -> Option<Event> {
        match event {
            Event::Hotend { stamp, temp } if self.step_k > 0.0 => {
                Some(Event::Hotend { stamp, temp: Celsius((temp.0 / self.step_k).round() * self.step_k) })
            }
            Event::Printer(_) => {
                self.states += 1;
                self.states.is_multiple_of(self.states_of).then_some(event)
            }
            _ => Some(event),
        }
    }

    /// Runs until a mode or worse is in force, at most for `span_s`; after how long, and why.
    fn until(
        &mut self,
        mode: Mode,
        span_s: f64,
        keeps: impl Fn(&Event) -> bool,
    ) -> Option<(f64, Option<Cause>)> {
        let from_s = self.heater.now_s;
        while self.heater.now_s - from_s < span_s {
            let events = self.heater.step();
            let stalled = self.heater.now_s % self.stalls_each_s < 0.28;
            for event in events {
                match self.seen(event).filter(|event| keeps(event)) {
                    Some(Event::Tick { .. }) if stalled => {}
                    Some(event) => self.held.push(event),
                    None => {}
                }
            }
            if stalled {
                continue;
            }
            for event in std::mem::take(&mut self.held) {
                let output = self.supervisor.on_event(Seconds(self.heater.now_s), event);
                if let Some(output) = output.filter(|output| output.permit.mode >= mode) {
                    return Some((self.heater.now_s - from_s, output.state.cause));
                }
            }
        }
        None
    }

    fn off(&mut self, span_s: f64) -> Option<(f64, Option<Cause>)> {
        self.until(Mode::SafeOff, span_s, |_| true)
    }

    /// Heats up, prints, prints hotter, cools: nothing may trip.
    fn print(&mut self) -> Option<(f64, Option<Cause>)> {
        let parts = [
            (215.0, 0.0, 0.0, 150.0),
            (215.0, 1.0, 4.0, 150.0),
            (235.0, 0.0, 8.0, 60.0),
            (0.0, 0.0, 0.0, 250.0),
        ];
        parts.into_iter().find_map(|(target_c, fan, flow_mm3_s, span_s)| {
            (self.heater.target_c, self.heater.fan, self.heater.flow_mm3_s) = (target_c, fan, flow_mm3_s);
            self.off(span_s)
        })
    }
}

/// A host that tells its state at 4 or 2 Hz shows one duty of several.
fn slow_host() -> Params {
    params_with("printer: {degraded_s: 0.5, pause_s: 2.7}", "printer: {degraded_s: 2.0, pause_s: 2.7}")
}

#[test]
fn p1_p2_states_of_a_slow_host_neither_trip_nor_hide_a_heater() {
    type Fault = (&'static str, fn(&mut Heater), f64);
    let faults: [Fault; 4] = [
        ("stuck on", |heater| heater.stuck_on = true, 5.0),
        ("loose", |heater| heater.gain = 0.2, 8.0),
        ("weak", |heater| heater.gain = 0.5, 20.0),
        ("dead", |heater| heater.gain = 0.0, 5.0),
    ];
    for (states_of, period_s) in [(13, 0.26), (25, 0.5)] {
        for seed in 0..20 {
            let mut bench = Bench { states_of, ..Bench::new(Heater::new(seed), slow_host()) };
            assert_eq!(bench.print(), None, "{period_s} s, seed {seed}");
            for (name, inject, limit_s) in faults {
                let heater = Heater::settled(seed, 215.0, 0.0, 3.0);
                let mut bench = Bench { states_of, ..Bench::new(heater, slow_host()) };
                assert_eq!(bench.off(60.0), None);
                inject(&mut bench.heater);
                let found = bench.off(60.0);
                let in_time = found.is_some_and(|(time_s, _)| time_s <= limit_s + 2.0 * period_s);
                assert!(in_time, "{name}, {period_s} s, seed {seed}: {found:?}");
            }
        }
    }
}

/// S2: ten bits of a divider are steps of 0.1 to 0.25 K: such a reading rests as long as its block does. One that is stuck
/// shows when the block has to move.
#[test]
fn s2_a_coarse_converter_rests_and_one_that_is_stuck_is_found_when_it_should_move() {
    for (step_k, noise_k) in [(0.1, 0.01), (0.25, 0.01), (0.25, 0.05), (0.5, 0.15)] {
        for seed in 0..20 {
            let heater = || Heater::new(seed).with_noise(noise_k);
            let mut bench = Bench { step_k, ..Bench::new(heater(), params()) };
            assert_eq!(bench.print(), None, "{step_k} K and {noise_k} K, seed {seed}");
            let mut bench = Bench { step_k, ..Bench::new(heater(), params()) };
            bench.heater.target_c = 215.0;
            assert_eq!(bench.off(150.0), None);
            (bench.heater.frozen, bench.heater.fan, bench.heater.flow_mm3_s) = (true, 1.0, 8.0);
            let found = bench.off(60.0);
            assert!(
                found.is_some_and(|(time_s, cause)| time_s < 20.0 && cause == Some(Cause::HotendFrozen)),
                "{step_k} K and {noise_k} K, seed {seed}: {found:?}"
            );
        }
    }
}

/// S2, S7: a supervisor that stands still for 0.28 s each 5.3 s finds a stuck reading all the same, and nothing else.
#[test]
fn s2_stalls_do_not_hide_a_reading_that_stands_still() {
    for seed in 0..10 {
        let stalls_each_s = 5.3;
        let mut bench = Bench { stalls_each_s, ..Bench::new(Heater::new(seed), params()) };
        assert_eq!(bench.print(), None, "seed {seed}");
        let heater = Heater::settled(seed, 215.0, 0.0, 0.0);
        let mut bench = Bench { stalls_each_s, ..Bench::new(heater, params()) };
        assert_eq!(bench.off(60.0), None);
        bench.heater.frozen = true;
        let found = bench.off(30.0);
        assert!(found.is_some_and(|(time_s, _)| time_s <= 11.0), "seed {seed}: {found:?}");
    }
}

/// S2: behind the latch the reading stands on, a stall is no proof that it moved, and neither is a restart.
#[test]
fn s2_a_reading_that_still_stands_is_not_acknowledged() {
    let patient = || params_with("unseen_s: 8.0", "unseen_s: 600.0");
    let mut bench = Bench::new(Heater::settled(3, 215.0, 0.0, 0.0), patient());
    assert_eq!(bench.off(30.0), None);
    bench.heater.frozen = true;
    assert!(bench.off(30.0).is_some_and(|(_, cause)| cause == Some(Cause::HotendFrozen)));
    let acknowledged = |bench: &mut Bench| {
        let now = Seconds(bench.heater.now_s);
        let output = bench.supervisor.on_event(now, Event::Operator(Operator::Acknowledge)).unwrap();
        output.permit.mode < Mode::SafeOff
    };
    let wait = |bench: &mut Bench, span_s: f64| bench.until(Mode::Estop, span_s, |_| true).is_none();
    bench.heater.target_c = 0.0;
    assert!(wait(&mut bench, 5.0) && !acknowledged(&mut bench));
    // 0.3 s in which nothing is taken: a stall.
    (0..15).for_each(|_| drop(bench.heater.step()));
    assert!(wait(&mut bench, 1.0) && !acknowledged(&mut bench), "after a stall");
    bench.supervisor = Supervisor::new(patient(), 2, bench.supervisor.latch());
    assert!(wait(&mut bench, 25.0) && !acknowledged(&mut bench), "after a restart");
    bench.heater.frozen = false;
    assert!(wait(&mut bench, 10.0) && acknowledged(&mut bench), "it moves");
}

/// P1: nobody asks for heat and the block warms, behind readings or states of which most are lost, and spikes.
#[test]
fn p1_an_idle_heater_that_warms_is_cut_off_behind_any_flicker() {
    let mut worst = (0.0_f64, 0.0_f64);
    for (lost_of_hotend, lost_of_states, spiked, limit_s) in
        [(0.9, 0.0, 0.0, 30.0), (0.0, 0.97, 0.0, 30.0), (0.9, 0.0, 0.12, 60.0)]
    {
        for seed in 0..20 {
            let random = std::cell::RefCell::new(Random(seed));
            let keeps = |event: &Event| match event {
                Event::Hotend { .. } => random.borrow_mut().uniform() >= lost_of_hotend,
                Event::Printer(_) => random.borrow_mut().uniform() >= lost_of_states,
                _ => true,
            };
            let mut bench = Bench::new(Heater::new(seed), params());
            assert_eq!(bench.off(30.0), None);
            bench.heater.stuck_on = true;
            let from_s = bench.heater.now_s;
            let mut found = None;
            while found.is_none() && bench.heater.now_s - from_s < 120.0 {
                let is_spike = random.borrow_mut().uniform() < spiked;
                bench.heater.spike_k = if is_spike { 80.0 } else { 0.0 };
                found = bench.until(Mode::Estop, 0.1, keeps).map(|_| bench.heater.now_s - from_s);
            }
            let what = format!("{lost_of_hotend} {lost_of_states} {spiked}, seed {seed}: {found:?}");
            assert!(found.is_some_and(|time_s| time_s <= limit_s), "{what}, {} degC", bench.heater.block_c);
            worst = (worst.0.max(found.unwrap_or(0.0)), worst.1.max(bench.heater.block_c));
        }
    }
    println!(
        "idle and stuck on behind a flicker: cut off after {:.1} s, {:.0} degC at most",
        worst.0, worst.1
    );
}
