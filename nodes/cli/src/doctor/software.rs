//! System, nodes, processors, memory, disk, clock.

use super::finding::Finding;
use super::machine::{Machine, nearest};
use crate::up::recipes::NODES;
use rustix::fs::{Access, access, statvfs};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Oldest Debian that the binaries are built for and tested on.
const DEBIAN_MIN: u32 = 12;
/// Exit code of a node that refuses its arguments.
const REFUSED: i32 = 2;
/// Exit code of the loader where a library is missing.
const NOT_LOADED: i32 = 127;
/// The recorder keeps this much free (faults.md, T1) `[byte]`.
const DISK_MIN: u64 = 500_000_000;
/// An hour with camera takes about this much `[byte]`.
const DISK_USUAL: u64 = 4_000_000_000;
/// All nodes together take about this much `[byte]`.
const MEMORY_MIN: u64 = 500_000_000;
/// Below this the machine begins to swap beside a browser `[byte]`.
const MEMORY_USUAL: u64 = 1_000_000_000;
/// The supervisor's period.
const TICK: Duration = Duration::from_millis(20);
/// Lateness that it forgives, and one that a quiet machine stays below `[s]`.
const LATE_MAX_S: f64 = 0.2;
const LATE_USUAL_S: f64 = 0.02;
/// Ticks that are watched.
const TICKS: u32 = 50;

/// The distribution.
pub(super) fn system(machine: &Machine) -> Finding {
    let text = machine.text("etc/os-release").unwrap_or_default();
    let value = |key: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('='));
        line.map(|value| value.trim_matches('"').to_owned()).unwrap_or_default()
    };
    let name = value("PRETTY_NAME");
    let version: Option<u32> = value("VERSION_ID").parse().ok();
    if value("ID") == "debian" && version.is_some_and(|version| version >= DEBIAN_MIN) {
        return Finding::ok("system", name);
    }
    let name = if name.is_empty() { "unknown".to_owned() } else { name };
    Finding::warn(
        "system",
        name,
        format!("tested on Debian {DEBIAN_MIN} and later: packages may have other names here"),
    )
}

/// Each node beside this executable is loaded with its libraries; it refuses the argument and ends.
pub(super) fn nodes() -> Finding {
    const NAME: &str = "nodes";
    let Some(folder) = std::env::current_exe().ok().and_then(|exe| Some(exe.parent()?.to_path_buf())) else {
        return Finding::fail(NAME, "the folder of this executable is not known", "call fdm by its path");
    };
    let missing: Vec<&str> = NODES.into_iter().filter(|name| !folder.join(name).is_file()).collect();
    if !missing.is_empty() {
        let found = format!("missing in {}: {}", folder.display(), missing.join(", "));
        return Finding::fail(NAME, found, "cargo build --release --workspace --bins");
    }
    judged(NODES.into_iter().filter_map(|name| loads(&folder.join(name)).err()).collect())
}

/// Why a program does not come as far as to refuse an argument.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Trouble {
    /// The loader misses a library.
    Library(String),
    /// It ended in some other way.
    Other(String),
}

fn judged(troubles: Vec<Trouble>) -> Finding {
    const NAME: &str = "nodes";
    let count = NODES.len();
    match troubles.first() {
        None => Finding::ok(NAME, format!("all {count} load with their libraries")),
        Some(Trouble::Library(first)) => Finding::fail(
            NAME,
            format!("{} of {count} do not load: {first}", troubles.len()),
            "apt-get install --no-install-recommends libopencv-videoio406 (OpenCV of Debian 12; it brings core, \
             imgproc and imgcodecs)",
        ),
        Some(Trouble::Other(first)) => Finding::fail(
            NAME,
            format!("{} of {count} do not start: {first}", troubles.len()),
            "start that program by itself to see why; cargo build --release --workspace --bins makes all anew",
        ),
    }
}

/// Starts a node with an argument that no node takes.
fn loads(program: &Path) -> Result<(), Trouble> {
    let name = program.file_name().unwrap_or_default().to_string_lossy();
    let ended = Command::new(program).arg("--doctor").stdin(Stdio::null()).output();
    let ended = ended.map_err(|error| Trouble::Other(format!("{name}: {error}")))?;
    match ended.status.code() {
        Some(REFUSED) => Ok(()),
        Some(NOT_LOADED) => {
            let said = String::from_utf8_lossy(&ended.stderr);
            Err(Trouble::Library(said.lines().next().unwrap_or_default().to_owned()))
        }
        // Of a signal the system says number and name.
        _ => Err(Trouble::Other(format!("{name} ended by itself ({})", ended.status))),
    }
}

/// A compiler is for building alone.
pub(super) fn build_tools() -> Finding {
    let there = |program: &str| {
        let path = std::env::var_os("PATH").unwrap_or_default();
        std::env::split_paths(&path).any(|folder| folder.join(program).is_file())
    };
    let (has, lacks): (Vec<&str>, Vec<&str>) =
        ["cargo", "c++", "clang"].into_iter().partition(|name| there(name));
    let list = |names: Vec<&str>| if names.is_empty() { "none".to_owned() } else { names.join(", ") };
    Finding::ok("build tools", format!("not needed to run; here: {}, not here: {}", list(has), list(lacks)))
}

/// Count and load of the processors.
pub(super) fn processors(machine: &Machine) -> Finding {
    const NAME: &str = "processors";
    let count = std::thread::available_parallelism().map_or(1, usize::from);
    let load = machine.text("proc/loadavg").and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    let found = format!("{count}, load {}", load.map_or("not known".to_owned(), |load| format!("{load:.1}")));
    let governor = machine.text("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
    if load.is_some_and(|load| load > 1.5 * count as f64) {
        return Finding::warn(
            NAME,
            found,
            "other work slows the nodes down: the supervisor degrades where it comes late",
        );
    }
    match governor.as_deref() {
        Some("powersave") => Finding::warn(
            NAME,
            format!("{found}, governor powersave"),
            "echo schedutil | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor, where ticks come late",
        ),
        _ if count < 2 => Finding::warn(NAME, found, "two or more leave the supervisor one of its own"),
        _ => Finding::ok(NAME, found),
    }
}

/// Free memory.
pub(super) fn memory(machine: &Machine) -> Finding {
    const NAME: &str = "memory";
    let text = machine.text("proc/meminfo").unwrap_or_default();
    let Some(free) = kib(&text, "MemAvailable") else {
        return Finding::warn(NAME, "not known", "");
    };
    let found = format!("{:.1} of {:.1} GB free", gb(free), gb(kib(&text, "MemTotal").unwrap_or(0)));
    match free {
        ..MEMORY_MIN => {
            Finding::fail(NAME, found, "all nodes together take about half a gigabyte: end other programs")
        }
        MEMORY_MIN..MEMORY_USUAL => Finding::warn(NAME, found, "end other programs for prints with a camera"),
        _ => Finding::ok(NAME, found),
    }
}

fn gb(bytes: u64) -> f64 {
    bytes as f64 / 1e9
}

/// A line of `/proc/meminfo` in bytes.
fn kib(text: &str, key: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(':'))?;
    line.split_whitespace().next()?.parse::<u64>().ok()?.checked_mul(1024)
}

/// Room for bags.
pub(super) fn disk(bags: &Path) -> Finding {
    const NAME: &str = "disk";
    let folder = nearest(bags);
    let place = folder.display();
    let Ok(disk) = statvfs(&folder) else {
        return Finding::warn(NAME, format!("{place}: not known"), "");
    };
    let free = disk.f_bavail.saturating_mul(disk.f_frsize);
    let found = format!("{:.1} GB free at {place}", gb(free));
    if !folder.is_dir() || access(&folder, Access::WRITE_OK).is_err() {
        return Finding::fail(
            NAME,
            format!("{place} cannot be written"),
            "choose another folder with --bags and fdm up --bag",
        );
    }
    match free {
        ..DISK_MIN => Finding::fail(NAME, found, "bags need room: delete old ones, or choose another folder"),
        DISK_MIN..DISK_USUAL => Finding::warn(NAME, found, "an hour with a camera takes about 4 GB"),
        _ => Finding::ok(NAME, found),
    }
}

/// The clock of the nodes, and the wall clock that bags are dated by.
pub(super) fn clock(machine: &Machine) -> [Finding; 2] {
    [steadiness(machine), wall_clock(machine)]
}

fn steadiness(machine: &Machine) -> Finding {
    const NAME: &str = "clock";
    let source = machine.text("sys/devices/system/clocksource/clocksource0/current_clocksource");
    let source = source.unwrap_or_else(|| "not known".to_owned());
    let found = |late_s: f64| format!("{source}; ticks of 20 ms came at most {:.1} ms late", late_s * 1e3);
    let slow = ["jiffies", "refined-jiffies", "acpi_pm", "pit"].contains(&source.as_str());
    match lateness() {
        Err(error) => Finding::fail(NAME, format!("{source}; {error:#}"), "start fdm doctor again"),
        Ok(late_s) if late_s > LATE_MAX_S => Finding::fail(
            NAME,
            found(late_s),
            "the supervisor would degrade: end other programs, or take a faster machine",
        ),
        Ok(late_s) if late_s > LATE_USUAL_S => {
            Finding::warn(NAME, found(late_s), "other work comes in between: see processors")
        }
        Ok(late_s) if slow => {
            Finding::warn(NAME, found(late_s), "this clock source is coarse: see the kernel's log for why")
        }
        Ok(late_s) => Finding::ok(NAME, found(late_s)),
    }
}

/// Largest lateness of a tick `[s]` over one second.
fn lateness() -> anyhow::Result<f64> {
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    executor.block_on(async {
        let start = tokio::time::Instant::now();
        let mut latest_s = 0.0_f64;
        for tick in 1..=TICKS {
            let due = start + TICK * tick;
            tokio::time::sleep_until(due).await;
            latest_s = latest_s.max(due.elapsed().as_secs_f64());
        }
        Ok(latest_s)
    })
}

fn wall_clock(machine: &Machine) -> Finding {
    const NAME: &str = "wall clock";
    let stamped = machine.path("run/systemd/timesync/synchronized").exists();
    let asked = Command::new("timedatectl").args(["show", "-p", "NTPSynchronized", "--value"]).output().ok();
    let said =
        asked.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned()).unwrap_or_default();
    match said.as_str() {
        "yes" => Finding::ok(NAME, "kept by NTP"),
        _ if stamped => Finding::ok(NAME, "kept by NTP"),
        "no" => Finding::warn(
            NAME,
            "not kept by NTP",
            "bags may carry a wrong date: sudo timedatectl set-ntp true",
        ),
        _ => Finding::ok(NAME, "whether NTP keeps it is not known; only the dates of bags depend on it"),
    }
}

#[cfg(test)]
mod tests;
