//! Sensor topics.

use super::{WireError, finite, stamp_from_wire, within};
use fdm_loop_msgs::{BeadWidth, FilamentMotion, Temperature};
use models::units::{Celsius, Seconds};

/// A position of the filament.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilamentPosition {
    /// Time of the reading.
    pub stamp: Seconds,
    /// Filament past the wheel since start `[m]`.
    pub position_m: f64,
}

/// A measured width of the road.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WidthReading {
    /// Time of exposure.
    pub exposed: Seconds,
    /// Width `[m]`.
    pub width_m: f64,
    /// Its standard deviation `[m]`.
    pub sigma_m: f64,
}

/// A temperature: stamp and value.
///
/// # Errors
/// [`WireError`] for a value that is not finite or below absolute zero.
pub fn temperature_from_wire(wire: &Temperature) -> Result<(Seconds, Celsius), WireError> {
    let value = within("temperature", wire.temperature, (-273.15, 2000.0))?;
    Ok((stamp_from_wire(&wire.header)?, Celsius(value)))
}

/// A filament position.
///
/// # Errors
/// [`WireError`] for a value that is not finite.
pub fn filament_from_wire(wire: &FilamentMotion) -> Result<FilamentPosition, WireError> {
    finite("speed_m_s", wire.speed_m_s)?;
    Ok(FilamentPosition {
        stamp: stamp_from_wire(&wire.header)?,
        position_m: within("position_m", wire.position_m, (-1e4, 1e6))?,
    })
}

/// A width of the road.
///
/// # Errors
/// [`WireError`] for a value that is not finite, a width beyond 0.1 m or a standard deviation of nothing.
pub fn bead_width_from_wire(wire: &BeadWidth) -> Result<WidthReading, WireError> {
    Ok(WidthReading {
        exposed: stamp_from_wire(&wire.header)?,
        width_m: within("width_m", wire.width_m, (0.0, 0.1))?,
        sigma_m: within("sigma_m", wire.sigma_m, (1e-9, 0.1))?,
    })
}
