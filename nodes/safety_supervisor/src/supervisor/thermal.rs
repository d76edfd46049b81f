//! Heaters, thermistors, part fan and stop contact: what goes into their checks and what they call for.

use models::command::Mode;
use models::units::{Celsius, Seconds};

use super::Supervisor;
use super::parts::Checks;
use crate::cause::{Cause, Reaction};
use crate::checks::heater::{Drive, HeaterFault};
use crate::checks::range::RangeCheck;
use crate::checks::unseen::Sight;
use crate::event::PrinterReport;
use crate::modes::Raised;
use crate::params::Params;

/// Age of the printer's state from which nobody knows what the heaters are told `[s]`: until then readings wait for it.
const UNORDERED_S: f64 = 1.5;

/// Causes behind which a reading is not the block's or the bed's, or may not be: what falls behind what a heater should give
/// may be a thermistor that fell out.
const DOUBTS: [Cause; 7] = [
    Cause::HotendFrozen,
    Cause::ThermistorDetached,
    Cause::HotendStep,
    Cause::HeaterDeficit,
    Cause::BedFrozen,
    Cause::BedThermistorDetached,
    Cause::BedDeficit,
];

impl Supervisor {
    pub(super) fn on_hotend(&mut self, now: Seconds, stamp: Seconds, temp: Celsius) {
        if !(temp.0.is_finite() && stamp.0.is_finite()) {
            return self.checks.bad_values.note(now);
        }
        self.ages.hotend.note(now);
        // A bead on its way to the air is no block; there it may rest, and the balance begins anew.
        // Nor is there a balance without the orders: it begins anew when they are heard again.
        let unordered = self.ages.printer.age(now).is_some_and(|age| age.0 > UNORDERED_S);
        let lost = self.modes.latch().is_some_and(|latch| latch.cause == Cause::ThermistorDetached);
        let is_off = if lost { Some(false) } else { self.are_to_be_off(now).map(|(hotend, _)| hotend) };
        let checks = &mut self.checks;
        checks.rising.on_sample(now, temp, is_off);
        checks.hotend_range.on_sample(now, temp);
        checks.frozen.on_sample(now, temp);
        self.hotend = Some(temp);
        if !checks.hotend_pace.counts(stamp) {
            return;
        }
        checks.noise.on_sample(temp, checks.hotend_range.is_inside());
        if checks.hotend_range.is_inside() {
            // One that falls is no step, however far it is from reading to reading.
            checks.detached.on_sample(stamp, temp);
            checks.step.on_sample(stamp, temp);
            if checks.step.is_apart() {
                return;
            }
            if unordered || lost && !checks.detached.is_at_rest() {
                checks.heater.reset();
            }
            checks.heater.on_sample(stamp, temp);
            if let Some(balance) = checks.heater.balance().filter(|_| !checks.noise.is_suspect()) {
                let bed_w = checks.bed_tells_w(self.params.drift.bed_above_air_k, &self.params);
                checks.drift.on_balance(stamp, balance, bed_w);
            }
        }
    }

    pub(super) fn on_bed(&mut self, now: Seconds, stamp: Seconds, temp: Celsius) {
        if !(temp.0.is_finite() && stamp.0.is_finite()) {
            return self.checks.bad_values.note(now);
        }
        self.ages.bed.note(now);
        let is_off = self.are_to_be_off(now).map(|(_, bed)| bed);
        let checks = &mut self.checks;
        checks.bed_rising.on_sample(now, temp, is_off);
        checks.bed_range.on_sample(now, temp);
        checks.bed_frozen.on_sample(now, temp);
        if checks.bed_range.is_inside() && checks.bed_pace.counts(stamp) {
            checks.bed_heater.on_sample(stamp, temp);
            checks.bed_detached.on_sample(stamp, temp);
        }
    }

    /// What the readings show of heaters that are off by order.
    pub(super) fn sight(&self, now: Seconds, raised: &Raised) -> Option<Sight> {
        let latch = self.modes.latch().filter(|latch| !latch.estop)?;
        let calls = |cause: &Cause| raised[*cause as usize] >= Some(Reaction::SafeOff);
        // Where the printer is not heard either, no order would reach it.
        let heard = self.ages.printer.age(now).is_some_and(|age| age.0 <= UNORDERED_S);
        let silent = heard && [Cause::StaleHotend, Cause::StaleBed].iter().any(calls);
        Some(if DOUBTS.contains(&latch.cause) || DOUBTS.iter().any(calls) {
            Sight::Doubted
        } else if silent || [Cause::HotendRange, Cause::BedRange].iter().any(calls) {
            Sight::None
        } else {
            let well = |range: &RangeCheck| range.newest().is_none() || range.is_well();
            let clear = well(&self.checks.hotend_range) && well(&self.checks.bed_range);
            if clear { Sight::Clear } else { Sight::Unsure }
        })
    }

    /// Whether hot end and bed are to be off, by our order or because nobody asks for heat; `None` where that is not known
    /// just now.
    fn are_to_be_off(&self, now: Seconds) -> Option<(bool, bool)> {
        match self.modes.mode() {
            Mode::SafeOff => return Some((true, true)),
            // Off the mains nothing heats, and what has been found may be acknowledged.
            Mode::Estop => return Some((false, false)),
            _ => {}
        }
        let printer =
            self.printer.filter(|_| self.ages.printer.age(now).is_some_and(|age| age.0 <= UNORDERED_S));
        printer.map(|printer| heats(&printer)).map(|(hotend, bed)| (!hotend, !bed))
    }

    /// What the printer does with its heaters and fan.
    pub(super) fn on_drive(&mut self, now: Seconds, report: &PrinterReport) {
        let powered = |duty: f64| if report.mains_on { duty } else { 0.0 };
        let (hotend, bed) = (powered(report.hotend_duty), powered(report.bed_duty));
        let checks = &mut self.checks;
        checks.part_fan.on_speed(now, report.fan, report.part_fan_speed_1_s);
        checks.stop_input.on_input(report.stop_input);
        // A fan that does not turn does not cool, whatever it is told.
        let fan = checks.part_fan.flow_share(report.fan, report.part_fan_speed_1_s);
        let motor_position_m = report.motor_position_m;
        // Where no encoder tells, what is made up for is all that is known to be lost.
        let slip = checks.filament.slip().or(report.trims.slip).map_or(0.0, |slip| slip.clamp(0.0, 1.0));
        checks.heater.on_drive(report.stamp, Drive { duty: hotend, fan, motor_position_m, slip });
        checks.frozen.on_duty(hotend);
        let bed_drive = Drive { duty: bed, fan: 0.0, motor_position_m: 0.0, slip: 0.0 };
        checks.bed_heater.on_drive(report.stamp, bed_drive);
        checks.bed_frozen.on_duty(bed);
    }

    /// Whatever the parameters require: what heats has to be measured, and judged.
    pub(super) fn look_at_heat(&mut self, now: Seconds) {
        let (hotend, bed) = self.printer.map_or((false, false), |printer| heats(&printer));
        let ordered = self.modes.latch().is_none();
        if hotend {
            self.ages.hotend.expect(now);
        }
        if bed {
            self.ages.bed.expect(now);
        }
        let checks = &mut self.checks;
        // What is off by order is not in use, whatever the slicer asks for; the readings alone are looked at then.
        checks.unjudged.look(now, hotend && ordered, checks.heater.is_judging());
        checks.bed_unjudged.look(now, bed && ordered, checks.bed_heater.is_judging());
    }
}

impl Checks {
    /// What the bed's balance lacks or has too much of, where the bed is warm enough to tell of the air.
    fn bed_tells_w(&self, above_air_k: f64, params: &Params) -> Option<f64> {
        let warm = self.bed_heater.block().0 >= params.bed_heater.ambient_c + above_air_k;
        self.bed_heater.balance().filter(|_| warm).map(|balance| balance.disturbance_w)
    }

    /// What each thermal cause calls for now.
    pub(super) fn thermal_causes(&self, now: Seconds, params: &Params) -> [(Cause, Option<Reaction>); 17] {
        let safe_off = |tripped: bool| tripped.then_some(Reaction::SafeOff);
        let estop = |tripped: bool| tripped.then_some(Reaction::Estop);
        let degrade = |tripped: bool| tripped.then_some(Reaction::Degrade);
        let noisy = self.noise.is_suspect();
        // The balance of a reading that stands still is the balance of nothing.
        let suspect = self.frozen.still().0 >= params.frozen.suspect_s
            || self.detached.is_falling()
            || self.step.is_apart();
        let fault = self.heater.fault(noisy).filter(|_| !suspect);
        let bed_suspect =
            self.bed_frozen.still().0 >= params.bed_frozen.suspect_s || self.bed_detached.is_falling();
        let bed_fault = self.bed_heater.fault(false).filter(|_| !bed_suspect);
        // Where fan and tachometer do not agree, nobody knows what cools the block.
        let drifted = self.drift.tripped() && !self.part_fan.is_slow(now);
        let drift = safe_off(drifted).or(degrade(self.drift.is_doubtful()));
        [
            (Cause::HotendRange, safe_off(self.hotend_range.tripped())),
            (Cause::BedRange, safe_off(self.bed_range.tripped())),
            (Cause::HotendFrozen, safe_off(self.frozen.tripped(self.heater.moved_k()))),
            (Cause::ThermistorDetached, safe_off(self.detached.tripped() && !noisy)),
            (Cause::HeaterStuckOn, estop(fault == Some(HeaterFault::StuckOn) || self.rising.tripped())),
            (Cause::HeaterDeficit, safe_off(fault == Some(HeaterFault::Deficit))),
            (Cause::HotendStep, safe_off(self.step.tripped())),
            (Cause::HotendNoisy, degrade(self.noise.tripped())),
            (Cause::HotendDrift, drift),
            (Cause::BedFrozen, safe_off(self.bed_frozen.tripped(self.bed_heater.moved_k()))),
            (Cause::BedThermistorDetached, safe_off(self.bed_detached.tripped())),
            // A switch that conducts by itself stops at the mains relay alone.
            (Cause::BedStuckOn, estop(bed_fault == Some(HeaterFault::StuckOn) || self.bed_rising.tripped())),
            (Cause::HotendUnjudged, safe_off(self.unjudged.unjudged_s(now).is_some())),
            (Cause::BedUnjudged, safe_off(self.bed_unjudged.unjudged_s(now).is_some())),
            (Cause::BedDeficit, safe_off(bed_fault == Some(HeaterFault::Deficit))),
            (Cause::PartFan, degrade(self.part_fan.tripped(now))),
            (Cause::StopInput, estop(self.stop_input.tripped())),
        ]
    }
}

/// Whether hot end and bed are, or are about to be, heated.
fn heats(printer: &PrinterReport) -> (bool, bool) {
    let hotend =
        printer.hotend_duty > 0.0 || printer.hotend_target.0 > 0.0 || printer.hotend_sliced_target.0 > 0.0;
    (hotend, printer.bed_duty > 0.0 || printer.bed_target.0 > 0.0)
}
