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
//! A draught takes as much power as a drift gives. The bed beside it feels the same air: what the bed's balance lacks
//! at the same time explains its share of what the hot end's lacks. Without a bed that is warm enough to tell, a
//! residual is a reason to be careful, not to switch off.

use models::units::Seconds;

use crate::params::DriftParams;

/// Longest step of the sums `[s]`: after a longer gap only the time is taken.
const GAP_MAX_S: f64 = 1.0;

/// Weight of the recent while there is little to learn from `[-]`: 1 is a plain mean.
const RECENT: f64 = 2.0;

/// What the balances say at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Balance {
    /// Heat that nobody ordered `[W]`, negative where ordered heat is missing.
    pub disturbance_w: f64,
    /// Power that warms the block `[W]`.
    pub warming_w: f64,
}

/// One direction of the cumulative sum.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Sum {
    beyond_j: f64,
    energy_j: f64,
    newest_w: f64,
}

impl Sum {
    fn add(&mut self, excess_w: f64, allowance_w: f64, dt_s: f64) {
        self.beyond_j = (self.beyond_j + (excess_w - allowance_w) * dt_s).max(0.0);
        self.energy_j = if self.beyond_j > 0.0 { self.energy_j + excess_w * dt_s } else { 0.0 };
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
        // While the set-point moves, what is missing may be the error of the capacity.
        if !(dt_s > 0.0 && dt_s <= GAP_MAX_S) || balance.warming_w.abs() > self.params.steady_w {
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
            self.over.add(excess_w, self.params.allowance_w, dt_s);
            self.under.add(-excess_w, self.params.allowance_w, dt_s);
        }
        if self.over.beyond_j.max(self.under.beyond_j) <= self.params.doubt_j {
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

    /// Whether they are so far apart that corrections rest on a wrong reading.
    #[must_use]
    pub fn is_doubtful(&self) -> bool {
        self.residual_k().abs() >= self.params.degraded_k
    }

    /// The limit `[K]` that the residual has reached, with its sign.
    #[must_use]
    pub fn limit_k(&self) -> f64 {
        let limit_k = if self.tripped() { self.params.safe_off_k } else { self.params.degraded_k };
        limit_k.copysign(self.residual_k())
    }

    /// Whether they are so far apart that heating on is a risk, and no draught explains it.
    #[must_use]
    pub fn tripped(&self) -> bool {
        self.bed_known && self.residual_k().abs() >= self.params.safe_off_k
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
mod tests {
    use super::*;

    fn check() -> DriftCheck {
        DriftCheck::new(DriftParams {
            capacity_j_k: 16.7,
            lag_s: 6.0,
            learn_s: 20.0,
            usual_time_s: 180.0,
            usual_max_w: 4.0,
            steady_w: 2.5,
            allowance_w: 1.6,
            doubt_j: 15.0,
            air_share: 0.36,
            bed_above_air_k: 15.0,
            degraded_k: 5.0,
            safe_off_k: 15.0,
        })
    }

    /// Feeds a constant balance at 10 Hz until a span is over or the check trips; returns the time it took.
    fn feed(check: &mut DriftCheck, from_s: f64, span_s: f64, (hotend_w, bed_w): (f64, Option<f64>)) -> f64 {
        let mut now_s = from_s;
        while now_s < from_s + span_s && !check.tripped() {
            now_s += 0.1;
            let balance = Balance { disturbance_w: hotend_w, warming_w: 0.0 };
            check.on_balance(Seconds(now_s), balance, bed_w);
        }
        now_s - from_s
    }

    /// 0.2 K/s take 16.7 * 0.2 = 3.34 W; 5 K are there after 25 s, 15 K after 75 s.
    #[test]
    fn a_drift_is_as_far_as_its_energy_says() {
        for sign in [-1.0, 1.0] {
            let mut check = check();
            feed(&mut check, 0.0, 400.0, (2.0, Some(4.0)));
            feed(&mut check, 400.0, 30.0, (2.0 + sign * 3.34, Some(4.0)));
            assert!(check.is_doubtful() && !check.tripped(), "{}", check.residual_k());
            assert!((check.limit_k() - sign * 5.0).abs() < 1e-12 && check.residual_k() * sign > 5.0);
            let time_s = 30.0 + feed(&mut check, 430.0, 60.0, (2.0 + sign * 3.34, Some(4.0)));
            // This balance comes without the lag of 6 s that is made up for; the doubt takes 15 J / 1.7 W = 9 s, in
            // which the usual power learns 9/180 of the change: (250 J - 19 J) / 3.2 W = 73 s.
            assert!((69.0..77.0).contains(&time_s), "{time_s} s");
        }
    }

    #[test]
    fn an_overtaken_balance_counts_no_time_twice() {
        let [mut in_order, mut overtaken] = [check(), check()];
        for sums in [&mut in_order, &mut overtaken] {
            feed(sums, 0.0, 400.0, (2.0, Some(4.0)));
        }
        for tick in 1..=300 {
            let now_s = 400.0 + 0.1 * f64::from(tick);
            let balance = Balance { disturbance_w: 5.34, warming_w: 0.0 };
            in_order.on_balance(Seconds(now_s), balance, Some(4.0));
            overtaken.on_balance(Seconds(now_s), balance, Some(4.0));
            overtaken.on_balance(Seconds(now_s - 0.15), balance, Some(4.0));
        }
        assert!(in_order.is_doubtful());
        assert!((in_order.residual_k() - overtaken.residual_k()).abs() < 1e-9);
    }

    #[test]
    fn what_the_bed_feels_too_is_air() {
        let mut check = check();
        feed(&mut check, 0.0, 100.0, (2.0, Some(4.0)));
        feed(&mut check, 100.0, 200.0, (2.0 - 4.5, Some(4.0 - 12.5)));
        assert!(!check.is_doubtful(), "{}", check.residual_k());
    }

    #[test]
    fn without_a_bed_to_tell_it_never_switches_off() {
        let mut check = check();
        feed(&mut check, 0.0, 100.0, (2.0, None));
        feed(&mut check, 100.0, 200.0, (2.0 - 4.5, None));
        assert!(check.is_doubtful() && !check.tripped());
    }

    #[test]
    fn a_change_below_the_allowance_becomes_usual() {
        let mut check = check();
        feed(&mut check, 0.0, 100.0, (2.0, Some(4.0)));
        feed(&mut check, 100.0, 600.0, (3.5, Some(4.0)));
        assert!(check.residual_k().abs() < 1e-9);
        assert!((check.usual_w - 3.5).abs() < 0.1);
    }

    /// From its first balance on, -0.2 K/s: 3.34 W, and 0.1 W/K of what it has come to. Nothing else would be found.
    #[test]
    fn a_drift_that_was_learnt_is_found_by_what_it_grows_to() {
        let found_s = |usual_max_w: f64| {
            let mut check = DriftCheck::new(DriftParams { usual_max_w, ..check().params });
            let tick = (0..3000).find(|tick| {
                let now_s = 0.1 * f64::from(*tick);
                let balance = Balance { disturbance_w: -4.34 - 0.02 * now_s, warming_w: 0.0 };
                check.on_balance(Seconds(now_s), balance, Some(4.0));
                check.tripped()
            });
            tick.map(|tick| 0.1 * f64::from(tick))
        };
        // Beyond 3.2 W and the allowance of 1.6 W from 23 s on; 250 J of what is beyond 3.2 W: 1.6 W and more.
        assert!(found_s(3.2).is_some_and(|at_s| (80.0..140.0).contains(&at_s)), "{:?}", found_s(3.2));
        assert!(found_s(100.0).is_none_or(|at_s| at_s > 200.0), "{:?}", found_s(100.0));
    }

    /// An onset just after the usual power is known: what is learnt of it takes the usual time.
    #[test]
    fn a_young_check_learns_no_faster_than_an_old_one() {
        let mut check = check();
        feed(&mut check, 0.0, 22.0, (-1.0, Some(4.0)));
        let time_s = feed(&mut check, 22.0, 120.0, (-1.0 + 3.34, Some(4.0)));
        assert!(check.tripped() && time_s < 90.0, "{time_s} s, {} K", check.residual_k());
    }

    /// 3 W beyond an allowance of 1 W for 0.5 s: 1 J beyond, 1.5 J in all, and 3 W for each second of lag.
    #[test]
    fn a_sum_counts_energy() {
        let mut sum = Sum::default();
        sum.add(3.0, 1.0, 0.5);
        assert!((sum.beyond_j - 1.0).abs() < 1e-12 && (sum.until_now_j(2.0) - 7.5).abs() < 1e-12, "{sum:?}");
        sum.add(-1.0, 1.0, 1.0);
        assert_eq!(sum, Sum::default(), "what is back below it is forgotten");
    }

    #[test]
    fn a_moving_set_point_is_not_judged() {
        let mut check = check();
        feed(&mut check, 0.0, 100.0, (2.0, Some(4.0)));
        for tick in 0..600 {
            let balance = Balance { disturbance_w: -6.0, warming_w: 20.0 };
            check.on_balance(Seconds(100.0 + 0.1 * f64::from(tick)), balance, Some(4.0));
        }
        assert!(check.residual_k().abs() < 1e-9);
    }
}
