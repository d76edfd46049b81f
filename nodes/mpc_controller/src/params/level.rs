//! What is corrected, by its name in the file.

use serde::Deserialize;
use serde::de::{self, Deserializer, Unexpected, Visitor};
use std::fmt;

/// What is corrected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Nothing: the slicer's own values.
    Off,
    /// Slip and pressure advance.
    Encoder,
    /// Feed, speed and set-point too.
    Mpc,
}

/// Names of the levels.
const NAMES: [&str; 3] = ["off", "encoder", "mpc"];

/// YAML 1.1, which ROS parameter files are written in, reads a bare `off` as the boolean false: both are [`Level::Off`].
impl<'de> Deserialize<'de> for Level {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Named)
    }
}

struct Named;

impl Visitor<'_> for Named {
    type Value = Level;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("off, encoder or mpc")
    }

    fn visit_bool<E: de::Error>(self, value: bool) -> Result<Level, E> {
        if value { Err(E::invalid_type(Unexpected::Bool(value), &self)) } else { Ok(Level::Off) }
    }

    fn visit_str<E: de::Error>(self, value: &str) -> Result<Level, E> {
        match value {
            "off" => Ok(Level::Off),
            "encoder" => Ok(Level::Encoder),
            "mpc" => Ok(Level::Mpc),
            _ => Err(E::unknown_variant(value, &NAMES)),
        }
    }
}
