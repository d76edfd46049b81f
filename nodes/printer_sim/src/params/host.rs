//! Who executes trims, and how fast.

use super::RawSimulator;
use crate::executor::Settings;
use models::params::{ParamError, in_range};
use models::status::HostProfile;
use serde::Deserialize;

/// Pace of a host over HTTP.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawLink {
    /// Period of the printer's state `[s]`.
    pub status_period_s: f64,
    /// Time until a trim acts, at least and at most `[s]`.
    pub effect_s: (f64, f64),
}

impl RawLink {
    fn check(&self) -> Result<Self, ParamError> {
        in_range("status_period_s", self.status_period_s, "s", (1e-3, 10.0))?;
        in_range("effect_s", self.effect_s.0, "s", (0.0, 10.0))?;
        in_range("effect_s", self.effect_s.1, "s", (self.effect_s.0, 10.0))?;
        Ok(*self)
    }
}

/// Host profile as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RawHost {
    /// See [`HostProfile::Native`].
    Native,
    /// See [`HostProfile::Serial`].
    Serial,
    /// See [`HostProfile::Moonraker`].
    Moonraker,
    /// See [`HostProfile::Octoprint`].
    Octoprint,
}

/// Pace of the host, where it is one over HTTP.
pub(super) fn link(raw: &RawSimulator) -> Result<Option<RawLink>, ParamError> {
    Ok(match raw.host {
        RawHost::Native | RawHost::Serial => None,
        RawHost::Moonraker => Some(raw.moonraker.check()?),
        RawHost::Octoprint => Some(raw.octoprint.check()?),
    })
}

/// So many moves that a firmware knows ahead.
fn moves(name: &'static str, count: usize) -> Result<usize, ParamError> {
    #[allow(clippy::cast_precision_loss, reason = "what counts is far below 2^52")]
    in_range(name, count as f64, "-", (1.0, 1e4))?;
    Ok(count)
}

/// Settings of the host and the firmware's motion.
pub(super) fn executor(raw: &RawSimulator) -> Result<Settings, ParamError> {
    Ok(Settings {
        host: match raw.host {
            RawHost::Native => HostProfile::Native,
            RawHost::Serial => HostProfile::Serial,
            RawHost::Moonraker => HostProfile::Moonraker,
            RawHost::Octoprint => HostProfile::Octoprint,
        },
        serial_buffer_moves: moves("serial_buffer_moves", raw.serial_buffer_moves)?,
        serial_buffer_s: in_range("serial_buffer_s", raw.serial_buffer_s, "s", (0.0, 10.0))?,
        serial_piece_s: in_range("serial_piece_s", raw.serial_piece_s, "s", (0.01, 10.0))?,
        plan_moves: moves("plan_moves", raw.plan_moves)?,
        plan_s: in_range("plan_s", raw.plan_s, "s", (0.0, 10.0))?,
        schedule_advance_max_s: in_range(
            "schedule_advance_max_s",
            raw.schedule_advance_max_s,
            "s",
            (0.0, 10.0),
        )?,
        schedule_validity_max_s: in_range(
            "schedule_validity_max_s",
            raw.schedule_validity_max_s,
            "s",
            (0.0, 60.0),
        )?,
        pause_ramp_s: in_range("pause_ramp_s", raw.pause_ramp_s, "s", (1e-3, 10.0))?,
        homing_s: in_range("homing_s", raw.homing_s, "s", (0.0, 600.0))?,
        reached_band_k: in_range("reached_band_k", raw.reached_band_k, "K", (0.1, 20.0))?,
    })
}
