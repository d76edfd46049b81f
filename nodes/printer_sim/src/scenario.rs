//! Scenario files (`config/scenarios/*.yaml`): which faults set in, when, how much.
//!
//! ```yaml
//! description: drive gear loses 9 % from the middle of the print on
//! faults:
//!   - component: extruder       # see `faults::Component`
//!     kind: slip                # see `faults::Kind` for the kinds, their units and ranges
//!     size: 0.09                # [-]
//!     onset: {filament_share: 0.5}   # share of the commanded filament [0, 1]; or {time_s: 120}
//!     ramp_s: 0                 # [s] from nothing to full size
//!     duration_s: 30            # [s] from the onset; leave out for good
//! ```

use crate::faults::{Component, Fault, Kind};
use check::{bounded, name_of, range};
use models::units::Seconds;
use serde::{Deserialize, Serialize};

mod check;
mod told;

pub use check::{COMPONENTS, FaultError, LONGEST_S, SHORTEST_S, Size, allowed_kinds, size_of};

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
    seed: Option<u64>,
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

/// How much, and how it comes and goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Course {
    /// How much, unit by kind; only kinds without a size may leave it out.
    pub size: Option<f64>,
    /// Time to grow from nothing to full size `[s]`.
    pub ramp_s: f64,
    /// How long it lasts from its onset `[s]`; `None` for good.
    pub duration_s: Option<f64>,
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

impl RawEntry {
    /// The size, which kinds that have one need, and no others take; 0 is none.
    fn size_within(&self, limits: (&'static str, f64, f64)) -> Result<f64, FaultError> {
        let kind = || name_of(&self.kind);
        let (unit, low, high) = limits;
        match (self.size, has_no_size(self.component, self.kind)) {
            (None, false) => Err(FaultError::NoSize { kind: kind(), unit, low, high }),
            (Some(size), true) if size != 0.0 => Err(FaultError::Sized { size, kind: kind() }),
            (size, true) => Ok(size.unwrap_or(0.0)),
            (Some(size), false) => bounded("size", size, limits),
        }
    }

    /// Refuses a course in time where there is none: a skip or a knock is a moment, and a part that came off stays off.
    fn check_course(&self) -> Result<(), FaultError> {
        let for_good = is_for_good(self.component, self.kind);
        let refused = |name| Err(FaultError::NoCourse { name, kind: name_of(&self.kind) });
        match self.duration_s {
            Some(_) if self.kind.at_once() || for_good => refused("duration_s"),
            _ if (self.kind.at_once() || for_good) && self.ramp_s != 0.0 => refused("ramp_s"),
            _ => Ok(()),
        }
    }
}

/// It is there or not: `Kind::Detached` has a size at a thermistor alone.
fn has_no_size(component: Component, kind: Kind) -> bool {
    kind.has_no_size() || is_for_good(component, kind)
}

/// What came off the bed stays off.
fn is_for_good(component: Component, kind: Kind) -> bool {
    (component, kind) == (Component::Part, Kind::Detached)
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
        let duration =
            raw.duration_s.map(|s| bounded("duration_s", s, ("s", SHORTEST_S, LONGEST_S))).transpose()?;
        let size = raw.size_within(range(raw.component, raw.kind)?)?;
        raw.check_course()?;
        Ok(Self {
            component: raw.component,
            kind: raw.kind,
            size,
            onset,
            ramp: Seconds(bounded("ramp_s", raw.ramp_s, ("s", 0.0, LONGEST_S))?),
            duration: duration.map(Seconds),
            seed: None,
        })
    }
}

impl Component {
    /// Its name in files and services.
    #[must_use]
    pub fn name(self) -> String {
        name_of(&self)
    }

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
    /// A fault with its course; sets in at `onset_s` of the simulation.
    ///
    /// # Errors
    /// [`FaultError`] for a kind that the component does not have, numbers out of range, and a size that is missing.
    pub fn at(component: Component, kind: Kind, course: Course, onset_s: f64) -> Result<Self, FaultError> {
        let Course { size, ramp_s, duration_s } = course;
        Self::try_from(RawEntry { component, kind, size, onset: Onset::TimeS(onset_s), ramp_s, duration_s })
    }

    /// A fault as the `inject_fault` service asks for it; sets in `start_s` after `now`.
    ///
    /// # Errors
    /// As [`Entry::at`], and for a `start_s` out of range.
    pub fn after(
        now: Seconds,
        (component, kind): (Component, Kind),
        course: Course,
        start_s: f64,
    ) -> Result<Self, FaultError> {
        let start_s = bounded("start_s", start_s, ("s", 0.0, LONGEST_S))?;
        let entry = Self::at(component, kind, course, start_s)?;
        Ok(Self { onset: Onset::TimeS(now.0 + start_s), ..entry })
    }

    /// The same with a seed for its random part alone, so that it can be had again in another run.
    ///
    /// # Errors
    /// [`FaultError::NoSeed`] for a kind in which nothing is random.
    pub fn seeded(self, seed: u64) -> Result<Self, FaultError> {
        if !self.kind.is_random() {
            return Err(FaultError::NoSeed { seed, kind: name_of(&self.kind) });
        }
        Ok(Self { seed: Some(seed), ..self })
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
            seed: self.seed,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(component: Component, kind: Kind, size: f64) -> Result<Entry, FaultError> {
        Entry::at(component, kind, course(size, None), 0.0)
    }

    fn course(size: f64, duration_s: Option<f64>) -> Course {
        Course { size: Some(size), ramp_s: 0.0, duration_s }
    }

    #[test]
    fn a_fault_of_another_component_is_refused_with_what_is_possible() {
        let error = entry(Component::Fan, Kind::RunOut, 0.0).unwrap_err();
        assert_eq!(error.to_string(), "kind = run_out: not a fault of fan; it can be gain");
    }

    #[test]
    fn sizes_out_of_range_and_not_a_number_are_refused() {
        let error = entry(Component::Extruder, Kind::Slip, 1.5).unwrap_err();
        assert_eq!(error.to_string(), "size = 1.5 (no unit): must be in [0, 0.95]");
        assert!(entry(Component::Extruder, Kind::Slip, f64::NAN).is_err());
    }

    /// Model book 1.12: lost steps, a knock and a part that came off, each with its unit and range.
    #[test]
    fn faults_of_motion_and_part_carry_metres_accelerations_and_nothing() {
        let refusal = |component, kind, size| entry(component, kind, size).unwrap_err().to_string();
        for kind in [Kind::LayerShiftX, Kind::LayerShiftY] {
            assert!(entry(Component::Motion, kind, -8e-4).is_ok());
            // 0.8 taken for metres by mistake is 80 cm.
            assert_eq!(refusal(Component::Motion, kind, 0.8), "size = 0.8 m: must be in [-0.05, 0.05]");
        }
        assert!(entry(Component::Motion, Kind::Knock, 45.0).is_ok());
        assert_eq!(refusal(Component::Motion, Kind::Knock, -1.0), "size = -1 m/s2: must be in [0, 200]");
        assert_eq!(
            refusal(Component::Extruder, Kind::Leak, 0.95),
            "size = 0.95 (no unit): must be in [0, 0.9]"
        );
        assert_eq!(
            refusal(Component::Part, Kind::Knock, 1.0),
            "kind = knock: not a fault of part; it can be detached"
        );
        let sized: Result<Entry, _> =
            serde_saphyr::from_str("{component: part, kind: detached, onset: {time_s: 1}}");
        assert!(sized.is_ok());
        let bare: Result<Entry, _> =
            serde_saphyr::from_str("{component: motion, kind: knock, onset: {time_s: 1}}");
        assert!(bare.is_err());
    }

    #[test]
    fn what_happens_in_a_moment_or_for_good_has_no_course_in_time() {
        let lasting =
            |component, kind, size| Entry::at(component, kind, course(size, Some(1.0)), 0.0).unwrap_err();
        for kind in [Kind::LayerShiftX, Kind::Knock] {
            let name = name_of(&kind);
            let error = lasting(Component::Motion, kind, 0.01);
            assert_eq!(error, FaultError::NoCourse { name: "duration_s", kind: name });
        }
        let error = lasting(Component::Part, Kind::Detached, 0.0);
        assert_eq!(error.to_string(), "duration_s: detached has none, leave it out");
        let half = course(0.5, Some(1.0));
        assert!(Entry::at(Component::HotendThermistor, Kind::Detached, half, 0.0).is_ok());
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
