//! The catalogue of faults (`config/faults.yaml`): what may go wrong, what has to follow, within what time, and how it
//! is brought about.

mod process_spec;
mod source;
mod trial_spec;

pub use process_spec::{Act, Bench, Bound, DiskAnswer, ProcessSpec};
pub use source::LimitSource;
pub use trial_spec::{Mark, OnsetSpec, Person, TrialSpec};

use anyhow::{Context, bail};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// All that is asked of the whole.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Catalogue {
    /// What is printed meanwhile, by name.
    pub jobs: BTreeMap<String, JobSpec>,
    /// Every fault, in the order of the catalogue.
    pub faults: Vec<FaultSpec>,
    /// Sound prints with every nuisance: nothing may trip.
    pub sound: Vec<SoundSpec>,
}

/// What is printed.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JobSpec {
    /// A G-code file, relative to the folder of the parameter files.
    #[serde(default)]
    pub file: Option<String>,
    /// Or its text.
    #[serde(default)]
    pub text: Option<String>,
    /// Only the first layers.
    #[serde(default)]
    pub layers: Option<u32>,
    /// The printer starts hot.
    #[serde(default)]
    pub warm: bool,
}

/// One entry.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FaultSpec {
    /// ID of the catalogue.
    pub id: String,
    /// What goes wrong.
    pub fault: String,
    /// What has to follow.
    pub reaction: Reaction,
    /// The limit in words, where it is not one of seconds.
    #[serde(default)]
    pub limit: Option<String>,
    /// Where the limits come from, in words and of every trial that names no other source.
    #[serde(default)]
    pub source: Option<LimitSource>,
    /// How it is shown in virtual time.
    #[serde(default)]
    pub trials: Vec<TrialSpec>,
    /// How it is shown with real processes over DDS.
    #[serde(default)]
    pub process: Vec<ProcessSpec>,
    /// Test of the workspace that shows it.
    #[serde(default)]
    pub test: Option<String>,
    /// Why it cannot be shown yet.
    #[serde(default)]
    pub waiting: Option<String>,
}

/// What the protection of other firmware needs for the same fault `[s]`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Peers {
    /// Klipper.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub klipper_s: Option<f64>,
    /// Marlin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub marlin_s: Option<f64>,
}

/// What has to follow on a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reaction {
    /// Nothing: the loop bears it, or refuses what is wrong.
    None,
    /// `fdm` tells that a process ended or hangs; corrections may be taken back, or go on where it was not missed.
    Told,
    /// An event says so, nothing else follows.
    Flagged,
    /// The printer is at the slicer's own values.
    Baseline,
    /// Corrections are no longer asked for: the supervisor is in `observe`.
    Observe,
    /// Corrections are taken back.
    Degraded,
    /// The print pauses.
    Paused,
    /// Heaters off for good.
    SafeOff,
    /// Emergency stop, mains open.
    Estop,
}

impl Reaction {
    /// Name in files and figures.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Told => "told",
            Self::Flagged => "flagged",
            Self::Baseline => "baseline",
            Self::Observe => "observe",
            Self::Degraded => "degraded",
            Self::Paused => "paused",
            Self::SafeOff => "safe_off",
            Self::Estop => "estop",
        }
    }
}

/// A sound print.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SoundSpec {
    /// A G-code file, relative to the folder of the parameter files.
    pub file: String,
    /// Material instead of the file's.
    #[serde(default)]
    pub material: Option<String>,
    /// A scenario with nuisances only.
    #[serde(default)]
    pub scenario: Option<String>,
    /// Only the first layers.
    #[serde(default)]
    pub layers: Option<u32>,
    /// `off`, `encoder` or `mpc`.
    #[serde(default = "trial_spec::mpc")]
    pub control: String,
    /// Frames are rendered and judged, accelerations sampled: slow, so only a share of the hours is of such prints.
    #[serde(default)]
    pub camera: bool,
}

impl Catalogue {
    /// Reads and checks it.
    ///
    /// # Errors
    /// File, line and field; an ID that stands twice, is shown by nothing, or names no job.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let catalogue: Self = runtime::params::from_yaml(path)?;
        catalogue.check().with_context(|| path.display().to_string())?;
        Ok(catalogue)
    }

    fn check(&self) -> anyhow::Result<()> {
        let mut ids = std::collections::BTreeSet::new();
        for fault in &self.faults {
            let id = &fault.id;
            if !ids.insert(id) {
                bail!("{id} stands there twice");
            }
            let shown = !fault.trials.is_empty() || !fault.process.is_empty() || fault.test.is_some();
            if !shown && fault.waiting.is_none() {
                bail!("{id} has no trial, no test and no reason to wait");
            }
            source::check(fault)?;
            for trial in &fault.process {
                trial.check().with_context(|| format!("{id}, process trial '{}'", trial.name))?;
            }
            for trial in &fault.trials {
                let name = &trial.name;
                if !self.jobs.contains_key(&trial.job) {
                    bail!("{id}, trial '{name}': job '{}' is unknown", trial.job);
                }
                trial
                    .entries()
                    .and_then(|_| trial.check())
                    .with_context(|| format!("{id}, trial '{name}'"))?;
            }
        }
        Ok(())
    }
}
