//! Flow of the slicer's own feed, calibrated, through the same lag: what the estimated flow is compared with (model book 1.7).

use models::extruder::LinearLag;
use models::status::PrinterStatus;
use models::units::Seconds;

/// Outlet flow that the feed would give without feedback.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nominal {
    lag: LinearLag,
    flow_m_s: f64,
    before: Option<(f64, f64)>,
    /// Since when the feed is followed without a gap `[s]`.
    since_s: f64,
}

impl Nominal {
    pub(crate) fn new(lag_s: f64) -> Self {
        Self { lag: LinearLag { lag_s }, flow_m_s: 0.0, before: None, since_s: f64::INFINITY }
    }

    /// Flow `[m/s]`, 0 or more; `None` until so many lags have passed that the start is forgotten.
    pub(crate) fn flow_m_s(&self, settle_lags: f64) -> Option<f64> {
        let (newest_s, _) = self.before?;
        (newest_s - self.since_s >= settle_lags * self.lag.lag_s).then(|| self.flow_m_s.max(0.0))
    }

    pub(crate) fn clear(&mut self) {
        *self = Self::new(self.lag.lag_s);
    }

    /// Follows the filament wanted since the last status, trims taken out again and the base's put in.
    pub(crate) fn on_status(&mut self, status: &PrinterStatus, base_feed: f64, jump_m: f64) {
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
        // below zero stands a stroke drawn back, not a flow: it does not decay
        self.flow_m_s = if self.flow_m_s < 0.0 {
            self.flow_m_s + feed_m_s * dt_s / self.lag.lag_s
        } else {
            self.lag.step(self.flow_m_s, feed_m_s, Seconds(dt_s))
        };
    }
}
