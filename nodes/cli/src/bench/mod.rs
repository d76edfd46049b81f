//! `fdm bench`: measured figures beside a peer's, or beside their target.

mod advance;
mod controller;
mod estimator;
mod graph;
mod kills;
mod load;
mod peers;
mod proc;
mod recorder;
mod sim;

use crate::output::{self, Failed, Json};
use clap::{Args, Subcommand};
use serde::Serialize;
use std::path::{Path, PathBuf};

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
    /// A step of the filter beside FilterPy's, on the same problem.
    Estimator(PeerArgs),
    /// A plan of the controller beside OSQP's and that of do-mpc with IPOPT, on the same problem.
    Controller(PeerArgs),
    /// Steps of the simulated plant beside plain Python's; the whole loop of `fdm sim`.
    Sim(PeerArgs),
    /// One answer of the advance predictor: the pressure advance of a condition, an update of the foresight of turns.
    Advance(AdvanceArgs),
    /// A process of the other benchmarks.
    #[command(hide = true)]
    Load(load::LoadArgs),
}

impl What {
    /// Where the figures go.
    fn json(&self) -> Option<&Path> {
        match self {
            Self::Recorder(args) => args.json.as_deref(),
            Self::Graph(args) => args.json.as_deref(),
            Self::Estimator(args) | Self::Controller(args) | Self::Sim(args) => args.json.as_deref(),
            Self::Advance(args) => args.json.as_deref(),
            Self::Load(_) => None,
        }
    }

    /// The work, which takes minutes.
    fn measure(&self) -> anyhow::Result<Vec<Benchmark>> {
        match self {
            Self::Recorder(args) => match args.kills {
                Some(kills) => kills::run(args, kills),
                None => recorder::run(args),
            },
            Self::Graph(args) => graph::run(args),
            Self::Estimator(args) => estimator::run(args),
            Self::Controller(args) => controller::run(args),
            Self::Sim(args) => sim::run(args),
            Self::Advance(args) => advance::run(args),
            Self::Load(args) => load::run(args).map(|()| Vec::new()),
        }
    }
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

/// The advance predictor.
#[derive(Debug, Args)]
pub struct AdvanceArgs {
    /// File whose path is followed.
    #[arg(long, default_value = "tests/data/gcode/prusa_cube_pla_marlin_relE.gcode")]
    gcode: PathBuf,
    /// Folder with the parameter files.
    #[arg(long)]
    config: Option<PathBuf>,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// What is measured beside Python packages.
#[derive(Debug, Args)]
pub struct PeerArgs {
    /// Python with the peers; tests/bench_peers/setup.sh makes it.
    #[arg(long, default_value = "target/bench_peers/bin/python")]
    python: PathBuf,
    /// Folder with the parameter files.
    #[arg(long)]
    config: Option<PathBuf>,
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
    /// The target is the least, not the most.
    pub(crate) at_least: bool,
    pub(crate) unit: &'static str,
    pub(crate) peer_name: &'static str,
}

impl Benchmark {
    fn new(name: impl Into<String>, unit: &'static str, ours: f64) -> Self {
        Self {
            name: name.into(),
            ours,
            peer: None,
            ratio: None,
            target: None,
            at_least: false,
            unit,
            peer_name: "",
        }
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

    /// At least this.
    fn at_least(mut self, target: f64) -> Self {
        (self.target, self.at_least) = (Some(target), true);
        self
    }

    fn is_missed(&self) -> bool {
        self.target.is_some_and(|target| if self.at_least { self.ours < target } else { self.ours > target })
    }
}

/// All of them.
#[derive(Debug, Serialize)]
struct Figures {
    benchmarks: Vec<Benchmark>,
}

/// Runs the command.
///
/// # Errors
/// One line that says what is wrong and where; a target that was missed.
pub fn run(args: &BenchArgs) -> anyhow::Result<()> {
    let what = &args.what;
    if let What::Load(load) = what {
        return load::run(load);
    }
    let json = Json::new(what.json());
    json.check()?;
    let figures = Figures { benchmarks: what.measure()? };
    if !json.is_stdout() {
        output::line(&page(&figures.benchmarks))?;
    }
    json.write(&figures)?;
    match figures.benchmarks.iter().find(|benchmark| benchmark.is_missed()) {
        Some(missed) => Err(Failed(miss(missed)).into()),
        None => Ok(()),
    }
}

/// A missed target, with as many digits of the figure as it takes to see that it is missed.
fn miss(Benchmark { name, ours, unit, target, at_least, .. }: &Benchmark) -> String {
    let (target, side) = (target.unwrap_or_default(), if *at_least { "less" } else { "more" });
    let shown = |digits| crate::options::significant(*ours, digits);
    let apart = |text: &String| text.parse::<f64>().is_ok_and(|value| (value - target).abs() > 0.0);
    let ours = (3..17).map(shown).find(apart).unwrap_or_else(|| shown(17));
    format!("{name}: {ours} {unit}, {side} than {target}")
}

fn page(benchmarks: &[Benchmark]) -> String {
    let shown = |value: Option<f64>| {
        value.map_or_else(|| "-".to_owned(), |value| crate::options::significant(value, 3))
    };
    let mut page = format!("{:<60} {:>12} {:>12} {:>10} {:>12}\n", "", "ours", "peer", "ratio", "target");
    for benchmark in benchmarks {
        let Benchmark { name, ours, peer, ratio, target, at_least, unit, peer_name } = benchmark;
        let side = if *at_least { ">=" } else { "<=" };
        let wanted =
            target.map_or_else(|| "-".to_owned(), |target| format!("{side} {}", shown(Some(target))));
        let [ours, peer, ratio] = [Some(*ours), *peer, *ratio].map(shown);
        let name = format!("{name} [{unit}]");
        let line = format!("{name:<60} {ours:>12} {peer:>12} {ratio:>10} {wanted:>12}  {peer_name}");
        page.push_str(line.trim_end());
        page.push('\n');
    }
    page + &summary(benchmarks)
}

/// One line: how many targets there are, and the name, figure and limit of each that is missed; nothing without targets.
fn summary(benchmarks: &[Benchmark]) -> String {
    let aimed = benchmarks.iter().filter(|benchmark| benchmark.target.is_some()).count();
    let told = |benchmark: &Benchmark| {
        let Benchmark { name, ours, unit, target, at_least, .. } = benchmark;
        let (target, side) = (target.unwrap_or_default(), if *at_least { "least" } else { "most" });
        format!("{name} {} {unit}, at {side} {target}", crate::options::significant(*ours, 3))
    };
    let missed: Vec<String> = benchmarks.iter().filter(|benchmark| benchmark.is_missed()).map(told).collect();
    match (aimed, missed.len()) {
        (0, _) => String::new(),
        (_, 0) => format!("{aimed} of {aimed} targets met\n"),
        (_, count) => format!("{count} of {aimed} targets MISSED: {}\n", missed.join("; ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_miss_is_told_with_the_digits_that_show_it() {
        let told = |ours| miss(&Benchmark::new("answer", "us", ours).target(5.0));
        assert_eq!(told(8.684_361_999_999_998), "answer: 8.68 us, more than 5");
        assert_eq!(told(5.000_4), "answer: 5.0004 us, more than 5");
    }

    /// Who reads the last line alone knows whether a limit is missed, which one and by how much.
    #[test]
    fn the_last_line_says_which_targets_are_missed() {
        let told = Benchmark::new("told alone", "us", 9.0);
        let [slow, few] = [
            Benchmark::new("answer", "us", 6.25).target(5.0),
            Benchmark::new("rate", "1/s", 3.0).at_least(2.0),
        ];
        let last = |benchmarks: &[Benchmark]| page(benchmarks).lines().last().unwrap().to_owned();
        assert_eq!(
            last(&[told.clone(), slow, few.clone()]),
            "1 of 2 targets MISSED: answer 6.25 us, at most 5"
        );
        assert_eq!(last(&[told.clone(), few]), "1 of 1 targets met");
        assert!(last(&[told]).starts_with("told alone"));
    }
}
