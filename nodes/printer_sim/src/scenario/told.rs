//! A fault in words, for answers, logs and events.

use super::check::{Size, name_of, size_of};
use super::{Entry, Onset};
use crate::faults::{Component, Kind};
use models::params::with_unit;
use std::fmt;

/// Component and kind, size, onset, growth and duration, each with its unit, and a seed of its own.
impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { component, kind, size, onset, ramp, duration, seed } = self;
        write!(f, "{} {}", name_of(component), name_of(kind))?;
        if let Some(Size { unit, .. }) = size_of(*component, *kind) {
            write!(f, ", size {}", with_unit(size, unit))?;
        }
        match onset {
            Onset::FilamentShare(share) => write!(f, ", from {} % of the filament on", share * 100.0)?,
            Onset::TimeS(time_s) => write!(f, ", from {time_s:.2} s of the simulation on")?,
        }
        if ramp.0 > 0.0 {
            write!(f, ", grows for {} s", ramp.0)?;
        }
        match duration {
            _ if kind.at_once() => Ok(()),
            Some(duration) => write!(f, ", lasts {} s", duration.0),
            None => write!(f, ", lasts for good"),
        }?;
        seed.map_or(Ok(()), |seed| write!(f, ", seed {seed}"))
    }
}

impl Entry {
    /// Whether nothing but the camera's frames, and the inertial unit beside it, tells of it: not of a width that stands in.
    #[must_use]
    pub fn shows_in_frames_alone(&self) -> bool {
        matches!(
            (self.component, self.kind),
            (Component::Motion | Component::Part | Component::Camera | Component::Imu, _) | (_, Kind::Leak)
        )
    }
}

#[cfg(test)]
mod tests {
    use crate::faults::{Component, Kind};
    use crate::scenario::{Course, Entry};
    use models::units::Seconds;

    #[test]
    fn a_fault_is_told_with_size_onset_growth_duration_and_units() {
        let told = |of, size, ramp_s, duration_s| {
            let course = Course { size, ramp_s, duration_s };
            Entry::after(Seconds(10.0), of, course, 2.5).unwrap().to_string()
        };
        let bias = (Component::HotendThermistor, Kind::Bias);
        assert_eq!(
            told(bias, Some(-60.0), 300.0, Some(400.0)),
            "hotend_thermistor bias, size -60 K, from 12.50 s of the simulation on, grows for 300 s, lasts 400 s"
        );
        let noise = Course { size: Some(10.0), ramp_s: 0.0, duration_s: None };
        let noise = Entry::at(Component::BedThermistor, Kind::Noise, noise, 3.0).unwrap();
        assert_eq!(
            noise.seeded(7).unwrap().to_string(),
            "bed_thermistor noise, size 10 (no unit), from 3.00 s of the simulation on, lasts for good, seed 7"
        );
        assert_eq!(
            told((Component::Extruder, Kind::Slip), Some(0.09), 0.0, None),
            "extruder slip, size 0.09 (no unit), from 12.50 s of the simulation on, lasts for good"
        );
        assert_eq!(
            told((Component::Part, Kind::Detached), None, 0.0, None),
            "part detached, from 12.50 s of the simulation on, lasts for good"
        );
        // A skip is a moment: it has no duration.
        assert_eq!(
            told((Component::Motion, Kind::LayerShiftX), Some(8e-4), 0.0, None),
            "motion layer_shift_x, size 0.0008 m, from 12.50 s of the simulation on"
        );
    }
    #[test]
    fn what_only_the_camera_sees_is_known() {
        let sees = |component, kind| {
            let course = Course { size: Some(0.05), ramp_s: 0.0, duration_s: None };
            Entry::after(Seconds(10.0), (component, kind), course, 0.0).unwrap().shows_in_frames_alone()
        };
        assert!(sees(Component::Extruder, Kind::Leak) && sees(Component::Motion, Kind::LayerShiftY));
        assert!(!sees(Component::Extruder, Kind::Slip));
    }
}
