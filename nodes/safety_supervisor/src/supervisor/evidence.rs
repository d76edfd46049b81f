//! What each cause rests on, in a number for people.

use models::units::Seconds;

use super::Supervisor;
use crate::cause::Cause;
use crate::event::Evidence;

fn evidence(value: f64, unit: &'static str, digits: usize) -> Option<Evidence> {
    value.is_finite().then_some(Evidence { value, unit, digits })
}

fn count(value: u64, unit: &'static str) -> Option<Evidence> {
    #[allow(clippy::cast_precision_loss, reason = "for people")]
    evidence(value as f64, unit, 0)
}

impl Supervisor {
    /// The number that a cause rests on now; `None` where its text says all.
    pub(super) fn evidence(&self, now: Seconds, cause: Cause) -> Option<Evidence> {
        self.of_heat(cause).or_else(|| self.of_silence(now, cause)).or_else(|| self.of_the_rest(cause))
    }

    fn of_heat(&self, cause: Cause) -> Option<Evidence> {
        let checks = &self.checks;
        match cause {
            Cause::HotendRange => evidence(checks.hotend_range.newest()?.0, "degC", 1),
            Cause::BedRange => evidence(checks.bed_range.newest()?.0, "degC", 1),
            Cause::HotendFrozen => evidence(checks.frozen.still().0, "s", 1),
            Cause::BedFrozen => evidence(checks.bed_frozen.still().0, "s", 1),
            Cause::HeaterStuckOn | Cause::HeaterDeficit => evidence(checks.heater.excess_w(), "W", 1),
            Cause::BedStuckOn | Cause::BedDeficit => evidence(checks.bed_heater.excess_w(), "W", 1),
            Cause::ThermistorDetached => evidence(-checks.detached.fall_k_s(), "K/s", 1),
            Cause::BedThermistorDetached => evidence(-checks.bed_detached.fall_k_s(), "K/s", 1),
            Cause::HotendNoisy => evidence(100.0 * checks.noise.share(), "% of the readings", 0),
            Cause::HotendDrift => evidence(checks.drift.residual_k(), "K", 1),
            Cause::HotendStep => evidence(checks.step.step_k()?, "K", 1),
            _ => None,
        }
    }

    fn of_silence(&self, now: Seconds, cause: Cause) -> Option<Evidence> {
        let age = match cause {
            Cause::StaleHotend => &self.ages.hotend,
            Cause::StaleBed => &self.ages.bed,
            Cause::StaleEncoder => &self.ages.encoder,
            Cause::StalePrinter => &self.ages.printer,
            Cause::StaleCommand => &self.ages.command,
            Cause::StaleEstimate => &self.ages.estimate,
            Cause::StaleImu => &self.ages.imu,
            Cause::StaleVision => &self.ages.vision,
            _ => return None,
        };
        evidence(age.age(now)?.0, "s", 2)
    }

    fn of_the_rest(&self, cause: Cause) -> Option<Evidence> {
        let checks = &self.checks;
        match cause {
            Cause::BadValues => count(checks.bad_values.total(), "since the start"),
            Cause::Envelope => count(self.envelope.clamped(), "commands since the start"),
            Cause::SecondPublisher => count(self.envelope.refused(), "commands refused since the start"),
            Cause::PartFan => evidence(self.printer?.part_fan_speed_1_s?, "1/s", 1),
            Cause::FilamentSlip => evidence(100.0 * checks.filament.slip()?, "% slip", 0),
            Cause::LayerShift => evidence(1e3 * checks.shift.newest_m()?, "mm", 2),
            Cause::Spaghetti | Cause::UnderExtrusion | Cause::OverExtrusion | Cause::Confidence => {
                evidence(checks.attention.newest()?, "confidence", 2)
            }
            _ => None,
        }
    }
}
