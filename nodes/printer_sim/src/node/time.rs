//! Whose time the printer's stamps are of: its own, which all follow on `/clock`, or the host's, as a real printer has it.

use models::units::Seconds;
use runtime::{Clock, ClockDriver, Node, RuntimeError};
use std::time::Duration;
use tokio::time::{Interval, MissedTickBehavior, interval};

/// The time that stamps are of.
#[derive(Debug)]
pub(super) enum TimeBase {
    /// Simulated time, told on `/clock`.
    Simulated(Box<ClockDriver>),
    /// The host's clock, and what it showed when the simulation began.
    Host { clock: Clock, epoch: Seconds },
}

impl TimeBase {
    /// Takes `/clock` over, unless the host's clock is asked for.
    pub(super) fn of(node: &mut Node, host_clock: bool) -> Result<Self, RuntimeError> {
        Ok(match host_clock {
            false => Self::Simulated(Box::new(node.drive_clock()?)),
            true => Self::Host { clock: node.clock(), epoch: Seconds(0.0) },
        })
    }

    /// The simulation begins now, at `simulated`.
    pub(super) fn begin(&mut self, simulated: Seconds) {
        if let Self::Host { clock, epoch } = self {
            *epoch = clock.now() - simulated;
        }
    }

    /// What is added to simulated time.
    pub(super) fn epoch(&self) -> Seconds {
        match self {
            Self::Simulated(_) => Seconds(0.0),
            Self::Host { epoch, .. } => *epoch,
        }
    }

    /// Tells everyone the time, where it is nobody else's.
    pub(super) fn tell(&self, simulated: Seconds) {
        if let Self::Simulated(driver) = self {
            driver.set(simulated);
        }
    }

    /// Wall time of one look, `period_s` of simulated time. What was missed of simulated time is not made up for in a
    /// burst: the other nodes would see seconds pass in which they had no chance to act. The host's seconds pass anyhow.
    pub(super) fn pace(&self, period_s: f64, speed: f64) -> Interval {
        let mut pace = interval(Duration::from_secs_f64(period_s / speed));
        pace.set_missed_tick_behavior(match self {
            Self::Simulated(_) => MissedTickBehavior::Delay,
            Self::Host { .. } => MissedTickBehavior::Burst,
        });
        pace
    }
}
