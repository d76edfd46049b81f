//! Kinematic limits of a printer and the settings of reader and planner: block `printer_motion`.

use crate::params::{ParamError, in_range};
use serde::Deserialize;

/// Index of an axis in arrays over all four.
pub mod axis {
    /// Carriage.
    pub const X: usize = 0;
    /// Bed, or second carriage.
    pub const Y: usize = 1;
    /// Height.
    pub const Z: usize = 2;
    /// Filament.
    pub const E: usize = 3;
}

/// How fast a corner may be taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Cornering {
    /// Each axis may jump by its jerk (Marlin's classic jerk).
    ClassicJerk,
    /// The corner is a circle that leaves it by the junction deviation (grbl, Klipper, Marlin 2).
    JunctionDeviation,
}

/// Limits in force; a file's `machine_max_*` comments and `M201`-`M205` replace single values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Speed of X, Y, Z, E `[m/s]`.
    pub feedrate_m_s: [f64; 4],
    /// Acceleration of X, Y, Z, E `[m/s2]`.
    pub acceleration_m_s2: [f64; 4],
    /// Instantaneous change of speed of X, Y, Z, E `[m/s]`.
    pub jerk_m_s: [f64; 4],
    /// Path acceleration while tool and filament move `[m/s2]`.
    pub extruding_m_s2: f64,
    /// Path acceleration while the tool alone moves `[m/s2]`.
    pub travel_m_s2: f64,
    /// Acceleration of filament alone `[m/s2]`.
    pub retract_m_s2: f64,
    /// Deviation at a corner `[m]`.
    pub junction_deviation_m: f64,
    /// Law of corners in force.
    pub cornering: Cornering,
}

/// Bounds and defaults of reading a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadParams {
    /// Filament where the file does not state a diameter `[m]`.
    pub filament_diameter_m: f64,
    /// Length of a firmware retraction before any `M207` or `SET_RETRACTION` `[m]`.
    pub firmware_retract_m: f64,
    /// Speed of a firmware retraction before any `M207` or `SET_RETRACTION` `[m/s]`.
    pub firmware_retract_m_s: f64,
    /// Feed before the first F word `[m/s]`.
    pub first_feed_m_s: f64,
    /// Lowest F word that is believed `[m/s]`.
    pub feed_min_m_s: f64,
    /// Largest coordinate that is believed `[m]`.
    pub coordinate_max_m: f64,
    /// Largest E word that is believed `[m]`.
    pub filament_max_m: f64,
    /// E word above which 32-bit firmware loses resolution `[m]`: executed, and named.
    pub filament_noted_m: f64,
    /// Filament of one move above which it is named `[m]`: executed all the same.
    pub filament_move_noted_m: f64,
    /// Highest hot end or bed set-point that is believed `[degC]`.
    pub target_max_c: f64,
    /// Largest distance of a chord from its arc `[m]`.
    pub chord_tolerance_m: f64,
    /// Bytes of a line that are read; the rest is refused.
    pub line_bytes_max: usize,
    /// Bytes of a command beyond which it is named: firmware has short buffers.
    pub command_bytes_noted: usize,
    /// Bytes at each end of a file that are searched for comments on limits.
    pub header_bytes: usize,
    /// Warnings that are kept; more are counted.
    pub warnings_max: usize,
}

/// The block `printer_motion` of `config/printers/*_motion.yaml`.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawMotionParams")]
pub struct MotionParams {
    /// The printer's own limits.
    pub limits: Limits,
    /// Bounds and defaults of reading a file.
    pub read: ReadParams,
    /// Moves known ahead of the one that is released.
    pub lookahead_moves: usize,
    /// No move beyond those is ever known: as a firmware whose buffer holds so many, at the cost of a pass a move.
    pub starved: bool,
}

impl MotionParams {
    /// The same with a buffer that holds no more than so many moves ahead of the current one.
    #[must_use]
    pub fn with_buffer(self, moves: usize) -> Self {
        Self { lookahead_moves: moves, starved: true, ..self }
    }
}

/// The block as it is written; arrays are X, Y, Z, E.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "each field has the name and the meaning of its checked counterpart")]
pub struct RawMotionParams {
    pub feedrate_max_m_s: [f64; 4],
    pub acceleration_max_m_s2: [f64; 4],
    pub jerk_max_m_s: [f64; 4],
    pub extruding_acceleration_m_s2: f64,
    pub travel_acceleration_m_s2: f64,
    pub retract_acceleration_m_s2: f64,
    pub junction_deviation_m: f64,
    pub cornering: Cornering,
    pub lookahead_moves: u32,
    pub chord_tolerance_m: f64,
    pub filament_diameter_m: f64,
    pub firmware_retract_m: f64,
    pub firmware_retract_m_s: f64,
    pub first_feed_m_s: f64,
    pub feed_min_m_s: f64,
    pub coordinate_max_m: f64,
    pub filament_max_m: f64,
    pub filament_noted_m: f64,
    pub filament_move_noted_m: f64,
    pub target_max_c: f64,
    pub line_bytes_max: u32,
    pub command_bytes_noted: u32,
    pub header_bytes: u32,
    pub warnings_max: u32,
}

impl TryFrom<RawMotionParams> for MotionParams {
    type Error = ParamError;

    fn try_from(raw: RawMotionParams) -> Result<Self, ParamError> {
        Ok(Self {
            limits: limits(&raw)?,
            read: reading(&raw)?,
            lookahead_moves: count("printer_motion.lookahead_moves", raw.lookahead_moves, (2.0, 10_000.0))?,
            starved: false,
        })
    }
}

fn limits(raw: &RawMotionParams) -> Result<Limits, ParamError> {
    for axis in 0..4 {
        in_range("printer_motion.feedrate_max_m_s", raw.feedrate_max_m_s[axis], "m/s", (1e-4, 10.0))?;
        in_range(
            "printer_motion.acceleration_max_m_s2",
            raw.acceleration_max_m_s2[axis],
            "m/s2",
            (1e-3, 100.0),
        )?;
        in_range("printer_motion.jerk_max_m_s", raw.jerk_max_m_s[axis], "m/s", (1e-6, 1.0))?;
    }
    let path = |name, value| in_range(name, value, "m/s2", (1e-3, 100.0));
    Ok(Limits {
        feedrate_m_s: raw.feedrate_max_m_s,
        acceleration_m_s2: raw.acceleration_max_m_s2,
        jerk_m_s: raw.jerk_max_m_s,
        extruding_m_s2: path("printer_motion.extruding_acceleration_m_s2", raw.extruding_acceleration_m_s2)?,
        travel_m_s2: path("printer_motion.travel_acceleration_m_s2", raw.travel_acceleration_m_s2)?,
        retract_m_s2: path("printer_motion.retract_acceleration_m_s2", raw.retract_acceleration_m_s2)?,
        junction_deviation_m: in_range(
            "printer_motion.junction_deviation_m",
            raw.junction_deviation_m,
            "m",
            (1e-7, 1e-3),
        )?,
        cornering: raw.cornering,
    })
}

fn reading(raw: &RawMotionParams) -> Result<ReadParams, ParamError> {
    let length = |name, value, range| in_range(name, value, "m", range);
    Ok(ReadParams {
        filament_diameter_m: length(
            "printer_motion.filament_diameter_m",
            raw.filament_diameter_m,
            (1e-3, 4e-3),
        )?,
        firmware_retract_m: length("printer_motion.firmware_retract_m", raw.firmware_retract_m, (0.0, 0.02))?,
        firmware_retract_m_s: in_range(
            "printer_motion.firmware_retract_m_s",
            raw.firmware_retract_m_s,
            "m/s",
            (1e-6, 10.0),
        )?,
        first_feed_m_s: in_range("printer_motion.first_feed_m_s", raw.first_feed_m_s, "m/s", (1e-6, 10.0))?,
        feed_min_m_s: in_range("printer_motion.feed_min_m_s", raw.feed_min_m_s, "m/s", (1e-9, 1.0))?,
        coordinate_max_m: length("printer_motion.coordinate_max_m", raw.coordinate_max_m, (0.01, 100.0))?,
        filament_max_m: length("printer_motion.filament_max_m", raw.filament_max_m, (1.0, 1e6))?,
        filament_noted_m: length("printer_motion.filament_noted_m", raw.filament_noted_m, (1.0, 1e6))?,
        filament_move_noted_m: length(
            "printer_motion.filament_move_noted_m",
            raw.filament_move_noted_m,
            (0.01, 1e3),
        )?,
        target_max_c: in_range("printer_motion.target_max_c", raw.target_max_c, "degC", (100.0, 600.0))?,
        chord_tolerance_m: length("printer_motion.chord_tolerance_m", raw.chord_tolerance_m, (1e-6, 1e-3))?,
        line_bytes_max: count("printer_motion.line_bytes_max", raw.line_bytes_max, (96.0, 16_777_216.0))?,
        command_bytes_noted: count(
            "printer_motion.command_bytes_noted",
            raw.command_bytes_noted,
            (16.0, 16_777_216.0),
        )?,
        header_bytes: count("printer_motion.header_bytes", raw.header_bytes, (1024.0, 16_777_216.0))?,
        warnings_max: count("printer_motion.warnings_max", raw.warnings_max, (1.0, 1e6))?,
    })
}

fn count(name: &'static str, value: u32, range: (f64, f64)) -> Result<usize, ParamError> {
    in_range(name, f64::from(value), "-", range)?;
    Ok(value as usize)
}
