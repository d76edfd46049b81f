//! Scenario files (`config/scenarios/*.yaml`): which faults set in, when, how much.
//!
//! ```yaml
//! description: drive gear loses 9 % from the middle of the print on
//! faults:
//!   - component: extruder       # extruder | filament | hotend_heater | hotend_thermistor | fan | ambient
//!     kind: slip                # see `faults::Kind` for the kinds, their units and ranges
//!     size: 0.09                # [-]
//!     onset: {filament_share: 0.5}   # share of the commanded filament [0, 1]; or {time_s: 120}
//!     ramp_s: 0                 # [s] from nothing to full size
//!     duration_s: 30            # [s] from the onset; leave out for good
//! ```

use crate::faults::{Component, Fault, Kind};
use models::units::Seconds;
use serde::{Deserialize, Serialize};

/// Faults of one run.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// One sentence for people.
    pub description: String,
    /// The faults, in any order.
    #[serde(default)]
    pub faults: Vec<Entry>,
}

/// One fault as written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawEntry")]
pub struct Entry {
    component: Component,
    kind: Kind,
    size: f64,
    onset: Onset,
    ramp: Seconds,
    duration: Option<Seconds>,
}

/// When a fault sets in.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Onset {
    /// At this share of the filament that the file commands `[0, 1]`.
    FilamentShare(f64),
    /// At this time of the simulation `[s]`.
    TimeS(f64),
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawEntry {
    component: Component,
    kind: Kind,
    size: Option<f64>,
    onset: Onset,
    #[serde(default)]
    ramp_s: f64,
    duration_s: Option<f64>,
}

/// Why a fault cannot be injected.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FaultError {
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
    #[error("size: {kind} needs one, see config/scenarios/README.md")]
    NoSize {
        /// Kind asked for.
        kind: String,
    },
    /// A number outside its range.
    #[error("{name} = {value} {unit}: must be in [{low}, {high}]")]
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

/// Longest time that a fault's fields may name `[s]`: a week.
const LONGEST_S: f64 = 604_800.0;

/// Allowed sizes by fault: `(unit, low, high)`.
fn range(component: Component, kind: Kind) -> Result<(&'static str, f64, f64), FaultError> {
    Ok(match (component, kind) {
        (Component::Extruder, Kind::Slip) => ("-", 0.0, 0.95),
        (Component::Extruder, Kind::Clog) => ("-", 0.05, 1.0),
        (Component::Filament, Kind::Diameter) => ("-", -0.1, 0.1),
        (Component::HotendHeater | Component::Fan, Kind::Gain)
        | (Component::HotendThermistor, Kind::Detached) => ("-", 0.0, 1.0),
        (Component::HotendThermistor, Kind::Bias) => ("K", -300.0, 300.0),
        (Component::Ambient, Kind::Draught) => ("K", -30.0, 30.0),
        (Component::Filament, Kind::RunOut)
        | (Component::HotendHeater, Kind::StuckOn)
        | (Component::HotendThermistor, Kind::Open | Kind::Short | Kind::Stuck) => ("-", 0.0, 1.0),
        _ => {
            return Err(FaultError::Unknown {
                component: name_of(&component),
                kind: name_of(&kind),
                allowed: allowed_kinds(component),
            });
        }
    })
}

/// Names of the kinds of a component.
pub(crate) fn allowed_kinds(component: Component) -> &'static str {
    match component {
        Component::Extruder => "slip, clog",
        Component::Filament => "diameter, run_out",
        Component::HotendHeater => "gain, stuck_on",
        Component::HotendThermistor => "open, short, detached, stuck, bias",
        Component::Fan => "gain",
        Component::Ambient => "draught",
    }
}

fn name_of<T: std::fmt::Debug>(value: &T) -> String {
    let mut name = String::new();
    for letter in format!("{value:?}").chars() {
        if letter.is_uppercase() && !name.is_empty() {
            name.push('_');
        }
        name.extend(letter.to_lowercase());
    }
    name
}

fn bounded(
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

impl RawEntry {
    /// The size, which only kinds without one may leave out.
    fn size_or_none(&self) -> Result<f64, FaultError> {
        let without =
            matches!(self.kind, Kind::RunOut | Kind::StuckOn | Kind::Open | Kind::Short | Kind::Stuck);
        self.size.or(without.then_some(0.0)).ok_or_else(|| FaultError::NoSize { kind: name_of(&self.kind) })
    }
}

impl TryFrom<RawEntry> for Entry {
    type Error = FaultError;
    fn try_from(raw: RawEntry) -> Result<Self, FaultError> {
        let onset = match raw.onset {
            Onset::FilamentShare(share) => {
                Onset::FilamentShare(bounded("filament_share", share, ("-", 0.0, 1.0))?)
            }
            Onset::TimeS(time_s) => Onset::TimeS(bounded("time_s", time_s, ("s", 0.0, LONGEST_S))?),
        };
        let duration = raw.duration_s.map(|s| bounded("duration_s", s, ("s", 0.0, LONGEST_S))).transpose()?;
        Ok(Self {
            component: raw.component,
            kind: raw.kind,
            size: bounded("size", raw.size_or_none()?, range(raw.component, raw.kind)?)?,
            onset,
            ramp: Seconds(bounded("ramp_s", raw.ramp_s, ("s", 0.0, LONGEST_S))?),
            duration: duration.map(Seconds),
        })
    }
}

impl Component {
    /// From its name in files and services.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::deserialize(serde::de::value::StrDeserializer::<serde::de::value::Error>::new(name)).ok()
    }
}

impl Kind {
    /// From its name in files and services.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::deserialize(serde::de::value::StrDeserializer::<serde::de::value::Error>::new(name)).ok()
    }
}

impl Entry {
    /// A fault by name, as the `inject_fault` service asks for it; sets in at `onset_s` of the simulation.
    ///
    /// # Errors
    /// [`FaultError`] for a kind that the component does not have and for numbers out of range.
    pub fn new(
        (component, kind): (Component, Kind),
        size: f64,
        onset_s: f64,
        duration_s: Option<f64>,
    ) -> Result<Self, FaultError> {
        Self::try_from(RawEntry {
            component,
            kind,
            size: Some(size),
            onset: Onset::TimeS(onset_s),
            ramp_s: 0.0,
            duration_s,
        })
    }

    /// The fault, if its onset has come.
    #[must_use]
    pub fn due(&self, now: Seconds, filament_share: f64) -> Option<Fault> {
        let due = match self.onset {
            Onset::FilamentShare(share) => filament_share >= share,
            Onset::TimeS(time_s) => now.0 >= time_s,
        };
        due.then_some(Fault {
            component: self.component,
            kind: self.kind,
            size: self.size,
            ramp: self.ramp,
            duration: self.duration,
            onset: now,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(component: Component, kind: Kind, size: f64) -> Result<Entry, FaultError> {
        Entry::new((component, kind), size, 0.0, None)
    }

    #[test]
    fn a_fault_of_another_component_is_refused_with_what_is_possible() {
        let error = entry(Component::Fan, Kind::RunOut, 0.0).unwrap_err();
        assert_eq!(error.to_string(), "kind = run_out: not a fault of fan; it can be gain");
    }

    #[test]
    fn sizes_out_of_range_and_not_a_number_are_refused() {
        let error = entry(Component::Extruder, Kind::Slip, 1.5).unwrap_err();
        assert_eq!(error.to_string(), "size = 1.5 -: must be in [0, 0.95]");
        assert!(entry(Component::Extruder, Kind::Slip, f64::NAN).is_err());
    }

    #[test]
    fn the_share_of_filament_triggers_the_onset() {
        let raw = RawEntry {
            component: Component::Extruder,
            kind: Kind::Slip,
            size: Some(0.09),
            onset: Onset::FilamentShare(0.5),
            ramp_s: 0.0,
            duration_s: None,
        };
        let entry = Entry::try_from(raw).unwrap();
        assert!(entry.due(Seconds(100.0), 0.499).is_none());
        let fault = entry.due(Seconds(101.0), 0.5).unwrap();
        assert_eq!(fault.onset, Seconds(101.0));
    }
}
