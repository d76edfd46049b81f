//! Flow of the slicer's own feed, calibrated, through the same lag: what the estimated flow is compared with (model book 1.7).

use models::extruder::{LinearLag, StaticLaw};
use models::status::PrinterStatus;
use models::units::Seconds;

/// Outlet flow that the feed would give without feedback.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nominal {
    lag: LinearLag,
    flow_m_s: f64,
    /// Filament so far `[m]`.
    fed_m: f64,
    before: Option<(f64, f64)>,
    /// Since when the feed is followed without a gap `[s]`.
    since_s: f64,
}

impl Nominal {
    pub(crate) fn new(lag_s: f64) -> Self {
        Self { lag: LinearLag { lag_s }, flow_m_s: 0.0, fed_m: 0.0, before: None, since_s: f64::INFINITY }
    }

    /// Flow `[m/s]`, 0 or more; `None` until so many lags have passed that the start is forgotten.
    pub(crate) fn flow_m_s(&self, settle_lags: f64) -> Option<f64> {
        let (newest_s, _) = self.before?;
        (newest_s - self.since_s >= settle_lags * self.lag.lag_s).then(|| self.flow_m_s.max(0.0))
    }

    /// Filament that the feed would have pushed without feedback so far `[m]`.
    pub(crate) fn fed_m(&self) -> f64 {
        self.fed_m
    }

    pub(crate) fn clear(&mut self) {
        *self = Self::new(self.lag.lag_s);
    }

    /// Follows the filament wanted since the last status, trims taken out again and the base's put in, behind the law of the
    /// outlet; behind its linear lag before there is one.
    pub(crate) fn on_status(
        &mut self,
        status: &PrinterStatus,
        (base_feed, jump_m): (f64, f64),
        law: Option<&StaticLaw>,
    ) {
        let (stamp_s, wanted_m) = (status.stamp.0, status.wanted_position_m);
        let before = self.before.replace((stamp_s, wanted_m));
        let Some((before_s, before_m)) = before else {
            self.since_s = stamp_s;
            return;
        };
        let (dt_s, moved_m) = (stamp_s - before_s, wanted_m - before_m);
        if dt_s <= 0.0 || moved_m.abs() > jump_m {
            self.flow_m_s = 0.0;
            self.since_s = stamp_s;
            return;
        }
        let feed_m_s = moved_m / dt_s / (status.trims.flow * status.trims.speed) * base_feed;
        self.fed_m += feed_m_s * dt_s;
        // below zero stands a stroke drawn back, not a flow: it does not decay
        self.flow_m_s = match law {
            Some(law) => law.flow_after(self.flow_m_s, feed_m_s, Seconds(dt_s), Seconds(self.lag.lag_s)),
            None if self.flow_m_s < 0.0 => self.flow_m_s + feed_m_s * dt_s / self.lag.lag_s,
            None => self.lag.step(self.flow_m_s, feed_m_s, Seconds(dt_s)),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::advance::tests::status;

    /// A steady feed that stops: a melt's law keeps the filament that a line would let out, and both follow the feed at last.
    #[test]
    fn it_follows_the_feed_behind_the_law_it_is_given() {
        let law = StaticLaw::of_compression(0.4, 1e-2, 0.436);
        let after = |feeds: &[(f64, u32)], law: Option<&StaticLaw>| {
            let mut nominal = Nominal::new(0.63);
            let (mut step, mut wanted_m) = (0, 0.0);
            for &(feed_m_s, steps) in feeds {
                for _ in 0..steps {
                    (step, wanted_m) = (step + 1, wanted_m + 0.02 * feed_m_s);
                    let status = PrinterStatus {
                        wanted_position_m: wanted_m,
                        ..status(0.02 * f64::from(step), feed_m_s)
                    };
                    nominal.on_status(&status, (1.0, 0.05), law);
                }
            }
            assert!((nominal.fed_m() - (wanted_m - 0.02 * feeds[0].0)).abs() < 1e-12);
            nominal.flow_m_s(5.0).unwrap()
        };
        for law in [None, Some(&law)] {
            assert!((after(&[(2e-3, 1000)], law) / 2e-3 - 1.0).abs() < 1e-6);
        }
        // 0.2 s of nothing: exp(-0.2 / 0.63) of the flow, or the slower fall of a steep law
        assert!((after(&[(2e-3, 1000), (0.0, 10)], None) / 2e-3 - 0.728).abs() < 1e-3);
        let expected = law.flow_after(2e-3, 0.0, Seconds(0.2), Seconds(0.63));
        assert!((after(&[(2e-3, 1000), (0.0, 10)], Some(&law)) / expected - 1.0).abs() < 1e-3);
    }
}
