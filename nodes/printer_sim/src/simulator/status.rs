//! What the printer says of itself.

use super::Simulator;
use models::status::PrinterStatus;

impl Simulator {
    /// Line of the file that asked for the pause in force, from 1 (`M0`, `M25`, `M600`); `None` where none did.
    #[must_use]
    pub fn paused_by_line(&self) -> Option<u64> {
        self.executor.paused_by_line()
    }

    /// The file's own speed of the tool here, without any trim `[m/s]`.
    #[must_use]
    pub fn sliced_speed_m_s(&self) -> f64 {
        self.motion.sliced_speed_m_s
    }

    /// The mains relay feeds the heaters.
    #[must_use]
    pub fn mains_on(&self) -> bool {
        self.mains_on
    }

    /// State of printer and job now.
    #[must_use]
    pub fn status(&self) -> PrinterStatus {
        let segment = self.executor.segment();
        let road = self.road();
        let planned = self.motion.planned_speed_m_s;
        let per_path = segment.filter(|s| s.length_m > 0.0).map_or(0.0, |s| s.filament_m / s.length_m);
        PrinterStatus {
            stamp: self.now,
            phase: self.phase(),
            host: self.params.simulator.executor.host,
            progress: if self.filament_m > 0.0 {
                (self.executor.fed_m() / self.filament_m).min(1.0)
            } else {
                0.0
            },
            layer: self.executor.layer(),
            line: self.executor.line(),
            position_m: self.executor.position_m(),
            path_speed_m_s: self.motion.path_speed_m_s,
            planned_speed_m_s: planned,
            planned_feed_m_s: if per_path > 0.0 { per_path * planned } else { self.motion.feed.other_m_s },
            motor_position_m: self.drive.motor_m(),
            wanted_position_m: self.drive.wanted_m(),
            path_time_s: self.executor.path_time_s(),
            depositing: road.is_some(),
            target_width_m: road.map(|road| road.target_width_m),
            layer_height_m: road.map(|road| road.height_m),
            hotend_target: self.heaters.hotend_target,
            hotend_sliced_target: self.executor.sliced().hotend,
            bed_target: self.heaters.bed_target,
            hotend_duty: self.heaters.hotend_duty,
            bed_duty: self.heaters.bed_duty,
            fan: self.fan(),
            trims: self.motion.trims.unwrap_or(self.in_force.trims),
            advance_s: self.advance_s,
            homed: self.executor.homed(),
            mains_on: self.mains_on,
            filament_present: self
                .params
                .simulator
                .firmware
                .runout_switch
                .then_some(!self.faults_in_force.run_out),
            part_fan_speed_1_s: self.part_fan.speed_1_s(),
            stop_input: self.params.simulator.firmware.stop_input.then_some(self.faults_in_force.stop_input),
        }
    }
}
