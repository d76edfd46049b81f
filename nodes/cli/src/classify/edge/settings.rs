//! `config/models/edge_training.yaml`.

use crate::config::ConfigDir;
use anyhow::Context;
use defect_classifier::width::edge::training::EdgeFit;
use models::params::{ParamError, in_range, ordered};
use printer_sim::camera::Style;
use serde::Deserialize;

/// How the edge network is made and judged. Built only from a valid [`RawSettings`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawSettings")]
pub(super) struct Settings(RawSettings);

/// The file as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSettings {
    /// Seed of first weights and windows.
    pub(super) seed: u64,
    /// Threads that render.
    pub(super) threads: u32,
    pub(super) looks: LookSettings,
    pub(super) scene: SceneSettings,
    pub(super) fit: EdgeFit,
}

/// Cameras.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LookSettings {
    pub(super) style: Style,
    /// First seed of training.
    pub(super) first: u64,
    /// How many are trained with.
    pub(super) count: u32,
    /// How many judge it, of either style.
    pub(super) judged: u32,
}

/// One frame of straight roads; unit, range and meaning stand beside each value in the file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneSettings {
    pub(super) heights_m: Vec<f64>,
    pub(super) wanted_m: [f64; 2],
    pub(super) width_rel: [f64; 2],
    pub(super) axis_share: f64,
    pub(super) bed_share: f64,
    pub(super) across_share: f64,
    pub(super) turn_rad: [f64; 2],
    pub(super) solid_max: u32,
    pub(super) solid_half_m: f64,
    pub(super) roads_max: u32,
    pub(super) half_length_m: f64,
    pub(super) away_m: [f64; 2],
    pub(super) speed_m_s: [f64; 2],
    pub(super) along_share: f64,
    pub(super) blur_max_px: f64,
    pub(super) pieces_m: Vec<f64>,
    pub(super) piece_m: f64,
    pub(super) margin_px: f64,
    pub(super) profile_from_m: f64,
    pub(super) profile_to_m: f64,
}

impl std::ops::Deref for Settings {
    type Target = RawSettings;

    fn deref(&self) -> &RawSettings {
        &self.0
    }
}

impl TryFrom<RawSettings> for Settings {
    type Error = ParamError;

    fn try_from(raw: RawSettings) -> Result<Self, ParamError> {
        in_range("threads", f64::from(raw.threads), "-", (1.0, 256.0))?;
        in_range("looks.count", f64::from(raw.looks.count), "looks", (1.0, 1e6))?;
        in_range("looks.judged", f64::from(raw.looks.judged), "looks", (1.0, 1e6))?;
        // A seed that is written into YAML and the file as a number; both styles' looks must fit above it.
        #[expect(clippy::cast_precision_loss, reason = "compared with a power of ten")]
        in_range("looks.first", raw.looks.first as f64, "-", (0.0, 1e15))?;
        raw.scene.check()?;
        Ok(Self(raw))
    }
}

impl SceneSettings {
    fn check(&self) -> Result<(), ParamError> {
        let span = |name, [low, high]: [f64; 2], unit, range: (f64, f64)| {
            in_range(name, low, unit, range)?;
            in_range(name, high, unit, (low, range.1))
        };
        in_range("scene.heights_m", f64::from(u8::from(!self.heights_m.is_empty())), "given", (1.0, 1.0))?;
        for height_m in &self.heights_m {
            in_range("scene.heights_m", *height_m, "m", (5e-5, 1e-3))?;
        }
        for middle_m in &self.pieces_m {
            in_range("scene.pieces_m", *middle_m, "m", (-2e-2, 2e-2))?;
        }
        span("scene.wanted_m", self.wanted_m, "m", (1e-4, 2e-3))?;
        span("scene.width_rel", self.width_rel, "-", (0.2, 3.0))?;
        span("scene.turn_rad", self.turn_rad, "rad", (0.0, 3.15))?;
        span("scene.away_m", self.away_m, "m", (0.0, 2e-2))?;
        span("scene.speed_m_s", self.speed_m_s, "m/s", (0.0, 1.0))?;
        in_range("scene.axis_share", self.axis_share, "-", (0.0, 1.0))?;
        in_range("scene.bed_share", self.bed_share, "-", (0.0, 1.0))?;
        in_range("scene.across_share", self.across_share, "-", (0.0, 1.0))?;
        in_range("scene.along_share", self.along_share, "-", (0.0, 1.0))?;
        in_range("scene.solid_max", f64::from(self.solid_max), "layers", (1.0, 10.0))?;
        in_range("scene.roads_max", f64::from(self.roads_max), "roads", (1.0, 20.0))?;
        in_range("scene.solid_half_m", self.solid_half_m, "m", (1e-3, 2e-2))?;
        in_range("scene.half_length_m", self.half_length_m, "m", (1e-3, 2e-2))?;
        in_range("scene.blur_max_px", self.blur_max_px, "px", (0.0, 100.0))?;
        in_range("scene.piece_m", self.piece_m, "m", (1e-4, 1e-2))?;
        in_range("scene.margin_px", self.margin_px, "px", (1.0, 200.0))?;
        in_range("scene.profile_from_m", self.profile_from_m, "m", (-2e-3, 2e-3))?;
        in_range("scene.profile_to_m", self.profile_to_m, "m", (-2e-3, 2e-3))?;
        ordered(("scene.profile_from_m", self.profile_from_m), ("scene.profile_to_m", self.profile_to_m))
    }
}

/// Reads the settings.
///
/// # Errors
/// File, line, field and what is wrong.
pub(super) fn load(config: &ConfigDir) -> anyhow::Result<Settings> {
    let path = config.file("models/edge_training.yaml");
    runtime::params::from_yaml(&path).with_context(|| path.display().to_string())
}
