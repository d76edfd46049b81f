//! A print that goes well, whose parts can be switched off.

use models::command::{Command, Mode, Trims};
use models::status::JobPhase;
use models::units::{Celsius, Seconds};
use safety_supervisor::{Event, Operator, Output, PrinterReport, Supervisor, VisionReport, What};

use super::{params_with, report};

/// A frame on which nothing is wrong.
pub(crate) const SOUND: VisionReport = VisionReport {
    usable: true,
    confidence: 0.1,
    defect: None,
    confirmed: false,
    told: true,
    offset_m: None,
};

/// A print at 210 degC, at 50 Hz, whose parts can be switched off.
pub(crate) struct Print {
    pub(crate) supervisor: Supervisor,
    pub(crate) tick: u32,
    pub(crate) output: Output,
    pub(crate) report: PrinterReport,
    pub(crate) temp_c: f64,
    /// What the last digits of its readings differ by `[K]`.
    pub(crate) bits: f64,
    pub(crate) hotend: bool,
    pub(crate) encoder: bool,
    pub(crate) printer: bool,
    pub(crate) controller: bool,
    pub(crate) estimator: bool,
    pub(crate) slip: f64,
    pub(crate) encoder_m: f64,
    pub(crate) wish: Trims,
    pub(crate) sequence: u64,
}

impl Print {
    pub(crate) fn with(mut supervisor: Supervisor) -> Self {
        let output = supervisor.on_event(Seconds(0.0), Event::Tick { now: Seconds(0.0) }).unwrap();
        let report = PrinterReport {
            hotend_duty: 0.32,
            hotend_target: Celsius(210.0),
            hotend_sliced_target: Celsius(210.0),
            filament_present: Some(true),
            ..report(0.0)
        };
        Self {
            supervisor,
            tick: 0,
            output,
            report,
            temp_c: 210.0,
            bits: 0.01,
            hotend: true,
            encoder: true,
            printer: true,
            controller: true,
            estimator: true,
            slip: 0.0,
            encoder_m: 0.0,
            wish: Trims { flow: 1.05, ..Trims::NEUTRAL },
            sequence: 0,
        }
    }

    pub(crate) fn acting() -> Self {
        let mut print =
            Self::with(Supervisor::new(params_with("start_mode: observe", "start_mode: act"), 7, None));
        print.run(5.0);
        assert_eq!(print.mode(), Mode::Act, "{:?}", print.output.state.cause);
        print
    }

    pub(crate) fn now(&self) -> f64 {
        f64::from(self.tick) * 0.02
    }

    pub(crate) fn mode(&self) -> Mode {
        self.output.permit.mode
    }

    pub(crate) fn event(&mut self, event: Event) {
        let now = Seconds(self.now());
        if let Some(output) = self.supervisor.on_event(now, event) {
            self.output = output;
        }
    }

    pub(crate) fn ask(&mut self, operator: Operator) -> What {
        self.event(Event::Operator(operator));
        self.output.events.last().unwrap().what
    }

    pub(crate) fn step(&mut self) {
        self.tick += 1;
        let now = Seconds(self.now());
        if self.report.phase == JobPhase::Printing {
            self.report.motor_position_m += 2e-3 * 0.02;
            self.encoder_m += 2e-3 * 0.02 * (1.0 - self.slip);
        }
        if self.hotend && self.tick.is_multiple_of(5) {
            // the last digits differ, as of a sound sensor
            let temp = Celsius(self.temp_c + f64::from(self.tick % 7) * self.bits);
            self.event(Event::Hotend { stamp: now, temp });
        }
        if self.printer {
            self.event(Event::Printer(PrinterReport { stamp: now, ..self.report }));
        }
        if self.encoder {
            self.event(Event::Encoder { stamp: now, position_m: self.encoder_m });
        }
        if self.estimator {
            self.event(Event::EstimateHeartbeat { stamp: now });
        }
        if self.controller && self.tick.is_multiple_of(12) {
            let command = self.command();
            self.event(command);
        }
        self.event(Event::Tick { now });
    }

    /// The controller's next command.
    pub(crate) fn command(&mut self) -> Event {
        self.sequence += 1;
        let (sequence, trims) = (self.sequence, self.wish);
        Event::Command(Command { session: 3, sequence, validity: Seconds(1.0), trims })
    }

    pub(crate) fn run(&mut self, span_s: f64) {
        let end_s = self.now() + span_s;
        while self.now() < end_s {
            self.step();
        }
    }

    /// Runs under frames at 2 Hz.
    pub(crate) fn watch(&mut self, report: VisionReport, span_s: f64) {
        let end_s = self.now() + span_s;
        while self.now() < end_s {
            if self.tick.is_multiple_of(25) {
                self.event(Event::Vision(report));
            }
            self.step();
        }
    }

    /// Runs until the mode is reached and returns how long it took.
    pub(crate) fn until(&mut self, mode: Mode) -> f64 {
        let start_s = self.now();
        while self.mode() != mode && self.now() - start_s < 30.0 {
            self.step();
        }
        self.now() - start_s
    }
}
