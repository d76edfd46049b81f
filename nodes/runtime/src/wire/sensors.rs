//! Sensor topics.

use super::{WireError, stamp_from_wire, within};
use fdm_loop_msgs::{BeadWidth, FilamentMotion, LayerHeight, Temperature};
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

/// A measured height of the wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeightReading {
    /// Time of the measurement.
    pub stamp: Seconds,
    /// Layer from 0.
    pub layer: u32,
    /// Place along the bead `[m]`.
    pub along_m: f64,
    /// Height of the wall above its base `[m]`.
    pub height_m: f64,
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
    within("speed_m_s", wire.speed_m_s, (-10.0, 10.0))?;
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

/// A height of the wall.
///
/// # Errors
/// [`WireError`] for a value that is not finite, a place beyond 1 km, a height beyond 10 m or a standard deviation of
/// nothing.
pub fn layer_height_from_wire(wire: &LayerHeight) -> Result<HeightReading, WireError> {
    Ok(HeightReading {
        stamp: stamp_from_wire(&wire.header)?,
        layer: wire.layer,
        along_m: within("along_m", wire.along_m, (0.0, 1e3))?,
        height_m: within("height_m", wire.height_m, (-10.0, 10.0))?,
        sigma_m: within("sigma_m", wire.sigma_m, (1e-9, 1.0))?,
    })
}
