//! The whole supervisor against values that no sensor sends: permits keep their laws, and no check is blind afterwards.
//!
//! `FDM_POISON_CASES` sets how many prints are poisoned.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::params_with;
use common::print::Print;
use models::command::{Command, Mode, Request, Trims};
use models::status::JobPhase;
use models::units::{Celsius, Seconds};
use proptest::prelude::*;
use safety_supervisor::{
    Cause, Defect, Event, Latch, Operator, PrinterReport, Stream, Supervisor, VisionReport, What,
};

/// What happens between two ticks.
#[derive(Debug, Clone)]
enum Step {
    /// Ticks on which all is well, but for what was switched off.
    Well(u32),
    /// A broken value, and which one it breaks.
    Poison {
        place: usize,
        value: f64,
        whole: u64,
    },
    Ask(Operator),
    /// A stream falls silent, or speaks again.
    Switch(usize),
    Phase(JobPhase),
    /// The clock jumps by so many ticks.
    Jump(i32),
}

/// What a broken sender, a flipped bit or an attacker writes into a field.
fn broken() -> impl Strategy<Value = f64> {
    prop_oneof![
        prop::sample::select(vec![
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::MAX,
            f64::MIN,
            f64::MIN_POSITIVE / 4.0,
            -f64::MIN_POSITIVE,
            -0.0,
            0.0,
            1e300,
            -1e9,
            4.3e9,
            1e6,
        ]),
        any::<u64>().prop_map(f64::from_bits),
        -2e3..2e3,
    ]
}

fn step() -> impl Strategy<Value = Step> {
    use JobPhase::{Done, Failed, Idle, Paused, Preparing, Printing};
    let asked = vec![
        Operator::Pause,
        Operator::Resume,
        Operator::Stop,
        Operator::Estop,
        Operator::Acknowledge,
        Operator::Acknowledge,
        Operator::Approve,
        Operator::SetMode(Mode::Act),
        Operator::SetMode(Mode::Advise),
        Operator::SetMode(Mode::Estop),
    ];
    let phases = vec![Idle, Preparing, Printing, Printing, Printing, Paused, Done, Failed];
    let whole = prop_oneof![0..4_u64, Just(u64::MAX), any::<u64>()];
    prop_oneof![
        8 => (1..40_u32).prop_map(Step::Well),
        24 => (0..PLACES, broken(), whole).prop_map(|(place, value, whole)| Step::Poison { place, value, whole }),
        2 => prop::sample::select(asked).prop_map(Step::Ask),
        2 => (0..5_usize).prop_map(Step::Switch),
        1 => prop::sample::select(phases).prop_map(Step::Phase),
        1 => prop::sample::select(vec![-180_000, -40, 15, 60, 700, 180_000]).prop_map(Step::Jump),
    ]
}

const PLACES: usize = 29;

/// The event that carries the broken value.
fn poisoned(print: &Print, place: usize, value: f64, whole: u64) -> Event {
    let now = Seconds(print.now());
    let (stamp, temp) = (Seconds(value), Celsius(value));
    let report = PrinterReport { stamp: now, ..print.report };
    let frame = VisionReport {
        usable: true,
        confidence: 0.1,
        defect: Some(Defect::Spaghetti),
        confirmed: whole.is_multiple_of(2),
        offset_m: None,
    };
    let command =
        Command { session: 3, sequence: print.sequence + 1, validity: Seconds(1.0), trims: print.wish };
    let trims = |change: fn(&mut Trims, f64)| {
        let mut trims = print.wish;
        change(&mut trims, value);
        Event::Command(Command { trims, ..command })
    };
    match place {
        0 => Event::Hotend { stamp, temp: Celsius(print.temp_c) },
        1 => Event::Hotend { stamp: now, temp },
        2 => Event::Bed { stamp, temp: Celsius(60.0) },
        3 => Event::Bed { stamp: now, temp },
        4 => Event::Encoder { stamp, position_m: print.encoder_m },
        5 => Event::Encoder { stamp: now, position_m: value },
        6 => Event::EstimateHeartbeat { stamp },
        7 => Event::Imu { first: stamp, period: Seconds(1e-3), samples: vec![[0.0, 0.0, 9.81]; 20] },
        8 => Event::Imu { first: now, period: Seconds(value), samples: vec![[0.0, 0.0, 9.81]; 20] },
        9 => Event::Imu { first: now, period: Seconds(1e-3), samples: vec![[0.0, value, 9.81]; 20] },
        10 => Event::Vision(VisionReport { confidence: value, ..frame }),
        11 => Event::Vision(VisionReport { offset_m: Some([value, 0.0]), ..frame }),
        12 => Event::Printer(PrinterReport { stamp, ..report }),
        13 => Event::Printer(PrinterReport { motor_position_m: value, ..report }),
        14 => Event::Printer(PrinterReport { wanted_position_m: value, ..report }),
        15 => Event::Printer(PrinterReport { hotend_duty: value, ..report }),
        16 => Event::Printer(PrinterReport { bed_duty: value, ..report }),
        17 => Event::Printer(PrinterReport { hotend_target: temp, ..report }),
        18 => Event::Printer(PrinterReport { hotend_sliced_target: temp, ..report }),
        19 => Event::Printer(PrinterReport { bed_target: temp, ..report }),
        20 => Event::Printer(PrinterReport { fan: value, path_speed_m_s: value, ..report }),
        21 => trims(|trims, value| trims.flow = value),
        22 => trims(|trims, value| trims.speed = value),
        23 => trims(|trims, value| trims.setpoint_offset_k = value),
        24 => trims(|trims, value| trims.advance_s = Some(value)),
        25 => trims(|trims, value| trims.slip = Some(value)),
        26 => Event::Command(Command { sequence: whole, session: whole % 5, ..command }),
        27 => Event::Command(Command { validity: Seconds(value), ..command }),
        _ => Event::Refused { stream: Stream::ALL[(whole % 8) as usize] },
    }
}

/// A print whose every output was looked at.
struct Watched {
    print: Print,
    sequence: u64,
    latch: Option<Latch>,
}

impl Watched {
    fn new(latch: Option<Latch>) -> Self {
        let params = params_with("start_mode: observe", "start_mode: act");
        let print = Print::with(Supervisor::new(params, 1, latch));
        Self { sequence: print.output.permit.sequence, latch: print.supervisor.latch(), print }
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
        let print = &mut self.print;
        (print.hotend, print.encoder, print.printer) = (true, true, true);
        (print.controller, print.estimator) = (true, true);
        print.report.phase = JobPhase::Printing;
        let end_s = print.now() + span_s;
        while self.print.now() < end_s {
            self.tick();
        }
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
        // As long as a start may wait, and what was seen last is no older than its stream.
        watched.heal(10.5);
        watched.print.hotend = false;
        // 3 s of silence after the last sample, and a tick or two.
        let took = watched.until(3.06, |print| print.mode() >= Mode::SafeOff);
        prop_assert!(took.is_some(), "{:?}", watched.print.output.state);
    }

    /// P1, S5: whatever came before, a heater that cannot be switched off is found.
    #[test]
    fn after_any_poison_a_heater_stuck_on_is_found(steps in prop::collection::vec(step(), 1..100)) {
        let mut watched = after(None, &steps);
        // The balance begins with ten samples and has settled after 10 s.
        watched.heal(13.0);
        watched.print.report.hotend_duty = 0.0;
        let start_s = watched.print.now();
        while watched.print.mode() != Mode::Estop && watched.print.now() - start_s < 8.0 {
            // 40 W of a shorted switch less 15 W of losses, over 16.7 J/K.
            watched.print.temp_c += 1.5 * 0.02;
            watched.tick();
        }
        prop_assert_eq!(watched.print.mode(), Mode::Estop, "{:?}", watched.print.output.state);
    }
}
