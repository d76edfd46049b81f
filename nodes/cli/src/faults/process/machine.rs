//! How much of the machine is taken by what is none of ours, and how late it wakes a thread that does nothing: without
//! these a measured jitter says little.

use super::aside::Aside;
use super::session::Session;
use runtime::topics;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Name of what [`bare_timer`] measures.
pub(super) const BARE: &str = "bare timer late";

/// Ticks of the processors since the start: all, busy ones, and those of the graph and of this process.
#[derive(Debug, Clone, Copy)]
pub(super) struct Machine {
    all: f64,
    busy: f64,
    ours: f64,
}

impl Machine {
    /// Looks now.
    pub(super) fn look(session: &Session) -> Self {
        let text = std::fs::read_to_string("/proc/stat").unwrap_or_default();
        let fields = text.lines().next().unwrap_or_default().split_whitespace().skip(1);
        // user nice system idle iowait irq softirq steal; guests are part of user.
        let ticks: Vec<f64> = fields.take(8).filter_map(|field| field.parse().ok()).collect();
        let idle: f64 = ticks.iter().skip(3).take(2).sum();
        let all: f64 = ticks.iter().sum();
        let pids = session.graph.pids().into_values().map(|pid| pid.as_raw_nonzero().get().unsigned_abs());
        let ours = pids.chain([std::process::id()]).map(ticks_of).sum();
        Self { all, busy: all - idle, ours }
    }

    /// Processors that were busy with something else since `before`.
    pub(super) fn foreign_since(&self, before: &Self) -> f64 {
        let all = self.all - before.all;
        let foreign = (self.busy - before.busy) - (self.ours - before.ours);
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        #[allow(clippy::cast_precision_loss, reason = "a handful")]
        let cores = cores as f64;
        if all > 0.0 { (cores * foreign / all).max(0.0) } else { 0.0 }
    }
}

/// Ticks in which a process ran.
fn ticks_of(pid: u32) -> f64 {
    let text = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    // The name may hold anything, it ends with the last bracket; then user and system time are the 12th and 13th.
    let (_, rest) = text.rsplit_once(')').unwrap_or_default();
    rest.split_whitespace().skip(11).take(2).filter_map(|field| field.parse::<f64>().ok()).sum()
}

/// A thread that wakes as often as the supervisor ticks, and does nothing else: how much longer than that it took each time
/// `[s]`.
pub(super) fn bare_timer() -> Aside<Vec<f64>> {
    Aside::start(|stop| {
        let period = Duration::from_secs_f64(topics::PERMIT_PERIOD.0);
        let mut due = Instant::now() + period;
        let mut before: Option<Instant> = None;
        let mut late = Vec::new();
        while !stop.load(Ordering::Relaxed) {
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
            let now = Instant::now();
            late.extend(before.map(|before| now.duration_since(before).saturating_sub(period).as_secs_f64()));
            before = Some(now);
            while due <= now {
                due += period;
            }
        }
        Ok(late)
    })
}
