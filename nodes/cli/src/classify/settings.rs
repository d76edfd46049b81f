//! `config/models/training.yaml`.

use crate::config::ConfigDir;
use anyhow::bail;
use defect_classifier::network::training::FitParams;
use serde::Deserialize;

/// How the committed networks are made and judged.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Settings {
    /// Seed of everything that is left to chance.
    pub(super) seed: u64,
    /// Resamples of a bootstrap interval.
    pub(super) resamples: u32,
    pub(super) renders: RenderSettings,
    pub(super) photographs: PhotographSettings,
    /// Fit of the toolhead's network.
    pub(super) toolhead_fit: FitParams,
    /// Fit of the photographs' network.
    pub(super) photograph_fit: FitParams,
}

/// Rendered frames.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RenderSettings {
    /// Frames per class of the training style.
    pub(super) per_class: u32,
    /// Frames per class of the test style.
    pub(super) test_per_class: u32,
    /// First seed of the training frames.
    pub(super) first_seed: u64,
    /// First seed of the test frames.
    pub(super) test_first_seed: u64,
    /// How many times as many frames of nothing wrong.
    pub(super) ok_times: u32,
    /// Radius of the disc that the head hides, as share of the picture's height.
    pub(super) hidden_share: f64,
    /// Threads that render.
    pub(super) threads: u32,
}

/// Photographs.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PhotographSettings {
    /// Share of the groups that no training sees.
    pub(super) held_out_share: f64,
    /// Beginnings of sources that no training sees.
    pub(super) unseen_sources: Vec<String>,
}

/// Reads the settings.
///
/// # Errors
/// File, line, field and what is wrong.
pub(super) fn load(config: &ConfigDir) -> anyhow::Result<Settings> {
    let path = config.file("models/training.yaml");
    let settings: Settings = runtime::params::from_yaml(&path)?;
    let renders = settings.renders;
    if renders.first_seed + u64::from(renders.per_class * renders.ok_times) > renders.test_first_seed {
        bail!("{}: renders.test_first_seed lies among the seeds of training", path.display());
    }
    if !(0.05..=0.9).contains(&settings.photographs.held_out_share) {
        bail!("{}: photographs.held_out_share must be in [0.05, 0.9]", path.display());
    }
    if settings.resamples < 100 || renders.threads == 0 || renders.ok_times == 0 {
        bail!("{}: resamples below 100, or threads or ok_times of 0", path.display());
    }
    Ok(settings)
}
