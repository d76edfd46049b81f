//! The whole graph over DDS: from a sample to the permit that it has part in.
//!
//! A temperature of the hot end is answered at once by estimator, controller and supervisor; a sample of the filament
//! encoder waits for the estimator's next turn (20 Hz). The times are the senders' own, so that the one who looks on delays
//! nothing.

use super::proc;
use super::{Benchmark, GraphArgs};
use anyhow::{Context, bail};
use runtime::{Args as NodeArgs, Gid, Node, RawSubscription, topics};
use rustix::process::{Pid, Signal, kill_process};
use std::collections::BTreeMap;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Longest time until commands flow `[s]`.
const PATIENCE: Duration = Duration::from_secs(60);
/// Oldest sample that is waited for `[ns]`.
const OLD_NS: i64 = 1_000_000_000;
/// Node that stands for the printer, and is none of ours.
const PRINTER: &str = "printer_sim";

/// Stations of a sample.
const STATIONS: usize = 4;
/// Whose samples are followed.
const HOTEND: usize = 0;
/// Whose samples are followed, and counted.
const ENCODER: usize = 1;

/// One topic as it is looked on.
struct Station {
    subscription: RawSubscription,
    newest: BTreeMap<Gid, i64>,
    heard: u64,
    lost: u64,
}

impl Station {
    /// The time at which a message was sent `[ns]`.
    async fn next(&mut self) -> Option<i64> {
        let message = self.subscription.recv().await;
        self.heard += 1;
        if let Some(before) = self.newest.insert(message.publisher, message.sequence) {
            self.lost += u64::try_from(message.sequence - before - 1).unwrap_or(0);
        }
        message.sent_ns
    }
}

/// Samples under way, by the station that they have passed.
#[derive(Default)]
struct Ways {
    waiting: [Vec<(i64, i64)>; STATIONS - 1],
    /// Length of each part of the way and of the whole `[ms]`.
    parts_ms: [Vec<f64>; STATIONS],
    samples: u64,
    unanswered: u64,
}

impl Ways {
    /// A message was sent from a station at `ns`: what waited there goes on.
    fn pass(&mut self, station: usize, ns: i64) {
        if station == 0 {
            self.samples += 1;
            return self.waiting[0].push((ns, ns));
        }
        let waiting = std::mem::take(&mut self.waiting[station - 1]);
        let (old, rest): (Vec<_>, Vec<_>) = waiting.into_iter().partition(|(_, at)| ns - at > OLD_NS);
        self.unanswered += old.len() as u64;
        // What was sent later than this message has no part in it.
        let (gone, stays): (Vec<_>, Vec<_>) = rest.into_iter().partition(|(_, at)| *at < ns);
        self.waiting[station - 1] = stays;
        for (first, at) in gone {
            self.parts_ms[station - 1].push(milliseconds(ns - at));
            match self.waiting.get_mut(station) {
                Some(next) => next.push((first, ns)),
                None => self.parts_ms[STATIONS - 1].push(milliseconds(ns - first)),
            }
        }
    }
}

#[allow(clippy::cast_precision_loss, reason = "lengths of time")]
fn milliseconds(ns: i64) -> f64 {
    ns as f64 * 1e-6
}

/// A quantile of sorted values.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let at = ((sorted.len() as f64 - 1.0).max(0.0) * share).round() as usize;
    sorted.get(at).copied().unwrap_or(f64::NAN)
}

pub(super) fn run(args: &GraphArgs) -> anyhow::Result<Vec<Benchmark>> {
    let folder = proc::scratch("graph")?;
    let mut graph = Command::new(std::env::current_exe()?)
        .args(["up", "--warm", "--stay", "--gcode"])
        .arg(&args.gcode)
        .arg("--bag")
        .arg(folder.join("bag"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()?;
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let measured = executor.block_on(follow(args.samples, graph.id()));
    _ = kill_process(Pid::from_child(&graph), Signal::INT);
    graph.wait()?;
    _ = std::fs::remove_dir_all(&folder);
    measured
}

async fn follow(samples: u64, graph: u32) -> anyhow::Result<Vec<Benchmark>> {
    let namespace = Some("/printer".to_owned());
    let mut node = Node::start_with("fdm_bench_graph", NodeArgs { namespace, ..NodeArgs::default() })?;
    let mut stations = Vec::new();
    let mut infos = [
        topics::HOTEND_TEMPERATURE.info(),
        topics::FILAMENT_MOTION.info(),
        topics::ESTIMATE.info(),
        topics::CONTROL_COMMAND.info(),
        topics::SAFETY_COMMAND.info(),
    ];
    for info in &mut infos {
        info.qos.requested.depth = 1000;
        let subscription = node.subscribe_raw(info)?;
        stations.push(Station { subscription, newest: BTreeMap::new(), heard: 0, lost: 0 });
    }
    let Ok([mut hotend, mut encoder, mut estimate, mut command, mut permit]) =
        <[Station; STATIONS + 1]>::try_from(stations)
    else {
        bail!("five topics");
    };
    let flows = tokio::time::timeout(PATIENCE, command.next()).await;
    flows.context("no command within a minute: is the graph up? see fdm up")?;
    let before = usage(graph);
    let begin = Instant::now();
    let mut ways: [Ways; 2] = Default::default();
    while ways[ENCODER].samples < samples {
        let (of, station, sent) = tokio::select! {
            sent = hotend.next() => (Some(HOTEND), 0, sent),
            sent = encoder.next() => (Some(ENCODER), 0, sent),
            sent = estimate.next() => (None, 1, sent),
            sent = command.next() => (None, 2, sent),
            sent = permit.next() => (None, 3, sent),
            () = tokio::time::sleep(PATIENCE) => bail!("the graph fell silent"),
        };
        let Some(ns) = sent else { continue };
        for way in ways
            .iter_mut()
            .enumerate()
            .filter(|(index, _)| of.is_none_or(|of| of == *index))
            .map(|(_, way)| way)
        {
            way.pass(station, ns);
        }
    }
    let wall_s = begin.elapsed().as_secs_f64();
    let mut all = told(&mut ways[HOTEND], "temperature");
    all.extend(told(&mut ways[ENCODER], "filament"));
    for (name, station) in [
        ("temperature", &hotend),
        ("filament", &encoder),
        ("estimate", &estimate),
        ("command", &command),
        ("permit", &permit),
    ] {
        #[allow(clippy::cast_precision_loss, reason = "counts of messages")]
        let share = 1e6 * station.lost as f64 / (station.heard + station.lost).max(1) as f64;
        all.push(Benchmark::new(format!("{name}: messages lost on the way to a reader"), "of 10^6", share));
    }
    all.extend(nodes(&before, &usage(graph), wall_s));
    Ok(all)
}

#[allow(clippy::cast_precision_loss, reason = "counts of messages")]
fn told(ways: &mut Ways, sample: &str) -> Vec<Benchmark> {
    let mut all = vec![
        Benchmark::new(format!("{sample}: samples followed"), "-", ways.samples as f64),
        Benchmark::new(format!("{sample}: samples without a permit within 1 s"), "-", ways.unanswered as f64),
    ];
    let names = ["sample to estimate", "estimate to command", "command to permit", "sample to permit"];
    for (name, values) in names.into_iter().zip(&mut ways.parts_ms) {
        values.sort_by(f64::total_cmp);
        for (which, share) in [("p50", 0.5), ("p99", 0.99), ("max", 1.0)] {
            all.push(Benchmark::new(format!("{sample}: {name}, {which}"), "ms", quantile(values, share)));
        }
    }
    all
}

/// Processor time and peak memory by node.
fn usage(graph: u32) -> BTreeMap<String, (f64, f64)> {
    let of = |(name, pid): (String, u32)| Some((name, (proc::cpu_s(pid)?, proc::peak_mib(pid)?)));
    proc::children(graph).into_iter().filter_map(of).collect()
}

fn nodes(
    before: &BTreeMap<String, (f64, f64)>,
    after: &BTreeMap<String, (f64, f64)>,
    wall_s: f64,
) -> Vec<Benchmark> {
    let mut all = Vec::new();
    let (mut cpu, mut memory) = (0.0, 0.0);
    for (name, (cpu_s, peak_mib)) in after {
        let share = 100.0 * (cpu_s - before.get(name).map_or(0.0, |(cpu_s, _)| *cpu_s)) / wall_s;
        if name != PRINTER {
            cpu += share;
            memory += peak_mib;
        }
        all.push(Benchmark::new(format!("{name}: processor"), "% of a core", share));
        all.push(Benchmark::new(format!("{name}: memory"), "MiB", *peak_mib));
    }
    all.push(Benchmark::new("graph without the simulator: processor", "% of a core", cpu));
    all.push(Benchmark::new("graph without the simulator: memory", "MiB", memory));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sent at 0 and 8 ms, estimated at 10, commanded at 11, permitted at 20: 20 and 12 ms. A sample at 10.5 waits.
    #[test]
    fn a_sample_is_followed_from_station_to_station() {
        let mut ways = Ways::default();
        let ms = |at: f64| (at * 1e6).round().to_string().parse::<i64>().unwrap();
        for (station, at) in [(0, 0.0), (0, 8.0), (3, 9.0), (1, 10.0), (0, 10.5), (2, 11.0), (3, 20.0)] {
            ways.pass(station, ms(at));
        }
        assert_eq!(ways.parts_ms[3], [20.0, 12.0]);
        assert_eq!((ways.parts_ms[0].len(), ways.waiting[0].len(), ways.samples), (2, 1, 3));
        assert!((quantile(&[1.0, 2.0, 3.0], 0.5) - 2.0).abs() < 1e-12);
    }
}
