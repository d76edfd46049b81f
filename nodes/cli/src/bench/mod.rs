//! `fdm bench`: measured figures beside a peer's, or beside their target.

mod graph;
mod kills;
mod load;
mod proc;
mod recorder;

use crate::output::{self, Json};
use clap::{Args, Subcommand};
use serde::Serialize;
use std::path::PathBuf;

/// Measures.
#[derive(Debug, Args)]
pub struct BenchArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// The recorder at 2 kHz IMU and 30 frames of 300 kB a second, beside PyPI's mcap writer; over DDS; under kills.
    Recorder(RecorderArgs),
    /// The whole graph over DDS: a sample of a sensor in, a permit out; processor and memory by node.
    Graph(GraphArgs),
    /// A process of the other benchmarks.
    #[command(hide = true)]
    Load(load::LoadArgs),
}

/// The recorder.
#[derive(Debug, Args)]
pub struct RecorderArgs {
    /// Length of each run `[s]`.
    #[arg(long, default_value_t = 20.0)]
    seconds: f64,
    /// Kills at random moments instead: each bag is recovered and counted.
    #[arg(long)]
    kills: Option<u32>,
    /// Seed of the moments.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Keep the recovered bags of `--kills` in this folder.
    #[arg(long, requires = "kills")]
    keep: Option<PathBuf>,
    /// Python with PyPI's mcap and rosbags.
    #[arg(long, default_value = "target/venv/bin/python")]
    python: PathBuf,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// The graph.
#[derive(Debug, Args)]
pub struct GraphArgs {
    /// Samples of the filament encoder that are followed.
    #[arg(long, default_value_t = 5000)]
    samples: u64,
    /// File to print.
    #[arg(long, default_value = "tests/data/gcode/prusa_cube_pla_marlin_relE.gcode")]
    gcode: PathBuf,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// One measured quantity.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Benchmark {
    pub(crate) name: String,
    pub(crate) ours: f64,
    pub(crate) peer: Option<f64>,
    /// Ours over the peer's.
    pub(crate) ratio: Option<f64>,
    pub(crate) target: Option<f64>,
    pub(crate) unit: &'static str,
    pub(crate) peer_name: &'static str,
}

impl Benchmark {
    fn new(name: impl Into<String>, unit: &'static str, ours: f64) -> Self {
        Self { name: name.into(), ours, peer: None, ratio: None, target: None, unit, peer_name: "" }
    }

    fn beside(mut self, peer_name: &'static str, peer: f64) -> Self {
        self.ratio = (peer > 0.0).then_some(self.ours / peer);
        (self.peer, self.peer_name) = (Some(peer), peer_name);
        self
    }

    /// At most this.
    fn target(mut self, target: f64) -> Self {
        self.target = Some(target);
        self
    }
}

/// All of them.
#[derive(Debug, Serialize)]
struct Figures {
    benchmarks: Vec<Benchmark>,
}

/// A target was missed: exit code 1.
#[derive(Debug)]
pub struct Missed(String);

impl std::fmt::Display for Missed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Missed {}

/// Runs the command.
///
/// # Errors
/// One line that says what is wrong and where; a target that was missed.
pub fn run(args: &BenchArgs) -> anyhow::Result<()> {
    let (json, benchmarks) = match &args.what {
        What::Load(load) => return load::run(load),
        What::Recorder(recorder) => (
            &recorder.json,
            match recorder.kills {
                Some(kills) => kills::run(recorder, kills),
                None => recorder::run(recorder),
            },
        ),
        What::Graph(graph) => (&graph.json, graph::run(graph)),
    };
    let json = Json::new(json.as_deref());
    json.check()?;
    let figures = Figures { benchmarks: benchmarks? };
    if !json.is_stdout() {
        output::line(&page(&figures.benchmarks))?;
    }
    json.write(&figures)?;
    let misses = |benchmark: &&Benchmark| benchmark.target.is_some_and(|target| benchmark.ours > target);
    match figures.benchmarks.iter().find(misses) {
        Some(Benchmark { name, ours, unit, target, .. }) => {
            let target = target.unwrap_or_default();
            Err(Missed(format!("{name}: {ours} {unit}, more than {target}")).into())
        }
        None => Ok(()),
    }
}

fn page(benchmarks: &[Benchmark]) -> String {
    let shown = |value: Option<f64>| {
        value.map_or_else(|| "-".to_owned(), |value| crate::options::significant(value, 3))
    };
    let mut page = format!("{:<52} {:>12} {:>12} {:>8} {:>10}\n", "", "ours", "peer", "ratio", "at most");
    for benchmark in benchmarks {
        let Benchmark { name, ours, peer, ratio, target, unit, peer_name } = benchmark;
        let [ours, peer, ratio, target] = [Some(*ours), *peer, *ratio, *target].map(shown);
        let name = format!("{name} [{unit}]");
        page.push_str(&format!("{name:<52} {ours:>12} {peer:>12} {ratio:>8} {target:>10}  {peer_name}\n"));
    }
    page
}
