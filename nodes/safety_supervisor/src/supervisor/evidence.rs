//! What each cause rests on, in a number for people, and the limit that it went beyond.

use models::units::Seconds;

use super::Supervisor;
use crate::attention::Level;
use crate::cause::Cause;
use crate::event::Evidence;

fn evidence(value: f64, unit: &'static str, digits: usize) -> Option<Evidence> {
    value.is_finite().then_some(Evidence { value, unit, digits, limit: None })
}

fn count(value: u64, unit: &'static str) -> Option<Evidence> {
    #[allow(clippy::cast_precision_loss, reason = "for people")]
    evidence(value as f64, unit, 0)
}

impl Supervisor {
    /// The number that a cause rests on now; `None` where its text says all.
    pub(super) fn evidence(&self, now: Seconds, cause: Cause) -> Option<Evidence> {
        let (number, limit) = self
            .of_heat(cause)
            .or_else(|| self.of_silence(now, cause))
            .or_else(|| self.of_the_rest(cause))?;
        Some(limit.map_or(number, |limit| number.beyond(limit)))
    }

    /// A reading that stands still is judged by several spans: no single one is its limit.
    fn of_heat(&self, cause: Cause) -> Option<(Evidence, Option<f64>)> {
        let (checks, params) = (&self.checks, &self.params);
        let heater = |(excess_w, limit_w): (f64, Option<f64>)| (evidence(excess_w, "W", 1), limit_w);
        let (number, limit) = match cause {
            Cause::HotendRange => {
                (evidence(checks.hotend_range.newest()?.0, "degC", 1), checks.hotend_range.limit_c())
            }
            Cause::BedRange => {
                (evidence(checks.bed_range.newest()?.0, "degC", 1), checks.bed_range.limit_c())
            }
            Cause::HotendFrozen => (evidence(checks.frozen.still().0, "s", 1), None),
            Cause::BedFrozen => (evidence(checks.bed_frozen.still().0, "s", 1), None),
            Cause::HeaterStuckOn | Cause::HeaterDeficit => heater(checks.heater.beyond_w()),
            Cause::BedStuckOn | Cause::BedDeficit => heater(checks.bed_heater.beyond_w()),
            Cause::ThermistorDetached => {
                (evidence(-checks.detached.fall_k_s(), "K/s", 1), Some(-params.detached.fall_k_s))
            }
            Cause::BedThermistorDetached => {
                (evidence(-checks.bed_detached.fall_k_s(), "K/s", 1), Some(-params.bed_detached.fall_k_s))
            }
            Cause::HotendNoisy => (
                evidence(100.0 * checks.noise.share(), "% of the readings", 0),
                Some(100.0 * params.noise.share_max),
            ),
            Cause::HotendDrift => (evidence(checks.drift.residual_k(), "K", 1), Some(checks.drift.limit_k())),
            Cause::HotendStep => (
                evidence(checks.step.step_k()?, "K", 1),
                Some(params.hotend_step.step_k.copysign(checks.step.step_k()?)),
            ),
            _ => return None,
        };
        Some((number?, limit))
    }

    fn of_silence(&self, now: Seconds, cause: Cause) -> Option<(Evidence, Option<f64>)> {
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
        Some((evidence(age.age(now)?.0, "s", 2)?, age.limit_s(now)))
    }

    fn of_the_rest(&self, cause: Cause) -> Option<(Evidence, Option<f64>)> {
        let (checks, params) = (&self.checks, &self.params);
        let (number, limit) = match cause {
            Cause::BadValues => (count(checks.bad_values.total(), "since the start"), None),
            Cause::Envelope => (count(self.envelope.clamped(), "commands since the start"), None),
            Cause::SecondPublisher => {
                (count(self.envelope.refused(), "commands refused since the start"), None)
            }
            Cause::PartFan => {
                let printer = self.printer?;
                let fan = &params.part_fan;
                let limit_1_s = fan.share_standing * printer.fan * fan.full_1_s;
                (evidence(printer.part_fan_speed_1_s?, "1/s", 1), Some(limit_1_s))
            }
            Cause::FilamentSlip => (
                evidence(100.0 * checks.filament.slip()?, "% slip", 0),
                Some(100.0 * params.filament.slip_max),
            ),
            Cause::LayerShift => {
                (evidence(1e3 * checks.shift.newest_m()?, "mm", 2), Some(1e3 * checks.shift.limit_m()))
            }
            // A defect that lasts is confirmed by the judge itself, whatever its confidence.
            Cause::Spaghetti | Cause::UnderExtrusion | Cause::OverExtrusion | Cause::Confidence => {
                let hard = checks.attention.level() == Level::Hard;
                (evidence(checks.attention.newest()?, "confidence", 2), hard.then_some(params.attention.hard))
            }
            _ => return None,
        };
        Some((number?, limit))
    }
}
