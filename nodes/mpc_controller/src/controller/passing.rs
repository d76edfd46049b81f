//! A dip of the flow that passes by itself: whether there is one, and the path's speed while it passes.

use super::Controller;
use crate::input::Estimate;
use crate::params::Level;
use crate::roads::Road;
use models::units::Seconds;

impl Controller {
    /// Whether a frame, while the encoder speaks, is of a flow that comes back by itself, or of its rest. On a road that has not
    /// been steady for long a large error counts alone, and none where a nozzle has narrowed beyond what the laws follow: its
    /// widths are off behind each change of speed, and a path that followed them would swing. So are those of corners that
    /// are not planned.
    pub(super) fn sees_dip(&mut self, exposed: Seconds, (road, steady): (&Road, bool), error: f64) -> bool {
        let told = steady || road.is_settled(&self.params.clog) && !self.clog.is_beyond();
        let vouched = self.estimate.is_some_and(|estimate| estimate.encoder_alive);
        let trims = &self.params.trims;
        let bound = if steady { trims.transient } else { trims.transient.max(trims.transient_settled) };
        if !(told && vouched && self.is_transient(exposed.0, error - self.spool_error(), bound)) {
            return false;
        }
        if self.plans_corners() {
            let (least, band) = (self.params.trims.transient_slowed, &self.params.deadband);
            self.slowing.on_section(exposed.0, road.section() * error, least, band);
        }
        true
    }

    /// Whether roads at corners keep their section, so that a thin one tells of a dip.
    fn plans_corners(&self) -> bool {
        let executes = self.status.is_some_and(|status| status.host.executes_schedules());
        executes && self.params.advance.source.plans_corners()
    }

    /// What the roads are off by since the spool is not known yet: no dip `[-]`.
    fn spool_error(&self) -> f64 {
        let estimate = self.estimate.filter(|_| self.base.is_new());
        estimate.map_or(0.0, |estimate| estimate.gain * self.base.feed() - 1.0)
    }

    /// Whether a width error beyond `bound` is of a flow that comes back by itself, or its rest is.
    fn is_transient(&mut self, at_s: f64, error: f64, bound: f64) -> bool {
        if error.abs() > bound {
            self.transient.on_error(at_s, error, self.fade_s());
        }
        self.passes(at_s)
    }

    /// Whether a dip has not passed yet.
    pub(super) fn passes(&self, at_s: f64) -> bool {
        self.transient.rest(at_s, self.fade_s()).max(self.clog.rest(at_s)) > self.params.deadband.start
    }

    /// Moves the path's speed towards what gives a road its section while a dip of the flow passes, at the same feed over
    /// time: within the limits of speed and flow, by their rates. Once nobody vouches for the feed any more, back it goes.
    pub(super) fn slow_down(&mut self, estimate: &Estimate, dt_s: f64) {
        if self.params.control != Level::Mpc {
            self.slowing.forget();
            return;
        }
        let (limits, [feed, speed, _]) = (&self.params.limits, self.held);
        let flow = self.base.feed() * (1.0 + feed) / (1.0 + speed);
        let low = ((1.0 + limits.speed_low) / (1.0 + speed)).max(flow / (1.0 + limits.feed)) - 1.0;
        let high = ((1.0 + limits.speed_high) / (1.0 + speed)).min(flow / (1.0 - limits.feed)) - 1.0;
        let most = limits.speed_rate * (dt_s / self.params.period_s).clamp(0.0, 1.0);
        let share = if estimate.encoder_alive { self.params.trims.transient_speed } else { 0.0 };
        self.slowing.advance(estimate.stamp.0, (self.fade_s().max(1e-3), share), ((low, high), most), speed);
    }

    pub(super) fn fade_s(&self) -> f64 {
        self.params.trims.transient_lags * self.printer.material.lag_s
    }
}
