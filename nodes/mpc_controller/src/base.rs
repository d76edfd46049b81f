//! What of the road's section is the spool's own: a constant of the print that is fed forward, apart from feedback.
//!
//! A spool that differs from the file's diameter is a calibration to make, not a disturbance to fight. The base `c` is a slow
//! mean of the estimated gain less one: of all that was seen at first, of `averaging_s` later on. The feed is divided by
//! `1 + c`, and the plan and the fast trims correct what differs from it.

use crate::params::RawBase;

/// Weight of the recent while there is little to learn from `[-]`: 1 is a plain mean. What is estimated of the gain is a mean
/// already, and its first words are the prior's.
const RECENT: f64 = 4.0;

/// Spool's share of the section.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Base {
    params: RawBase,
    error: f64,
    known_s: f64,
}

impl Base {
    /// Nothing known yet; it never takes more of the feed's range than there is.
    pub(crate) fn new(params: RawBase, feed_limit: f64) -> Self {
        let params = RawBase { limit: params.limit.min(feed_limit), ..params };
        Self { params, error: 0.0, known_s: 0.0 }
    }

    /// Forgets the spool: the next print may have another one.
    pub(crate) fn clear(&mut self) {
        (self.error, self.known_s) = (0.0, 0.0);
    }

    /// Whether less has been seen of the spool than its average is over.
    pub(crate) fn is_new(&self) -> bool {
        self.known_s < RECENT * self.params.averaging_s
    }

    /// Another setting; what was learnt stays, within the new bounds.
    pub(crate) fn retuned(&self, params: RawBase, feed_limit: f64) -> Self {
        let new = Self::new(params, feed_limit);
        let error = self.error.clamp(-new.params.limit, new.params.limit);
        Self { error, known_s: self.known_s, ..new }
    }

    /// Section over nominal section, less one `[-]`.
    pub(crate) fn error(&self) -> f64 {
        self.error
    }

    /// Factor on the feed that gives the nominal section `[-]`, > 0.
    pub(crate) fn feed(&self) -> f64 {
        1.0 / (1.0 + self.error)
    }

    /// A gain that was estimated over `dt_s` while a road was laid and nothing passed through the nozzle that is not the
    /// spool's.
    pub(crate) fn on_gain(&mut self, gain: f64, dt_s: f64) {
        if self.params.limit <= 0.0 || dt_s <= 0.0 {
            return;
        }
        self.known_s = (self.known_s + dt_s).min(RECENT * self.params.averaging_s);
        // at first the newest sixth counts for half: what stands for the prior is soon outweighed
        let mean_s = (self.known_s / RECENT).max(self.params.first_s);
        let share = 1.0 - (-dt_s / mean_s).exp();
        let most = self.params.rate_1_s * dt_s;
        let change = (share * (gain - 1.0 - self.error)).clamp(-most, most);
        self.error = (self.error + change).clamp(-self.params.limit, self.params.limit);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PARAMS: RawBase = RawBase { averaging_s: 20.0, first_s: 4.0, rate_1_s: 0.01, limit: 0.06 };

    fn after(seconds: u32, gain: impl Fn(f64) -> f64) -> Base {
        let mut base = Base::new(PARAMS, 0.25);
        (0..seconds * 20).for_each(|step| base.on_gain(gain(f64::from(step) * 0.05), 0.05));
        base
    }

    /// A first order lag of 4 s, that grows from 16 s on: 1/20 of the start is left after 12 s.
    #[test]
    fn a_spool_is_known_after_ten_seconds_and_corrected_whole() {
        let base = after(12, |_| 1.023);
        assert!((base.error() - 0.023).abs() < 0.1 * 0.023, "{}", base.error());
        assert!((base.feed() * (1.0 + base.error()) - 1.0).abs() < 1e-15);
    }

    /// Four times the 20 s that it is averaged over.
    #[test]
    fn a_spool_is_new_until_its_average_is_full() {
        assert!(Base::new(PARAMS, 0.25).is_new() && after(79, |_| 1.023).is_new());
        let mut base = after(81, |_| 1.023);
        assert!(!base.is_new());
        base.clear();
        assert!(base.is_new());
    }

    /// Noise of 0.8 % that changes sign each second leaves 0.8 % / (2 x 20) either way.
    #[test]
    fn noise_is_averaged_over_its_time() {
        let base = after(60, |t_s| if t_s % 2.0 < 1.0 { 1.008 } else { 0.992 });
        assert!(base.error().abs() < 5e-4, "{}", base.error());
    }

    #[test]
    fn it_moves_by_its_rate_and_stays_within_its_limit() {
        let mut base = after(1, |_| 3.0);
        assert!((base.error() - 0.01).abs() < 1e-9);
        (0..2000).for_each(|_| base.on_gain(3.0, 0.05));
        assert!((base.error() - 0.06).abs() < 1e-12);
        base.clear();
        assert!(base.error().abs() < 1e-15);
        let mut thin = after(1, |_| 0.1);
        assert!((thin.error() + 0.01).abs() < 1e-9);
        (0..2000).for_each(|_| thin.on_gain(0.1, 0.05));
        assert!((thin.error() + 0.06).abs() < 1e-12);
        let mut narrow = Base::new(PARAMS, 0.03);
        (0..2000).for_each(|_| narrow.on_gain(3.0, 0.05));
        assert!((narrow.error() - 0.03).abs() < 1e-12, "no more than the feed's range");
        assert!((thin.retuned(PARAMS, 0.02).error() + 0.02).abs() < 1e-12);
        let mut off = Base::new(PARAMS, 0.0);
        off.on_gain(1.05, 0.05);
        assert!((off.feed() - 1.0).abs() < 1e-15);
    }
}
