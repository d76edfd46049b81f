//! The newest values that Marlin told, and the state made of them.

use crate::event::Refusals;
use crate::job::Job;
use crate::line::Temperatures;
use crate::params::MarlinParams;
use models::command::Trims;
use models::status::{HostProfile, JobPhase, PrinterStatus};
use models::units::{Celsius, Seconds};

/// Newest sound values; one that is refused leaves the one before.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Seen {
    /// The set-points have been told: without them there is no state.
    targets: bool,
    hotend_target_c: f64,
    bed_target_c: f64,
    hotend_duty: f64,
    bed_duty: f64,
    /// When, and where `[m]`.
    pub(super) position: Option<(Seconds, [f64; 3])>,
}

impl Seen {
    pub(super) fn on_temperatures(
        &mut self,
        report: &Temperatures,
        params: &MarlinParams,
        refusals: &mut Refusals,
    ) {
        let mut take = |slot: &mut f64, value: Option<f64>, full: f64| {
            if let Some(value) = value.filter(|value| refusals.allow(*value, (0.0, full))) {
                *slot = value;
            }
        };
        let celsius = |temp: Option<Celsius>| temp.map(|temp| temp.0);
        let duty = |power: Option<f64>| power.map(|power| power / params.duty_full);
        take(&mut self.hotend_target_c, celsius(report.hotend_target), params.target_max_c);
        take(&mut self.bed_target_c, celsius(report.bed_target), params.target_max_c);
        take(&mut self.hotend_duty, duty(report.hotend_power), 1.0);
        take(&mut self.bed_duty, duty(report.bed_power), 1.0);
        let sound = |target: Option<Celsius>| {
            target.is_some_and(|target| (0.0..=params.target_max_c).contains(&target.0))
        };
        self.targets |= sound(report.hotend_target) || sound(report.bed_target);
    }

    pub(super) fn on_position(
        &mut self,
        (stamp, position_m): (Seconds, [f64; 3]),
        limit_m: f64,
        refusals: &mut Refusals,
    ) {
        if position_m.iter().all(|value_m| refusals.allow(*value_m, (-limit_m, limit_m))) {
            self.position = Some((stamp, position_m));
        }
    }

    /// The state; `None` before any set-point was told. What Marlin does not tell is neutral: see the crate's page.
    pub(super) fn status(&self, now: Seconds, job: &Job) -> Option<PrinterStatus> {
        let phase = job.phase().unwrap_or(JobPhase::Idle);
        self.targets.then(|| PrinterStatus {
            stamp: now,
            phase,
            host: HostProfile::Serial,
            progress: if phase == JobPhase::Done { 1.0 } else { 0.0 },
            layer: None,
            line: 0,
            position_m: self.position.map_or([0.0; 3], |(_, position_m)| position_m),
            path_speed_m_s: 0.0,
            planned_speed_m_s: 0.0,
            planned_feed_m_s: 0.0,
            motor_position_m: 0.0,
            wanted_position_m: 0.0,
            path_time_s: 0.0,
            depositing: false,
            target_width_m: None,
            layer_height_m: None,
            hotend_target: Celsius(self.hotend_target_c),
            // Nobody offsets it: what is in force is what was sliced.
            hotend_sliced_target: Celsius(self.hotend_target_c),
            bed_target: Celsius(self.bed_target_c),
            hotend_duty: self.hotend_duty,
            bed_duty: self.bed_duty,
            fan: 0.0,
            trims: Trims::NEUTRAL,
            advance_s: 0.0,
            homed: false,
            mains_on: true,
            filament_present: job.is_out_of_filament().then_some(false),
            part_fan_speed_1_s: None,
            stop_input: None,
        })
    }
}

impl Refusals {
    /// Whether a value is inside its range; counted where it is not.
    fn allow(&mut self, value: f64, (low, high): (f64, f64)) -> bool {
        let allowed = (low..=high).contains(&value);
        self.not_finite += u64::from(!value.is_finite());
        self.out_of_range += u64::from(value.is_finite() && !allowed);
        allowed
    }
}
