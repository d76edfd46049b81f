//! The whole graph over DDS: from a sample to the permit that it has part in.
//!
//! A temperature of the hot end is answered at once by estimator, controller and supervisor; a sample of the filament
//! encoder waits for the estimator's next turn (20 Hz). The times are the senders' own, so that the one who looks on delays
//! nothing. The graph runs on the host's clock, as beside a real printer: `/clock`, which wakes every node 50 times a second,
//! is a simulator's.

use super::proc;
use super::{Benchmark, GraphArgs};
use crate::participant;
use anyhow::{Context, bail, ensure};
use runtime::{Args as NodeArgs, Gid, RawSubscription, topics};
use rustix::process::{Pid, Signal, kill_process};
use std::collections::BTreeMap;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Longest time until commands flow `[s]`.
const PATIENCE: Duration = Duration::from_secs(60);
/// Oldest sample that is waited for `[ns]`.
const OLD_NS: i64 = 1_000_000_000;
/// From when nobody looks on until the graph has noticed.
const LEFT_ALONE: Duration = Duration::from_secs(2);
/// Time in which processor and memory are measured, as a share of the samples' own: apart, for to send all of them to one
/// more reader costs three nodes a good part of their work, and a print has no such reader.
const ALONE_SHARE: f64 = 0.5;
/// Samples of the filament encoder in a second.
const SAMPLES_1_S: f64 = 100.0;
/// Node that stands for the printer, and is none of ours.
const PRINTER: &str = "printer_sim";

/// Processes of the graph without the printer.
const NODES: usize = 9;
/// The sample that is answered at once.
const TEMPERATURE: &str = "temperature";
/// From a sample of it to the permit `[ms]`.
const P50_MS: f64 = 2.0;
const P99_MS: f64 = 10.0;
/// Messages lost of a million.
const LOST: f64 = 0.0;
/// All processes but the printer: of one core `[%]`, and of memory `[MiB]`.
const PROCESSOR_PERCENT: f64 = 25.0;
const MEMORY_MIB: f64 = 400.0;

/// Stations of a sample.
const STATIONS: usize = 4;
/// One topic as it is looked on.
struct Station {
    subscription: RawSubscription,
    newest: BTreeMap<Gid, i64>,
    /// Moments of sending `[ns]`.
    sent_ns: Vec<i64>,
    heard: u64,
    lost: u64,
}

impl Station {
    /// Takes a message in.
    async fn next(&mut self) {
        let message = self.subscription.recv().await;
        self.heard += 1;
        if let Some(before) = self.newest.insert(message.publisher, message.sequence) {
            self.lost += u64::try_from(message.sequence - before - 1).unwrap_or(0);
        }
        self.sent_ns.extend(message.sent_ns);
    }
}

/// How long samples took.
#[derive(Default)]
struct Ways {
    /// Length of each part of the way and of the whole `[ms]`.
    parts_ms: [Vec<f64>; STATIONS],
    samples: u64,
    unanswered: u64,
}

impl Ways {
    /// Follows each sample to the first message of each station that was sent after that of the station before. All are
    /// moments of sending `[ns]` in their order: messages of several topics reach a reader in any order.
    fn of(samples: &[i64], stations: [&[i64]; STATIONS - 1]) -> Self {
        let mut ways = Self::default();
        let end_ns = stations[STATIONS - 2].last().map_or(i64::MIN, |newest| newest - OLD_NS);
        for begin_ns in samples.iter().copied().filter(|begin_ns| *begin_ns <= end_ns) {
            ways.samples += 1;
            let mut at_ns = [begin_ns; STATIONS];
            let answered = stations.iter().enumerate().all(|(index, sent)| {
                let next = sent.get(sent.partition_point(|ns| *ns <= at_ns[index]));
                next.is_some_and(|ns| {
                    at_ns[index + 1] = *ns;
                    ns - begin_ns <= OLD_NS
                })
            });
            if !answered {
                ways.unanswered += 1;
                continue;
            }
            for part in 1..STATIONS {
                ways.parts_ms[part - 1].push(milliseconds(at_ns[part] - at_ns[part - 1]));
            }
            ways.parts_ms[STATIONS - 1].push(milliseconds(at_ns[STATIONS - 1] - begin_ns));
        }
        ways
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
        .args(["up", "--host-clock", "--warm", "--stay", "--gcode"])
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
    let mut node = participant::join("fdm_bench_graph", NodeArgs { namespace, ..NodeArgs::default() })?;
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
        stations.push(Station {
            subscription,
            newest: BTreeMap::new(),
            sent_ns: Vec::new(),
            heard: 0,
            lost: 0,
        });
    }
    let Ok([mut hotend, mut encoder, mut estimate, mut command, mut permit]) =
        <[Station; STATIONS + 1]>::try_from(stations)
    else {
        bail!("five topics");
    };
    let flows = tokio::time::timeout(PATIENCE, command.next()).await;
    flows.context("no command within a minute: is the graph up? see fdm up")?;
    while encoder.heard < samples {
        tokio::select! {
            () = hotend.next() => (),
            () = encoder.next() => (),
            () = estimate.next() => (),
            () = command.next() => (),
            () = permit.next() => (),
            () = tokio::time::sleep(PATIENCE) => bail!("the graph fell silent"),
        }
    }
    for station in [&mut hotend, &mut encoder, &mut estimate, &mut command, &mut permit] {
        station.sent_ns.sort_unstable();
    }
    let mut all = figures([&hotend, &encoder, &estimate, &command, &permit]);
    drop((hotend, encoder, estimate, command, permit));
    drop(node);
    tokio::time::sleep(LEFT_ALONE).await;
    let (before, begin) = (usage(graph), Instant::now());
    tokio::time::sleep(Duration::from_secs_f64(samples_s(samples) * ALONE_SHARE)).await;
    all.extend(nodes(&before, &usage(graph), begin.elapsed().as_secs_f64())?);
    Ok(all)
}

/// Time of so many samples `[s]`.
#[allow(clippy::cast_precision_loss, reason = "a count of samples")]
fn samples_s(samples: u64) -> f64 {
    samples as f64 / SAMPLES_1_S
}

/// How long samples took, and what of each topic was lost.
#[allow(clippy::cast_precision_loss, reason = "counts of messages")]
fn figures(all: [&Station; STATIONS + 1]) -> Vec<Benchmark> {
    let [hotend, encoder, estimate, command, permit] = all.map(|station| &station.sent_ns[..]);
    let stations = [estimate, command, permit];
    let mut figures = told(Ways::of(hotend, stations), TEMPERATURE);
    figures.extend(told(Ways::of(encoder, stations), "filament"));
    for (name, station) in ["temperature", "filament", "estimate", "command", "permit"].into_iter().zip(all) {
        let share = 1e6 * station.lost as f64 / (station.heard + station.lost).max(1) as f64;
        let lost = Benchmark::new(format!("{name}: messages lost on the way to a reader"), "of 10^6", share);
        figures.push(lost.target(LOST));
    }
    figures
}

#[allow(clippy::cast_precision_loss, reason = "counts of messages")]
fn told(mut ways: Ways, sample: &str) -> Vec<Benchmark> {
    let mut all = vec![
        Benchmark::new(format!("{sample}: samples followed"), "-", ways.samples as f64),
        Benchmark::new(format!("{sample}: samples without a permit within 1 s"), "-", ways.unanswered as f64),
    ];
    let names = ["sample to estimate", "estimate to command", "command to permit", "sample to permit"];
    for (name, values) in names.into_iter().zip(&mut ways.parts_ms) {
        values.sort_by(f64::total_cmp);
        for (which, share, target) in [("p50", 0.5, P50_MS), ("p99", 0.99, P99_MS), ("max", 1.0, f64::MAX)] {
            let took = Benchmark::new(format!("{sample}: {name}, {which}"), "ms", quantile(values, share));
            let answered_at_once = sample == TEMPERATURE && name == names[3] && share < 1.0;
            all.push(if answered_at_once { took.target(target) } else { took });
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
) -> anyhow::Result<Vec<Benchmark>> {
    let mut all = Vec::new();
    let (mut cpu, mut memory) = (0.0, 0.0);
    let seen = after.keys().filter(|name| *name != PRINTER && before.contains_key(*name)).count();
    ensure!(seen >= NODES, "the processes of {seen} nodes are seen, of {NODES}");
    for (name, (cpu_s, peak_mib)) in after {
        let share = 100.0 * (cpu_s - before.get(name).map_or(0.0, |(cpu_s, _)| *cpu_s)) / wall_s;
        if name != PRINTER {
            cpu += share;
            memory += peak_mib;
        }
        all.push(Benchmark::new(format!("{name}: processor"), "% of a core", share));
        all.push(Benchmark::new(format!("{name}: memory"), "MiB", *peak_mib));
    }
    let processor = Benchmark::new("graph without the simulator: processor", "% of a core", cpu);
    let memory = Benchmark::new("graph without the simulator: memory", "MiB", memory);
    all.extend([processor.target(PROCESSOR_PERCENT), memory.target(MEMORY_MIB)]);
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sent at 0 and 8 ms, estimated at 10, commanded at 11, permitted at 20: 20 and 12 ms. A sample at 10.5 is too young.
    /// One at -2 s had no answer in time.
    #[test]
    fn a_sample_is_followed_from_station_to_station() {
        let ms = |at: &[i64]| at.iter().map(|at| at * 100_000).collect::<Vec<_>>();
        let samples = ms(&[-20_000, 0, 80, 105]);
        let (estimates, commands, permits) = (ms(&[100, 10_050]), ms(&[110, 10_060]), ms(&[90, 200, 10_100]));
        let ways = Ways::of(&samples, [&estimates, &commands, &permits]);
        assert_eq!(ways.parts_ms[3], [20.0, 12.0]);
        assert_eq!(ways.parts_ms[0], [10.0, 2.0]);
        assert_eq!((ways.samples, ways.unanswered), (3, 1));
        assert!((quantile(&[1.0, 2.0, 3.0], 0.5) - 2.0).abs() < 1e-12);
    }
}
