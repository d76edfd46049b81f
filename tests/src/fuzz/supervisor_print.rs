//! A supervisor in a print that goes well, whose every output is looked at.

use super::shipped;
use models::command::{Command, Mode, Request, Scheduled, Trims};
use models::status::JobPhase;
use models::units::{Celsius, Seconds};
use runtime::Parameters;
use safety_supervisor::{Event, Latch, Operator, Output, Params, PrinterReport, Supervisor, What};
use std::sync::LazyLock;

/// The shipped ones, of a supervisor that may act.
static PARAMS: LazyLock<Params> = LazyLock::new(|| {
    let act = [("start_mode".to_owned(), "act".to_owned())];
    let file = shipped::file("safety_supervisor.param.yaml");
    let read = Parameters::read(&[file], &act, &shipped::node("safety_supervisor")).unwrap();
    read.without(&["latch_file"]).parse().unwrap()
});
/// Two seconds into a print, in the mode act.
static ACTING: LazyLock<Print> = LazyLock::new(|| {
    let mut print = Print::new(None);
    (0..150).for_each(|_| print.step());
    assert_eq!(print.mode, Mode::Act);
    print
});

/// A print at 210 degC at 50 Hz.
#[derive(Debug, Clone)]
pub(crate) struct Print {
    supervisor: Supervisor,
    /// What the sound parts say.
    pub(crate) report: PrinterReport,
    pub(crate) tick: i64,
    pub(crate) temp_c: f64,
    pub(crate) encoder_m: f64,
    /// Hot end, encoder, printer, controller, estimator speak.
    pub(crate) speaks: [bool; 5],
    sequence: u64,
    mode: Mode,
    permits: u64,
    latch: Option<Latch>,
}

impl Print {
    pub(crate) fn acting() -> Self {
        ACTING.clone()
    }

    pub(crate) fn new(latch: Option<Latch>) -> Self {
        let report = PrinterReport {
            stamp: Seconds(0.0),
            phase: JobPhase::Printing,
            layer: None,
            motor_position_m: 0.0,
            wanted_position_m: 0.0,
            hotend_duty: 0.32,
            bed_duty: 0.0,
            hotend_target: Celsius(210.0),
            hotend_sliced_target: Celsius(210.0),
            bed_target: Celsius(0.0),
            fan: 0.0,
            trims: Trims::NEUTRAL,
            path_speed_m_s: 0.0,
            filament_present: Some(true),
            homed: true,
            mains_on: true,
            part_fan_speed_1_s: None,
            stop_input: None,
        };
        let supervisor = Supervisor::new(*PARAMS, 1, latch);
        let (latch, mode) = (supervisor.latch(), Mode::Init);
        let mut print = Self {
            supervisor,
            report,
            tick: 0,
            temp_c: 210.0,
            encoder_m: 0.0,
            speaks: [true; 5],
            sequence: 0,
            mode,
            permits: 0,
            latch,
        };
        print.event(print.now(), Event::Tick { now: print.now() });
        print
    }

    pub(crate) fn now(&self) -> Seconds {
        Seconds(self.tick as f64 * 0.02)
    }

    /// The controller's next wish.
    pub(crate) fn wish(&mut self) -> Command {
        self.sequence += 1;
        let trims = Trims { flow: 1.05, ..Trims::NEUTRAL };
        Command { session: 3, sequence: self.sequence, validity: Seconds(1.0), trims }
    }

    /// 20 ms in which those that speak speak soundly.
    pub(crate) fn step(&mut self) {
        self.tick += 1;
        let (now, tick) = (self.now(), self.tick);
        let [hotend, encoder, printer, controller, estimator] = self.speaks;
        if self.report.phase == JobPhase::Printing {
            self.report.motor_position_m += 4e-5;
            self.encoder_m += 4e-5;
        }
        if hotend && tick % 5 == 0 {
            // The last digits differ, as of a sound sensor.
            let temp = Celsius(self.temp_c + (tick % 7) as f64 * 0.01);
            self.event(now, Event::Hotend { stamp: now, temp });
        }
        if printer {
            self.event(now, Event::Printer(PrinterReport { stamp: now, ..self.report }));
        }
        if encoder {
            self.event(now, Event::Encoder { stamp: now, position_m: self.encoder_m });
        }
        if estimator {
            self.event(now, Event::EstimateHeartbeat { stamp: now });
        }
        if controller && tick % 12 == 0 {
            let wish = self.wish();
            self.event(now, Event::Command(wish));
        }
        self.event(now, Event::Tick { now });
    }

    pub(crate) fn event(&mut self, now: Seconds, event: Event) {
        let asked = match event {
            Event::Operator(asked) => Some(asked),
            _ => None,
        };
        if let Some(output) = self.supervisor.on_event(now, event) {
            self.check(&output, asked);
        }
    }

    /// Trims of a coming move pass in the mode act alone, and inside of the limits.
    pub(crate) fn scheduled(&mut self, scheduled: Scheduled) {
        if let Some(passed) = self.supervisor.on_scheduled(self.now(), scheduled) {
            assert!(self.supervisor.latch().is_none() && passed.trim.is_valid(), "{passed:?}");
            let trims = Trims { flow: passed.trim.flow, speed: passed.trim.speed, ..Trims::NEUTRAL };
            assert!(is_inside(&trims), "{passed:?}");
        }
    }

    /// The laws of every output.
    fn check(&mut self, output: &Output, asked: Option<Operator>) {
        let (permit, state) = (&output.permit, &output.state);
        assert!(is_inside(&permit.trims) && permit.validity.0 > 0.0, "{permit:?}");
        assert!(permit.sequence > self.permits, "{permit:?} after {}", self.permits);
        let latched = permit.mode >= Mode::SafeOff;
        // No heat, and no correction of anything.
        assert_eq!(latched, permit.request >= Request::HeatersOff, "{permit:?}");
        assert!(!latched || permit.trims == Trims::NEUTRAL, "{permit:?}");
        assert_eq!(permit.mode == Mode::Estop, permit.request == Request::EmergencyStop, "{permit:?}");
        assert!(permit.mode != Mode::Paused || permit.request >= Request::Pause, "{permit:?}");
        assert!(
            asked != Some(Operator::Estop) || permit.mode == Mode::Estop,
            "an emergency stop was refused"
        );
        // Latched is latched, but for a person who acknowledges.
        let acknowledged =
            output.events.iter().any(|event| event.what == What::Granted(Operator::Acknowledge));
        let now = self.supervisor.latch();
        assert_eq!(now.map(Latch::mode), latched.then_some(permit.mode), "{permit:?}");
        let weaker = match (self.latch, now) {
            (None, _) => false,
            (Some(_), None) => true,
            (Some(before), Some(now)) => before.estop && !now.estop,
        };
        assert!(!weaker || acknowledged, "{:?} ended as {now:?}", self.latch);
        assert!(!acknowledged || asked == Some(Operator::Acknowledge), "acknowledged unasked");
        assert!(state.hotend_excess_w.is_finite() && state.bed_excess_w.is_finite(), "{state:?}");
        assert!(state.drift_k.is_finite() && state.since.0.is_finite(), "{state:?}");
        assert!(state.slip.is_none_or(f64::is_finite), "{state:?}");
        assert!(matches!(state.set_mode, Mode::Observe | Mode::Advise | Mode::Act), "{state:?}");
        assert!(state.mode < Mode::Degraded || !state.what_to_do.is_empty(), "{state:?}");
        (self.permits, self.mode, self.latch) = (permit.sequence, permit.mode, now);
    }
}

/// Finite and in the envelope; the last step of a slew may round.
fn is_inside(trims: &Trims) -> bool {
    let Ok(clamped) = PARAMS.limits.clamp(trims) else { return false };
    let kept = clamped.trims;
    let near = |value: f64, kept: f64| (value - kept).abs() <= 1e-12;
    let both = |value: Option<f64>, kept: Option<f64>| near(value.unwrap_or(0.0), kept.unwrap_or(0.0));
    near(trims.flow, kept.flow)
        && near(trims.speed, kept.speed)
        && near(trims.setpoint_offset_k, kept.setpoint_offset_k)
        && both(trims.advance_s, kept.advance_s)
        && both(trims.slip, kept.slip)
}
