//! `config/plants/wire.yaml` and `config/wire/printer_sim.param.yaml`.

use models::params::{ParamError, in_range};
use serde::Deserialize;
use std::path::PathBuf;

/// The simulated process. Built only from a valid [`RawParams`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawParams")]
pub struct Params(RawParams);

impl std::ops::Deref for Params {
    type Target = RawParams;
    fn deref(&self) -> &RawParams {
        &self.0
    }
}

/// The `wire_plant` block as it is written; ranges stand beside the values of the file.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawParams {
    /// Diameter of the wire `[m]`.
    pub diameter_m: f64,
    /// Length of wire that makes one drop `[m]`.
    pub drop_length_m: f64,
    /// Wire delivered per commanded `[-]`.
    pub feed_ratio: f64,
    /// Width of the wall `[m]`.
    pub bead_width_m: f64,
    /// Standard deviation of a drop's bell along the wall `[m]`.
    pub spread_m: f64,
    /// First-order lag of wire drive and head `[s]`.
    pub drive_lag_s: f64,
    /// Length of the wall `[m]`.
    pub wall_length_m: f64,
    /// Grid of the surface `[m]`.
    pub cell_m: f64,
    /// Time of the way back to the start of the next layer `[s]`.
    pub return_s: f64,
    /// Scatter of a drop's volume, relative `[-]`.
    pub drop_volume_sigma: f64,
    /// Scatter of a drop's place `[m]`.
    pub drop_place_sigma_m: f64,
    /// Dips and bumps in a layer `[-]`.
    pub features_per_layer: u32,
    /// Their height, up or down `[m]`.
    pub feature_height_m: f64,
    /// Standard deviation of their bell along the wall `[m]`.
    pub feature_length_m: f64,
    /// The height sensor.
    pub sensor: RawSensor,
}

/// The `sensor` block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawSensor {
    /// Time between two samples `[s]`.
    pub period_s: f64,
    /// Noise of a sample, standard deviation `[m]`.
    pub sigma_m: f64,
    /// Time from the measurement to its arrival `[s]`.
    pub delay_s: f64,
    /// How far behind the head the sensor looks `[m]`.
    pub trail_m: f64,
}

impl TryFrom<RawParams> for Params {
    type Error = ParamError;

    fn try_from(raw: RawParams) -> Result<Self, ParamError> {
        in_range("diameter_m", raw.diameter_m, "m", (1e-4, 0.02))?;
        in_range("drop_length_m", raw.drop_length_m, "m", (1e-4, 0.1))?;
        in_range("feed_ratio", raw.feed_ratio, "-", (0.5, 1.5))?;
        in_range("bead_width_m", raw.bead_width_m, "m", (1e-4, 0.1))?;
        in_range("spread_m", raw.spread_m, "m", (1e-4, 0.05))?;
        in_range("drive_lag_s", raw.drive_lag_s, "s", (0.001, 10.0))?;
        in_range("wall_length_m", raw.wall_length_m, "m", (0.01, 10.0))?;
        in_range("cell_m", raw.cell_m, "m", (1e-5, 0.01))?;
        in_range("return_s", raw.return_s, "s", (0.0, 1000.0))?;
        in_range("drop_volume_sigma", raw.drop_volume_sigma, "-", (0.0, 0.5))?;
        in_range("drop_place_sigma_m", raw.drop_place_sigma_m, "m", (0.0, 0.01))?;
        in_range("features_per_layer", f64::from(raw.features_per_layer), "-", (0.0, 100.0))?;
        in_range("feature_height_m", raw.feature_height_m, "m", (0.0, 0.01))?;
        in_range("feature_length_m", raw.feature_length_m, "m", (0.001, 1.0))?;
        in_range("sensor.period_s", raw.sensor.period_s, "s", (0.001, 100.0))?;
        in_range("sensor.sigma_m", raw.sensor.sigma_m, "m", (0.0, 0.01))?;
        in_range("sensor.delay_s", raw.sensor.delay_s, "s", (0.0, 1000.0))?;
        in_range("sensor.trail_m", raw.sensor.trail_m, "m", (0.0, 1.0))?;
        Ok(Self(raw))
    }
}

impl Params {
    /// The same process with another noise of its sensor `[m]`.
    ///
    /// # Errors
    /// [`ParamError::OutOfRange`] as for the parameters themselves.
    pub fn with_noise(&self, sigma_m: f64) -> Result<Self, ParamError> {
        Self::try_from(RawParams { sensor: RawSensor { sigma_m, ..self.0.sensor }, ..self.0 })
    }
}

/// Paces of the machine. Built only from valid [`RawMachine`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawMachine")]
pub struct MachineSettings(RawMachine);

impl std::ops::Deref for MachineSettings {
    type Target = RawMachine;
    fn deref(&self) -> &RawMachine {
        &self.0
    }
}

/// The `wire_machine` block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawMachine {
    /// Period of the machine's state `[s]`.
    pub status_period_s: f64,
    /// Smallest standard deviation that the height sensor states `[m]`.
    pub sigma_floor_m: f64,
}

impl TryFrom<RawMachine> for MachineSettings {
    type Error = ParamError;

    fn try_from(raw: RawMachine) -> Result<Self, ParamError> {
        in_range("status_period_s", raw.status_period_s, "s", (0.01, 1.0))?;
        in_range("sigma_floor_m", raw.sigma_floor_m, "m", (1e-7, 1e-3))?;
        Ok(Self(raw))
    }
}

/// What is built and how fast. Built only from a valid [`RawWireRun`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawWireRun")]
pub struct WireRun(RawWireRun);

impl std::ops::Deref for WireRun {
    type Target = RawWireRun;
    fn deref(&self) -> &RawWireRun {
        &self.0
    }
}

/// The `run` block of the wire process as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawWireRun {
    /// Must be `wire`.
    pub process: crate::run_params::ProcessKind,
    /// Layers of the wall `[-]`.
    pub layers: u32,
    /// Seed of all scatter and noise.
    pub seed: u64,
    /// Simulated over wall time `[-]`.
    pub speed: f64,
    /// Text of the configuration of the whole graph; empty for this node's own.
    pub config_file: PathBuf,
}

impl TryFrom<RawWireRun> for WireRun {
    type Error = ParamError;

    fn try_from(raw: RawWireRun) -> Result<Self, ParamError> {
        in_range("layers", f64::from(raw.layers), "-", (1.0, 10_000.0))?;
        in_range("speed", raw.speed, "-", (0.1, 20.0))?;
        Ok(Self(raw))
    }
}
