//! `fdm status`: who is there, and what the printer does.

mod life;

use crate::operate::{executor, in_namespace};
use crate::output::{self, Failed, Json};
use crate::participant;
use crate::up::words::{mode_name, phase_name, todo};
use anyhow::bail;
use clap::Args;
use fdm_loop_msgs::{Heartbeat, PrinterState, SafetyState, Temperature};
use models::units::Seconds;
use runtime::{Received, topics};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// Which printer.
#[derive(Debug, Args)]
pub struct StatusArgs {
    /// Namespace of the printer.
    #[arg(long, default_value = "/printer", value_parser = runtime::check_namespace)]
    namespace: String,
    /// How long to listen `[s]`.
    #[arg(long, default_value_t = 2.0)]
    listen_s: f64,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// What was heard of a node.
#[derive(Debug, Clone, Default, Serialize)]
struct Seen {
    beats: u64,
    work_counter: u64,
    /// Its state by its own word: `active`, or what it is else; `None` where it did not answer.
    state: Option<String>,
}

/// What was heard of a graph.
#[derive(Debug, Clone, Serialize)]
struct Status {
    nodes: BTreeMap<String, Seen>,
    /// Nodes of this graph whose heart is not heard.
    silent: Vec<String>,
    mode: Option<String>,
    /// The mode that a person has asked for, in force where nothing speaks against it.
    mode_as_set: Option<String>,
    cause: Option<String>,
    what_to_do: Option<String>,
    /// The mode ends by acknowledge alone.
    latched: Option<bool>,
    phase: Option<String>,
    progress: Option<f64>,
    layer: Option<u32>,
    line: Option<u64>,
    /// The mains relay feeds the heaters.
    mains_on: Option<bool>,
    hotend_degc: Option<f64>,
    hotend_target_degc: Option<f64>,
    bed_degc: Option<f64>,
    bed_target_degc: Option<f64>,
    flow_factor: Option<f64>,
    speed_factor: Option<f64>,
}

/// Listens for a while and says who is there and what the printer does.
///
/// # Errors
/// No graph in this domain, exit code 2; nodes and no supervisor, exit code 1.
pub fn run(args: &StatusArgs) -> anyhow::Result<()> {
    let json = Json::new(args.json.as_deref());
    json.check()?;
    let seen = executor()?.block_on(listen(args))?;
    if !json.is_stdout() {
        output::line(&text(&seen))?;
    }
    json.write(&seen)?;
    match seen.mode {
        None => Err(Failed(no_supervisor(&args.namespace)).into()),
        Some(_) => Ok(()),
    }
}

/// What to do where nodes are there and nobody guards them.
fn no_supervisor(namespace: &str) -> String {
    format!(
        "no supervisor of {namespace} was heard: nobody guards this printer, and `fdm pause` may reach nobody. `fdm estop` tells \
         the printer itself where it must stop; look into the log of safety_supervisor, and start it again"
    )
}

async fn listen(args: &StatusArgs) -> anyhow::Result<Status> {
    let mut node = participant::join("fdm", in_namespace(&args.namespace))?;
    let mut beats = node.subscribe(&topics::HEARTBEAT)?;
    let mut states = node.subscribe(&topics::PRINTER_STATE)?;
    let mut safety = node.subscribe(&topics::SAFETY_STATE)?;
    let mut hotends = node.subscribe(&topics::HOTEND_TEMPERATURE)?;
    let mut beds = node.subscribe(&topics::BED_TEMPERATURE)?;
    let (mut hotend, mut bed) = (None, None);
    let (mut state, mut supervisor): (Option<PrinterState>, Option<SafetyState>) = (None, None);
    let mut nodes: BTreeMap<String, Seen> = BTreeMap::new();
    let started = node.clock().now();
    let mut ticks = node.timer(Seconds(0.05));
    while (node.clock().now() - started).0 < args.listen_s {
        _ = ticks.next().await;
        while let Some(beat) = beats.try_recv() {
            note(&mut nodes, &beat.message);
        }
        state = states.drain_newest().map(|received| received.message).or(state);
        hotend = hotends.drain_newest().or(hotend);
        bed = beds.drain_newest().or(bed);
        supervisor = safety.drain_newest().map(|received| received.message).or(supervisor);
    }
    // The participant of this command has a heart as well.
    nodes.remove(&node.name());
    if nodes.is_empty() {
        bail!(nothing_heard(args, &node.published_topics()));
    }
    let silent = life::silent(&args.namespace, &nodes, &node.published_topics());
    if life::states(&mut node, &mut nodes).await? {
        output::note(&format!("no node told its state: {}", crate::operate::other_rmw()));
    }
    let degc = |read: Option<Received<Temperature>>| read.map(|read| read.message.temperature);
    Ok(status((nodes, silent), supervisor, state, (degc(hotend), degc(bed))))
}

/// What the newest messages say.
fn status(
    (nodes, silent): (BTreeMap<String, Seen>, Vec<String>),
    supervisor: Option<SafetyState>,
    state: Option<PrinterState>,
    (hotend_degc, bed_degc): (Option<f64>, Option<f64>),
) -> Status {
    Status {
        nodes,
        silent,
        mode: supervisor.as_ref().map(|safety| mode_name(safety.mode).to_owned()),
        mode_as_set: supervisor.as_ref().map(|safety| mode_name(safety.set_mode).to_owned()),
        cause: supervisor.as_ref().map(|safety| safety.cause.clone()),
        latched: supervisor.as_ref().map(|safety| safety.latched),
        what_to_do: supervisor.map(|safety| safety.what_to_do),
        phase: state.as_ref().map(|state| phase_name(state.phase).to_owned()),
        progress: state.as_ref().map(|state| state.progress),
        layer: state.as_ref().filter(|state| state.layer_known).map(|state| state.layer + 1),
        line: state.as_ref().map(|state| state.line),
        mains_on: state.as_ref().map(|state| state.mains_on),
        hotend_degc,
        hotend_target_degc: state.as_ref().map(|state| state.hotend_target_degc),
        bed_degc,
        bed_target_degc: state.as_ref().map(|state| state.bed_target_degc),
        flow_factor: state.as_ref().map(|state| state.flow_factor),
        speed_factor: state.as_ref().map(|state| state.speed_factor),
    }
}

/// What to do where nothing of a printer was heard; of others perhaps.
fn nothing_heard(args: &StatusArgs, published: &BTreeSet<String>) -> String {
    let of =
        |topic: &String| topic.strip_suffix(topics::HEARTBEAT.name())?.strip_suffix('/').map(str::to_owned);
    let own = args.namespace.trim_end_matches('/');
    let others: Vec<String> = published.iter().filter_map(of).filter(|other| other != own).collect();
    let todo = if others.is_empty() {
        "is `fdm up` running, with the same ROS_DOMAIN_ID?".to_owned()
    } else {
        let named = |other: &String| format!("--namespace {}", if other.is_empty() { "/" } else { other });
        format!("others are there: {}", others.iter().map(named).collect::<Vec<_>>().join(", "))
    };
    format!("no node of {} was heard in {} s: {todo}", args.namespace, args.listen_s)
}

fn note(nodes: &mut BTreeMap<String, Seen>, beat: &Heartbeat) {
    let seen = nodes.entry(beat.node.clone()).or_default();
    seen.beats += 1;
    seen.work_counter = beat.work_counter;
}

fn text(status: &Status) -> String {
    let mut lines: Vec<String> = status
        .nodes
        .iter()
        .map(|(name, seen)| {
            let state = seen.state.as_deref().filter(|state| *state != "active");
            let state = state.map_or(String::new(), |state| format!(", NOT ACTIVE: {state}"));
            format!("{name:<32} {} heartbeats, work {}{state}", seen.beats, seen.work_counter)
        })
        .chain(
            status
                .silent
                .iter()
                .map(|name| format!("{name:<32} silent: no heartbeat, it hangs or has ended")),
        )
        .collect();
    let mode = status.mode.as_deref().unwrap_or("not heard");
    let cause = status.cause.as_deref().filter(|cause| !cause.is_empty());
    let cause = cause.map_or(String::new(), |cause| format!(" ({cause})"));
    let latched = if status.latched == Some(true) { ", latched until `fdm acknowledge`" } else { "" };
    let set = status.mode_as_set.as_deref().filter(|set| *set != mode);
    let set = set.map_or(String::new(), |set| format!(", set to {set}"));
    lines.push(format!("supervisor: {mode}{cause}{latched}{set}"));
    if let Some(text) = status.what_to_do.as_deref().filter(|text| !text.is_empty()) {
        lines.push(format!("what to do: {}", todo(text)));
    }
    if let Some(progress) = status.progress {
        let layer = status.layer.map_or("-".to_owned(), |layer| layer.to_string());
        let phase = status.phase.as_deref().unwrap_or("unknown");
        let mains = if status.mains_on == Some(false) { ", off the mains" } else { "" };
        lines.push(format!("printer: {phase}, {:.1} %, layer {layer}{mains}", progress * 100.0));
    }
    let hotend = temperature(status.hotend_degc, status.hotend_target_degc);
    let bed = temperature(status.bed_degc, status.bed_target_degc);
    lines.push(format!("temperatures: hot end {hotend}; bed {bed}"));
    lines.join("\n")
}

/// What is read, and the set-point.
fn temperature(read_degc: Option<f64>, target_degc: Option<f64>) -> String {
    let read = read_degc.map_or("not heard".to_owned(), |read_degc| format!("{read_degc:.1} degC"));
    target_degc.map_or(read.clone(), |target_degc| format!("{read}, set to {target_degc:.0} degC"))
}

#[cfg(test)]
mod tests;
