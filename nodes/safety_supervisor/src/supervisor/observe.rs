//! What the streams say goes into the checks; what the checks say is raised.

use models::command::{Mode, Request};
use models::status::JobPhase;
use models::units::Seconds;

use super::Supervisor;
use crate::attention::Level;
use crate::cause::{Cause, Reaction};
use crate::event::{Decision, PrinterReport, VisionReport, What};
use crate::modes::{Raised, Readiness};

/// Time in which a printer gives up the job that it is told to, a slow host's included `[s]`.
const CARRIED_OUT_S: f64 = 5.0;

/// A state that is older than the newest by no more was overtaken: S6's window; by more, the printer's clock was set back `[s]`.
const OVERTAKEN_S: f64 = 0.2;

/// What is judged before the start is over: a person's hand, and heat.
const AT_ONCE: [Cause; 5] =
    [Cause::StopInput, Cause::HotendRange, Cause::BedRange, Cause::HeaterStuckOn, Cause::BedStuckOn];

impl Supervisor {
    pub(super) fn on_encoder(&mut self, now: Seconds, stamp: Seconds, position_m: f64) {
        if !(is_a_position(position_m) && stamp.0.is_finite()) {
            return self.checks.bad_values.note(now);
        }
        self.ages.encoder.note(now);
        self.checks.filament.on_encoder(stamp, position_m);
    }

    pub(super) fn on_imu(&mut self, now: Seconds, (first, period): (Seconds, Seconds), samples: &[[f64; 3]]) {
        let finite = samples.iter().flatten().all(|value| value.is_finite());
        // The last one is no further ahead than a stamp may be: what came later would count as seen.
        let last_s = first.0 + period.0 * samples.len() as f64;
        if !(finite
            && first.0.is_finite()
            && period.0 > 0.0
            && last_s <= now.0 + self.params.stale.imu.oldest_stamp().0)
        {
            return self.checks.bad_values.note(now);
        }
        self.ages.imu.note(now);
        self.checks.impulse.on_samples(first, period, samples);
    }

    pub(super) fn on_vision(&mut self, now: Seconds, report: &VisionReport) {
        let offset_sound =
            report.offset_m.is_none_or(|offset_m| offset_m.iter().all(|part| part.is_finite()));
        if !((0.0..=1.0).contains(&report.confidence) && offset_sound) {
            return self.checks.bad_values.note(now);
        }
        self.ages.vision.note(now);
        self.checks.defect.on_report(now, report);
        if report.usable {
            let before = self.checks.attention.level();
            if self.checks.attention.on_confidence(report.confidence) > before {
                self.checks.convicted = report.defect;
            }
            self.look_beside(report);
            let impulse = self.checks.impulse.recent(now, self.checks.shift.memory());
            self.checks.shift.on_offset(report.offset_m, impulse);
        }
    }

    pub(super) fn on_printer(&mut self, now: Seconds, report: PrinterReport) {
        let targets = [report.hotend_target, report.hotend_sliced_target, report.bed_target];
        let [hotend_c, sliced_c, bed_c] = targets.map(|target| target.0);
        let finite = [report.stamp.0, report.path_speed_m_s, hotend_c, sliced_c, bed_c];
        let shares = [report.hotend_duty, report.bed_duty, report.fan];
        let fan_sound = report.part_fan_speed_1_s.is_none_or(|speed| speed.is_finite() && speed >= 0.0);
        if !(finite.iter().all(|value| value.is_finite())
            && is_a_position(report.motor_position_m)
            && fan_sound
            && shares.iter().all(|share| (0.0..=1.0).contains(share)))
        {
            return self.checks.bad_values.note(now);
        }
        let phase_before = self.printer.map(|printer| printer.phase);
        self.ages.printer.note(now);
        // What was overtaken on its way is over.
        let behind_s = self.printer.map_or(0.0, |before| (before.stamp - report.stamp).0);
        if behind_s > 0.0 && behind_s <= OVERTAKEN_S {
            return;
        }
        self.on_drive(now, &report);
        self.on_first_job(now, report.phase);
        let leapt = self.printer.is_some_and(|before| leaps(&before, &report));
        if leapt {
            self.checks.bad_values.note(now);
        }
        if leapt || self.ages.encoder.reaction(now).is_some() {
            self.checks.filament.reset();
        } else {
            self.checks.filament.on_motor(report.stamp, report.motor_position_m);
        }
        let printing = report.phase == JobPhase::Printing;
        self.checks.run_out.on_switch(now, report.filament_present.filter(|_| printing));
        if printing && phase_before != Some(JobPhase::Printing) {
            // The controller need not speak before there is a move to correct.
            self.ages.command.note(now);
            // Frames are judged while the job prints.
            self.ages.vision.restart(now);
        }
        if printing && phase_before == Some(JobPhase::Paused) {
            self.on_resumed_there(now);
        }
        if report.phase == JobPhase::Failed && phase_before.is_some_and(|phase| phase != JobPhase::Failed) {
            // What it was told to give up it has not given up by itself, however soon that was acknowledged.
            let told = self.told_off.is_some_and(|told| (0.0..CARRIED_OUT_S).contains(&(now - told).0));
            self.printer_failed = !told;
        }
        let alone = report.phase == JobPhase::Paused && self.modes.request(now) == Request::Run;
        self.paused_alone_since = if alone { self.paused_alone_since.or(Some(now)) } else { None };
        self.takes_up &= report.phase == JobPhase::Paused;
        self.printer = Some(report);
    }

    /// A pause of the printer's own ends where it began: whoever stands there has let it go on.
    fn on_resumed_there(&mut self, now: Seconds) {
        let cause = Some(Cause::PrinterPaused);
        let before = self.modes.mode();
        let ready = Readiness { homed: true, filament: true, hot: true };
        if self.modes.paused_for() != cause || self.modes.resume(now, ready).is_err() {
            return;
        }
        self.resumed(now, cause);
        let (what, after) = (What::ModeChanged, self.modes.mode());
        self.decisions.push(Decision { what, why: "resumed at the printer", cause: None, before, after });
    }

    /// What calls for a reaction before the start is over: what is not heard yet may be late, what is heard counts.
    fn raised_at_once(&self, now: Seconds) -> Raised {
        let mut raised: Raised = [None; Cause::COUNT];
        for (cause, reaction) in self.checks.thermal_causes(now, &self.params) {
            raised[cause as usize] = reaction.filter(|_| AT_ONCE.contains(&cause));
        }
        raised
    }

    /// What each cause calls for now.
    pub(super) fn raised(&mut self, now: Seconds) -> Raised {
        self.follow_grace(now);
        if !self.modes.is_initialised() {
            return self.raised_at_once(now);
        }
        let mut raised: Raised = [None; Cause::COUNT];
        let mut set = |cause: Cause, reaction: Option<Reaction>| raised[cause as usize] = reaction;
        let acting = self.modes.set_mode() == Mode::Act;
        if acting {
            self.ages.expect(self.params.required_to_act, now);
        }
        self.look_at_heat(now);
        let printing = self.printer.is_some_and(|printer| printer.phase == JobPhase::Printing);
        for cause in SILENCES {
            let counts = match cause {
                Cause::StaleVision => printing,
                Cause::StaleCommand => acting && printing,
                _ => true,
            };
            set(cause, self.ages.called_for(now, cause).filter(|_| counts));
        }

        for (cause, reaction) in self.idlers(now, printing) {
            set(cause, reaction);
        }

        let checks = &self.checks;
        for (cause, reaction) in checks.thermal_causes(now, &self.params) {
            set(cause, reaction);
        }
        set(Cause::FilamentSlip, (printing && checks.filament.tripped()).then_some(Reaction::Pause));
        set(Cause::EncoderSurplus, checks.filament.reads_too_much().then_some(Reaction::Degrade));
        set(Cause::RunOut, checks.run_out.tripped(now).then_some(Reaction::Pause));
        set(Cause::LayerShift, (printing && checks.shift.tripped()).then_some(Reaction::Pause));
        let hard = printing && checks.attention.level() == Level::Hard;
        let convicted = hard.then(|| Cause::of_defect(checks.convicted));
        let defect =
            checks.defect.tripped().filter(|_| printing).map(|defect| Cause::of_defect(Some(defect)));
        for cause in [Cause::Spaghetti, Cause::UnderExtrusion, Cause::OverExtrusion, Cause::Confidence] {
            let called = defect == Some(cause) || convicted == Some(cause);
            set(cause, called.then_some(Reaction::Pause));
        }
        set(Cause::VisionBlind, (printing && checks.defect.is_blind(now)).then_some(Reaction::Degrade));
        set(Cause::BadValues, checks.bad_values.tripped(now).then_some(Reaction::Degrade));
        set(Cause::Envelope, self.envelope.is_outside(now).then_some(Reaction::Degrade));
        set(Cause::Oscillation, checks.oscillation.tripped(now).then_some(Reaction::Degrade));
        for (cause, reaction) in self.brains.raised(acting && printing) {
            set(cause, reaction);
        }
        for (cause, heard) in self.envelope.rivals(now) {
            set(cause, heard.then_some(Reaction::Degrade));
        }
        set(Cause::PrinterFailed, self.printer_failed.then_some(Reaction::SafeOff));
        let modes = &self.params.modes;
        let patience_s = if self.takes_up { modes.take_up_s.max(modes.adopt_s) } else { modes.adopt_s };
        let alone = self.paused_alone_since.is_some_and(|since| now.0 - since.0 > patience_s);
        set(Cause::PrinterPaused, alone.then_some(Reaction::Pause));
        let sight = self.sight(now, &raised);
        self.checks.unseen.look(now, sight);
        let unseen = self.checks.unseen.unseen_s(now).is_some();
        raised[Cause::HeatUnseen as usize] = unseen.then_some(Reaction::Estop);
        self.graced(raised, printing)
    }
}

/// Causes of somebody who is not heard.
const SILENCES: [Cause; 8] = [
    Cause::StaleHotend,
    Cause::StaleBed,
    Cause::StaleEncoder,
    Cause::StalePrinter,
    Cause::StaleEstimate,
    Cause::StaleImu,
    Cause::StaleVision,
    Cause::StaleCommand,
];

/// Farthest that filament goes `[m]`: 3 t of it. Sums beyond would no longer tell the millimetres of a slip.
const POSITION_MAX_M: f64 = 1e6;

fn is_a_position(position_m: f64) -> bool {
    position_m.abs() <= POSITION_MAX_M
}

/// Fastest that a motor pushes or draws filament, pressure advance in a corner included `[m/s]`.
const MOTOR_MAX_M_S: f64 = 0.3;
/// Shortest time between two states that a way counts for `[s]`: of 50 Hz.
const REPORT_MIN_S: f64 = 0.02;

/// Whether the motor's position is not where a motor can have gone since the state before: it is counted anew, or false.
fn leaps(before: &PrinterReport, report: &PrinterReport) -> bool {
    let span_s = (report.stamp - before.stamp).0.max(REPORT_MIN_S);
    (report.motor_position_m - before.motor_position_m).abs() > MOTOR_MAX_M_S * span_s
}
