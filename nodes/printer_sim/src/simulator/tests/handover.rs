//! The advance where a permit brings another one, or is taken back, in the midst of a road.

use super::*;

/// `K_A` of the permits `[s]`; the file has none.
const ADVANCE_S: f64 = 0.4;
/// As shipped: `advance_handover_s` and `advance_return_s`.
const HANDOVER_S: f64 = 20.0;
const RETURN_S: f64 = 2.0;

/// A printer that lays lines without a break, and what its motor does.
struct Watched {
    simulator: Simulator,
    permits: u64,
    motor_m: f64,
}

impl Watched {
    fn new(simulator: Simulator) -> Self {
        Self { simulator, permits: 0, motor_m: 0.0 }
    }

    /// One step under a permit with this advance, or under none; returns the motor's speed against the slicer's.
    fn step(&mut self, permit: Option<(Mode, Option<f64>)>) -> f64 {
        let request = match permit {
            Some((Mode::Paused, _)) => Request::Pause,
            _ => Request::Run,
        };
        if let Some((mode, advance_s)) = permit {
            self.permits += 1;
            let permit = Permit {
                session: 1,
                sequence: self.permits,
                validity: Seconds(0.25),
                mode,
                request,
                trims: Trims { advance_s, ..Trims::NEUTRAL },
            };
            self.simulator.on_permit(permit).unwrap();
        }
        self.simulator.step(Seconds(1e-3));
        let before_m = std::mem::replace(&mut self.motor_m, self.simulator.status().motor_position_m);
        (self.motor_m - before_m) / 1e-3 / straight_job(1).filament_m
    }

    /// Slowest and fastest motor until so much road time has passed; before the first road nothing counts.
    fn until(&mut self, deposit_s: f64, permit: Option<(Mode, Option<f64>)>) -> (f64, f64) {
        let mut span = (f64::INFINITY, f64::NEG_INFINITY);
        while self.simulator.truth().integrals.deposit_s < deposit_s {
            let started = self.simulator.truth().integrals.deposit_s > 0.1;
            let speed = self.step(permit);
            if started {
                span = (span.0.min(speed), span.1.max(speed));
            }
        }
        span
    }
}

/// Act to observe and back: what is held, `K_A u`, goes back over 20 s of road, so that the motor runs slower by
/// `0.4 s / 20 s`, and faster by as much on the way there; then the file's own stands.
#[test]
fn a_change_of_mode_moves_the_advance_by_little_at_a_time() {
    let (act, observe) = (Some((Mode::Act, Some(ADVANCE_S))), Some((Mode::Observe, None)));
    let change = ADVANCE_S / HANDOVER_S;
    let mut watched = Watched::new(warm(straight_job(66), &Scenario::default()));
    watched.until(2.5, observe);
    for end_s in [23.0, 65.0] {
        let (_, fastest) = watched.until(end_s, act);
        assert!((fastest - 1.0 - change).abs() < 1e-3, "{fastest}");
        assert!((watched.simulator.status().advance_s - ADVANCE_S).abs() < 1e-9);
        if end_s < 30.0 {
            let (slowest, _) = watched.until(44.0, observe);
            assert!((slowest - 1.0 + change).abs() < 1e-3, "{slowest}");
            assert!(watched.simulator.status().advance_s.abs() < 1e-9, "as sliced");
        }
    }
}

/// C2, and corrections that are taken back: as sliced within 2 s, along a line too, whoever is alive.
#[test]
fn without_a_permit_or_under_one_that_degrades_the_advance_is_as_sliced_within_2_s() {
    for (away, delay_s) in [(None, 0.25), (Some((Mode::Degraded, None)), 0.0)] {
        let mut watched = Watched::new(warm(straight_job(26), &Scenario::default()));
        watched.until(21.5, Some((Mode::Act, Some(ADVANCE_S))));
        let (slowest, _) = watched.until(21.5 + delay_s + RETURN_S / 2.0, away);
        assert!((slowest - 1.0 + ADVANCE_S / RETURN_S).abs() < 1e-3, "{slowest}");
        assert!((watched.simulator.status().advance_s - ADVANCE_S / 2.0).abs() < 2e-3);
        watched.until(21.5 + delay_s + RETURN_S + 0.01, away);
        assert!(watched.simulator.status().advance_s.abs() < 1e-9);
    }
}

/// A pause takes every correction back, and lays nothing: after it the advance is what it was.
#[test]
fn a_pause_leaves_the_advance_as_it_was() {
    let mut watched = Watched::new(warm(straight_job(26), &Scenario::default()));
    let act = Some((Mode::Act, Some(ADVANCE_S)));
    watched.until(21.5, act);
    for _ in 0..4000 {
        watched.step(Some((Mode::Paused, None)));
    }
    assert_eq!(watched.simulator.phase(), JobPhase::Paused);
    let deposit_s = watched.simulator.truth().integrals.deposit_s;
    watched.until(deposit_s + 0.1, act);
    assert!((watched.simulator.status().advance_s - ADVANCE_S).abs() < 1e-9);
}

/// A prediction of the first road comes in that road: it is there at once, and 2 s later takes its time.
#[test]
fn at_the_begin_of_a_road_the_advance_is_there_at_once() {
    let observe = Some((Mode::Observe, None));
    for (after_s, at_once) in [(1.0, true), (2.5, false)] {
        let mut watched = Watched::new(warm(straight_job(4), &Scenario::default()));
        watched.until(after_s, observe);
        (0..2).for_each(|_| _ = watched.step(Some((Mode::Act, Some(ADVANCE_S)))));
        assert_eq!((watched.simulator.status().advance_s - ADVANCE_S).abs() < 1e-9, at_once, "{after_s}");
    }
}

/// While it heats nothing is held: the first road has the advance that is set by then.
#[test]
fn after_a_rest_the_advance_is_there_at_once() {
    let cold = Simulator::new(params(), straight_job(1), &Scenario::default(), 1).unwrap();
    let mut watched = Watched::new(cold);
    watched.step(Some((Mode::Act, Some(ADVANCE_S))));
    assert!((watched.simulator.status().advance_s - ADVANCE_S).abs() < 1e-12);
    watched.step(Some((Mode::Observe, None)));
    assert!(watched.simulator.status().advance_s.abs() < 1e-12);
}
