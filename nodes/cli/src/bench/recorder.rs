//! The recorder under load: its threads beside PyPI's writer, and as a process over DDS.

use super::load::{self, Took};
use super::proc;
use super::{Benchmark, RecorderArgs};
use crate::config::ConfigDir;
use crate::programs;
use anyhow::{Context, bail};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// The peer.
const PEER: &str = include_str!("peer.py");
/// Its name.
const PEER_NAME: &str = "PyPI mcap 1.x, zstd chunks";
/// Messages that the whole load may lose.
const NONE: f64 = 0.0;
/// What of a core the writer may take under the load `[%]`.
const PROCESSOR_PERCENT: f64 = 5.0;

pub(super) fn run(args: &RecorderArgs) -> anyhow::Result<Vec<Benchmark>> {
    crate::options::in_range("--seconds", args.seconds, "s", (1.0, 3600.0))?;
    let folder = proc::scratch("recorder")?;
    let ours = threads(&folder.join("paced"), args.seconds, false)?;
    let flood = threads(&folder.join("flood"), args.seconds.min(5.0), true)?;
    let (peer, peer_flood) = if args.python.is_file() {
        let peer = |pace, seconds| python(&args.python, &folder, (pace, seconds)).map(Some);
        (peer("paced", args.seconds)?, peer("flood", args.seconds.min(5.0))?)
    } else {
        crate::output::note(&format!("{} is missing: no peer (--python)", args.python.display()));
        (None, None)
    };
    let mut all = beside(&ours, peer.as_ref());
    all.push(with(
        "messages of 0.3 kB a second, one core",
        "1/s",
        rate(&flood),
        peer_flood.as_ref().map(rate),
    ));
    all.extend(over_dds(&folder, args.seconds)?);
    _ = std::fs::remove_dir_all(&folder);
    Ok(all)
}

/// Messages a second of processor time while recording.
fn rate(took: &Took) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "a count of messages")]
    let messages = took.messages as f64;
    messages / took.cpu_s.max(1e-3)
}

fn with(name: &str, unit: &'static str, ours: f64, peer: Option<f64>) -> Benchmark {
    let benchmark = Benchmark::new(name, unit, ours);
    match peer {
        Some(peer) => benchmark.beside(PEER_NAME, peer),
        None => benchmark,
    }
}

#[allow(clippy::cast_precision_loss, reason = "counts of messages")]
fn beside(ours: &Took, peer: Option<&Took>) -> Vec<Benchmark> {
    let of = |value: fn(&Took) -> f64| (value(ours), peer.map(value));
    let share = |took: &Took| 100.0 * took.cpu_s / took.wall_s;
    let share_all = |took: &Took| 100.0 * took.cpu_all_s / took.wall_s;
    let (memory, peer_memory) = of(|took| took.peak_mib);
    vec![
        Benchmark::new("writer: messages dropped", "-", ours.dropped as f64).target(NONE),
        with("writer: processor while recording", "% of a core", share(ours), peer.map(share))
            .target(PROCESSOR_PERCENT),
        with("writer: processor, compacting included", "% of a core", share_all(ours), peer.map(share_all)),
        with("writer: memory", "MiB", memory, peer_memory),
    ]
}

fn said(child: Child, what: &str) -> anyhow::Result<Took> {
    let output = child.wait_with_output()?;
    let text = String::from_utf8_lossy(&output.stdout);
    let Some(line) = text.lines().last().filter(|_| output.status.success()) else {
        bail!("{what} ended with {}: {}", output.status, String::from_utf8_lossy(&output.stderr));
    };
    serde_json::from_str(line).with_context(|| format!("{what}: {line}"))
}

fn threads(bag: &Path, seconds: f64, flood: bool) -> anyhow::Result<Took> {
    let mut command = Command::new(std::env::current_exe()?);
    command
        .args(["bench", "load", "--into", "recorder", "--seconds", &seconds.to_string(), "--bag"])
        .arg(bag);
    if flood {
        command.arg("--unpaced");
    }
    said(command.stdout(Stdio::piped()).spawn()?, "the recorder's threads")
}

fn python(python: &Path, folder: &Path, (pace, seconds): (&str, f64)) -> anyhow::Result<Took> {
    let imu = crate::replay::encode(&load::imu(0.0)).unwrap_or_default().len();
    let child = Command::new(python)
        .args(["-c", PEER])
        .arg(folder.join(format!("peer_{pace}.mcap")))
        .args([&seconds.to_string(), pace, &imu.to_string(), &load::FRAME.to_string()])
        .stdout(Stdio::piped())
        .spawn()
        .with_context(|| python.display().to_string())?;
    said(child, "PyPI's writer")
}

/// The node as a process, the load from another one.
#[allow(clippy::cast_precision_loss, reason = "counts of messages")]
fn over_dds(folder: &Path, seconds: f64) -> anyhow::Result<Vec<Benchmark>> {
    let bag = folder.join("dds");
    let config = ConfigDir::find(None)?;
    let mut node = Command::new(programs::there("bag_recorder")?)
        .args(["--ros-args", "-r", "__ns:=/printer", "--log-level", "warn", "--params-file"])
        .arg(config.file("bag_recorder.param.yaml"))
        .args(["-p", &format!("bag_dir:={}", bag.display())])
        .spawn()?;
    let load = Command::new(std::env::current_exe()?)
        .args(["bench", "load", "--into", "dds", "--seconds", &seconds.to_string()])
        .stdout(Stdio::piped())
        .spawn()?;
    let sent = said(load, "the load over DDS");
    std::thread::sleep(Duration::from_millis(500));
    let (cpu_s, peak_mib) = (proc::cpu_s(node.id()), proc::peak_mib(node.id()));
    _ = kill_process(Pid::from_child(&node), Signal::TERM);
    node.wait()?;
    let sent = sent?;
    let counts: Value = serde_json::from_slice(&std::fs::read(bag.join("counts.json"))?)?;
    let of =
        |topic: &str| counts["topics"][topic].as_u64().with_context(|| format!("counts.json: no {topic}"));
    let written = of("/printer/sensors/imu/data_raw")? + of("/printer/sensors/camera/image_raw/compressed")?;
    let dropped = counts["run"]["dropped"].as_f64().context("counts.json: no run.dropped")?;
    let cpu_s = cpu_s.context("the recorder's processor time cannot be read")?;
    let lost = sent.messages as f64 - written as f64;
    let length_s = sent.wall_s + 2.5;
    Ok(vec![
        Benchmark::new("over DDS: messages dropped by the recorder", "-", dropped).target(NONE),
        Benchmark::new("over DDS: messages sent", "-", sent.messages as f64),
        Benchmark::new("over DDS: messages that did not arrive", "-", lost).target(NONE),
        Benchmark::new("over DDS: processor", "% of a core", 100.0 * cpu_s / length_s),
        Benchmark::new("over DDS: memory", "MiB", peak_mib.unwrap_or(0.0)),
    ])
}
