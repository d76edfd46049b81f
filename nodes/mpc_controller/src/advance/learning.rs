//! Learns how far the foretold `K_A` is off, from the widths of roads whose speed has just changed.
//!
//! At a feed v the drive holds `kappa L(v)` compressed, `L` the foretold law; the printer needs `rho L(u)` at an outlet u.
//! Near `rho = kappa = f`, the factor that is believed, the printer is `f L'(v) y' + y = L(v)`, and the width error is
//! `e = r_w (kappa - rho)/f (L(v) - y)/(L'(v) v)`. With `h = r_w (L(v) - y)/(L'(v) v)` that is `kappa h - f e = rho h`: a line
//! through widths, whose slope is `rho`. For one `K_0`, `L = K_0 v` and `h = r_w (1 - u/v)`, u the feed behind the lag. Two
//! more parts of a law, its melt's index and a nozzle that has narrowed, have a `kappa`, a `rho` and an `h` of their own (`fit`).

use super::fit::{Fit, Learnt, Triple, parts_m};
use super::{Foretold, attaches};
use crate::params::RawLearning;
use models::bead::ROUND_SIDES;
use models::command::AdvanceLaw;
use models::extruder::LinearLag;
use models::status::PrinterStatus;
use models::units::Seconds;
use std::collections::VecDeque;

/// A smaller relative change from status to status is none.
const CALM: f64 = 0.01;
/// Advances that differ by less are one `[s]`.
const SAME_S: f64 = 1e-6;
/// Slower feeds count as this one where the law is steep `[m/s]`: a tenth of what a slow road takes.
pub(super) const SLOW_M_S: f64 = 1e-4;
/// Statuses kept to meet a frame: 1.6 s at 50 Hz.
const STATUSES: usize = 80;

/// Whether laws attached to moves are executed: the host attaches them, a permit lets them act, and nothing is being handed
/// over, during which the printer tells another advance than the permit's.
fn is_ahead(status: &PrinterStatus) -> bool {
    let handed_over = |permitted_s: f64| (status.advance_s - permitted_s).abs() <= SAME_S;
    attaches(status.host) && status.trims.advance_s.is_some_and(handed_over)
}

/// Feed that goes into roads `[m/s]`: what takes a retraction back does not.
fn laid_m_s(status: &PrinterStatus) -> f64 {
    if !status.depositing {
        return 0.0;
    }
    (status.planned_feed_m_s * status.trims.flow * status.trims.speed).max(0.0)
}

/// A moment at which a road was laid.
#[derive(Debug, Clone, Copy)]
struct Moment {
    stamp_s: f64,
    /// Since when a road has been laid without a break `[s]`.
    since_s: f64,
    /// Since when the feed has been constant `[s]`.
    calm_since_s: f64,
    target_width_m: f64,
    /// `h`: what an error of each coefficient does to the relative width `[-]`.
    levers: Triple,
    /// `kappa`: coefficients of the advance in force `[-]`.
    shares: Triple,
    /// `f`: factor that was believed `[-]`.
    factor: f64,
    /// What the melt's part of the foretold law held `[m]`.
    melt_m: f64,
}

/// What was learnt.
#[derive(Debug, Clone)]
pub(crate) struct Learning {
    settings: RawLearning,
    /// y: what the printer holds over the factor, of each part of the law `[m]`.
    held_m: Triple,
    /// The filament is drawn back: the outlet is dry, and what is held stays.
    drawn: bool,
    before: Option<(f64, f64)>,
    since_s: Option<f64>,
    calm_since_s: f64,
    moments: VecDeque<Moment>,
    fit: Fit,
    /// Share of `narrowed_reach` that is open; 0 in a sound nozzle.
    doubt: f64,
    /// In force. Factor and index follow what the frames say slowly: of one K, a change while a road is laid is itself a width error.
    learnt: Learnt,
}

impl Learning {
    pub(crate) fn new(settings: RawLearning) -> Self {
        Self {
            settings,
            held_m: Triple::zeros(),
            drawn: false,
            before: None,
            since_s: None,
            calm_since_s: f64::NEG_INFINITY,
            moments: VecDeque::with_capacity(STATUSES),
            fit: Fit::default(),
            doubt: 0.0,
            learnt: Learnt::NOTHING,
        }
    }

    /// L and `kappa` of what is executed: the law of the moves, which carry what is believed, else one K.
    fn executed(&self, status: &PrinterStatus, foretold: &Foretold) -> (AdvanceLaw, Triple) {
        if is_ahead(status) {
            (foretold.law, self.learnt.coefficients())
        } else {
            let one = AdvanceLaw { linear_s: foretold.advance_s, shear: 0.0, index: 1.0 };
            (one, Triple::new(status.advance_s / foretold.advance_s, 0.0, 0.0))
        }
    }

    /// What is believed, each within its reach.
    pub(crate) fn learnt(&self) -> Learnt {
        self.learnt
    }

    fn goal(&self) -> Learnt {
        let RawLearning { reach, index_reach, narrowed_reach, width_noise, .. } = self.settings;
        self.fit.learnt(width_noise, Triple::new(reach, index_reach, narrowed_reach * self.doubt))
    }

    /// Lets factor and index go towards what the frames say; how much more `held_m` is by it.
    fn follow_goal(&mut self, dt_s: f64, held_m: impl Fn(&Learnt) -> f64) -> f64 {
        let most = self.settings.slew_1_s * dt_s.clamp(0.0, 1.0);
        let (goal, before_m) = (self.goal(), held_m(&self.learnt));
        self.learnt.factor += (goal.factor - self.learnt.factor).clamp(-most, most);
        self.learnt.index += (goal.index - self.learnt.index).clamp(-most, most);
        held_m(&self.learnt) - before_m
    }

    /// The nozzle has narrowed, by a force of which so much is open, or is sound: 0.
    pub(crate) fn set_doubt(&mut self, doubt: f64) {
        if self.doubt > 0.0 && doubt <= 0.0 {
            self.fit.forget_narrowing();
            self.learnt.narrowed = 0.0;
        }
        self.doubt = doubt;
    }

    /// Follows the feed behind the foretold lag, and returns how much more the law with what was learnt holds at it since the last
    /// status `[m]`.
    pub(crate) fn on_status(&mut self, status: &PrinterStatus, foretold: &Foretold) -> f64 {
        let stamp_s = status.stamp.0;
        let feed_m_s = laid_m_s(status);
        self.drawn = !status.depositing && (self.drawn || status.planned_feed_m_s < 0.0);
        let (before_s, before_m_s) = self.before.replace((stamp_s, feed_m_s)).unwrap_or((stamp_s, feed_m_s));
        let dt_s = stamp_s - before_s;
        if (feed_m_s - before_m_s).abs() > CALM * feed_m_s.max(before_m_s) {
            self.calm_since_s = stamp_s;
        }
        let grown_m = self.follow_goal(dt_s, |learnt| learnt.of(foretold.law).held_m(feed_m_s));
        let (law, shares) = self.executed(status, foretold);
        let wanted_m = parts_m(&law, feed_m_s, SLOW_M_S);
        if !(foretold.advance_s > 0.0 && (0.0..=foretold.advance_s).contains(&dt_s)) {
            self.held_m = wanted_m;
            self.since_s = None;
            return grown_m;
        }
        let factor = self.learnt.factor;
        let slope_s = |at_m_s: f64| law.lag_s(at_m_s.max(SLOW_M_S));
        let lag = LinearLag { lag_s: factor * slope_s(0.5 * (before_m_s + feed_m_s)) };
        let from_m = parts_m(&law, before_m_s, SLOW_M_S);
        if !self.drawn {
            self.held_m = Triple::from_fn(|of, _| {
                lag.step_ramp(self.held_m[of], (from_m[of], wanted_m[of]), Seconds(dt_s))
            });
        }
        let (Some(target_width_m), Some(height_m), true) =
            (status.target_width_m, status.layer_height_m, status.depositing && feed_m_s > 0.0)
        else {
            self.since_s = None;
            return grown_m;
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
            levers: (wanted_m - self.held_m) / (slope_s(feed_m_s) * feed_m_s) * (1.0 - sides),
            shares,
            factor,
            melt_m: wanted_m[2],
        });
        grown_m
    }

    /// Learns from the width of a road that was laid at `exposed_s`, and returns how much more a nozzle that has narrowed is known
    /// to hold there since then `[m]`.
    pub(crate) fn on_width(&mut self, exposed_s: f64, width_m: f64) -> f64 {
        let after = self.moments.partition_point(|moment| moment.stamp_s < exposed_s);
        let Some(moment) = self.moments.get(after).copied() else { return 0.0 };
        // In a ramp and just behind it a width shows how the drive smooths its advance, which is no lag of the melt.
        let settled = moment.stamp_s - moment.since_s >= self.settings.settle_s
            && moment.stamp_s - moment.calm_since_s >= self.settings.calm_s;
        if moment.stamp_s - exposed_s > self.settings.pairing_s
            || !settled
            || moment.levers[0].abs() > self.settings.lever_max
        {
            return 0.0;
        }
        let error =
            (width_m / moment.target_width_m - 1.0).clamp(-self.settings.error_max, self.settings.error_max);
        // A feed that the loop itself has trimmed on that error would teach its own answer.
        let is_own = moment.levers[0].abs() < self.settings.lever_min;
        let seen = Triple::new(1.0, 1.0, if self.doubt > 0.0 { 1.0 } else { 0.0 });
        let levers = if is_own { Triple::zeros() } else { moment.levers.component_mul(&seen) };
        let answer = moment.shares.dot(&levers) - moment.factor * error;
        self.fit.take(levers, answer, 1.0 - 1.0 / self.settings.frames);
        if self.doubt <= 0.0 {
            return 0.0;
        }
        let (before, now) = (self.learnt.narrowed, self.goal().narrowed);
        self.learnt.narrowed = now;
        (now - before) * moment.melt_m
    }
}

#[cfg(test)]
mod frames_tests;
#[cfg(test)]
pub(crate) mod tests;
