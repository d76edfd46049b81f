//! What is told between two reports of the printer.

use super::noise::variances;
use super::{Covariance, Filter};
use crate::printer_model::{Drive, state};
use crate::ukf::Gaussian;
use models::status::PrinterStatus;

/// Time over which changes of the motor's speed from report to report are averaged `[s]`.
const WANDER_S: f64 = 5.0;

/// How much the motor's speed changes from one report to the next: what it does since the newest is not known by so much.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Wander {
    before_m_s: Option<f64>,
    /// Mean of the squared changes `[m²/s²]`.
    square_m2_s2: f64,
}

impl Wander {
    /// A report says how fast the motor turned for `dt_s`.
    pub(super) fn on_report(&mut self, speed_m_s: f64, dt_s: f64) {
        let before_m_s = self.before_m_s.replace(speed_m_s).unwrap_or(speed_m_s);
        let share = 1.0 - (-dt_s / WANDER_S).exp();
        self.square_m2_s2 += share * ((speed_m_s - before_m_s).powi(2) - self.square_m2_s2);
    }

    /// What the flow may have become `ahead_s` behind the newest report, behind a lag `[s]`.
    pub(super) fn ahead(&self, ahead_s: f64, lag_s: f64) -> Covariance {
        let mut deviations = [0.0; state::COUNT];
        deviations[state::FLOW] = self.square_m2_s2.sqrt() * (1.0 - (-ahead_s / lag_s).exp());
        variances(deviations)
    }
}

impl Filter {
    /// Belief carried from the newest status to `now_s`, as if motor and heater stayed what they were.
    pub(crate) fn outlook(&self, now_s: f64, status: &PrinterStatus) -> Option<Gaussian<{ state::COUNT }>> {
        let run = self.running.as_ref()?;
        let ahead_s = (now_s - run.at_s).max(0.0);
        let mut belief = *run.ukf.belief();
        if ahead_s > 0.0 {
            let drive = Drive { filament_speed_m_s: None, ..run.drive };
            let course = self.model.course(&belief.mean, &drive, self.law(&belief.mean).as_ref(), ahead_s);
            belief.mean = self.model.step_along(&belief.mean, &drive, &course, ahead_s);
            belief.covariance +=
                self.noise(run, status, ahead_s) + run.wander.ahead(ahead_s, self.model.lag_s());
        }
        belief.covariance += self.unseen(run, &belief.mean);
        // below zero the state is a stroke, not a flow
        belief.mean[state::FLOW] = belief.mean[state::FLOW].max(0.0);
        Some(belief)
    }
}
