//! What each cause rests on, in a number for people, and the limit that it went beyond.

use models::units::Seconds;

use super::Supervisor;
use crate::attention::Level;
use crate::cause::Cause;
use crate::event::Evidence;

#[allow(clippy::cast_precision_loss, reason = "for people")]
fn count(value: u64) -> f64 {
    value as f64
}

/// A number, and the one that it went beyond.
type Number = (f64, Option<f64>);

/// A number with the limit that it is beyond.
fn beside((value, limit): (f64, f64)) -> Number {
    (value, Some(limit))
}

impl Supervisor {
    /// Keeps what the cause in force rests on, from when it was found.
    pub(super) fn find(&mut self, now: Seconds) {
        self.found = self.modes.cause().map(|cause| (cause, self.evidence(now, cause)));
    }

    /// The number that a cause rests on now; `None` where its text says all.
    pub(super) fn evidence(&self, now: Seconds, cause: Cause) -> Option<Evidence> {
        let (value, limit) = self
            .of_heat(now, cause)
            .or_else(|| self.of_silence(now, cause))
            .or_else(|| self.of_the_rest(cause))?;
        Evidence::of(cause, value, limit)
    }

    /// What a cause rested on when it was found, where it is the one that was found last.
    #[must_use]
    pub fn evidence_of(&self, cause: Cause) -> Option<Evidence> {
        self.found.filter(|(found, _)| *found == cause).and_then(|(_, number)| number)
    }

    /// A reading that stands still is judged by several spans: no single one is its limit.
    fn of_heat(&self, now: Seconds, cause: Cause) -> Option<Number> {
        let (checks, params) = (&self.checks, &self.params);
        Some(match cause {
            Cause::HotendRange => (checks.hotend_range.newest()?.0, checks.hotend_range.limit_c()),
            Cause::BedRange => (checks.bed_range.newest()?.0, checks.bed_range.limit_c()),
            Cause::HotendFrozen => (checks.frozen.still().0, None),
            Cause::BedFrozen => (checks.bed_frozen.still().0, None),
            // It warms behind a latch: no balance says that.
            Cause::HeaterStuckOn if checks.rising.tripped() => return None,
            Cause::BedStuckOn if checks.bed_rising.tripped() => return None,
            Cause::HeaterStuckOn | Cause::HeaterDeficit => checks.heater.beyond_w(),
            Cause::BedStuckOn | Cause::BedDeficit => checks.bed_heater.beyond_w(),
            Cause::ThermistorDetached => fallen(checks.detached.fall_k_s()),
            Cause::BedThermistorDetached => fallen(checks.bed_detached.fall_k_s()),
            Cause::HotendUnjudged => beside(checks.unjudged.unjudged_s(now)?),
            Cause::BedUnjudged => beside(checks.bed_unjudged.unjudged_s(now)?),
            Cause::HeatUnseen => beside(checks.unseen.unseen_s(now)?),
            Cause::HotendNoisy => (100.0 * checks.noise.share(), Some(100.0 * params.noise.share_max)),
            Cause::HotendDrift => (checks.drift.residual_k(), Some(checks.drift.limit_k())),
            Cause::HotendStep => {
                (checks.step.step_k()?, Some(params.hotend_step.step_k.copysign(checks.step.step_k()?)))
            }
            _ => return None,
        })
    }

    fn of_silence(&self, now: Seconds, cause: Cause) -> Option<Number> {
        if let Some((idle_s, work_s)) = self.of_idleness(now, cause) {
            return Some(beside((idle_s, work_s)));
        }
        let age = self.ages.of_cause(cause)?;
        match (age.limit_s(now), self.ages.hang_s(cause)) {
            (None, Some((silent_s, hang_s))) => Some((silent_s, Some(hang_s))),
            (limit_s, _) => Some((age.age(now)?.0, limit_s)),
        }
    }

    fn of_the_rest(&self, cause: Cause) -> Option<Number> {
        let (checks, params) = (&self.checks, &self.params);
        Some(match cause {
            Cause::BadValues => (count(checks.bad_values.total()), None),
            Cause::Envelope => (count(self.envelope.clamped()), None),
            Cause::SecondPublisher => (count(self.envelope.refused()), None),
            Cause::PartFan => {
                let printer = self.printer?;
                let fan = &params.part_fan;
                let limit_1_s = fan.share_standing * printer.fan * fan.full_1_s;
                (printer.part_fan_speed_1_s?, Some(limit_1_s))
            }
            Cause::FilamentSlip => (100.0 * checks.filament.slip()?, Some(100.0 * params.filament.slip_max)),
            Cause::EncoderSurplus => {
                (100.0 * checks.filament.surplus()?, Some(100.0 * params.filament.surplus_max))
            }
            Cause::LayerShift => (1e3 * checks.shift.newest_m()?, Some(1e3 * checks.shift.limit_m())),
            // A defect that lasts is confirmed by the judge itself, whatever its confidence.
            Cause::Spaghetti | Cause::UnderExtrusion | Cause::OverExtrusion | Cause::Confidence => {
                let hard = checks.attention.level() == Level::Hard;
                (checks.attention.newest()?, hard.then_some(params.attention.hard))
            }
            _ => return None,
        })
    }
}

/// A fall beside the one that counts `[K/s]`, both as they change a reading.
fn fallen((fall_k_s, most_k_s): (f64, f64)) -> Number {
    (-fall_k_s, Some(-most_k_s))
}
