//! Processor and memory of a process, as the kernel counts them.

use anyhow::Context;

/// Ticks of the kernel's clock in a second, as Linux gives them to programs.
const TICKS_1_S: f64 = 100.0;

/// Processor time of a process `[s]`.
pub(super) fn cpu_s(pid: u32) -> Option<f64> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The name may hold anything, it ends with the last bracket; then user and system time are the 12th and 13th.
    let (_, rest) = text.rsplit_once(')')?;
    let ticks: f64 =
        rest.split_whitespace().skip(11).take(2).filter_map(|field| field.parse::<f64>().ok()).sum();
    Some(ticks / TICKS_1_S)
}

/// Most memory that a process has had `[MiB]`.
pub(super) fn peak_mib(pid: u32) -> Option<f64> {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok()? / 1024.0)
}

/// Name and number of each child of a process.
pub(super) fn children(pid: u32) -> Vec<(String, u32)> {
    let list = std::fs::read_to_string(format!("/proc/{pid}/task/{pid}/children")).unwrap_or_default();
    let name = |child: u32| {
        let name = std::fs::read_to_string(format!("/proc/{child}/comm")).unwrap_or_default();
        (name.trim().to_owned(), child)
    };
    list.split_whitespace().filter_map(|child| child.parse().ok()).map(name).collect()
}

/// An empty folder of this process.
pub(super) fn scratch(name: &str) -> anyhow::Result<std::path::PathBuf> {
    let folder = std::env::temp_dir().join(format!("fdm_bench_{}_{name}", std::process::id()));
    _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    Ok(folder)
}
