//! One way to bring a fault about, as the catalogue writes it.

use super::{LimitSource, Peers, Reaction};
use crate::sim::relay::Tampering;
use anyhow::bail;
use printer_sim::faults::{Component, Kind};
use printer_sim::scenario::{Course, Entry, FaultError};
use safety_supervisor::Operator;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Longest time that a trial may name `[s]`.
const LONGEST_S: f64 = 3600.0;
/// Longest way that a trial may name `[mm]`.
const LONGEST_MM: f64 = 1000.0;
/// Nodes whose parameters a trial may set.
const NODES: [&str; 4] = ["state_estimator", "mpc_controller", "safety_supervisor", "printer_sim"];

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
    /// The limit counts from when the motor has pushed this much after the onset `[mm]`.
    #[serde(default)]
    pub limit_mm: Option<f64>,
    /// Layers that may be begun between the onset and the reaction.
    #[serde(default)]
    pub limit_layers: Option<u32>,
    /// Where its limit comes from, instead of the entry's.
    #[serde(default)]
    pub source: Option<LimitSource>,
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
    /// The reaction must last for as long as it is watched: what comes late must not end it.
    #[serde(default)]
    pub lasts: bool,
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
    /// What other firmware needs for the same.
    #[serde(default)]
    pub peers: Peers,
    /// Parameters of nodes from the start, by node and name, each as YAML.
    #[serde(default)]
    pub set: BTreeMap<String, BTreeMap<String, String>>,
}

fn watch() -> f64 {
    2.0
}

pub(super) fn mpc() -> String {
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
    component: Component,
    kind: Kind,
    #[serde(default)]
    size: Option<f64>,
    #[serde(default)]
    ramp_s: f64,
}

impl PlantFault {
    fn entry(&self, duration_s: Option<f64>) -> Result<Entry, FaultError> {
        let course = Course { size: self.size, ramp_s: self.ramp_s, duration_s };
        Entry::at(self.component, self.kind, course, 0.0)
    }
}

impl TrialSpec {
    /// What happens to the printer.
    ///
    /// # Errors
    /// A component, kind or size that does not exist.
    pub fn entries(&self) -> anyhow::Result<Vec<Entry>> {
        let entries = self.plant.iter().map(|fault| fault.entry(self.duration_s));
        Ok(entries.collect::<Result<_, _>>()?)
    }

    /// Refuses numbers that no run can keep, and trials in which nothing happens.
    pub(super) fn check(&self) -> anyhow::Result<()> {
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
        if let Some(way_mm) = self.limit_mm
            && (self.limit_s.is_none() || !(0.1..=LONGEST_MM).contains(&way_mm))
        {
            bail!("limit_mm = {way_mm} mm: must be in [0.1, {LONGEST_MM}], beside a limit_s");
        }
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
