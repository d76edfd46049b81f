//! Newtypes of public signatures. Inside the maths values are bare `f64` with the unit in the name.

use serde::{Deserialize, Serialize};

/// Offset between the Celsius and the Kelvin scale `[K]`.
pub const ZERO_CELSIUS_K: f64 = 273.15;

/// A time or a span on the node's clock `[s]`.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Seconds(pub f64);

/// A temperature on the Celsius scale `[degC]`: topics and printer hosts speak it.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Celsius(pub f64);

/// An absolute temperature `[K]`: the physics speaks it.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Kelvin(pub f64);

impl From<Celsius> for Kelvin {
    fn from(temp: Celsius) -> Self {
        Self(temp.0 + ZERO_CELSIUS_K)
    }
}

impl From<Kelvin> for Celsius {
    fn from(temp: Kelvin) -> Self {
        Self(temp.0 - ZERO_CELSIUS_K)
    }
}

impl std::ops::Add for Seconds {
    type Output = Self;
    fn add(self, rhs: Self) -> Self {
        Self(self.0 + rhs.0)
    }
}

impl std::ops::Sub for Seconds {
    type Output = Self;
    fn sub(self, rhs: Self) -> Self {
        Self(self.0 - rhs.0)
    }
}
