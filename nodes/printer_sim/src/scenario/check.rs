//! Which faults there are, and which numbers they may carry.

use models::params::with_unit;

use crate::faults::{Component, Kind};

/// Why a fault cannot be injected.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FaultError {
    /// There is no such component.
    #[error("component = {component}: there is none of this name; it can be {}", component_names())]
    UnknownComponent {
        /// Component asked for.
        component: String,
    },
    /// The component has no such fault.
    #[error("kind = {kind}: not a fault of {component}; it can be {allowed}")]
    Unknown {
        /// Component asked for.
        component: String,
        /// Kind asked for.
        kind: String,
        /// Kinds of that component.
        allowed: &'static str,
    },
    /// A kind that has a size came without.
    #[error("size: {kind} needs one in {}, see config/scenarios/README.md", with_unit(format!("[{low}, {high}]"), .unit))]
    NoSize {
        /// Kind asked for.
        kind: String,
        /// Unit.
        unit: &'static str,
        /// Smallest allowed.
        low: f64,
        /// Largest allowed.
        high: f64,
    },
    /// A size for a kind that has none.
    #[error("size = {size}: {kind} has none, it is there or not; leave it out")]
    Sized {
        /// Size asked for.
        size: f64,
        /// Kind asked for.
        kind: String,
    },
    /// A course in time for what happens in one moment or for good.
    #[error("{name}: {kind} has none, leave it out")]
    NoCourse {
        /// Field.
        name: &'static str,
        /// Kind asked for.
        kind: String,
    },
    /// A seed for what is the same with every seed.
    #[error("seed = {seed}: nothing of {kind} is random, leave it out (0); noise, spikes and loose take one")]
    NoSeed {
        /// Seed asked for.
        seed: u64,
        /// Kind asked for.
        kind: String,
    },
    /// A number outside its range.
    #[error("{name} = {}: must be in [{low}, {high}]", with_unit(.value, .unit))]
    OutOfRange {
        /// Field.
        name: &'static str,
        /// Value asked for.
        value: f64,
        /// Unit.
        unit: &'static str,
        /// Smallest allowed.
        low: f64,
        /// Largest allowed.
        high: f64,
    },
}

/// All of them, in the order of `config/scenarios/README.md`.
pub const COMPONENTS: [Component; 14] = [
    Component::Extruder,
    Component::Filament,
    Component::HotendHeater,
    Component::HotendThermistor,
    Component::BedHeater,
    Component::BedThermistor,
    Component::Encoder,
    Component::Imu,
    Component::Camera,
    Component::Fan,
    Component::StopInput,
    Component::Ambient,
    Component::Motion,
    Component::Part,
];

/// Shortest time for which a fault may be there `[s]`: a step of the simulation.
pub const SHORTEST_S: f64 = 1e-3;

/// Longest time that a fault's fields may name `[s]`: a week.
pub const LONGEST_S: f64 = 604_800.0;

/// Allowed sizes by fault: `(unit, low, high)`.
pub(super) fn range(component: Component, kind: Kind) -> Result<(&'static str, f64, f64), FaultError> {
    Ok(match (component, kind) {
        (Component::Extruder, Kind::Slip) => ("-", 0.0, 0.95),
        (Component::Extruder, Kind::Clog) => ("-", 0.05, 1.0),
        (Component::Extruder, Kind::Leak) => ("-", 0.0, 0.9),
        (Component::Motion, Kind::LayerShiftX | Kind::LayerShiftY) => ("m", -0.05, 0.05),
        (Component::Motion, Kind::Knock) => ("m/s2", 0.0, 200.0),
        (Component::Filament, Kind::Diameter) => ("-", -0.1, 0.1),
        (Component::HotendHeater | Component::BedHeater | Component::Fan, Kind::Gain)
        | (Component::HotendThermistor | Component::BedThermistor, Kind::Detached) => ("-", 0.0, 1.0),
        (Component::HotendThermistor | Component::BedThermistor, Kind::Bias) => ("K", -300.0, 300.0),
        (Component::HotendThermistor | Component::BedThermistor, Kind::Noise) => ("-", 1.0, 100.0),
        (Component::HotendThermistor | Component::BedThermistor, Kind::Spikes) => ("-", 0.0, 0.5),
        (Component::HotendThermistor | Component::BedThermistor, Kind::Loose) => ("-", 0.0, 0.95),
        (Component::Ambient, Kind::Draught) => ("K", -30.0, 30.0),
        (Component::Filament, Kind::RunOut)
        | (Component::Part, Kind::Detached)
        | (Component::HotendHeater | Component::BedHeater, Kind::StuckOn)
        | (Component::StopInput, Kind::Pressed)
        | (Component::Encoder | Component::Imu | Component::Camera, Kind::Off | Kind::Stuck)
        | (Component::HotendThermistor | Component::BedThermistor, Kind::Open | Kind::Short | Kind::Stuck) => {
            ("-", 0.0, 1.0)
        }
        _ => {
            return Err(FaultError::Unknown {
                component: name_of(&component),
                kind: name_of(&kind),
                allowed: allowed_kinds(component),
            });
        }
    })
}

/// Unit and range of a size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Size {
    /// Unit, `-` for none.
    pub unit: &'static str,
    /// Smallest allowed.
    pub low: f64,
    /// Largest allowed.
    pub high: f64,
}

/// Unit and range of the size of a fault; `None` where it has no size, or the component no such fault.
#[must_use]
pub fn size_of(component: Component, kind: Kind) -> Option<Size> {
    let sized = !super::has_no_size(component, kind);
    range(component, kind).ok().filter(|_| sized).map(|(unit, low, high)| Size { unit, low, high })
}

/// Names of all components, for people.
fn component_names() -> String {
    COMPONENTS.iter().map(name_of).collect::<Vec<_>>().join(", ")
}

/// Names of the kinds of a component.
#[must_use]
pub fn allowed_kinds(component: Component) -> &'static str {
    match component {
        Component::Extruder => "slip, clog, leak",
        Component::Filament => "diameter, run_out",
        Component::HotendHeater | Component::BedHeater => "gain, stuck_on",
        Component::HotendThermistor | Component::BedThermistor => {
            "open, short, detached, stuck, bias, noise, spikes, loose"
        }
        Component::Encoder | Component::Imu | Component::Camera => "off, stuck",
        Component::StopInput => "pressed",
        Component::Fan => "gain",
        Component::Ambient => "draught",
        Component::Motion => "layer_shift_x, layer_shift_y, knock",
        Component::Part => "detached",
    }
}

/// Name of a component or kind in files and services.
pub(super) fn name_of<T: std::fmt::Debug>(value: &T) -> String {
    let mut name = String::new();
    for letter in format!("{value:?}").chars() {
        if letter.is_uppercase() && !name.is_empty() {
            name.push('_');
        }
        name.extend(letter.to_lowercase());
    }
    name
}

pub(super) fn bounded(
    name: &'static str,
    value: f64,
    (unit, low, high): (&'static str, f64, f64),
) -> Result<f64, FaultError> {
    if (low..=high).contains(&value) {
        Ok(value)
    } else {
        Err(FaultError::OutOfRange { name, value, unit, low, high })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{Course, Entry};

    fn entry(component: Component, kind: Kind, size: Option<f64>) -> Result<Entry, FaultError> {
        Entry::at(component, kind, Course { size, ramp_s: 0.0, duration_s: None }, 0.0)
    }

    #[test]
    fn a_sensor_is_off_or_stuck_and_nothing_else() {
        for component in [Component::Encoder, Component::Imu, Component::Camera] {
            assert!([Kind::Off, Kind::Stuck].iter().all(|kind| entry(component, *kind, None).is_ok()));
            let told = format!("kind = noise: not a fault of {}; it can be off, stuck", component.name());
            assert_eq!(entry(component, Kind::Noise, Some(2.0)).unwrap_err().to_string(), told);
            let error = entry(component, Kind::Off, Some(2.0)).unwrap_err();
            assert_eq!(error.to_string(), "size = 2: off has none, it is there or not; leave it out");
        }
    }
}
