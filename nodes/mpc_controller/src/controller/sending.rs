//! What is sent: the plan's moves about the base, as trims of the printer.

use super::Controller;
use crate::catch_up::Sending;
use crate::input::Estimate;
use crate::params::Level;
use crate::qp::{Move, input};
use models::command::Trims;
use models::status::{HostProfile, JobPhase, PrinterStatus};

impl Controller {
    pub(super) fn trims(&mut self, status: &PrinterStatus, estimate: &Estimate, dt_s: f64) -> Trims {
        let printing = !matches!(status.phase, JobPhase::Idle | JobPhase::Done | JobPhase::Failed);
        if self.params.control == Level::Off || !printing {
            return Trims::NEUTRAL;
        }
        let slip = self.slip(status, estimate, dt_s);
        let setpoint_offset_k =
            if self.params.control == Level::Mpc { self.held[input::SETPOINT] } else { 0.0 };
        let (flow, speed) = self.scheduled();
        Trims {
            flow,
            speed,
            setpoint_offset_k,
            advance_s: self.advance.command(estimate.stamp.0, status, self.printer.material.lag_s),
            slip,
        }
    }

    /// Flow over path and speed of the plan, as trims have them.
    pub(super) fn scheduled(&self) -> (f64, f64) {
        if self.params.control != Level::Mpc {
            return (1.0, 1.0);
        }
        let [feed, speed, _] = self.held;
        let most = self.params.limits.feed;
        // The move is feed over time, the printer's trim is feed over path. Slow and fed high at once, the quotient
        // would leave the range that the supervisor lets through (K6).
        let path = (1.0 + speed) * self.slowing.factor();
        let flow = self.base.feed() * (1.0 + feed) / path;
        let (slowest, fastest) = (1.0 + self.params.limits.speed_low, 1.0 + self.params.limits.speed_high);
        (flow.clamp(1.0 - most, 1.0 + most), path.clamp(slowest, fastest))
    }

    fn slip(&mut self, status: &PrinterStatus, estimate: &Estimate, dt_s: f64) -> Option<f64> {
        let within_reach = estimate.slip.clamp(self.params.slip.low, self.params.slip.high);
        if !estimate.encoder_alive {
            self.catch_up.open();
            self.balance.open();
            // A loop on an encoder that fell silent would push on and on: only where there is none is nothing closed by this.
            // Widths put down to a slip below none what is a thick spool's.
            let told = !self.params.slip.encoder_fitted && estimate.width_alive;
            return told.then_some(within_reach.max(0.0));
        }
        Some(match status.host {
            HostProfile::Native => within_reach,
            HostProfile::Serial | HostProfile::Moonraker | HostProfile::Octoprint => {
                let feed_m_s = estimate.reference_feed_m_s;
                let law = self.outlet_law(estimate, feed_m_s);
                let lag_s = law.map_or(self.printer.material.lag_s, |law| law.lag_s(feed_m_s));
                let sending = Sending { at_s: estimate.stamp.0, dt_s, feed_m_s, lag_s };
                self.catch_up.effective_slip(estimate.slip, sending)
            }
        })
    }
}

/// Feed over time about the base's, speed and offset of trims in force.
pub(super) fn moves_of(trims: &Trims, base_feed: f64) -> Move {
    [trims.flow * trims.speed / base_feed - 1.0, trims.speed - 1.0, trims.setpoint_offset_k]
}
