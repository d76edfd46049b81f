//! The catalogue of faults (`config/faults.yaml`): what may go wrong, what has to follow, within what time, and how it
//! is brought about.

use crate::sim::relay::Tampering;
use anyhow::{Context, bail};
use printer_sim::scenario::Entry;
use safety_supervisor::Operator;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::Path;

/// Longest time that a trial may name `[s]`.
const LONGEST_S: f64 = 3600.0;
/// Nodes whose parameters a trial may set.
const NODES: [&str; 4] = ["state_estimator", "mpc_controller", "safety_supervisor", "printer_sim"];

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
    /// What other firmware needs.
    #[serde(default)]
    pub peers: Peers,
    /// How it is shown in virtual time.
    #[serde(default)]
    pub trials: Vec<TrialSpec>,
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

/// One way to bring a fault about.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialSpec {
    /// What is special about it.
    pub name: String,
    /// Job during which it happens.
    pub job: String,
    /// When.
    pub onset: OnsetSpec,
    /// Longest time from injection to actuation `[s]`; where it is missing, none is asked for.
    #[serde(default)]
    pub limit_s: Option<f64>,
    /// Instead of the entry's.
    #[serde(default)]
    pub reaction: Option<Reaction>,
    /// IDs under which it may be found; where it is missing, its own.
    #[serde(default)]
    pub found_as: Vec<String>,
    /// Worst that may follow; where it is missing, the reaction itself.
    #[serde(default)]
    pub at_most: Option<Reaction>,
    /// How long it is watched after the reaction `[s]`: what follows late may be too much.
    #[serde(default = "watch")]
    pub watch_s: f64,
    /// Ends after this time `[s]`; for good where it is missing.
    #[serde(default)]
    pub duration_s: Option<f64>,
    /// Corrections must be back this long after its end `[s]`.
    #[serde(default)]
    pub recover_s: Option<f64>,
    /// How far the block may go above its set-point `[K]`.
    #[serde(default)]
    pub overshoot_max_k: Option<f64>,
    /// Frames are rendered and judged, accelerations sampled.
    #[serde(default)]
    pub camera: bool,
    /// `off`, `encoder` or `mpc`.
    #[serde(default = "mpc")]
    pub control: String,
    /// Faults of the printer.
    #[serde(default)]
    plant: Vec<PlantFault>,
    /// Faults of messages, nodes and network.
    #[serde(default)]
    pub relay: Vec<Tampering>,
    /// A person's request.
    #[serde(default)]
    pub person: Option<Person>,
    /// Parameters of nodes from the start, by node and name, each as YAML.
    #[serde(default)]
    pub set: BTreeMap<String, BTreeMap<String, String>>,
}

fn watch() -> f64 {
    2.0
}

fn mpc() -> String {
    "mpc".to_owned()
}

/// When a fault sets in.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OnsetSpec {
    /// From when on it counts.
    pub after: Mark,
    /// Time after that `[s]`.
    pub time_s: f64,
    /// Each seed adds a share of this `[s]`.
    #[serde(default)]
    pub spread_s: f64,
}

/// A moment of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mark {
    /// Its start.
    Start,
    /// The first move of the print.
    Printing,
    /// Its first road.
    Deposit,
}

/// What a person asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Person {
    /// Emergency stop.
    Estop,
    /// Heaters off.
    Stop,
    /// Pause.
    Pause,
}

impl From<Person> for Operator {
    fn from(person: Person) -> Self {
        match person {
            Person::Estop => Self::Estop,
            Person::Stop => Self::Stop,
            Person::Pause => Self::Pause,
        }
    }
}

/// A fault of the printer, as in a scenario, but without an onset.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlantFault {
    component: String,
    kind: String,
    #[serde(default)]
    size: Option<f64>,
    #[serde(default)]
    ramp_s: f64,
}

impl PlantFault {
    fn entry(&self, duration_s: Option<f64>) -> anyhow::Result<Entry> {
        let mut fields = json!({
            "component": self.component, "kind": self.kind, "ramp_s": self.ramp_s, "onset": {"time_s": 0.0},
        });
        for (name, value) in [("size", self.size), ("duration_s", duration_s)] {
            if let Some(value) = value {
                fields[name] = json!(value);
            }
        }
        serde_json::from_value::<Entry>(fields)
            .with_context(|| format!("{} of {}", self.kind, self.component))
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
}

impl TrialSpec {
    /// What happens to the printer.
    ///
    /// # Errors
    /// A component, kind or size that does not exist.
    pub fn entries(&self) -> anyhow::Result<Vec<Entry>> {
        self.plant.iter().map(|fault| fault.entry(self.duration_s)).collect()
    }

    /// Refuses numbers that no run can keep, and trials in which nothing happens.
    fn check(&self) -> anyhow::Result<()> {
        let some = |name: &'static str, value: Option<f64>, low: f64| match value {
            Some(value) if !(low..=LONGEST_S).contains(&value) => {
                bail!("{name} = {value} s: must be in [{low}, {LONGEST_S}]")
            }
            _ => Ok(()),
        };
        some("limit_s", self.limit_s, 1e-3)?;
        some("duration_s", self.duration_s, 1e-3)?;
        some("recover_s", self.recover_s, 1e-3)?;
        some("watch_s", Some(self.watch_s), 0.0)?;
        some("onset.time_s", Some(self.onset.time_s), 0.0)?;
        some("onset.spread_s", Some(self.onset.spread_s), 0.0)?;
        if let Some(node) = self.set.keys().find(|node| !NODES.contains(&node.as_str())) {
            bail!("set: there is no node {node} in this loop; there are {}", NODES.join(", "));
        }
        if self.plant.is_empty() && self.relay.is_empty() && self.set.is_empty() && self.person.is_none() {
            bail!("nothing happens: plant, relay, person and set are empty");
        }
        self.relay.iter().try_for_each(Tampering::check)
    }

    /// Parameters from the start, as the loader takes them.
    #[must_use]
    pub fn overrides(&self) -> BTreeMap<String, Vec<(String, String)>> {
        let pairs = |set: &BTreeMap<String, String>| set.clone().into_iter().collect();
        self.set.iter().map(|(node, set)| (node.clone(), pairs(set))).collect()
    }
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
            if fault.trials.is_empty() && fault.test.is_none() && fault.waiting.is_none() {
                bail!("{id} has no trial, no test and no reason to wait");
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
