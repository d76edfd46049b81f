//! Learns how far the foretold `K_A` is off, from the widths of roads whose speed has just changed.
//!
//! With `K y' + y = v + K_A v'` and `u` the same feed behind the lag alone, the width error is
//! `e = r_w (K_A - K)/K (1 - u/v)`. With `K = rho K_0`, `K_A = kappa K_0`, `K_0` foretold, and `h = r_w (1 - u/v)` behind
//! the lag that is believed now, `f K_0`, that is `kappa h - f e = rho h` near `f = rho`: a line through widths, whose slope
//! is `rho`. A constant part of `e` (diameter, slip) is no lag: slopes are taken about the means. The prior is `rho = 1`.

use crate::params::RawLearning;
use models::bead::ROUND_SIDES;
use models::extruder::LinearLag;
use models::status::PrinterStatus;
use models::units::Seconds;
use std::collections::VecDeque;

/// A smaller relative change from status to status is none.
const CALM: f64 = 0.01;
/// Statuses kept to meet a frame: 1.6 s at 50 Hz.
const STATUSES: usize = 80;

/// A moment at which a road was laid.
#[derive(Debug, Clone, Copy)]
struct Moment {
    stamp_s: f64,
    /// Since when a road has been laid without a break `[s]`.
    since_s: f64,
    /// Since when the feed has been constant `[s]`.
    calm_since_s: f64,
    target_width_m: f64,
    /// `h`: what a relative error of `K_A` does to the relative width `[-]`.
    lever: f64,
    /// `kappa`: advance in force over the foretold one `[-]`.
    share: f64,
    /// `f`: factor that was believed `[-]`.
    factor: f64,
}

/// Weighted sums over frames.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    weight: f64,
    lever: f64,
    answer: f64,
    lever_sq: f64,
    product: f64,
}

/// What was learnt.
#[derive(Debug, Clone)]
pub(crate) struct Learning {
    settings: RawLearning,
    outlet_m_s: f64,
    before: Option<(f64, f64)>,
    since_s: Option<f64>,
    calm_since_s: f64,
    moments: VecDeque<Moment>,
    sums: Sums,
}

impl Learning {
    pub(crate) fn new(settings: RawLearning) -> Self {
        Self {
            settings,
            outlet_m_s: 0.0,
            before: None,
            since_s: None,
            calm_since_s: f64::NEG_INFINITY,
            moments: VecDeque::with_capacity(STATUSES),
            sums: Sums::default(),
        }
    }

    /// Factor on the foretold advance `[-]`, within `1 +- reach`.
    pub(crate) fn factor(&self) -> f64 {
        let Sums { weight, lever, answer, lever_sq, product } = self.sums;
        if weight <= 0.0 || self.settings.reach <= 0.0 {
            return 1.0;
        }
        let spread = lever_sq - lever * lever / weight;
        let common = product - lever * answer / weight;
        let prior = (self.settings.width_noise / self.settings.reach).powi(2);
        let factor = (common + prior) / (spread.max(0.0) + prior);
        factor.clamp(1.0 - self.settings.reach, 1.0 + self.settings.reach)
    }

    /// Follows the feed behind a lag of `foretold_s`.
    pub(crate) fn on_status(&mut self, status: &PrinterStatus, foretold_s: f64) {
        let stamp_s = status.stamp.0;
        let feed_m_s = (status.planned_feed_m_s * status.trims.flow * status.trims.speed).max(0.0);
        let (before_s, before_m_s) = self.before.replace((stamp_s, feed_m_s)).unwrap_or((stamp_s, feed_m_s));
        let dt_s = stamp_s - before_s;
        if (feed_m_s - before_m_s).abs() > CALM * feed_m_s.max(before_m_s) {
            self.calm_since_s = stamp_s;
        }
        if !(foretold_s > 0.0 && (0.0..=foretold_s).contains(&dt_s)) {
            self.outlet_m_s = feed_m_s;
            self.since_s = None;
            return;
        }
        let factor = self.factor();
        let lag = LinearLag { lag_s: factor * foretold_s };
        self.outlet_m_s = lag.step_ramp(self.outlet_m_s, (before_m_s, feed_m_s), Seconds(dt_s));
        let (Some(target_width_m), Some(height_m), true) =
            (status.target_width_m, status.layer_height_m, status.depositing && feed_m_s > 0.0)
        else {
            self.since_s = None;
            return;
        };
        let since_s = *self.since_s.get_or_insert(stamp_s);
        let sides = height_m * ROUND_SIDES / target_width_m;
        if self.moments.len() == STATUSES {
            self.moments.pop_front();
        }
        self.moments.push_back(Moment {
            stamp_s,
            since_s,
            calm_since_s: self.calm_since_s,
            target_width_m,
            lever: (1.0 - self.outlet_m_s / feed_m_s) * (1.0 - sides),
            share: status.advance_s / foretold_s,
            factor,
        });
    }

    /// Learns from the width of a road that was laid at `exposed_s`.
    pub(crate) fn on_width(&mut self, exposed_s: f64, width_m: f64) {
        let after = self.moments.partition_point(|moment| moment.stamp_s < exposed_s);
        let Some(moment) = self.moments.get(after).copied() else { return };
        // In a ramp the drive's smoothing and the nozzle's flat show, which are no lag of the melt.
        let settled = moment.stamp_s - moment.since_s >= self.settings.settle_s
            && moment.stamp_s - moment.calm_since_s >= self.settings.calm_s;
        if moment.stamp_s - exposed_s > self.settings.pairing_s
            || !settled
            || moment.lever.abs() > self.settings.lever_max
        {
            return;
        }
        let error =
            (width_m / moment.target_width_m - 1.0).clamp(-self.settings.error_max, self.settings.error_max);
        let answer = moment.share * moment.lever - moment.factor * error;
        let kept = 1.0 - 1.0 / self.settings.frames;
        let sums = &mut self.sums;
        sums.weight = kept * sums.weight + 1.0;
        sums.lever = kept * sums.lever + moment.lever;
        sums.answer = kept * sums.answer + answer;
        sums.lever_sq = kept * sums.lever_sq + moment.lever * moment.lever;
        sums.product = kept * sums.product + moment.lever * answer;
    }
}

#[cfg(test)]
mod tests;
