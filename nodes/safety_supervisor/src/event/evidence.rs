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
        Cause::HotendUnjudged | Cause::BedUnjudged | Cause::HeatUnseen => ("s", 1),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_told_in_the_unit_of_its_cause() {
        for (cause, value, limit, text) in [
            (Cause::BedRange, 131.25, Some(130.0), "131.2 degC, limit 130.0 degC"),
            (Cause::BedFrozen, 20.04, None, "20.0 s"),
            (Cause::BedDeficit, -40.0, Some(-35.5), "-40.0 W, limit -35.5 W"),
            (Cause::BedThermistorDetached, 6.1, Some(5.0), "6.1 K/s, limit 5.0 K/s"),
            (Cause::HotendNoisy, 24.0, Some(20.0), "24 % of the readings, limit 20 %"),
            (Cause::HotendStep, 20.0, Some(12.0), "20.0 K, limit 12.0 K"),
            (Cause::StaleImu, 0.301, Some(0.25), "0.30 s, limit 0.25 s"),
            (Cause::JudgeIdle, 5.04, Some(5.0), "5.0 s, limit 5.0 s"),
            (Cause::BedUnjudged, 30.04, Some(30.0), "30.0 s, limit 30.0 s"),
            (Cause::BadValues, 3.0, None, "3 since the start"),
            (Cause::Envelope, 3.0, None, "3 commands since the start"),
            (Cause::SecondPublisher, 7.0, None, "7 commands refused since the start"),
            (Cause::PartFan, 12.0, Some(48.0), "12.0 1/s, limit 48.0 1/s"),
            (Cause::FilamentSlip, 61.0, Some(50.0), "61 % slip, limit 50 %"),
            (Cause::EncoderSurplus, 31.0, Some(30.0), "31 % beyond the motor's way, limit 30 %"),
            (Cause::LayerShift, 0.8, Some(0.5), "0.80 mm, limit 0.50 mm"),
            (Cause::Confidence, 0.9, Some(0.8), "0.90 confidence, limit 0.80 confidence"),
        ] {
            let told = Evidence::of(cause, value, limit).map(|evidence| evidence.to_string());
            assert_eq!(told.as_deref(), Some(text), "{cause:?}");
        }
        for cause in [Cause::RunOut, Cause::OperatorStop, Cause::LatchUnreadable] {
            assert_eq!(Evidence::of(cause, 1.0, None), None, "{cause:?}");
        }
        assert_eq!(Evidence::of(Cause::PartFan, f64::NAN, None), None);
        let endless = Evidence::of(Cause::PartFan, 1.0, Some(f64::INFINITY));
        assert!(endless.is_some_and(|evidence| evidence.limit.is_none()));
    }
}
