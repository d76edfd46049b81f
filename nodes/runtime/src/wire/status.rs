//! `PrinterState`.

use super::command::unknown;
use super::{WireError, optional, stamp_from_wire, within};
use fdm_loop_msgs::{Header, PrinterState};
use models::command::Trims;
use models::status::{HostProfile, JobPhase, PrinterStatus};
use models::units::Celsius;
#[cfg(test)]
use models::units::Seconds;

const SHARE: (f64, f64) = (0.0, 1.0);
const SPEED_M_S: (f64, f64) = (0.0, 10.0);
/// Filament moves back too.
const FEED_M_S: (f64, f64) = (-10.0, 10.0);
/// Farthest place that any printer has.
const PLACE_M: (f64, f64) = (-100.0, 100.0);
/// 3 t of filament.
const FILAMENT_M: (f64, f64) = (-1e6, 1e6);
/// 30 years of printing.
const PATH_TIME_S: (f64, f64) = (0.0, 1e9);
const OFFSET_K: (f64, f64) = (-300.0, 300.0);
const FACTOR: (f64, f64) = (0.0, 10.0);
const ROAD_M: (f64, f64) = (0.0, 0.1);
/// The fastest small fans turn 1000 times a second.
const FAN_SPEED_1_S: (f64, f64) = (0.0, 2000.0);
const TARGET_C: (f64, f64) = (-50.0, 600.0);

/// The state as sent.
#[must_use]
pub fn status_to_wire(status: &PrinterStatus) -> PrinterState {
    let trims = &status.trims;
    PrinterState {
        header: Header::at(status.stamp.0),
        phase: status.phase as u8,
        host: status.host as u8,
        progress: status.progress,
        layer_known: status.layer.is_some(),
        layer: status.layer.unwrap_or(0),
        line: status.line,
        position_m: status.position_m,
        path_speed_m_s: status.path_speed_m_s,
        planned_speed_m_s: status.planned_speed_m_s,
        planned_feed_m_s: status.planned_feed_m_s,
        motor_position_m: status.motor_position_m,
        wanted_position_m: status.wanted_position_m,
        path_time_s: status.path_time_s,
        depositing: status.depositing,
        target_width_known: status.target_width_m.is_some(),
        target_width_m: status.target_width_m.unwrap_or(0.0),
        layer_height_known: status.layer_height_m.is_some(),
        layer_height_m: status.layer_height_m.unwrap_or(0.0),
        hotend_target_degc: status.hotend_target.0,
        hotend_sliced_target_degc: status.hotend_sliced_target.0,
        bed_target_degc: status.bed_target.0,
        hotend_duty: status.hotend_duty,
        bed_duty: status.bed_duty,
        fan: status.fan,
        flow_factor: trims.flow,
        speed_factor: trims.speed,
        nozzle_setpoint_offset_k: trims.setpoint_offset_k,
        set_advance: trims.advance_s.is_some(),
        trim_advance_s: trims.advance_s.unwrap_or(0.0),
        close_extruder_loop: trims.slip.is_some(),
        slip_compensation: trims.slip.unwrap_or(0.0),
        advance_s: status.advance_s,
        homed: status.homed,
        mains_on: status.mains_on,
        filament_switch_fitted: status.filament_present.is_some(),
        filament_present: status.filament_present.unwrap_or(false),
        part_fan_speed_known: status.part_fan_speed_1_s.is_some(),
        part_fan_speed_1_s: status.part_fan_speed_1_s.unwrap_or(0.0),
        stop_input_fitted: status.stop_input.is_some(),
        stop_input: status.stop_input.unwrap_or(false),
    }
}

/// A state as received.
///
/// # Errors
/// [`WireError`] for a value that is not finite, out of the range of the definition, or an unknown phase or host.
pub fn status_from_wire(wire: &PrinterState) -> Result<PrinterStatus, WireError> {
    for (name, value) in [("position_m.x", 0), ("position_m.y", 1), ("position_m.z", 2)] {
        within(name, wire.position_m[value], PLACE_M)?;
    }
    let celsius = |field, value| within(field, value, TARGET_C).map(Celsius);
    Ok(PrinterStatus {
        stamp: stamp_from_wire(&wire.header)?,
        phase: phase_from_wire(wire.phase)?,
        host: host_from_wire(wire.host)?,
        progress: within("progress", wire.progress, SHARE)?,
        layer: wire.layer_known.then_some(wire.layer),
        line: wire.line,
        position_m: wire.position_m,
        path_speed_m_s: within("path_speed_m_s", wire.path_speed_m_s, SPEED_M_S)?,
        planned_speed_m_s: within("planned_speed_m_s", wire.planned_speed_m_s, SPEED_M_S)?,
        planned_feed_m_s: within("planned_feed_m_s", wire.planned_feed_m_s, FEED_M_S)?,
        motor_position_m: within("motor_position_m", wire.motor_position_m, FILAMENT_M)?,
        wanted_position_m: within("wanted_position_m", wire.wanted_position_m, FILAMENT_M)?,
        path_time_s: within("path_time_s", wire.path_time_s, PATH_TIME_S)?,
        depositing: wire.depositing,
        target_width_m: optional(wire.target_width_known, "target_width_m", wire.target_width_m, ROAD_M)?,
        layer_height_m: optional(wire.layer_height_known, "layer_height_m", wire.layer_height_m, ROAD_M)?,
        hotend_target: celsius("hotend_target_degc", wire.hotend_target_degc)?,
        hotend_sliced_target: celsius("hotend_sliced_target_degc", wire.hotend_sliced_target_degc)?,
        bed_target: celsius("bed_target_degc", wire.bed_target_degc)?,
        hotend_duty: within("hotend_duty", wire.hotend_duty, SHARE)?,
        bed_duty: within("bed_duty", wire.bed_duty, SHARE)?,
        fan: within("fan", wire.fan, SHARE)?,
        trims: trims_in_force(wire)?,
        advance_s: within("advance_s", wire.advance_s, FACTOR)?,
        homed: wire.homed,
        mains_on: wire.mains_on,
        filament_present: wire.filament_switch_fitted.then_some(wire.filament_present),
        part_fan_speed_1_s: optional(
            wire.part_fan_speed_known,
            "part_fan_speed_1_s",
            wire.part_fan_speed_1_s,
            FAN_SPEED_1_S,
        )?,
        stop_input: wire.stop_input_fitted.then_some(wire.stop_input),
    })
}

fn trims_in_force(wire: &PrinterState) -> Result<Trims, WireError> {
    Ok(Trims {
        flow: within("flow_factor", wire.flow_factor, FACTOR)?,
        speed: within("speed_factor", wire.speed_factor, FACTOR)?,
        setpoint_offset_k: within("nozzle_setpoint_offset_k", wire.nozzle_setpoint_offset_k, OFFSET_K)?,
        advance_s: optional(wire.set_advance, "trim_advance_s", wire.trim_advance_s, FACTOR)?,
        slip: optional(wire.close_extruder_loop, "slip_compensation", wire.slip_compensation, (-0.2, 0.99))?,
    })
}

fn phase_from_wire(value: u8) -> Result<JobPhase, WireError> {
    const PHASES: [JobPhase; 6] = [
        JobPhase::Idle,
        JobPhase::Preparing,
        JobPhase::Printing,
        JobPhase::Paused,
        JobPhase::Done,
        JobPhase::Failed,
    ];
    PHASES.get(usize::from(value)).copied().ok_or(unknown("phase", value, 5.0))
}

fn host_from_wire(value: u8) -> Result<HostProfile, WireError> {
    const HOSTS: [HostProfile; 4] =
        [HostProfile::Native, HostProfile::Serial, HostProfile::Moonraker, HostProfile::Octoprint];
    HOSTS.get(usize::from(value)).copied().ok_or(unknown("host", value, 3.0))
}

/// A state that every check passes, for tests of this crate.
#[cfg(test)]
pub(crate) fn sound() -> PrinterStatus {
    PrinterStatus {
        stamp: Seconds(12.5),
        phase: JobPhase::Printing,
        host: HostProfile::Serial,
        progress: 0.5,
        layer: Some(4),
        line: 99,
        position_m: [0.1, 0.2, 0.001],
        path_speed_m_s: 0.05,
        planned_speed_m_s: 0.06,
        planned_feed_m_s: 0.002,
        motor_position_m: 1.2,
        wanted_position_m: 1.1,
        path_time_s: 33.0,
        depositing: true,
        target_width_m: Some(4.5e-4),
        layer_height_m: Some(2e-4),
        hotend_target: Celsius(216.0),
        hotend_sliced_target: Celsius(215.0),
        bed_target: Celsius(60.0),
        hotend_duty: 0.4,
        bed_duty: 0.2,
        fan: 1.0,
        trims: Trims { slip: Some(0.02), ..Trims::NEUTRAL },
        advance_s: 0.05,
        homed: true,
        mains_on: true,
        filament_present: None,
        part_fan_speed_1_s: Some(78.5),
        stop_input: Some(false),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_survives_the_wire() {
        assert_eq!(status_from_wire(&status_to_wire(&sound())), Ok(sound()));
        let bare = PrinterStatus { target_width_m: None, layer_height_m: None, layer: None, ..sound() };
        let bare = PrinterStatus { part_fan_speed_1_s: None, stop_input: None, ..bare };
        assert_eq!(status_from_wire(&status_to_wire(&bare)), Ok(bare));
    }

    #[test]
    fn lies_are_refused_by_name() {
        let mut wire = status_to_wire(&sound());
        wire.hotend_duty = 1.5;
        let error = status_from_wire(&wire).unwrap_err();
        assert_eq!(error.to_string(), "hotend_duty = 1.5: must be in [0, 1]");
        let mut wire = status_to_wire(&sound());
        wire.motor_position_m = f64::NAN;
        assert_eq!(status_from_wire(&wire), Err(WireError::NotFinite { field: "motor_position_m" }));
        let mut wire = status_to_wire(&sound());
        wire.header.stamp.nanosec = 2_000_000_000;
        assert_eq!(status_from_wire(&wire), Err(WireError::Stamp { nanosec: 2_000_000_000 }));
    }
}
