//! How a fault of processes, services, storage, time or load is brought about on a running graph.

use super::{LimitSource, Reaction};
use anyhow::bail;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Longest time that a trial may name `[s]`.
const LONGEST_S: f64 = 86_400.0;

/// One way to bring a fault about on real processes over DDS.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProcessSpec {
    /// What is special about it.
    pub name: String,
    /// What is done.
    #[serde(rename = "do")]
    pub act: Act,
    /// Instead of the entry's.
    #[serde(default)]
    pub reaction: Option<Reaction>,
    /// Worst that may follow; where it is missing, the reaction itself.
    #[serde(default)]
    pub at_most: Option<Reaction>,
    /// IDs under which the supervisor may find it, instead of its own.
    #[serde(default)]
    pub found_as: Vec<String>,
    /// Longest time from the fault until `fdm` tells that the process ended, hangs or cannot write `[s]`; its source is
    /// the entry's.
    #[serde(default)]
    pub told_s: Option<f64>,
    /// Longest time from the fault until the reaction is carried out `[s]`; of `told`, where the supervisor acts at all.
    #[serde(default)]
    pub limit_s: Option<f64>,
    /// Where `limit_s` or `bounds` come from, instead of the entry's.
    #[serde(default)]
    pub source: Option<LimitSource>,
    /// The reaction must not come before `[s]`.
    #[serde(default)]
    pub earliest_s: Option<f64>,
    /// The printer is at the slicer's own values within `[s]`, once a reaction was called for.
    #[serde(default)]
    pub neutral_s: Option<f64>,
    /// All is whole again so long after the fault is over `[s]`.
    #[serde(default)]
    pub recover_s: Option<f64>,
    /// Limits of what is measured meanwhile, by its name.
    #[serde(default)]
    pub bounds: BTreeMap<String, Bound>,
    /// Such a limit may be missed where the supervisor says so in `/diagnostics`.
    #[serde(default)]
    pub or_alarm: bool,
}

/// Limits of a measured time.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bound {
    /// Of 99 % `[s]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p99_s: Option<f64>,
    /// Of 99.9 % `[s]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p999_s: Option<f64>,
}

/// What a disk that refuses answers to each write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DiskAnswer {
    /// No room.
    #[default]
    Full,
    /// An error of the device, also to a sync.
    IoError,
    /// It is read-only.
    ReadOnly,
}

/// What is done to the graph.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Act {
    /// SIGKILL to a node.
    Kill(String),
    /// SIGSTOP to a node, SIGCONT after a while.
    Stop {
        /// The node.
        node: String,
        /// How long `[s]`.
        for_s: f64,
    },
    /// Nodes are started in random orders.
    Orders {
        /// How many orders.
        count: u32,
        /// Longest pause between two starts `[s]`.
        gap_s: f64,
    },
    /// Services of all kinds are called.
    Calls {
        /// Calls a second of all callers together `[Hz]`.
        rate_hz: f64,
        /// How long `[s]`.
        for_s: f64,
    },
    /// Processes that do nothing but count.
    Spin {
        /// How many; with 0 the machine is left alone.
        processes: u32,
        /// How long `[s]`.
        for_s: f64,
    },
    /// Messages on the topics that every node may publish on.
    Flood {
        /// Messages a second of all topics together `[Hz]`.
        rate_hz: f64,
        /// How long `[s]`.
        for_s: f64,
        /// How much a process may grow `[MiB]`.
        growth_mib: f64,
    },
    /// A node gets no more memory.
    Memory {
        /// The node.
        node: String,
        /// How long it is watched `[s]`.
        for_s: f64,
    },
    /// No node opens a file or socket any more; then an emergency stop.
    Files {
        /// How long before the emergency stop `[s]`.
        for_s: f64,
    },
    /// The wall clock of all nodes is set.
    StepClock {
        /// Its offsets, one after the other `[s]`.
        to_s: Vec<f64>,
        /// How long each lasts `[s]`.
        each_s: f64,
    },
    /// The recorder's disk takes its time.
    SlowDisk {
        /// Time of each write and sync `[s]`.
        delay_s: f64,
        /// How long `[s]`.
        for_s: f64,
    },
    /// The recorder's disk refuses.
    FullDisk {
        /// How long `[s]`.
        for_s: f64,
        /// What it answers.
        #[serde(default)]
        answer: DiskAnswer,
    },
    /// Nothing is done: the memory of all nodes is watched.
    Soak {
        /// How long `[s]`.
        for_s: f64,
        /// How fast a process may grow, where it is watched for half an hour at least `[MiB/h]`.
        slope_mib_h: f64,
    },
    /// Emergency stops and acknowledgements by turns.
    Estop {
        /// How many.
        calls: u32,
        /// Spinning processes meanwhile.
        spinning: u32,
    },
}

/// On what a trial runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Bench {
    /// On a graph that prints.
    Plain,
    /// On one whose disk and wall clock are in the harness's hand.
    Shimmed,
    /// On one on the host's clock, as beside a real printer: elsewhere the simulator's own pace is in each interval.
    HostClock,
    /// On one that prints for long.
    Long,
    /// On graphs of its own.
    Own,
}

impl Act {
    /// On what it runs.
    #[must_use]
    pub fn bench(&self) -> Bench {
        match self {
            Self::Orders { .. } => Bench::Own,
            Self::Spin { .. } | Self::Calls { .. } => Bench::HostClock,
            Self::StepClock { .. } | Self::SlowDisk { .. } | Self::FullDisk { .. } => Bench::Shimmed,
            _ => Bench::Plain,
        }
    }
}

impl ProcessSpec {
    /// Whether the process of this node may end meanwhile: it is what is done, or follows from it.
    #[must_use]
    pub fn may_end(&self, node: &str) -> bool {
        match &self.act {
            Act::Kill(victim) | Act::Stop { node: victim, .. } | Act::Memory { node: victim, .. } => {
                victim == node
            }
            // Without a file there is no bag to be closed.
            Act::FullDisk { .. } | Act::Files { .. } => node == "bag_recorder",
            // Where the clock falls back, every node ends at once and starts again.
            Act::StepClock { .. } => self.reaction.is_some_and(|reaction| reaction != Reaction::None),
            _ => false,
        }
    }

    /// Whether nothing can be tried on the same graph afterwards.
    #[must_use]
    pub fn ends_print(&self) -> bool {
        let latches = self.reaction.is_some_and(|reaction| reaction >= Reaction::SafeOff);
        latches || matches!(self.act, Act::Estop { .. } | Act::Files { .. })
    }

    /// Refuses nodes that do not exist and numbers that no run can keep.
    pub(super) fn check(&self) -> anyhow::Result<()> {
        if let Act::Kill(node) | Act::Stop { node, .. } | Act::Memory { node, .. } = &self.act
            && !crate::up::recipes::NODES.contains(&node.as_str())
        {
            bail!("there is no node {node}");
        }
        let times = [
            self.told_s,
            self.limit_s,
            self.earliest_s,
            self.neutral_s,
            self.recover_s,
            self.act.duration_s(),
        ];
        for time_s in times.into_iter().flatten() {
            if !(1e-3..=LONGEST_S).contains(&time_s) {
                bail!("{time_s} s: must be in [0.001, {LONGEST_S}]");
            }
        }
        Ok(())
    }
}

impl Act {
    /// How long it lasts, where it says so `[s]`.
    fn duration_s(&self) -> Option<f64> {
        match self {
            Self::Stop { for_s, .. }
            | Self::Calls { for_s, .. }
            | Self::Spin { for_s, .. }
            | Self::Flood { for_s, .. }
            | Self::Memory { for_s, .. }
            | Self::Files { for_s }
            | Self::SlowDisk { for_s, .. }
            | Self::FullDisk { for_s, .. }
            | Self::Soak { for_s, .. } => Some(*for_s),
            Self::StepClock { each_s, .. } => Some(*each_s),
            Self::Kill(_) | Self::Orders { .. } | Self::Estop { .. } => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn may_end(act: Value, reaction: &str, node: &str) -> bool {
        let spec = json!({"name": "a", "do": act, "reaction": reaction});
        serde_json::from_value::<ProcessSpec>(spec).unwrap().may_end(node)
    }

    /// Who ends beside the victim is a miss.
    #[test]
    fn the_victim_may_end_and_nobody_beside_it() {
        let (kill, calls) = (json!({"kill": "imu"}), json!({"calls": {"rate_hz": 200, "for_s": 1.0}}));
        assert!(may_end(kill.clone(), "told", "imu") && !may_end(kill, "told", "camera"));
        assert!(!may_end(calls, "none", "imu"));
        let step = json!({"step_clock": {"to_s": [0.0], "each_s": 2.0}});
        assert!(may_end(step.clone(), "baseline", "imu") && !may_end(step, "none", "imu"));
    }
}
