//! The whole supervisor against values that no sensor sends: permits keep their laws, and no check is blind afterwards.
//!
//! `FDM_POISON_CASES` sets how many prints are poisoned.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;
#[path = "poison/steps.rs"]
mod steps;

use common::params_with;
use common::print::Print;
use models::command::{Mode, Request, Trims};
use models::status::JobPhase;
use proptest::prelude::*;
use safety_supervisor::{Cause, Latch, Operator, Supervisor, What};
use steps::{Step, poisoned, sound, step};

/// A print whose every output was looked at.
struct Watched {
    print: Print,
    sequence: u64,
    latch: Option<Latch>,
    /// What only a poisoned event has spoken of speaks as well, soundly.
    healed: bool,
}

impl Watched {
    fn new(latch: Option<Latch>) -> Self {
        let params = params_with("start_mode: observe", "start_mode: act");
        let print = Print::with(Supervisor::new(params, 1, latch));
        Self { sequence: print.output.permit.sequence, latch: print.supervisor.latch(), healed: false, print }
    }

    fn take(&mut self, step: &Step) {
        match *step {
            Step::Well(ticks) => {
                for _ in 1..ticks {
                    self.tick();
                }
            }
            Step::Poison { place, value, whole } => {
                let event = poisoned(&self.print, place, value, whole);
                self.print.event(event);
            }
            Step::Ask(operator) => {
                let acknowledged = self.print.ask(operator) == What::Granted(Operator::Acknowledge);
                if acknowledged {
                    assert_ne!(self.print.output.permit.request, Request::EmergencyStop);
                    self.latch = None;
                }
                self.check();
            }
            Step::Switch(stream) => {
                let print = &mut self.print;
                let switch = [
                    &mut print.hotend,
                    &mut print.encoder,
                    &mut print.printer,
                    &mut print.controller,
                    &mut print.estimator,
                ];
                switch.into_iter().nth(stream).into_iter().for_each(|on| *on = !*on);
            }
            Step::Phase(phase) => self.print.report.phase = phase,
            Step::Jump(ticks) => self.print.tick = self.print.tick.saturating_add_signed(ticks),
        }
        self.tick();
    }

    fn tick(&mut self) {
        if self.healed && self.print.tick.is_multiple_of(5) {
            sound(&self.print).into_iter().for_each(|event| self.print.event(event));
        }
        self.print.step();
        self.check();
    }

    /// The laws of every output.
    fn check(&mut self) {
        let output = &self.print.output;
        let permit = &output.permit;
        assert!(permit.trims.is_finite() && permit.validity.0 > 0.0);
        // The slew's last step may round.
        let within = |value: f64, low: f64, high: f64| value >= low - 1e-12 && value <= high + 1e-12;
        let trims = &permit.trims;
        assert!(within(trims.flow, 0.75, 1.25) && within(trims.speed, 0.7, 1.15));
        assert!(within(trims.setpoint_offset_k, -10.0, 10.0));
        assert!(
            within(trims.advance_s.unwrap_or(0.0), 0.0, 2.0) && within(trims.slip.unwrap_or(0.0), -0.05, 0.5)
        );
        assert!(permit.sequence > self.sequence);
        self.sequence = permit.sequence;
        let latched = permit.mode >= Mode::SafeOff;
        assert_eq!(latched, permit.request >= Request::HeatersOff);
        assert!(!latched || permit.trims == Trims::NEUTRAL);
        assert!(permit.mode != Mode::Paused || permit.request >= Request::Pause);
        assert!(matches!(output.state.set_mode, Mode::Observe | Mode::Advise | Mode::Act));
        let now = self.print.supervisor.latch();
        assert_eq!(now.map(Latch::mode), latched.then_some(permit.mode));
        let ended = now.is_none_or(|now| !now.estop && self.latch.is_some_and(|latch| latch.estop));
        assert!(self.latch.is_none() || !ended, "a latch ended by itself: {:?} {now:?}", self.latch);
        self.latch = now;
        assert!(output.state.hotend_excess_w.is_finite(), "the energy balance is lost");
        assert!(output.state.slip.is_none_or(f64::is_finite), "the slip is lost");
        let states = &output.state;
        assert!(
            states.since.0.is_finite() && (states.mode < Mode::Degraded || !states.what_to_do.is_empty())
        );
    }

    /// Every stream speaks again, soundly, for so long.
    fn heal(&mut self, span_s: f64) {
        self.healed = true;
        let print = &mut self.print;
        (print.hotend, print.encoder, print.printer) = (true, true, true);
        (print.controller, print.estimator) = (true, true);
        print.report.phase = JobPhase::Printing;
        let end_s = print.now() + span_s;
        while self.print.now() < end_s {
            self.tick();
        }
    }

    /// Heals, and a person ends what is latched: all that was seen counts as gone. From here on a trip is of what follows.
    fn begin_anew(&mut self, span_s: f64) {
        self.heal(span_s);
        if self.print.mode() >= Mode::SafeOff {
            self.take(&Step::Ask(Operator::Acknowledge));
            // What was latched may have hidden what has to settle.
            self.heal(span_s);
        }
        let (output, temp_c) = (&self.print.output, self.print.temp_c);
        assert!(self.print.mode() < Mode::SafeOff, "healed at {temp_c} degC: {output:?}");
    }

    /// Ticks until the law holds; how long it took.
    fn until(&mut self, within_s: f64, holds: impl Fn(&Print) -> bool) -> Option<f64> {
        let start_s = self.print.now();
        while self.print.now() - start_s <= within_s {
            if holds(&self.print) {
                return Some(self.print.now() - start_s);
            }
            self.tick();
        }
        None
    }
}

fn cases() -> u32 {
    std::env::var("FDM_POISON_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(256)
}

/// A print that was poisoned with all these steps.
fn after(latched: Option<bool>, steps: &[Step]) -> Watched {
    let latch = latched.map(|estop| Latch { estop, cause: Cause::HotendRange });
    let mut watched = Watched::new(latch);
    for step in steps {
        watched.take(step);
    }
    watched
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(cases()) })]

    /// S5, S7: whatever came before, a thermistor that falls silent is missed as soon as ever.
    #[test]
    fn after_any_poison_a_silent_thermistor_is_answered_in_time(
        latched in prop::option::weighted(0.2, any::<bool>()),
        steps in prop::collection::vec(step(), 1..400),
    ) {
        let mut watched = after(latched, &steps);
        // Longer than a start may wait, and than a balance needs to begin and to be seen at work.
        watched.begin_anew(13.0);
        watched.print.hotend = false;
        // 3 s of silence after the last sample, and a tick or two.
        let took_s = watched.until(3.06, |print| print.mode() >= Mode::SafeOff);
        let state = &watched.print.output.state;
        prop_assert!(took_s.is_some_and(|took_s| took_s > 2.9), "{took_s:?} {state:?}");
        prop_assert_eq!(state.cause, Some(Cause::StaleHotend));
    }

    /// P1, S5: whatever came before, a heater that cannot be switched off is found.
    #[test]
    fn after_any_poison_a_heater_stuck_on_is_found(steps in prop::collection::vec(step(), 1..100)) {
        let mut watched = after(None, &steps);
        // The balance begins with ten samples and has settled after 10 s.
        watched.begin_anew(13.0);
        watched.print.report.hotend_duty = 0.0;
        let start_s = watched.print.now();
        while watched.print.mode() != Mode::Estop && watched.print.now() - start_s < 8.0 {
            // 40 W of a shorted switch less 15 W of losses, over 16.7 J/K.
            watched.print.temp_c += 1.5 * 0.02;
            watched.tick();
        }
        let state = &watched.print.output.state;
        prop_assert_eq!((state.mode, state.cause), (Mode::Estop, Some(Cause::HeaterStuckOn)), "{:?}", state);
    }
}
