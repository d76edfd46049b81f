//! Extruder loop for hosts that have none: what the melt lacks of filament, folded into the slip that is sent.
//!
//! A native host feeds `v/(1-ŝ) + k (L_cmd - L_enc)` at 100 Hz (model book 1.7). Other hosts only divide the feed by
//! one minus the slip, so they get the slip that gives the same feed at the mean feed `v̄`:
//! `1/(1 - s_eff) = 1/(1 - ŝ) + k p/v̄`. Pressure advance drives the motor forth and back: what is divided by
//! one minus the slip is the feed forth, several times of what is laid, and its mean is `v̄`.
//!
//! What was laid thin is past: only what the melt still lacks of its pressure, `p`, is made up for. All of the shortfall,
//! pushed into later roads, would make them fat. With the slip in force, `s_f`, and the melt's lag at this flow, `K`,
//! `p' = v̄ (1 - (1 - ŝ)/(1 - s_f)) - p/K`, corrected by what encoder and printer count, whose steps are
//! as large as what is looked for where roads are slow.
//!
//! Such hosts act late: `p` counts as it will be once a correction acts, with what is on its way (`pending`).

use crate::params::RawSlip;
use crate::pending::Pending;
use crate::shortfall::Shortfall;

/// Time over which the feed forth is averaged `[s]`: some ten strokes.
const FORTH_S: f64 = 5.0;

/// Most by which a slip is taken to be told wrong `[-]`.
const UNTOLD_MAX: f64 = 0.03;

/// When a slip is sent, and how long after the last one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sending {
    pub(crate) at_s: f64,
    pub(crate) dt_s: f64,
    /// Slow mean of the slicer's feed `[m/s]`.
    pub(crate) feed_m_s: f64,
    /// Lag of the melt at that feed `[s]`.
    pub(crate) lag_s: f64,
}

/// What the melt lacks since the loop closed.
#[derive(Debug, Clone)]
pub(crate) struct CatchUp {
    settings: RawSlip,
    pending: Pending,
    /// As counted, less what faded.
    counted: Shortfall,
    /// As believed `[m]`.
    lacks_m: f64,
    /// Slip beyond the one that is told, as the count shows in the long run.
    untold: f64,
    /// Slip in force, where it is told.
    in_force: Option<f64>,
    /// Mean feed forth `[m/s]`.
    forth_m_s: f64,
    /// Filament is fed.
    feeds: bool,
}

impl CatchUp {
    pub(crate) fn new(settings: RawSlip) -> Self {
        Self {
            settings,
            pending: Pending::new(),
            counted: Shortfall::new(settings),
            lacks_m: 0.0,
            untold: 0.0,
            in_force: None,
            forth_m_s: 0.0,
            feeds: false,
        }
    }

    /// Opens the loop; it closes again with the next pair.
    pub(crate) fn open(&mut self) {
        self.counted.open();
        (self.lacks_m, self.untold) = (0.0, 0.0);
        self.pending.clear();
    }

    /// What the melt lacks by the count `[m]`.
    pub(crate) fn shortfall_m(&self) -> f64 {
        self.counted.owed_m()
    }

    pub(crate) fn newest_sample_s(&self) -> Option<f64> {
        self.counted.newest_sample_s()
    }

    /// The slip that is in force, where the printer tells it.
    pub(crate) fn on_in_force(&mut self, stamp_s: f64, slip: Option<f64>) {
        self.in_force = slip;
        if let Some(slip) = slip {
            self.pending.on_in_force(stamp_s, slip);
        }
    }

    pub(crate) fn on_wanted(&mut self, stamp_s: f64, wanted_m: f64) {
        let Some((moved_m, dt_s)) = self.counted.on_wanted(stamp_s, wanted_m) else {
            self.open();
            return;
        };
        if dt_s > 0.0 {
            let share = 1.0 - (-dt_s / FORTH_S).exp();
            self.forth_m_s += share * (moved_m.max(0.0) / dt_s - self.forth_m_s);
            self.feeds = moved_m > 0.0;
        }
    }

    pub(crate) fn on_encoder(&mut self, stamp_s: f64, position_m: f64) {
        if self.counted.on_encoder(stamp_s, position_m) {
            self.open();
        }
    }

    /// Slip to send; what the limit cannot catch up is forgotten, so that nothing winds up.
    pub(crate) fn effective_slip(&mut self, slip: f64, sending: Sending) -> f64 {
        let settings = self.settings;
        if settings.serial_gain_1_s <= 0.0 {
            return slip.clamp(settings.low, settings.high);
        }
        let slip = (slip + self.untold).clamp(settings.low, settings.high);
        let feed_m_s = sending.feed_m_s.max(self.forth_m_s);
        let most_m = settings.serial_limit * feed_m_s / settings.serial_gain_1_s;
        self.follow(slip, feed_m_s, most_m, sending);
        let lacking_m = self.pending.lacking_m(self.lacks_m, (sending.at_s, slip), feed_m_s, sending.lag_s);
        let extra_m_s = settings.serial_gain_1_s * lacking_m.clamp(-most_m, most_m);
        let feed = 1.0 / (1.0 - slip) + extra_m_s / feed_m_s;
        let sent = (1.0 - 1.0 / feed).clamp(settings.low, settings.high);
        self.pending.send(sending.at_s, sent);
        sent
    }

    /// Carries on what the melt lacks, and corrects it by the count.
    fn follow(&mut self, slip: f64, feed_m_s: f64, most_m: f64, Sending { dt_s, lag_s, .. }: Sending) {
        let left = if self.feeds { (-dt_s / lag_s).exp() } else { 1.0 };
        let owed_m = self.counted.owed_m();
        let kept_m = (left * owed_m).clamp(-most_m, most_m);
        self.counted.forget(owed_m - kept_m);
        if !self.counted.is_closed() {
            (self.lacks_m, self.untold) = (0.0, 0.0);
            return;
        }
        if let (Some(in_force), true) = (self.in_force, self.feeds) {
            self.lacks_m += feed_m_s * (1.0 - (1.0 - slip) / (1.0 - in_force)) * dt_s;
        }
        self.lacks_m *= left;
        let share = 1.0 - (-dt_s / self.settings.serial_smooths_s).exp();
        let beyond_m = share * (kept_m - self.lacks_m);
        let lacks_m = self.lacks_m + beyond_m;
        self.lacks_m = lacks_m.clamp(-most_m, most_m);
        // what a limit cuts off tells of no slip
        if self.feeds && lacks_m.abs() < most_m && kept_m.abs() < most_m {
            let untold = self.untold + beyond_m / (feed_m_s * self.settings.serial_learns_s);
            self.untold = untold.clamp(-UNTOLD_MAX, UNTOLD_MAX);
        }
    }
}

#[cfg(test)]
mod tests;
