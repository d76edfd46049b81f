//! Learns how far the foretold `K_A` is off, from the widths of roads whose speed has just changed.
//!
//! At a feed v the printer needs `rho L(u)` compressed, `L` the foretold law, u the outlet; the drive holds `D(v)`, by the trim that a
//! move was sent with, or by one `K`. What both lag behind by is y, `rho L'(v) y' + y = L(v)`, and a, `rho L'(v) a' + a = D(v)`. The
//! width error is `e = r_w ((D - a) - rho (L - y)) / (rho L'(v) v)`: with `h = r_w (L - y)/(L'(v) v)` and d the same of the drive's that
//! is `d - rho e = rho h`, a line through widths whose slope is `rho`. For one `K_0`, `L = K_0 v` and `h = r_w (1 - u/v)`, u the feed behind
//! the lag. Two more parts of a law, its melt's index and a nozzle that has narrowed, have a `rho` and an `h` of their own (`fit`).

use super::attached::{Attached, Driven};
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
    /// `d`: what the drive does to it `[-]`.
    driven: f64,
    /// What the melt's part of the foretold law held `[m]`.
    melt_m: f64,
}

/// What a dip told of the nozzle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Nozzle {
    /// Force over that of a sound one that laws follow `[-]`.
    pub(crate) force: f64,
    /// Share of `narrowed_reach` that is open; 0 in a sound one.
    pub(crate) doubt: f64,
}

impl Nozzle {
    pub(crate) const SOUND: Self = Self { force: 1.0, doubt: 0.0 };
}

/// What was learnt.
#[derive(Debug, Clone)]
pub(crate) struct Learning {
    settings: RawLearning,
    /// y: what the printer holds over the factor, of each part of the law `[m]`.
    held_m: Triple,
    attached: Attached,
    /// D, and the a behind it `[m]`.
    driven_m: f64,
    pushed_m: f64,
    /// The filament is drawn back: the outlet is dry, and what is held stays.
    drawn: bool,
    before: Option<(f64, f64)>,
    since_s: Option<f64>,
    calm_since_s: f64,
    moments: VecDeque<Moment>,
    fit: Fit,
    nozzle: Nozzle,
    /// In force. Factor and index follow what the frames say slowly: of one K, a change while a road is laid is itself a width error.
    learnt: Learnt,
}

impl Learning {
    pub(crate) fn new(settings: RawLearning) -> Self {
        Self {
            settings,
            held_m: Triple::zeros(),
            attached: Attached::default(),
            driven_m: 0.0,
            pushed_m: 0.0,
            drawn: false,
            before: None,
            since_s: None,
            calm_since_s: f64::NEG_INFINITY,
            moments: VecDeque::with_capacity(STATUSES),
            fit: Fit::default(),
            nozzle: Nozzle::SOUND,
            learnt: Learnt::NOTHING,
        }
    }

    /// D: what the drive holds compressed at a feed `[m/s]` `[m]`.
    fn driven_at_m(&self, status: &PrinterStatus, feed_m_s: f64) -> f64 {
        let sent = self.attached.under_way().filter(|_| is_ahead(status));
        sent.map_or(status.advance_s * feed_m_s, |sent| sent.held_m(feed_m_s))
    }

    /// Moves that were sent with a trim.
    pub(super) fn attached(&self) -> &Attached {
        &self.attached
    }

    /// The same, to send more of them, or anew.
    pub(super) fn attached_mut(&mut self) -> &mut Attached {
        &mut self.attached
    }

    /// What the drive holds now for a nozzle that has narrowed.
    pub(super) fn driven(&self, status: &PrinterStatus) -> Driven {
        let sent = self.attached.under_way().filter(|_| is_ahead(status));
        sent.map_or(Driven::SOUND, |sent| sent.driven())
    }

    /// Follows the moves that were sent: the fastest feed of the one under way `[m/s]`; `None` before the first.
    pub(crate) fn on_move(&mut self, status: &PrinterStatus) -> Option<f64> {
        self.attached.on_status(status);
        self.attached.under_way().map(|sent| sent.cruise_m_s)
    }

    /// What is believed, each within its reach.
    pub(crate) fn learnt(&self) -> Learnt {
        self.learnt
    }

    fn goal(&self) -> Learnt {
        let RawLearning { reach, index_reach, narrowed_reach, width_noise, .. } = self.settings;
        self.fit.learnt(width_noise, Triple::new(reach, index_reach, narrowed_reach * self.nozzle.doubt))
    }

    /// Lets factor and index go towards what the frames say; how much more `held_m` is by it.
    fn follow_goal(&mut self, dt_s: f64, held_m: impl Fn(&Learnt) -> f64) -> f64 {
        let most = self.settings.slew_1_s * dt_s.clamp(0.0, 1.0);
        let (goal, before_m) = (self.goal(), held_m(&self.learnt));
        self.learnt.factor += (goal.factor - self.learnt.factor).clamp(-most, most);
        self.learnt.index += (goal.index - self.learnt.index).clamp(-most, most);
        held_m(&self.learnt) - before_m
    }

    /// What the nozzle is known for now. What it holds by another force it holds already.
    fn take_nozzle(&mut self, nozzle: Nozzle, law: &AdvanceLaw) {
        if self.nozzle.doubt > 0.0 && nozzle.doubt <= 0.0 {
            self.fit.forget_narrowing();
            self.learnt.narrowed = 0.0;
        }
        let grown = nozzle.force / self.nozzle.force;
        if let Some((_, feed_m_s)) = self.before {
            let before = AdvanceLaw { shear: law.shear / grown, ..*law };
            self.held_m += parts_m(law, feed_m_s, SLOW_M_S) - parts_m(&before, feed_m_s, SLOW_M_S);
        }
        self.nozzle = nozzle;
    }

    /// Follows feed and drive behind the foretold lag, and returns how much more the law with what was learnt holds since the last
    /// status `[m]`.
    pub(crate) fn on_status(&mut self, status: &PrinterStatus, foretold: &Foretold, nozzle: Nozzle) -> f64 {
        let (stamp_s, law) = (status.stamp.0, foretold.law);
        let feed_m_s = laid_m_s(status);
        self.drawn = !status.depositing && (self.drawn || status.planned_feed_m_s < 0.0);
        self.take_nozzle(nozzle, &law);
        let (before_s, before_m_s) = self.before.replace((stamp_s, feed_m_s)).unwrap_or((stamp_s, feed_m_s));
        let dt_s = stamp_s - before_s;
        if (feed_m_s - before_m_s).abs() > CALM * feed_m_s.max(before_m_s) {
            self.calm_since_s = stamp_s;
        }
        let grown_m = self.follow_goal(dt_s, |learnt| learnt.of(law).held_m(feed_m_s));
        let wanted_m = parts_m(&law, feed_m_s, SLOW_M_S);
        let driven_m = self.driven_at_m(status, feed_m_s);
        let driven_before_m = std::mem::replace(&mut self.driven_m, driven_m);
        if !(foretold.advance_s > 0.0 && (0.0..=foretold.advance_s).contains(&dt_s)) {
            (self.held_m, self.pushed_m) = (wanted_m, driven_m);
            self.since_s = None;
            return grown_m;
        }
        let slope_s = |at_m_s: f64| law.lag_s(at_m_s.max(SLOW_M_S));
        if !self.drawn {
            let lag = LinearLag { lag_s: self.learnt.factor * slope_s(0.5 * (before_m_s + feed_m_s)) };
            let from_m = parts_m(&law, before_m_s, SLOW_M_S);
            self.held_m = Triple::from_fn(|of, _| {
                lag.step_ramp(self.held_m[of], (from_m[of], wanted_m[of]), Seconds(dt_s))
            });
            self.pushed_m = lag.step_ramp(self.pushed_m, (driven_before_m, driven_m), Seconds(dt_s));
        }
        self.note(status, feed_m_s, (wanted_m, slope_s(feed_m_s)));
        grown_m
    }

    /// Keeps the moment of a road at a feed `[m/s]`, with what the law wants there `[m]` and its slope `[s]`.
    fn note(&mut self, status: &PrinterStatus, feed_m_s: f64, (wanted_m, slope_s): (Triple, f64)) {
        let (Some(target_width_m), Some(height_m), true) =
            (status.target_width_m, status.layer_height_m, status.depositing && feed_m_s > 0.0)
        else {
            self.since_s = None;
            return;
        };
        let since_s = *self.since_s.get_or_insert(status.stamp.0);
        if self.moments.len() == STATUSES {
            self.moments.pop_front();
        }
        let section = 1.0 - height_m * ROUND_SIDES / target_width_m;
        let over_m = section / (slope_s * feed_m_s);
        self.moments.push_back(Moment {
            stamp_s: status.stamp.0,
            since_s,
            calm_since_s: self.calm_since_s,
            target_width_m,
            levers: (wanted_m - self.held_m) * over_m,
            driven: (self.driven_m - self.pushed_m) * over_m,
            melt_m: wanted_m[2],
        });
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
        let seen = Triple::new(1.0, 1.0, if self.nozzle.doubt > 0.0 { 1.0 } else { 0.0 });
        let (levers, driven) =
            if is_own { (Triple::zeros(), 0.0) } else { (moment.levers.component_mul(&seen), moment.driven) };
        self.fit.take(levers, (driven, error), 1.0 - 1.0 / self.settings.frames);
        if self.nozzle.doubt <= 0.0 {
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
