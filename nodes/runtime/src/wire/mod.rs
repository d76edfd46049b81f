//! Between the wire and the types that nodes share: one reader of every message, one list of reasons to refuse it.
//!
//! A reader checks what is true of a message in any node: every float finite, every enum known, every value in the
//! range that the `.msg` file states. What a node demands beyond that (age, order, plausibility) its brain checks.

mod command;
mod estimate;
mod imu;
mod motion;
mod schedule;
mod sensors;
mod status;
mod vision;

pub use command::{
    command_from_wire, command_to_wire, control_health_from_wire, permit_from_wire, permit_to_wire,
};
pub use estimate::{CHANNELS, STATES, StateReading, estimate_from_wire};
pub use imu::{ImuReading, imu_from_wire, imu_to_wire};
pub use motion::{PlannedMove, motion_from_wire, motion_to_wire};
pub use schedule::{schedule_from_wire, schedule_to_wire};
pub use sensors::{
    FilamentPosition, HeightReading, WidthReading, bead_width_from_wire, filament_from_wire,
    layer_height_from_wire, temperature_from_wire,
};
pub use status::{status_from_wire, status_to_wire};
pub use vision::{
    DefectReading, FRAME_BYTES_MAX, JpegFrame, defects_from_wire, frame_from_wire, frame_to_wire,
};

use fdm_loop_msgs::Header;
use models::units::Seconds;

/// Why a message is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WireError {
    /// A float is NaN or infinite.
    #[error("{field} is not finite")]
    NotFinite {
        /// Field of the message.
        field: &'static str,
    },
    /// A value outside the range of its definition.
    #[error("{field} = {value}: must be in [{low}, {high}]")]
    OutOfRange {
        /// Field of the message.
        field: &'static str,
        /// Refused value.
        value: f64,
        /// Smallest allowed.
        low: f64,
        /// Largest allowed.
        high: f64,
    },
    /// A stamp that is no time.
    #[error("stamp has {nanosec} ns, which is no fraction of a second")]
    Stamp {
        /// Nanoseconds of the stamp.
        nanosec: u32,
    },
    /// A named part is not there, or an array has not the length that belongs to its names.
    #[error("{field} is missing or of a wrong length")]
    Missing {
        /// Field of the message, or name inside of it.
        field: &'static str,
    },
}

/// A finite value inside `[low, high]`.
fn within(field: &'static str, value: f64, (low, high): (f64, f64)) -> Result<f64, WireError> {
    if !value.is_finite() {
        Err(WireError::NotFinite { field })
    } else if (low..=high).contains(&value) {
        Ok(value)
    } else {
        Err(WireError::OutOfRange { field, value, low, high })
    }
}

/// A finite value.
fn finite(field: &'static str, value: f64) -> Result<f64, WireError> {
    within(field, value, (f64::MIN, f64::MAX))
}

/// A value that counts only where its flag is set.
fn optional(
    known: bool,
    field: &'static str,
    value: f64,
    range: (f64, f64),
) -> Result<Option<f64>, WireError> {
    known.then(|| within(field, value, range)).transpose()
}

/// The stamp of a header on the node's clock.
///
/// # Errors
/// [`WireError::Stamp`] where the nanoseconds are a second or more.
pub fn stamp_from_wire(header: &Header) -> Result<Seconds, WireError> {
    let stamp = header.stamp.seconds().ok_or(WireError::Stamp { nanosec: header.stamp.nanosec })?;
    Ok(Seconds(stamp))
}
