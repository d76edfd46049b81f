//! S3: a reading that drifts away from its block.
//!
//! The firmware holds the reading, so the reading shows nothing: what shows is the power. While the block moves at
//! `r` under a reading that stands, the balance lacks `C r`, 3.3 W at 0.2 K/s. Against the usual power that the last
//! minutes have taught, a cumulative sum with an allowance tells a lasting change from noise, and the energy since
//! the change began, over the capacity, is how far block and reading have come apart:
//! `residual = 1/C integral (d - d_usual) dt`.
//!
//! A drift that begins before the usual power is known is learnt with it. Errors of the constants bound what can be usual,
//! and a block that has drifted off loses more or less heat than its reading says: it is found by what it grows to.
//!
//! Where the printer tells its duty so seldom that it is not known in between, `S` `[W^2 s]` of it, the usual power is known
//! to `sqrt(S / t)` after `t`, and the energy to `sqrt(S t)`: allowance and limits are wider by that.
//!
//! A draught takes as much power as a drift gives. The bed beside it feels the same air: what the bed's balance lacks
//! at the same time explains its share of what the hot end's lacks. Without a bed that is warm enough to tell, a
//! residual is a reason to be careful, not to switch off.

use models::units::Seconds;

use super::pace::Period;
use crate::params::DriftParams;

/// Longest step of the sums `[s]`: after a longer gap only the time is taken.
const GAP_MAX_S: f64 = 1.0;
/// Of slow readings one may be lost `[periods]`.
const GAP_PERIODS: f64 = 2.3;

/// Standard deviations of the energy by which an order that is not known widens the limits `[-]`.
const DEVIATIONS: f64 = 2.0;

/// Weight of the recent while there is little to learn from `[-]`: 1 is a plain mean.
const RECENT: f64 = 2.0;

/// What the balances say at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Balance {
    /// Heat that nobody ordered `[W]`, negative where ordered heat is missing.
    pub disturbance_w: f64,
    /// Power that warms the block `[W]`.
    pub warming_w: f64,
    /// Density of the ordered power that is not known `[W^2 s]`.
    pub unseen_w2_s: f64,
}

/// One direction of the cumulative sum.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Sum {
    beyond_j: f64,
    energy_j: f64,
    newest_w: f64,
    /// Of the energy, by what is not known.
    variance_j2: f64,
}

impl Sum {
    fn add(&mut self, excess_w: f64, allowance_w: f64, unseen_w2_s: f64, dt_s: f64) {
        self.beyond_j = (self.beyond_j + (excess_w - allowance_w) * dt_s).max(0.0);
        self.energy_j = if self.beyond_j > 0.0 { self.energy_j + excess_w * dt_s } else { 0.0 };
        self.variance_j2 = if self.beyond_j > 0.0 { self.variance_j2 + unseen_w2_s * dt_s } else { 0.0 };
        self.newest_w = if self.beyond_j > 0.0 { excess_w.max(0.0) } else { 0.0 };
    }

    /// Energy until now: the balance is known late by `lag_s`.
    fn until_now_j(&self, lag_s: f64) -> f64 {
        self.energy_j + self.newest_w * lag_s
    }
}

/// Watches one heater through its balance.
#[derive(Debug, Clone)]
pub struct DriftCheck {
    params: DriftParams,
    newest: Option<Seconds>,
    period: Period,
    learnt_s: f64,
    usual_w: f64,
    usual_bed_w: f64,
    bed_known: bool,
    over: Sum,
    under: Sum,
}

impl DriftCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: DriftParams) -> Self {
        Self {
            params,
            newest: None,
            period: Period::USUAL,
            learnt_s: 0.0,
            usual_w: 0.0,
            usual_bed_w: 0.0,
            bed_known: false,
            over: Sum::default(),
            under: Sum::default(),
        }
    }

    /// Takes the balance of the hot end at `stamp`, and the disturbance of a bed that is warm enough to tell of the
    /// air `[W]`.
    pub fn on_balance(&mut self, stamp: Seconds, balance: Balance, bed_w: Option<f64>) {
        let dt_s = self.newest.map_or(0.0, |newest| (stamp - newest).0);
        if (-GAP_MAX_S..0.0).contains(&dt_s) {
            // It was overtaken on its way: its time has been counted.
            return;
        }
        self.newest = Some(stamp);
        let gap_max_s = self.period.gap_s(GAP_MAX_S, GAP_PERIODS);
        if dt_s > 0.0 {
            self.period.on_span(dt_s);
        }
        // While the set-point moves, what is missing may be the error of the capacity.
        if !(dt_s > 0.0 && dt_s <= gap_max_s) || balance.warming_w.abs() > self.params.steady_w {
            return;
        }
        if bed_w.is_some() != self.bed_known {
            self.bed_known = bed_w.is_some();
            self.usual_bed_w = bed_w.unwrap_or(0.0);
        }
        let apart_w = balance.disturbance_w - self.usual_w;
        let apart_bed_w = bed_w.map_or(0.0, |bed_w| bed_w - self.usual_bed_w);
        if self.learnt_s >= self.params.learn_s {
            let excess_w = unexplained(apart_w, self.params.air_share * apart_bed_w);
            let unseen_w2_s = balance.unseen_w2_s;
            let unknown_w = (unseen_w2_s / self.learnt_s.min(self.params.usual_time_s)).sqrt();
            let allowance_w = self.params.allowance_w + unknown_w;
            self.over.add(excess_w, allowance_w, unseen_w2_s, dt_s);
            self.under.add(-excess_w, allowance_w, unseen_w2_s, dt_s);
        }
        if self.over.beyond_j.max(self.under.beyond_j) <= self.params.doubt_j + self.slack_j() {
            self.learnt_s += dt_s;
            // While it learns the newer half counts as much as all: what is left of a heat-up is soon outweighed.
            let learning = self.learnt_s <= self.params.learn_s;
            let time_s = if learning { self.learnt_s / RECENT } else { self.params.usual_time_s };
            let share = dt_s / time_s;
            let share = share.min(1.0);
            let usual_w = self.usual_w + apart_w * share;
            self.usual_w = usual_w.clamp(-self.params.usual_max_w, self.params.usual_max_w);
            self.usual_bed_w += apart_bed_w * share;
        }
    }

    /// How far block and reading have come apart `[K]`, positive for a reading above its block.
    #[must_use]
    pub fn residual_k(&self) -> f64 {
        let until_now_j = |sum: &Sum| sum.until_now_j(self.params.lag_s);
        (until_now_j(&self.over) - until_now_j(&self.under)) / self.params.capacity_j_k
    }

    /// What of the energy may be what is not known of the order `[J]`.
    fn slack_j(&self) -> f64 {
        DEVIATIONS * self.over.variance_j2.max(self.under.variance_j2).sqrt()
    }

    /// A limit of the residual `[K]`, wider by that.
    fn wider_k(&self, limit_k: f64) -> f64 {
        limit_k + self.slack_j() / self.params.capacity_j_k
    }

    /// Whether they are so far apart that corrections rest on a wrong reading.
    #[must_use]
    pub fn is_doubtful(&self) -> bool {
        self.residual_k().abs() >= self.wider_k(self.params.degraded_k)
    }

    /// The limit `[K]` that the residual has reached, with its sign.
    #[must_use]
    pub fn limit_k(&self) -> f64 {
        let limit_k = if self.tripped() { self.params.safe_off_k } else { self.params.degraded_k };
        self.wider_k(limit_k).copysign(self.residual_k())
    }

    /// Whether they are so far apart that heating on is a risk, and no draught explains it.
    #[must_use]
    pub fn tripped(&self) -> bool {
        self.bed_known && self.residual_k().abs() >= self.wider_k(self.params.safe_off_k)
    }

    /// Forgets everything.
    pub fn reset(&mut self) {
        *self = Self::new(self.params);
    }
}

/// What is left of a change once the air has had its share; never less than nothing.
fn unexplained(apart_w: f64, air_w: f64) -> f64 {
    if apart_w * air_w <= 0.0 { apart_w } else { apart_w.signum() * (apart_w.abs() - air_w.abs()).max(0.0) }
}

#[cfg(test)]
mod tests;
