//! L1, L2, L5: spinning processes, floods of messages, and time.

use super::aside::Aside;
use super::graph::Spinners;
use super::machine::{BARE, bare_timer};
use super::outcome::Observed;
use super::session::Session;
use super::watcher::Watcher;
use anyhow::Context;
use fdm_loop_msgs::{DiagnosticArray, Heartbeat, Log, PrintEvent};
use runtime::{Args, Node, topics};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Time between two looks at the memory `[s]`.
const LOOK_S: f64 = 1.0;
/// Time between two bursts of the flood.
const BURST: Duration = Duration::from_millis(10);
/// Topics of the flood.
const TOPICS: f64 = 4.0;
/// So long a slope of memory says something `[s]`.
const LONG_S: f64 = 1800.0;
/// Seconds in an hour.
const HOUR_S: f64 = 3600.0;

/// What was seen of permits and printer.
fn seen_of(watcher: &Watcher) -> Observed {
    let mut observed = Observed::of(watcher);
    observed.figures.insert("printer_state_gap_s", watcher.gap_s);
    observed.measures.insert("permit late", watcher.jitter.late());
    observed
}

/// L1: so many processes count meanwhile.
pub(super) async fn spin(session: &mut Session, processes: u32, for_s: f64) -> anyhow::Result<Observed> {
    let _spinners = Spinners::start(processes)?;
    let bare = bare_timer();
    let mut watcher = session.watcher();
    session.watch(&mut watcher, for_s).await?;
    bare.stop();
    let mut observed = seen_of(&watcher);
    observed.measures.insert(BARE, bare.result()?);
    Ok(observed)
}

/// L2: messages on the topics that everybody may publish on.
pub(super) async fn flood(
    session: &mut Session,
    (rate_hz, for_s): (f64, f64),
    growth_mib: f64,
) -> anyhow::Result<Observed> {
    let before = session.graph.resident_mib();
    let flood = Aside::start(move |stop| publish_all(rate_hz, stop));
    let mut watcher = session.watcher();
    let mut most: BTreeMap<&str, f64> = BTreeMap::new();
    while watcher.since(session.observer.now()) < for_s {
        session.watch(&mut watcher, LOOK_S).await?;
        for (name, resident) in session.graph.resident_mib() {
            let most = most.entry(name).or_insert(0.0);
            *most = most.max(resident - before.get(name).copied().unwrap_or(resident));
        }
    }
    flood.stop();
    session.watch(&mut watcher, LOOK_S).await?;
    let sent = flood.result()?;
    let mut observed = seen_of(&watcher);
    let (name, grown) = most.iter().max_by(|a, b| a.1.total_cmp(b.1)).map_or(("", 0.0), |(n, g)| (*n, *g));
    if grown > growth_mib {
        observed.wrong.push(format!("{name} grew by {grown:.0} MiB, limit {growth_mib}"));
    }
    observed.figures.insert("growth_mib", grown);
    #[allow(clippy::cast_precision_loss, reason = "thousands")]
    let sent_hz = sent as f64 / for_s;
    // Discovery takes its part of the time.
    if sent_hz < 0.8 * rate_hz {
        observed.wrong.push(format!("{sent_hz:.0} messages a second sent instead of {rate_hz}"));
    }
    observed.figures.insert("sent_hz", sent_hz);
    Ok(observed)
}

/// Publishes in bursts from a participant of its own; how many were sent.
fn publish_all(rate_hz: f64, stop: &AtomicBool) -> anyhow::Result<u64> {
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    executor.block_on(async {
        let args = Args { namespace: Some(super::NAMESPACE.to_owned()), ..Args::default() };
        let mut node = Node::start_with("stranger", args)?;
        let hearts = node.publish_on(&topics::HEARTBEAT)?;
        let reports = node.publish_on(&topics::DIAGNOSTICS)?;
        let events = node.publish_on(&topics::EVENTS)?;
        let lines = node.publish_on(&topics::ROSOUT)?;
        let mut pace = tokio::time::interval(BURST);
        let (mut due, mut sent) = (0.0, 0_u64);
        while !stop.load(Ordering::Relaxed) {
            _ = pace.tick().await;
            due += rate_hz / TOPICS * BURST.as_secs_f64();
            while due >= 1.0 {
                due -= 1.0;
                let name = node.name();
                let took = [
                    hearts.send(Heartbeat { node: name.clone(), ..Heartbeat::default() }),
                    reports.send(DiagnosticArray::default()),
                    events.send(PrintEvent::default()),
                    lines.send(Log { name, ..Log::default() }),
                ];
                sent += took.iter().map(|taken| u64::from(*taken)).sum::<u64>();
            }
        }
        Ok(sent)
    })
}

/// L5: nothing is done; the memory of every node is watched.
pub(super) async fn soak(session: &mut Session, for_s: f64, slope_mib_h: f64) -> anyhow::Result<Observed> {
    let mut watcher = session.watcher();
    let mut sizes: BTreeMap<&str, Vec<(f64, f64)>> = BTreeMap::new();
    while watcher.since(session.observer.now()) < for_s {
        session.watch(&mut watcher, LOOK_S).await?;
        let now_s = watcher.since(session.observer.now());
        for (name, resident) in session.graph.resident_mib() {
            sizes.entry(name).or_default().push((now_s, resident));
        }
    }
    let mut observed = seen_of(&watcher);
    // The first third warms caches and queues up.
    let settled =
        |points: &[(f64, f64)]| -> f64 { slope(points.get(points.len() / 3..).unwrap_or_default()) * HOUR_S };
    let steepest =
        sizes.iter().map(|(name, points)| (*name, settled(points))).max_by(|a, b| a.1.total_cmp(&b.1));
    let (name, steepest) = steepest.context("no node runs")?;
    if for_s >= LONG_S && steepest > slope_mib_h {
        observed.wrong.push(format!("{name} grows by {steepest:.1} MiB/h, limit {slope_mib_h}"));
    }
    observed.figures.insert("rss_slope_mib_h", steepest);
    let largest = sizes.values().filter_map(|points| Some(points.last()?.1)).sum();
    observed.figures.insert("rss_all_mib", largest);
    Ok(observed)
}

/// Slope of a line through the points, by least squares; 0 through fewer than two.
fn slope(points: &[(f64, f64)]) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "thousands")]
    let count = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |sum, point| (sum.0 + point.0, sum.1 + point.1));
    let (x, y) = (x / count, y / count);
    let (top, bottom) = points.iter().fold((0.0, 0.0), |(top, bottom), point| {
        (top + (point.0 - x) * (point.1 - y), bottom + (point.0 - x) * (point.0 - x))
    });
    if bottom > 0.0 { top / bottom } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_its_own_slope_and_a_point_none() {
        let points: Vec<(f64, f64)> = (0..10).map(|x| (f64::from(x), 5.0 + 0.25 * f64::from(x))).collect();
        assert!((slope(&points) - 0.25).abs() < 1e-12);
        assert!(slope(&points[..1]).abs() < 1e-12);
        assert!(slope(&[]).abs() < 1e-12);
    }
}
