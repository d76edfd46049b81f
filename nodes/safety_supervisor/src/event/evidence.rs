//! The number that a cause rests on.

use std::fmt;

use crate::cause::Cause;

/// A number with its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// What was measured or counted.
    pub value: f64,
    /// Its unit, or what was counted; the first word is the unit of the limit too.
    pub unit: &'static str,
    /// Digits behind the point for people.
    pub digits: usize,
    /// What it went beyond, where one number says that.
    pub limit: Option<f64>,
}

impl Evidence {
    /// The number of a cause, in the cause's unit; `None` where its text says all, or the number is none.
    #[must_use]
    pub fn of(cause: Cause, value: f64, limit: Option<f64>) -> Option<Self> {
        let (unit, digits) = unit(cause).filter(|_| value.is_finite())?;
        Some(Self { value, unit, digits, limit: limit.filter(|limit| limit.is_finite()) })
    }
}

/// In what a cause is measured or counted, and digits behind the point for people; `None` where its text says all.
fn unit(cause: Cause) -> Option<(&'static str, usize)> {
    Some(match cause {
        Cause::HotendRange | Cause::BedRange => ("degC", 1),
        Cause::HotendFrozen | Cause::BedFrozen => ("s", 1),
        Cause::HeaterStuckOn | Cause::HeaterDeficit | Cause::BedStuckOn | Cause::BedDeficit => ("W", 1),
        Cause::ThermistorDetached | Cause::BedThermistorDetached => ("K/s", 1),
        Cause::HotendNoisy => ("% of the readings", 0),
        Cause::HotendDrift | Cause::HotendStep => ("K", 1),
        Cause::StaleHotend
        | Cause::StaleBed
        | Cause::StaleEncoder
        | Cause::StalePrinter
        | Cause::StaleCommand
        | Cause::StaleEstimate
        | Cause::StaleImu
        | Cause::StaleVision => ("s", 2),
        Cause::EstimatorIdle | Cause::ControllerIdle | Cause::CameraIdle | Cause::JudgeIdle => ("s", 1),
        Cause::BadValues => ("since the start", 0),
        Cause::Envelope => ("commands since the start", 0),
        Cause::SecondPublisher => ("commands refused since the start", 0),
        Cause::PartFan => ("1/s", 1),
        Cause::FilamentSlip => ("% slip", 0),
        Cause::EncoderSurplus => ("% beyond the motor's way", 0),
        Cause::LayerShift => ("mm", 2),
        Cause::Spaghetti | Cause::UnderExtrusion | Cause::OverExtrusion | Cause::Confidence => {
            ("confidence", 2)
        }
        _ => return None,
    })
}

impl fmt::Display for Evidence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (unit, digits) = (self.unit, self.digits);
        write!(f, "{:.digits$} {unit}", self.value)?;
        let Some(limit) = self.limit else { return Ok(()) };
        let (unit, _) = unit.split_once(' ').unwrap_or((unit, ""));
        write!(f, ", limit {limit:.digits$} {unit}")
    }
}
