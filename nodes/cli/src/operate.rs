//! `fdm status`, and what a person asks of the supervisor: `pause`, `resume`, `stop`, `estop`, `acknowledge`, `mode`.

use crate::output::{self, Json};
use crate::participant;
use crate::up::words::mode_name;
use anyhow::{Context, bail};
use clap::Args;
use fdm_loop_msgs::{Heartbeat, PrinterState, SafetyState, SetModeRequest, Trigger, TriggerRequest};
use models::units::Seconds;
use runtime::topics::{self, Service};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Longest wait for the supervisor's answer `[s]`; it promises 250 ms, discovery takes up to 0.5 s.
const CALL_S: f64 = 3.0;

/// Which printer.
#[derive(Debug, Args)]
pub struct StatusArgs {
    /// Namespace of the printer.
    #[arg(long, default_value = "/printer")]
    namespace: String,
    /// How long to listen `[s]`.
    #[arg(long, default_value_t = 2.0)]
    listen_s: f64,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// Which printer.
#[derive(Debug, Args)]
pub struct AskArgs {
    /// Namespace of the printer.
    #[arg(long, default_value = "/printer")]
    namespace: String,
}

/// What was heard of a node.
#[derive(Debug, Clone, Serialize)]
struct Seen {
    beats: u64,
    work_counter: u64,
}

/// What was heard of a graph.
#[derive(Debug, Clone, Serialize)]
struct Status {
    nodes: BTreeMap<String, Seen>,
    mode: Option<String>,
    cause: Option<String>,
    what_to_do: Option<String>,
    progress: Option<f64>,
    layer: Option<u32>,
    line: Option<u64>,
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
/// No graph in this domain; exit code 2.
pub fn status(args: &StatusArgs) -> anyhow::Result<()> {
    let json = Json::new(args.json.as_deref());
    json.check()?;
    let seen = executor()?.block_on(listen(args))?;
    if !json.is_stdout() {
        output::line(&text(&seen))?;
    }
    json.write(&seen)
}

/// What a person asks of the supervisor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ask {
    /// Pause the job.
    Pause,
    /// End a pause.
    Resume,
    /// Heaters off, job given up.
    Stop,
    /// Emergency stop.
    Estop,
    /// End a latched mode whose cause is gone.
    Acknowledge,
}

impl Ask {
    fn service(self) -> &'static Service<Trigger> {
        match self {
            Self::Pause => &topics::SAFETY_PAUSE,
            Self::Resume => &topics::SAFETY_RESUME,
            Self::Stop => &topics::SAFETY_STOP,
            Self::Estop => &topics::SAFETY_ESTOP,
            Self::Acknowledge => &topics::SAFETY_ACKNOWLEDGE,
        }
    }
}

/// Asks the supervisor and waits for its answer.
///
/// # Errors
/// No supervisor, or one that refuses; exit code 2.
pub fn ask(what: Ask, args: &AskArgs) -> anyhow::Result<()> {
    let name = what.service().name();
    let answer = executor()?.block_on(async {
        let mut node = participant::join("fdm", in_namespace(&args.namespace))?;
        let client = node.client(what.service())?;
        anyhow::Ok(client.call(TriggerRequest::default(), Seconds(CALL_S)).await)
    })?;
    let unconfirmed = || match what {
        Ask::Estop | Ask::Stop => format!("{name} was not confirmed: use the printer's own switch"),
        _ => format!("{name} was not confirmed"),
    };
    let answer = answer.with_context(unconfirmed)?;
    if !answer.success {
        bail!("the supervisor refused {name}: {}", answer.message);
    }
    output::line(&format!("{name}: {}", answer.message))
}

/// Which mode, of which printer.
#[derive(Debug, Args)]
pub struct ModeArgs {
    /// What the loop may do: watch, watch and propose, or correct.
    #[arg(value_enum)]
    mode: Wanted,
    /// Namespace of the printer.
    #[arg(long, default_value = "/printer")]
    namespace: String,
}

/// Modes that a person may ask for.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Wanted {
    Observe,
    Advise,
    Act,
}

/// Asks the supervisor for another mode.
///
/// # Errors
/// No supervisor, or one that refuses; exit code 2.
pub fn set_mode(args: &ModeArgs) -> anyhow::Result<()> {
    let mode = match args.mode {
        Wanted::Observe => SetModeRequest::MODE_OBSERVE,
        Wanted::Advise => SetModeRequest::MODE_ADVISE,
        Wanted::Act => SetModeRequest::MODE_ACT,
    };
    let name = topics::SAFETY_SET_MODE.name();
    let answer = executor()?.block_on(async {
        let mut node = participant::join("fdm", in_namespace(&args.namespace))?;
        let client = node.client(&topics::SAFETY_SET_MODE)?;
        anyhow::Ok(client.call(SetModeRequest { mode }, Seconds(CALL_S)).await)
    })?;
    let answer = answer.with_context(|| format!("{name} was not confirmed"))?;
    if !answer.accepted {
        bail!("the supervisor refused {name}: {}", answer.message);
    }
    output::line(&format!("{name}: {}", answer.message))
}

fn executor() -> anyhow::Result<tokio::runtime::Runtime> {
    Ok(tokio::runtime::Builder::new_current_thread().enable_all().build()?)
}

fn in_namespace(namespace: &str) -> runtime::Args {
    runtime::Args { namespace: Some(namespace.to_owned()), ..runtime::Args::default() }
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
    if nodes.is_empty() {
        bail!(
            "no node of {} was heard in {} s: is `fdm up` running, and ROS_DOMAIN_ID the same?",
            args.namespace,
            args.listen_s
        );
    }
    Ok(Status {
        nodes,
        mode: supervisor.as_ref().map(|safety| mode_name(safety.mode).to_owned()),
        cause: supervisor.as_ref().map(|safety| safety.cause.clone()),
        what_to_do: supervisor.map(|safety| safety.what_to_do),
        progress: state.as_ref().map(|state| state.progress),
        layer: state.as_ref().filter(|state| state.layer_known).map(|state| state.layer + 1),
        line: state.as_ref().map(|state| state.line),
        hotend_degc: hotend.map(|read| read.message.temperature),
        hotend_target_degc: state.as_ref().map(|state| state.hotend_target_degc),
        bed_degc: bed.map(|read| read.message.temperature),
        bed_target_degc: state.as_ref().map(|state| state.bed_target_degc),
        flow_factor: state.as_ref().map(|state| state.flow_factor),
        speed_factor: state.as_ref().map(|state| state.speed_factor),
    })
}

fn note(nodes: &mut BTreeMap<String, Seen>, beat: &Heartbeat) {
    let seen = nodes.entry(beat.node.clone()).or_insert(Seen { beats: 0, work_counter: 0 });
    seen.beats += 1;
    seen.work_counter = beat.work_counter;
}

fn text(status: &Status) -> String {
    let mut lines: Vec<String> = status
        .nodes
        .iter()
        .map(|(name, seen)| format!("{name:<32} {} heartbeats, work {}", seen.beats, seen.work_counter))
        .collect();
    let mode = status.mode.as_deref().unwrap_or("not heard");
    let cause = status.cause.as_deref().filter(|cause| !cause.is_empty());
    lines.push(format!("supervisor: {mode}{}", cause.map_or(String::new(), |cause| format!(" ({cause})"))));
    if let Some(todo) = status.what_to_do.as_deref().filter(|todo| !todo.is_empty()) {
        lines.push(format!("what to do: {todo}"));
    }
    if let Some(progress) = status.progress {
        let layer = status.layer.map_or("-".to_owned(), |layer| layer.to_string());
        lines.push(format!("printer: {:.1} %, layer {layer}", progress * 100.0));
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
mod tests {
    use super::*;

    #[test]
    fn temperatures_stand_beside_their_set_points() {
        let mut status = Status {
            nodes: BTreeMap::new(),
            mode: None,
            cause: None,
            what_to_do: None,
            progress: Some(0.25),
            layer: Some(3),
            line: None,
            hotend_degc: Some(211.44),
            hotend_target_degc: Some(215.0),
            bed_degc: None,
            bed_target_degc: Some(60.0),
            flow_factor: None,
            speed_factor: None,
        };
        let told = text(&status);
        assert!(told.contains("printer: 25.0 %, layer 3\n"), "{told}");
        let line = "temperatures: hot end 211.4 degC, set to 215 degC; bed not heard, set to 60 degC";
        assert!(told.ends_with(line), "{told}");
        status.hotend_target_degc = None;
        assert!(text(&status).contains("hot end 211.4 degC; bed"));
    }
}
