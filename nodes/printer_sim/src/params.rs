//! Parameters: the plant's file (`config/plants/`) and the simulated host, firmware and sensors
//! (`config/printer_sim.param.yaml`).

use crate::camera::CameraParams;
use crate::sliced::SlicedFor;
use crate::structure::{ImpactParams, StructureParams};
use crate::{drive, executor, fan, imu, sensors};
use models::bed::Bed;
use models::command::{DeadManParams, Limits};
use models::extruder::{Extruder, Filament, SlipParams};
use models::heater::PidParams;
use models::hotend::Hotend;
use models::latent::Cooling;
use models::material::{Deviation, Material};
use models::params::{ParamError, in_range};
use models::quality::Quality;
use models::units::{Celsius, Kelvin};
use serde::Deserialize;

mod host;
pub use host::{RawHost, RawLink};

/// The simulated printer's physics: the `plant` block of a plant file.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlantParams {
    /// Hot end.
    pub hotend: Hotend,
    /// Bed.
    pub bed: Bed,
    /// Extruder and nozzle.
    pub extruder: Extruder,
    /// How a laid road cools.
    pub cooling: Cooling,
    /// Firmware's loop of the hot end.
    pub heater: PidParams,
    /// Firmware's loop of the bed.
    pub bed_heater: PidParams,
    /// Slip of the drive gear.
    pub slip: SlipParams,
    /// The spool's diameter.
    pub filament: Filament,
    /// The spool's material against what the estimator believes.
    pub material_deviation: Deviation,
    /// Resonances of the tool head.
    pub structure: StructureParams,
    /// Blows to the tool head.
    pub impact: ImpactParams,
    /// The printer that files are sliced for.
    pub sliced_for: SlicedFor,
    /// Room and incoming filament `[K]`.
    pub ambient_temp_k: f64,
}

/// Firmware of the simulated printer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Firmware {
    /// Advance before the file sets one `[s]`.
    pub advance_s: f64,
    /// Time in which the advance passes from file to permit or schedule and back `[s]`.
    pub advance_handover_s: f64,
    /// The same where nothing is laid, or corrections have to be back soon `[s]`.
    pub advance_return_s: f64,
    /// Hot end set-point while a pause lasts.
    pub standby: Celsius,
    /// Reading of a hot end whose heaters a supervisor has switched off above which the part fan cools it.
    pub cool_above: Celsius,
    /// Period of the printer's state `[s]`.
    pub status_period_s: f64,
    /// Time until a trim acts, at least and at most `[s]`; `None` where it acts at once.
    pub effect_s: Option<(f64, f64)>,
    /// Period of the heat balance `[s]`.
    pub thermal_period_s: f64,
    /// A run-out switch is fitted.
    pub runout_switch: bool,
    /// A stop contact is fitted.
    pub stop_input: bool,
    /// Part fan.
    pub part_fan: fan::Settings,
    /// Layer below the road `[K]` under its bed: how much colder it is than the bed.
    pub below_bed_k: f64,
    /// Flow at which a slicer's set-point is meant `[m3/s]`.
    pub reference_flow_m3_s: f64,
}

/// The `simulator` block of `config/printer_sim.param.yaml`.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawSimulator")]
pub struct SimulatorParams {
    /// Job execution.
    pub executor: executor::Settings,
    /// Extruder drive.
    pub drive: drive::Settings,
    /// Firmware.
    pub firmware: Firmware,
    /// Sensors.
    pub sensors: sensors::Settings,
    /// Inertial unit.
    pub imu: imu::Settings,
}

/// The `simulator` block as it is written.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "unit, range and meaning stand beside each value in the file")]
pub struct RawSimulator {
    pub host: RawHost,
    pub serial_buffer_moves: usize,
    pub serial_buffer_s: f64,
    pub serial_piece_s: f64,
    pub plan_moves: usize,
    pub moonraker: RawLink,
    pub octoprint: RawLink,
    pub plan_s: f64,
    pub schedule_advance_max_s: f64,
    pub schedule_validity_max_s: f64,
    pub pause_ramp_s: f64,
    pub homing_s: f64,
    pub reached_band_k: f64,
    pub loop_gain_1_s: f64,
    pub shortfall_kept_m: f64,
    pub shortfall_fades_s: f64,
    pub loop_period_s: f64,
    pub advance_smooth_s: f64,
    pub advance_s: f64,
    pub advance_handover_s: f64,
    pub advance_return_s: f64,
    pub standby_c: f64,
    pub cool_above_c: f64,
    pub status_period_s: f64,
    pub thermal_period_s: f64,
    pub runout_switch: bool,
    pub stop_input: bool,
    pub part_fan: fan::Settings,
    pub below_bed_k: f64,
    pub reference_flow_m3_s: f64,
    pub temperature_period_s: f64,
    pub temperature_sigma_k: f64,
    pub nozzle_sensor: bool,
    pub encoder_period_s: f64,
    pub encoder_quantum_m: f64,
    pub width_period_s: f64,
    pub width_dither: f64,
    pub width_delay_s: f64,
    pub width_sigma_m: f64,
    pub imu: imu::Settings,
}

impl TryFrom<RawSimulator> for SimulatorParams {
    type Error = ParamError;
    fn try_from(raw: RawSimulator) -> Result<Self, ParamError> {
        let period = |name, value| in_range(name, value, "s", (1e-3, 10.0));
        let link = host::link(&raw)?;
        let period_or_none = |name, value| if value == 0.0 { Ok(0.0) } else { period(name, value) };
        Ok(Self {
            executor: host::executor(&raw)?,
            drive: drive::Settings {
                loop_gain_1_s: in_range("loop_gain_1_s", raw.loop_gain_1_s, "1/s", (0.0, 20.0))?,
                shortfall_kept_m: in_range("shortfall_kept_m", raw.shortfall_kept_m, "m", (0.0, 0.1))?,
                shortfall_fades_s: in_range("shortfall_fades_s", raw.shortfall_fades_s, "s", (0.01, 1e4))?,
                loop_period_s: period("loop_period_s", raw.loop_period_s)?,
                advance_smooth_s: period("advance_smooth_s", raw.advance_smooth_s)?,
            },
            firmware: Firmware {
                advance_s: in_range("advance_s", raw.advance_s, "s", (0.0, 5.0))?,
                advance_handover_s: in_range(
                    "advance_handover_s",
                    raw.advance_handover_s,
                    "s",
                    (0.0, 600.0),
                )?,
                advance_return_s: in_range("advance_return_s", raw.advance_return_s, "s", (0.0, 2.0))?,
                standby: Celsius(in_range("standby_c", raw.standby_c, "degC", (0.0, 250.0))?),
                cool_above: Celsius(in_range("cool_above_c", raw.cool_above_c, "degC", (0.0, 250.0))?),
                status_period_s: link.map_or_else(
                    || period("status_period_s", raw.status_period_s),
                    |link| Ok(link.status_period_s),
                )?,
                effect_s: link.map(|link| link.effect_s),
                thermal_period_s: in_range("thermal_period_s", raw.thermal_period_s, "s", (1e-3, 0.1))?,
                runout_switch: raw.runout_switch,
                stop_input: raw.stop_input,
                part_fan: raw.part_fan,
                below_bed_k: in_range("below_bed_k", raw.below_bed_k, "K", (0.0, 50.0))?,
                reference_flow_m3_s: in_range(
                    "reference_flow_m3_s",
                    raw.reference_flow_m3_s,
                    "m3/s",
                    (0.0, 1e-7),
                )?,
            },
            sensors: sensors::Settings {
                temperature_period_s: period("temperature_period_s", raw.temperature_period_s)?,
                temperature_sigma_k: in_range(
                    "temperature_sigma_k",
                    raw.temperature_sigma_k,
                    "K",
                    (0.0, 10.0),
                )?,
                nozzle_sensor: raw.nozzle_sensor,
                encoder_period_s: period_or_none("encoder_period_s", raw.encoder_period_s)?,
                encoder_quantum_m: in_range("encoder_quantum_m", raw.encoder_quantum_m, "m", (1e-7, 1e-2))?,
                width_period_s: period_or_none("width_period_s", raw.width_period_s)?,
                width_dither: in_range("width_dither", raw.width_dither, "-", (0.0, 0.5))?,
                width_delay_s: in_range("width_delay_s", raw.width_delay_s, "s", (0.0, 10.0))?,
                width_sigma_m: in_range("width_sigma_m", raw.width_sigma_m, "m", (0.0, 1e-3))?,
            },
            imu: raw.imu,
        })
    }
}

/// Everything that a [`Simulator`](crate::Simulator) needs to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Params {
    /// The plant's physics.
    pub plant: PlantParams,
    /// Material as the makers state it; the plant applies its own deviation.
    pub material: Material,
    /// Host, firmware, sensors.
    pub simulator: SimulatorParams,
    /// Camera on the tool head.
    pub camera: CameraParams,
    /// What follows the supervisor's silence.
    pub dead_man: DeadManParams,
    /// The printer's own limits on trims.
    pub limits: Limits,
    /// Quality function that the truth is scored with.
    pub quality: Quality,
    /// How much colder than its block the nozzle is at reference conditions `[K]`: the file's set-point less this
    /// counts as the right nozzle temperature.
    pub nozzle_drop_k: f64,
}

impl PlantParams {
    /// Room and incoming filament.
    #[must_use]
    pub fn ambient(&self) -> Kelvin {
        Kelvin(self.ambient_temp_k)
    }
}
