//! What comes in, and what is refused.

use crate::advance::Prediction;
use models::motion::Segment;
use models::status::PrinterStatus;
use models::units::{Kelvin, Seconds};

/// What the controller needs of an estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Time of validity.
    pub stamp: Seconds,
    /// Nozzle temperature.
    pub nozzle: Kelvin,
    /// Outlet flow as filament speed `[m/s]`, 0 or more.
    pub flow_m_s: f64,
    /// Share of the motor's feed that is lost `[-]`.
    pub slip: f64,
    /// Road section over nominal section `[-]`, > 0.
    pub gain: f64,
    /// Slow mean of the slicer's feed `[m/s]`, > 0.
    pub reference_feed_m_s: f64,
    /// The encoder speaks: without it slip and flow are guesses.
    pub encoder_alive: bool,
    /// Widths come.
    pub width_alive: bool,
}

/// A move that is known before it begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coming {
    /// Its number from the start of the print, from 0.
    pub sequence: u64,
    /// When it begins on the slicer's own plan: where `PrinterStatus::path_time_s` reaches this it is under way.
    pub start: Seconds,
    /// What it does.
    pub segment: Segment,
}

/// What the controller reacts to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// A new estimate; a command follows at once.
    Estimate(Estimate),
    /// Status of the printer.
    Printer(PrinterStatus),
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
    },
    /// A word of the advance predictor.
    Prediction(Prediction),
    /// The period has passed: a plan is made.
    Tick {
        /// The node's time.
        now: Seconds,
    },
}

/// Inputs not used, by topic; `late` also counts what was too old to act on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Refused {
    /// NaN, infinite or impossible.
    pub invalid: u64,
    /// Out of order or too old.
    pub late: u64,
}

/// Refusals of every topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Refusals {
    /// Estimates.
    pub estimate: Refused,
    /// Printer status.
    pub printer: Refused,
    /// Encoder.
    pub encoder: Refused,
    /// Width.
    pub width: Refused,
    /// Words of the advance predictor.
    pub prediction: Refused,
    /// Ticks.
    pub tick: Refused,
}

impl Estimate {
    pub(crate) fn is_valid(&self) -> bool {
        let numbers =
            [self.stamp.0, self.nozzle.0, self.flow_m_s, self.slip, self.gain, self.reference_feed_m_s];
        numbers.iter().all(|number| number.is_finite())
            && self.nozzle.0 > 0.0
            && self.flow_m_s >= 0.0
            && self.gain > 0.0
            && self.reference_feed_m_s > 0.0
    }
}

pub(crate) fn is_valid(status: &PrinterStatus) -> bool {
    let trims = &status.trims;
    let numbers = [
        status.stamp.0,
        status.wanted_position_m,
        status.planned_feed_m_s,
        status.planned_speed_m_s,
        status.hotend_sliced_target.0,
        trims.flow,
        trims.speed,
        trims.setpoint_offset_k,
    ];
    let sizes = [status.target_width_m, status.layer_height_m];
    numbers.iter().all(|number| number.is_finite())
        && trims.flow > 0.0
        && trims.speed > 0.0
        && trims.slip.is_none_or(|slip| slip < 1.0)
        && sizes.into_iter().flatten().all(|size_m| size_m.is_finite() && size_m > 0.0)
}
