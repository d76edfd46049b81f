//! What printer and job are doing. The definitions in `msg/` and `srv/` are the truth.

use crate::definition::{Definition, RosType};
use crate::standard::Header;
use serde::{Deserialize, Serialize};

/// State of printer and job at one moment, by the bridge or the simulated printer (topic
/// printer/state).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PrinterState {
    /// stamp [s]: time of validity on the node's clock
    pub header: Header,
    /// Where the job stands, one of PHASE_*. Range `[0, 5]`.
    pub phase: u8,
    /// Who executes trims, and how fast, one of HOST_*. Range `[0, 3]`.
    pub host: u8,
    /// Share of the file's filament already commanded. Range `[0, 1]`.
    pub progress: f64,
    /// False before the first layer mark or first extrusion.
    pub layer_known: bool,
    /// Layer from 0. Invalid where layer_known is false.
    pub layer: u32,
    /// Line of the G-code file being executed, from 1; 0 before the first.
    pub line: u64,
    /// Commanded tool position in the bed frame `[m]`.
    pub position_m: [f64; 3],
    /// Executed path speed, speed trim included `[m/s]`. Range `[0, inf)`.
    pub path_speed_m_s: f64,
    /// The slicer's own path speed here, before the speed trim `[m/s]`. Range `[0, inf)`.
    pub planned_speed_m_s: f64,
    /// The slicer's own filament feed here, before every trim; negative in a retraction `[m/s]`.
    pub planned_feed_m_s: f64,
    /// Filament the extruder motor was told to push since start, every trim included `[m]`.
    pub motor_position_m: f64,
    /// Filament that ought to have passed the drive gear since start, slip compensation excluded `[m]`.
    pub wanted_position_m: f64,
    /// Time along the slicer's own plan `[s]`. Range `[0, inf)`.
    pub path_time_s: f64,
    /// The move deposits a road: tool and filament both advance.
    pub depositing: bool,
    /// False while no road is deposited.
    pub target_width_known: bool,
    /// Width of the road the slicer asked for `[m]`. Range `[0, inf)`; invalid where target_width_known
    /// is false.
    pub target_width_m: f64,
    /// False while no road is deposited.
    pub layer_height_known: bool,
    /// Height of the road `[m]`. Range `[0, inf)`; invalid where layer_height_known is false.
    pub layer_height_m: f64,
    /// Hot end set-point in force, offset included `[degC]`.
    pub hotend_target_degc: f64,
    /// Hot end set-point of the file `[degC]`.
    pub hotend_sliced_target_degc: f64,
    /// Bed set-point in force `[degC]`.
    pub bed_target_degc: f64,
    /// Hot end heater duty. Range `[0, 1]`.
    pub hotend_duty: f64,
    /// Bed heater duty. Range `[0, 1]`.
    pub bed_duty: f64,
    /// Part fan. Range `[0, 1]`.
    pub fan: f64,
    /// Flow trim in force; 1 on the slicer's values. Range `[0, inf)`.
    pub flow_factor: f64,
    /// Speed trim in force; 1 on the slicer's values. Range `[0, inf)`.
    pub speed_factor: f64,
    /// Offset in force on the file's hot end set-point `[K]`.
    pub nozzle_setpoint_offset_k: f64,
    /// An advance was commanded; false: the file's own.
    pub set_advance: bool,
    /// Commanded pressure advance `[s]`. Range `[0, inf)`; invalid where set_advance is false.
    pub trim_advance_s: f64,
    /// The encoder loop is closed around slip_compensation.
    pub close_extruder_loop: bool,
    /// Share of the feed lost in the drive gear, made up for. Range `[0, 1)`; invalid where
    /// close_extruder_loop is false.
    pub slip_compensation: f64,
    /// Advance in force: the file's own or the commanded one `[s]`. Range `[0, inf)`.
    pub advance_s: f64,
    /// All axes know their place.
    pub homed: bool,
    /// The mains relay feeds the heaters.
    pub mains_on: bool,
    /// False where the printer has no run-out switch.
    pub filament_switch_fitted: bool,
    /// The run-out switch sees filament. Invalid where filament_switch_fitted is false.
    pub filament_present: bool,
    /// False where the part fan has no tachometer.
    pub part_fan_speed_known: bool,
    /// Revolutions of the part fan `[1/s]`. Range `[0, inf)`; invalid where part_fan_speed_known is
    /// false.
    pub part_fan_speed_1_s: f64,
    /// False where the printer has no stop contact.
    pub stop_input_fitted: bool,
    /// The stop contact is open: emergency-stop button or door. Invalid where stop_input_fitted is
    /// false.
    pub stop_input: bool,
}

impl PrinterState {
    /// `PHASE_IDLE` of the definition.
    pub const PHASE_IDLE: u8 = 0;
    /// `PHASE_PREPARING` of the definition.
    pub const PHASE_PREPARING: u8 = 1;
    /// `PHASE_PRINTING` of the definition.
    pub const PHASE_PRINTING: u8 = 2;
    /// `PHASE_PAUSED` of the definition.
    pub const PHASE_PAUSED: u8 = 3;
    /// `PHASE_DONE` of the definition.
    pub const PHASE_DONE: u8 = 4;
    /// `PHASE_FAILED` of the definition.
    pub const PHASE_FAILED: u8 = 5;
    /// `HOST_NATIVE` of the definition.
    pub const HOST_NATIVE: u8 = 0;
    /// `HOST_SERIAL` of the definition.
    pub const HOST_SERIAL: u8 = 1;
    /// `HOST_MOONRAKER` of the definition.
    pub const HOST_MOONRAKER: u8 = 2;
    /// `HOST_OCTOPRINT` of the definition.
    pub const HOST_OCTOPRINT: u8 = 3;
}

impl RosType for PrinterState {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "PrinterState",
        text: include_str!("../msg/PrinterState.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}

/// One planned move as a timed trapezoid, published before it is executed (topic printer/motion).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct MotionSegment {
    /// stamp [s]: time of publication on the node's clock
    pub header: Header,
    /// Counts up by one per segment of a print.
    pub sequence: u64,
    /// Start on the slicer's own plan (PrinterState.path_time_s) `[s]`. Range `[0, inf)`.
    pub start_time_s: f64,
    /// Line of the G-code file, from 1.
    pub line: u64,
    /// False before the first layer.
    pub layer_known: bool,
    /// Layer from 0. Invalid where layer_known is false.
    pub layer: u32,
    /// One of KIND_*. Range `[0, 4]`.
    pub kind: u8,
    /// One of ROLE_*. Range `[0, 13]`.
    pub role: u8,
    /// Start in the bed frame `[m]`.
    pub start_m: [f64; 3],
    /// End in the bed frame `[m]`.
    pub end_m: [f64; 3],
    /// Way of the tool; 0 where only filament moves `[m]`. Range `[0, inf)`.
    pub length_m: f64,
    /// Path speed at the start `[m/s]`. Range `[0, inf)`.
    pub entry_speed_m_s: f64,
    /// Path speed of the flat part `[m/s]`. Range `[0, inf)`.
    pub cruise_speed_m_s: f64,
    /// Path speed at the end `[m/s]`. Range `[0, inf)`.
    pub exit_speed_m_s: f64,
    /// Duration of the speeding-up part `[s]`. Range `[0, inf)`.
    pub accelerate_s: f64,
    /// Duration of the flat part `[s]`. Range `[0, inf)`.
    pub cruise_s: f64,
    /// Duration of the slowing-down part `[s]`. Range `[0, inf)`.
    pub decelerate_s: f64,
    /// Filament fed over the segment; negative in a retraction `[m]`.
    pub filament_m: f64,
    /// False where no road is deposited.
    pub target_width_known: bool,
    /// Width the slicer asked for `[m]`. Range `[0, inf)`; invalid where target_width_known is false.
    pub target_width_m: f64,
    /// False where no road is deposited.
    pub target_height_known: bool,
    /// Height of the road `[m]`. Range `[0, inf)`; invalid where target_height_known is false.
    pub target_height_m: f64,
}

impl MotionSegment {
    /// `KIND_TRAVEL` of the definition.
    pub const KIND_TRAVEL: u8 = 0;
    /// `KIND_DEPOSIT` of the definition.
    pub const KIND_DEPOSIT: u8 = 1;
    /// `KIND_RETRACT` of the definition.
    pub const KIND_RETRACT: u8 = 2;
    /// `KIND_PRIME` of the definition.
    pub const KIND_PRIME: u8 = 3;
    /// `KIND_WIPE` of the definition.
    pub const KIND_WIPE: u8 = 4;
    /// `ROLE_UNKNOWN` of the definition.
    pub const ROLE_UNKNOWN: u8 = 0;
    /// `ROLE_CUSTOM` of the definition.
    pub const ROLE_CUSTOM: u8 = 1;
    /// `ROLE_SKIRT` of the definition.
    pub const ROLE_SKIRT: u8 = 2;
    /// `ROLE_EXTERNAL_PERIMETER` of the definition.
    pub const ROLE_EXTERNAL_PERIMETER: u8 = 3;
    /// `ROLE_PERIMETER` of the definition.
    pub const ROLE_PERIMETER: u8 = 4;
    /// `ROLE_OVERHANG` of the definition.
    pub const ROLE_OVERHANG: u8 = 5;
    /// `ROLE_INFILL` of the definition.
    pub const ROLE_INFILL: u8 = 6;
    /// `ROLE_SOLID` of the definition.
    pub const ROLE_SOLID: u8 = 7;
    /// `ROLE_TOP_SOLID` of the definition.
    pub const ROLE_TOP_SOLID: u8 = 8;
    /// `ROLE_BRIDGE` of the definition.
    pub const ROLE_BRIDGE: u8 = 9;
    /// `ROLE_GAP_FILL` of the definition.
    pub const ROLE_GAP_FILL: u8 = 10;
    /// `ROLE_SUPPORT` of the definition.
    pub const ROLE_SUPPORT: u8 = 11;
    /// `ROLE_IRONING` of the definition.
    pub const ROLE_IRONING: u8 = 12;
    /// `ROLE_TOWER` of the definition.
    pub const ROLE_TOWER: u8 = 13;
}

impl RosType for MotionSegment {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "MotionSegment",
        text: include_str!("../msg/MotionSegment.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}

/// What is being printed, with what configuration and build (topic print/info, latched).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PrintInfo {
    /// stamp [s]: time the print was started on the node's clock
    pub header: Header,
    /// Unique name of the print.
    pub print_id: String,
    /// File name without folder.
    pub gcode_file: String,
    /// SHA-256 of the file, lower-case hexadecimal.
    pub gcode_sha256: String,
    /// Text of the configuration in force, canonical form.
    pub config: String,
    /// SHA-256 of config, lower-case hexadecimal.
    pub config_sha256: String,
    /// Version and commit of the software.
    pub build: String,
    /// Name of the scenario; empty on a real printer.
    pub scenario: String,
}

impl RosType for PrintInfo {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "PrintInfo",
        text: include_str!("../msg/PrintInfo.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}
