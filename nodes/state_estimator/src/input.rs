//! What comes in, and what is refused.

use models::status::PrinterStatus;
use models::units::{Celsius, Seconds};

/// What the estimator reacts to.
#[expect(clippy::large_enum_variant, reason = "an event is passed by value once and never stored")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// Reading of the block thermistor.
    Hotend {
        /// Time of the sample.
        stamp: Seconds,
        /// Reading.
        temp: Celsius,
    },
    /// Reading of the sensor in the nozzle.
    Nozzle {
        /// Time of the sample.
        stamp: Seconds,
        /// Reading.
        temp: Celsius,
    },
    /// Position of the filament encoder.
    Encoder {
        /// Time of the sample.
        stamp: Seconds,
        /// Filament past the wheel since start `[m]`.
        position_m: f64,
    },
    /// Width of the road behind the nozzle.
    Width {
        /// Time of exposure.
        exposed: Seconds,
        /// Measured width `[m]`.
        width_m: f64,
        /// Its standard deviation `[m]`.
        sigma_m: f64,
    },
    /// Status of the printer.
    Printer(PrinterStatus),
    /// The period has passed.
    Tick {
        /// The node's time.
        now: Seconds,
    },
}

/// Samples of one topic that were not used, by reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Refused {
    /// NaN or infinite.
    pub not_finite: u64,
    /// Outside the credible range, or stamped ahead of the clock.
    pub out_of_range: u64,
    /// Older than the channel's limit when it came in.
    pub stale: u64,
    /// Not later than the sample before.
    pub disordered: u64,
}

/// Refused samples of every topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Refusals {
    /// Thermistor.
    pub hotend: Refused,
    /// Sensor in the nozzle.
    pub nozzle: Refused,
    /// Encoder.
    pub encoder: Refused,
    /// Width.
    pub width: Refused,
    /// Printer status.
    pub printer: Refused,
    /// Ticks that did not move forward.
    pub tick: Refused,
}

/// Why a sample is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Reason {
    NotFinite,
    OutOfRange,
    Stale,
    Disordered,
}

impl Refused {
    pub(crate) fn count(&mut self, reason: Reason) {
        *match reason {
            Reason::NotFinite => &mut self.not_finite,
            Reason::OutOfRange => &mut self.out_of_range,
            Reason::Stale => &mut self.stale,
            Reason::Disordered => &mut self.disordered,
        } += 1;
    }
}

/// Age limits of a stamp.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ages {
    /// Newest tick, if there was one.
    pub(crate) now_s: Option<f64>,
    pub(crate) lead_s: f64,
    pub(crate) limit_s: f64,
    /// Stamp of the sample before.
    pub(crate) before_s: Option<f64>,
}

impl Ages {
    pub(crate) fn check(&self, stamp: Seconds) -> Result<f64, Reason> {
        let stamp_s = finite(stamp.0)?;
        if let Some(now_s) = self.now_s {
            if stamp_s > now_s + self.lead_s {
                return Err(Reason::OutOfRange);
            }
            if stamp_s < now_s - self.limit_s {
                return Err(Reason::Stale);
            }
        }
        if self.before_s.is_some_and(|before_s| stamp_s <= before_s) {
            return Err(Reason::Disordered);
        }
        Ok(stamp_s)
    }
}

pub(crate) fn finite(value: f64) -> Result<f64, Reason> {
    if value.is_finite() { Ok(value) } else { Err(Reason::NotFinite) }
}

pub(crate) fn within(value: f64, (low, high): (f64, f64)) -> Result<f64, Reason> {
    let value = finite(value)?;
    if (low..=high).contains(&value) { Ok(value) } else { Err(Reason::OutOfRange) }
}

/// Refuses a status of which a used field is not finite or not possible.
pub(crate) fn check_status(status: &PrinterStatus) -> Result<(), Reason> {
    finite(status.motor_position_m)?;
    finite(status.planned_feed_m_s)?;
    finite(status.position_m[0])?;
    finite(status.position_m[1])?;
    within(status.path_speed_m_s, (0.0, f64::MAX))?;
    within(status.hotend_duty, (0.0, 1.0))?;
    within(status.fan, (0.0, 1.0))?;
    if let Some(speed_1_s) = status.part_fan_speed_1_s {
        within(speed_1_s, (0.0, f64::MAX))?;
    }
    if let Some(height_m) = status.layer_height_m {
        within(height_m, (f64::MIN_POSITIVE, f64::MAX))?;
    }
    Ok(())
}
