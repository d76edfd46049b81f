//! From report to report: heat, flow, and how the flow depends on the melt's lag.

use super::{Filter, Running};
use crate::estimator::Inbox;
use crate::measurement;
use crate::melt_lag::STEP;
use crate::printer_model::{Course, state};
use crate::ukf::Health;
use models::extruder::StaticLaw;
use models::status::PrinterStatus;
use models::units::Seconds;

/// Rounding of times and of quotients of two of them: must not add a step.
const ROUNDING: f64 = 1e-9;

impl Filter {
    /// Goes from report to report: a stroke back and a stroke forth do not cancel, since only one of them slips.
    pub(super) fn predict(&mut self, run: &mut Running, status: &PrinterStatus, inbox: &Inbox) -> Health {
        if status.stamp.0 <= run.at_s {
            return Health::Sound;
        }
        self.average_feed(status, status.stamp.0 - run.at_s);
        // without the count at the start (a new job) the slicer's feed has to do for the first step
        let mut before = inbox.samples.motor_at(run.at_s);
        let from_s = run.at_s;
        for sample in inbox.samples.iter().filter(|sample| sample.stamp_s > from_s) {
            let dt_s = sample.stamp_s - run.at_s;
            let by_widths = run.slip_by_widths();
            let (motor_speed_m_s, back_m_s) = before.map_or((status.planned_feed_m_s, 0.0), |before| {
                let back_m = if by_widths { sample.back_m(&before) } else { 0.0 };
                ((sample.motor_m - before.motor_m) / dt_s, back_m / dt_s)
            });
            before = Some(sample.position());
            run.wander.on_report(motor_speed_m_s, dt_s);
            let strokes = run.encoder_alive
                && measurement::is_stroking(&self.params.encoder, inbox, (run.at_s, sample.stamp_s));
            let pieces = if strokes { (dt_s / self.params.period_s - ROUNDING).ceil().max(1.0) } else { 1.0 };
            while run.at_s < sample.stamp_s {
                let to_s = (run.at_s + dt_s / pieces).min(sample.stamp_s);
                let to_s = if sample.stamp_s - to_s < ROUNDING { sample.stamp_s } else { to_s };
                let told = measurement::filament_between(inbox, (run.at_s, to_s)).filter(|_| strokes);
                // a slow host reports a mean over strokes, of which the encoder shows each
                let shown_m_s = told.filter(|_| pieces > 1.0).unwrap_or(motor_speed_m_s);
                run.drive = self.drive(status, (shown_m_s, back_m_s), told);
                if self.carry(run, status, to_s) == Health::Diverged {
                    return Health::Diverged;
                }
            }
            // what comes next is more like the mean than like the last stroke
            run.drive.motor_speed_m_s = motor_speed_m_s;
        }
        run.blind_s = if run.encoder_alive { 0.0 } else { run.blind_s + run.at_s - from_s };
        if !run.tells_slip() {
            run.ukf.freeze(state::SLIP);
        }
        Health::Sound
    }

    /// Carries the belief to `to_s` under the drive as it is.
    fn carry(&self, run: &mut Running, status: &PrinterStatus, to_s: f64) -> Health {
        let dt_s = to_s - run.at_s;
        let noise = self.noise(run, status, dt_s);
        let (model, drive) = (self.model, run.drive);
        let mean = run.ukf.belief().mean;
        let law = self.law(&mean);
        let course = model.course(&mean, &drive, law.as_ref(), dt_s);
        run.slopes.push((to_s, self.slope_m_s(run, law.as_ref(), (&course, dt_s))));
        let health = run.ukf.predict(&noise, |x| model.step_along(x, &drive, &course, dt_s));
        run.at_s = to_s;
        let forth_m_s = (drive.motor_speed_m_s + drive.back_m_s).max(0.0);
        run.slipped_m_s = course.slipped(run.slipped_m_s, forth_m_s);
        let x = &run.ukf.belief().mean;
        run.flows.push((run.at_s, x[state::FLOW]));
        let off_m_s = (model.pushed(x, &drive) - x[state::FLOW]).abs();
        let memory_s = self.params.width.memory_lags * model.lag_s();
        let before_m_s = run.imbalances.newest().map_or(0.0, |imbalance| imbalance.1);
        run.imbalances.push((to_s, off_m_s.max(before_m_s * (-dt_s / memory_s).exp())));
        health
    }

    /// How the flow at the end of a course depends on the factor of its law `[m/s]`; 0 where the melt is frozen.
    fn slope_m_s(&self, run: &Running, law: Option<&StaticLaw>, (course, dt_s): (&Course, f64)) -> f64 {
        let step = STEP / self.melt_lag.factor();
        let Some(law) = law.map(|law| law.scaled(1.0 + step)) else { return 0.0 };
        let before_m_s = run.slopes.newest().map_or(0.0, |slope| slope.1);
        let lag = Seconds(self.model.lag_s());
        let from_m_s = course.from_m_s + STEP * before_m_s;
        let to_m_s = law.flow_after(from_m_s, course.filament_m_s, Seconds(dt_s), lag);
        (to_m_s - course.to_m_s) / STEP
    }

    fn average_feed(&mut self, status: &PrinterStatus, dt_s: f64) {
        if status.depositing && status.planned_feed_m_s > 0.0 {
            let share = 1.0 - (-dt_s / self.params.reference.averaging_s).exp();
            self.reference_feed_m_s += share * (status.planned_feed_m_s - self.reference_feed_m_s);
        }
    }
}
