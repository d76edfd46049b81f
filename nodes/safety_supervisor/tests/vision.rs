//! What camera and inertial unit say, through the whole brain.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::print::Print;
use models::command::{Mode, Request, Trims};
use models::status::JobPhase;
use models::units::Seconds;
use safety_supervisor::{Cause, Defect, Event, Operator, VisionReport, What};

/// A sound frame that tells where the last layer lies.
const SOUND: VisionReport = VisionReport { offset_m: Some([1e-5, -2e-5]), ..common::print::SOUND };

/// A print with frames at 2 Hz and accelerations at 20 Hz.
struct Watched {
    print: Print,
    report: Option<VisionReport>,
    /// Acceleration along x beside gravity `[m/s2]`; `None`: the unit is silent.
    shock_m_s2: Option<f64>,
    seen: Vec<What>,
}

impl Watched {
    fn acting() -> Self {
        let mut watched =
            Self { print: Print::acting(), report: Some(SOUND), shock_m_s2: Some(0.0), seen: Vec::new() };
        watched.run(2.0);
        assert_eq!(watched.print.mode(), Mode::Act);
        watched
    }

    fn step(&mut self) {
        let (tick, now) = (self.print.tick, Seconds(self.print.now()));
        if let Some(report) = self.report.filter(|_| tick.is_multiple_of(25)) {
            self.print.event(Event::Vision(report));
        }
        if let Some(shock_m_s2) = self.shock_m_s2.filter(|_| tick.is_multiple_of(2)) {
            let samples = vec![[shock_m_s2, 0.0, 9.81]; 40];
            self.print.event(Event::Imu { first: now, period: Seconds(1e-3), samples });
        }
        self.print.step();
        self.seen.extend(self.print.output.events.iter().map(|decision| decision.what));
    }

    fn run(&mut self, span_s: f64) {
        let end_s = self.print.now() + span_s;
        while self.print.now() < end_s {
            self.step();
        }
    }

    fn until(&mut self, mode: Mode) -> f64 {
        let start_s = self.print.now();
        while self.print.mode() != mode && self.print.now() - start_s < 40.0 {
            self.step();
        }
        self.print.now() - start_s
    }

    fn cause(&self) -> Option<Cause> {
        self.print.output.state.cause
    }
}

/// P8, knock: flagged in 0.1 s, the print goes on as commanded.
#[test]
fn p8_a_knock_is_flagged_in_a_tenth_of_a_second_and_pauses_nothing() {
    let mut watched = Watched::acting();
    watched.shock_m_s2 = Some(40.0);
    watched.run(0.1);
    assert!(watched.seen.contains(&What::Impulse));
    watched.shock_m_s2 = Some(0.0);
    watched.run(20.0);
    assert_eq!(watched.seen.iter().filter(|what| **what == What::Impulse).count(), 1);
    assert_eq!((watched.print.mode(), watched.cause()), (Mode::Act, None));
}

/// P8: eight frames in a row at 2 Hz, two after an impulse; paused, never corrected.
#[test]
fn p8_a_layer_shift_pauses() {
    for (shock_m_s2, earliest_s, limit_s) in [(0.0, 3.5, 4.1), (40.0, 0.5, 1.1)] {
        let mut watched = Watched::acting();
        watched.shock_m_s2 = Some(shock_m_s2);
        watched.run(0.02);
        watched.shock_m_s2 = Some(0.0);
        watched.report = Some(VisionReport { offset_m: Some([0.0, 8e-4]), ..SOUND });
        let took_s = watched.until(Mode::Paused);
        assert!((earliest_s..=limit_s).contains(&took_s), "{took_s}");
        assert_eq!(watched.cause(), Some(Cause::LayerShift));
        assert_eq!(watched.print.output.permit.request, Request::Pause);
    }
}

/// P9, P5: loose strands pause at once, a thin road where it lasts; a class of no consequence never.
#[test]
fn p9_p5_confirmed_defects_pause_with_their_cause() {
    for (defect, cause, earliest_s, limit_s) in [
        (Defect::Spaghetti, Some(Cause::Spaghetti), 0.0, 0.6),
        (Defect::Under, Some(Cause::UnderExtrusion), 2.0, 2.6),
        (Defect::Over, Some(Cause::OverExtrusion), 2.0, 2.6),
        (Defect::Other, None, 40.0, 40.1),
    ] {
        let mut watched = Watched::acting();
        watched.report = Some(VisionReport { defect: Some(defect), confirmed: true, ..SOUND });
        let took_s = watched.until(Mode::Paused);
        assert!((earliest_s..=limit_s).contains(&took_s), "{defect:?} {took_s}");
        assert_eq!(watched.cause(), cause);
    }
}

/// Model book 1.6: three frames in a row above the hard threshold.
#[test]
fn a_high_fused_confidence_pauses_and_a_resume_begins_anew() {
    let mut watched = Watched::acting();
    watched.report = Some(VisionReport { confidence: 0.9, ..SOUND });
    // The third frame of 2 Hz.
    let took_s = watched.until(Mode::Paused);
    assert!((1.0..=1.6).contains(&took_s), "{took_s}");
    assert_eq!(watched.cause(), Some(Cause::Confidence));
    watched.print.report.phase = JobPhase::Paused;
    watched.report = Some(SOUND);
    watched.run(1.0);
    // hard is hard until a person has looked
    assert_eq!(watched.print.mode(), Mode::Paused);
    assert_eq!(watched.print.ask(Operator::Resume), What::Granted(Operator::Resume));
    watched.print.report.phase = JobPhase::Printing;
    watched.run(10.0);
    assert_eq!((watched.print.mode(), watched.cause()), (Mode::Act, None));
}

/// Model book 1.6, soft: two frames in a row hold what is in force. What was taken back comes back first, or raised
/// attention would keep the loop open.
#[test]
fn raised_attention_holds_corrections_but_not_their_absence() {
    let flows = |watched: &Watched, flow: f64| (watched.print.output.permit.trims.flow - flow).abs() < 1e-9;
    let mut watched = Watched::acting();
    assert!(flows(&watched, 1.05));
    watched.report = Some(VisionReport { confidence: 0.6, ..SOUND });
    watched.run(4.0);
    watched.print.wish.flow = 1.15;
    watched.run(4.0);
    assert!(watched.print.mode() == Mode::Act && flows(&watched, 1.05));

    watched.print.estimator = false;
    watched.until(Mode::Degraded);
    watched.run(3.0);
    assert!(flows(&watched, 1.0));
    watched.print.estimator = true;
    watched.until(Mode::Act);
    watched.run(4.0);
    assert!(flows(&watched, 1.15));
    watched.run(2.0);
    watched.print.wish.flow = 1.10;
    watched.run(4.0);
    assert!(watched.print.mode() == Mode::Act && flows(&watched, 1.15));

    watched.report = Some(SOUND);
    watched.run(4.0);
    assert!(flows(&watched, 1.10));
}

/// K7: what is held swings nothing, whatever the controller wishes meanwhile.
#[test]
fn corrections_that_are_held_are_no_limit_cycle() {
    let mut watched = Watched::acting();
    let swing = |watched: &mut Watched| {
        for half in 0..20 {
            watched.print.wish.flow = if half % 2 == 0 { 0.9 } else { 1.1 };
            watched.run(1.0);
        }
        watched.cause()
    };
    watched.report = Some(VisionReport { confidence: 0.6, ..SOUND });
    watched.run(4.0);
    assert_eq!(swing(&mut watched), None);
    watched.report = Some(SOUND);
    watched.run(4.0);
    assert_eq!(swing(&mut watched), Some(Cause::Oscillation));
}

/// The cause of a pause on confidence alone is the defect that carries it, where there is one to act upon.
#[test]
fn a_high_confidence_pauses_for_the_defect_that_carries_it() {
    for (defect, cause) in [
        (Some(Defect::Spaghetti), Cause::Spaghetti),
        (Some(Defect::Under), Cause::UnderExtrusion),
        (Some(Defect::Other), Cause::Confidence),
        (None, Cause::Confidence),
    ] {
        let mut watched = Watched::acting();
        watched.report = Some(VisionReport { confidence: 0.9, defect, ..SOUND });
        assert!((1.0..=1.6).contains(&watched.until(Mode::Paused)));
        watched.report = Some(VisionReport { confidence: 0.9, defect: Some(Defect::Over), ..SOUND });
        watched.print.report.phase = JobPhase::Paused;
        watched.run(2.0);
        assert_eq!(watched.cause(), Some(cause), "what is seen later changes nothing");
    }
}

/// S7, S8: silence and blindness take the corrections back, nothing more.
#[test]
fn s7_s8_a_silent_or_blind_camera_degrades_and_heals() {
    let blind = VisionReport { usable: false, ..SOUND };
    for (report, cause, earliest_s, limit_s) in
        [(None, Cause::StaleVision, 1.5, 2.6), (Some(blind), Cause::VisionBlind, 9.9, 10.6)]
    {
        let mut watched = Watched::acting();
        watched.report = report;
        let took_s = watched.until(Mode::Degraded);
        assert!((earliest_s..=limit_s).contains(&took_s), "{took_s}");
        assert_eq!(watched.cause(), Some(cause));
        watched.run(2.0);
        assert_eq!(watched.print.output.permit.trims, Trims::NEUTRAL);
        assert_eq!(watched.print.output.permit.request, Request::Run);
        watched.report = Some(SOUND);
        assert!(watched.until(Mode::Act) <= 5.0);
    }
    let mut watched = Watched::acting();
    watched.shock_m_s2 = None;
    assert!(watched.until(Mode::Degraded) <= 0.3);
    assert_eq!(watched.cause(), Some(Cause::StaleImu));
}
