//! `config/identify.yaml`.

use crate::config::ConfigDir;
use anyhow::Context;
use models::params::{in_range, ordered, positive};
use serde::Deserialize;

/// The block `identify`; unit, range and meaning stand beside each value in the file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct IdentifyParams {
    pub(super) excitation: Excitation,
    pub(super) prior: Prior,
    pub(super) fit: Fitting,
    pub(super) trial: Trial,
}

/// What a bag must hold.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Excitation {
    pub(super) temperature_hz: f64,
    pub(super) state_hz: f64,
    pub(super) rise_k: f64,
    pub(super) cold_s: f64,
    pub(super) hot_k: f64,
    pub(super) duty_low: f64,
    pub(super) duty_high: f64,
    pub(super) duty_s: f64,
    pub(super) still_s: f64,
    pub(super) fan_low: f64,
    pub(super) fan_high: f64,
    pub(super) fan_s: f64,
    pub(super) flow_m3_s: f64,
    pub(super) flow_s: f64,
    pub(super) motion_hz: f64,
    pub(super) widths: usize,
    pub(super) after_step: usize,
    pub(super) after_s: f64,
    pub(super) step_rel: f64,
    pub(super) flow_ratio: f64,
}

/// What is believed before a bag is read: standard deviations.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Prior {
    pub(super) capacity_rel: f64,
    pub(super) coupling_rel: f64,
    pub(super) loss_rel: f64,
    pub(super) sensor_lag_rel: f64,
    pub(super) melt_heat_rel: f64,
    pub(super) ambient_k: f64,
    pub(super) compression_rel: f64,
    pub(super) linear_lag_rel: f64,
    pub(super) flow_index: f64,
    pub(super) activation_rel: f64,
    pub(super) gain: f64,
    pub(super) gain_walk_rel: f64,
}

/// How it is fitted.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Fitting {
    pub(super) gain_knot_m: f64,
    pub(super) cell_s: f64,
    pub(super) calm_s: f64,
    pub(super) calm_rel: f64,
    pub(super) road_s: f64,
    pub(super) rounds: u32,
    pub(super) steps: u32,
    pub(super) tolerance: f64,
    pub(super) lag_speeds_m_s: [f64; 3],
    pub(super) informed: f64,
    pub(super) misfit_max: f64,
}

/// Ranges of simulated printers.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Trial {
    pub(super) hotend_rel: f64,
    pub(super) melt_heat_rel: f64,
    pub(super) compliance_rel: f64,
    pub(super) linear_lag_rel: f64,
    pub(super) consistency_rel: f64,
    pub(super) activation_rel: f64,
    pub(super) flow_index: f64,
    pub(super) ambient_k: f64,
    pub(super) noise_rel: f64,
}

impl IdentifyParams {
    /// Reads and checks the file.
    pub(super) fn load(config: &ConfigDir) -> anyhow::Result<Self> {
        let params: Self = crate::process::block(config, "identify.yaml", "identify")?;
        params.check().with_context(|| config.file("identify.yaml").display().to_string())?;
        Ok(params)
    }

    fn check(&self) -> Result<(), models::params::ParamError> {
        let (excitation, prior, fit) = (&self.excitation, &self.prior, &self.fit);
        for (name, value) in [
            ("excitation.temperature_hz", excitation.temperature_hz),
            ("excitation.state_hz", excitation.state_hz),
            ("excitation.rise_k", excitation.rise_k),
            ("excitation.cold_s", excitation.cold_s),
            ("excitation.hot_k", excitation.hot_k),
            ("excitation.duty_s", excitation.duty_s),
            ("excitation.still_s", excitation.still_s),
            ("excitation.fan_s", excitation.fan_s),
            ("excitation.flow_m3_s", excitation.flow_m3_s),
            ("excitation.flow_s", excitation.flow_s),
            ("excitation.motion_hz", excitation.motion_hz),
            ("excitation.after_s", excitation.after_s),
            ("prior.capacity_rel", prior.capacity_rel),
            ("prior.coupling_rel", prior.coupling_rel),
            ("prior.loss_rel", prior.loss_rel),
            ("prior.sensor_lag_rel", prior.sensor_lag_rel),
            ("prior.melt_heat_rel", prior.melt_heat_rel),
            ("prior.ambient_k", prior.ambient_k),
            ("prior.compression_rel", prior.compression_rel),
            ("prior.linear_lag_rel", prior.linear_lag_rel),
            ("prior.flow_index", prior.flow_index),
            ("prior.activation_rel", prior.activation_rel),
            ("prior.gain", prior.gain),
            ("prior.gain_walk_rel", prior.gain_walk_rel),
            ("fit.tolerance", fit.tolerance),
        ] {
            positive(name, value, "-")?;
        }
        self.check_ranges()
    }

    fn check_ranges(&self) -> Result<(), models::params::ParamError> {
        let (excitation, fit, trial) = (&self.excitation, &self.fit, &self.trial);
        for (name, value, range) in [
            ("excitation.duty_low", excitation.duty_low, (0.0, 1.0)),
            ("excitation.duty_high", excitation.duty_high, (0.0, 1.0)),
            ("excitation.fan_low", excitation.fan_low, (0.0, 1.0)),
            ("excitation.fan_high", excitation.fan_high, (0.0, 1.0)),
            ("excitation.step_rel", excitation.step_rel, (0.0, 10.0)),
            ("excitation.flow_ratio", excitation.flow_ratio, (1.0, 100.0)),
            ("fit.gain_knot_m", fit.gain_knot_m, (0.01, 10.0)),
            ("fit.cell_s", fit.cell_s, (0.001, 0.1)),
            ("fit.calm_s", fit.calm_s, (0.0, 10.0)),
            ("fit.calm_rel", fit.calm_rel, (0.0, 1.0)),
            ("fit.road_s", fit.road_s, (0.0, 10.0)),
            ("fit.misfit_max", fit.misfit_max, (1.0, 1e6)),
            ("fit.rounds", f64::from(fit.rounds), (2.0, 20.0)),
            ("fit.steps", f64::from(fit.steps), (1.0, 1000.0)),
            ("fit.informed", fit.informed, (0.0, 1.0)),
            ("trial.hotend_rel", trial.hotend_rel, (0.0, 0.5)),
            ("trial.melt_heat_rel", trial.melt_heat_rel, (0.0, 0.5)),
            ("trial.compliance_rel", trial.compliance_rel, (0.0, 0.5)),
            ("trial.linear_lag_rel", trial.linear_lag_rel, (0.0, 0.5)),
            ("trial.consistency_rel", trial.consistency_rel, (0.0, 0.5)),
            ("trial.activation_rel", trial.activation_rel, (0.0, 0.5)),
            ("trial.flow_index", trial.flow_index, (0.0, 0.05)),
            ("trial.ambient_k", trial.ambient_k, (0.0, 20.0)),
            ("trial.noise_rel", trial.noise_rel, (0.0, 0.9)),
        ] {
            in_range(name, value, "-", range)?;
        }
        for speed_m_s in fit.lag_speeds_m_s {
            in_range("fit.lag_speeds_m_s", speed_m_s, "m/s", (1e-5, 0.05))?;
        }
        // Of equal speeds no law could be told.
        for pair in fit.lag_speeds_m_s.windows(2) {
            ordered(("fit.lag_speeds_m_s", pair[0]), ("the next one", pair[1]))?;
        }
        Ok(())
    }
}
