//! `fdm replay`: the brains over a bag in virtual time, as recorded or with other parameters.
//!
//! Every brain hears what the bag holds, in its order, and what it says is compared with what was recorded. Where a
//! parameter is set, the run with the recorded parameters is what is compared with; brains behind a changed one then hear
//! its new words. The printer itself does not answer: what it did is what the bag says.

mod brains;
mod compare;
mod events;
mod fields;
mod record;
mod recorded;
mod schedule;
mod set;
mod settings;
mod text;

pub(crate) use brains::encode;
pub(crate) use record::VIRTUAL;

use crate::config::ConfigDir;
use crate::output::{self, Failed, Json};
use anyhow::bail;
use brains::{Brains, Feeds, Said};
use clap::Args;
use compare::{Output, SAID, compare};
use record::Record;
use runtime::topics;
use schedule::{Schedule, Timers};
use serde::Serialize;
use set::Set;
use settings::{Settings, Source};
use std::path::PathBuf;

/// Runs the brains over a bag in virtual time.
#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// Folder of the bag, or one .mcap or .mcap.active file.
    bag: PathBuf,
    /// Parameter in place of the recorded one: node.parameter=value. As often as wanted. The loop is open: what the sensors
    /// measured stays as it was recorded.
    #[arg(long = "set", value_name = "NODE.PARAM=VALUE")]
    set: Vec<String>,
    /// Namespace of the printer; the first one in the bag by default.
    #[arg(long)]
    namespace: Option<String>,
    /// Folder with the parameter files, for what the bag does not say.
    #[arg(long)]
    config: Option<PathBuf>,
    /// Material, for a bag that does not say its parameters; PLA by default.
    #[arg(long)]
    material: Option<String>,
    /// Judge the frames again too; slow. Else the recorded judgements stand.
    #[arg(long)]
    camera: bool,
    /// Exit code 1 unless every output is the recorded one, bit by bit.
    #[arg(long, conflicts_with = "set")]
    check: bool,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// What is told of a replay.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Figures {
    pub(crate) bag: String,
    pub(crate) namespace: String,
    /// `virtual`, `simulated` or `monotonic`.
    pub(crate) clock: String,
    pub(crate) messages: u64,
    pub(crate) span_s: f64,
    /// Where the parameters come from: `bag` or `config`.
    pub(crate) parameters: &'static str,
    /// What shows that the record is another build's, a line for each parameter.
    pub(crate) other_build: Vec<String>,
    pub(crate) set: Vec<String>,
    /// What the replay is compared with: `recorded` or `replayed`.
    pub(crate) baseline: &'static str,
    pub(crate) outputs: Vec<Output>,
    /// Every output is the baseline's, bit by bit.
    pub(crate) identical: bool,
}

/// Runs the command.
///
/// # Errors
/// One line that says what is wrong and where.
pub fn run(args: &ReplayArgs) -> anyhow::Result<()> {
    let json = Json::new(args.json.as_deref());
    json.check()?;
    let figures = figures(args)?;
    if !json.is_stdout() {
        output::line(&text::page(&figures))?;
    }
    json.write(&figures)?;
    match figures.outputs.iter().find(|output| !output.is_identical()) {
        Some(output) if args.check => {
            let build = if figures.other_build.is_empty() { "" } else { ", which is another build's" };
            let said = format!("{}: {} differs from its record{build}", figures.bag, output.topic);
            Err(Failed(said).into())
        }
        _ => Ok(()),
    }
}

fn figures(args: &ReplayArgs) -> anyhow::Result<Figures> {
    let sets = Set::parse_all(&args.set)?;
    let judged = args.camera || sets.iter().any(|set| set.node == "defect_classifier");
    let config = ConfigDir::find(args.config.as_deref())?;
    if let Some(asked) = &args.material {
        config.check_material(asked)?;
    }
    let record = Record::read(&args.bag, args.namespace.as_deref(), judged)?;
    let frames = record.has(topics::CAMERA_IMAGE.name());
    let predictions = record.has(topics::ADVANCE_PREDICTION.name());
    refuse_unheard(&sets, frames, predictions)?;
    let recorded = record.parameters();
    let material = recorded.material_for(args.material.as_deref(), &config, &args.bag)?;
    let source = Source {
        config: &config,
        recorded: &recorded,
        material: &material,
        frames,
        predictions,
        sessions: record.sessions(),
    };
    let changed = source.settings(&sets)?;
    let as_recorded = source.settings(&[])?;
    let base = play(&record, &as_recorded, Feeds::default())?;
    let outputs = if sets.is_empty() {
        beside(&of_record(&record), &base, record.is_virtual(), record.end_ns())
    } else {
        let feeds = feeds(&sets, frames);
        beside(&base, &play(&record, &changed, feeds)?, true, None)
    };
    Ok(Figures {
        bag: args.bag.display().to_string(),
        namespace: record.namespace.clone().unwrap_or_default(),
        clock: record.note.get("clock").cloned().unwrap_or_else(|| "unknown".to_owned()),
        messages: record.messages,
        span_s: record.span_s(),
        parameters: if recorded.is_empty() { "config" } else { "bag" },
        other_build: source.other_build()?,
        set: args.set.clone(),
        baseline: if sets.is_empty() { "recorded" } else { "replayed" },
        identical: outputs.iter().all(Output::is_identical),
        outputs,
    })
}

/// A parameter of a brain that would hear nothing changes nothing.
fn refuse_unheard(sets: &[Set], frames: bool, predictions: bool) -> anyhow::Result<()> {
    for set in sets {
        let lacking = match set.node {
            "defect_classifier" if !frames => topics::CAMERA_IMAGE.name(),
            "advance_predictor" if !predictions => topics::ADVANCE_PREDICTION.name(),
            _ => continue,
        };
        bail!("--set {}.{}: the bag holds nothing of {lacking}", set.node, set.name);
    }
    Ok(())
}

/// Whose new words are heard: those of changed brains, and of all behind them.
fn feeds(sets: &[Set], frames: bool) -> Feeds {
    let set = |node| sets.iter().any(|set| set.node == node);
    // Estimates and widths feed each other.
    let estimate = set("state_estimator") || set("defect_classifier");
    let prediction = set("advance_predictor");
    Feeds {
        estimate,
        vision: estimate && frames,
        prediction,
        command: estimate || prediction || set("mpc_controller"),
    }
}

/// Lets the brains live through a record.
fn play(record: &Record, settings: &Settings, feeds: Feeds) -> anyhow::Result<Vec<Said>> {
    let usual = |has: bool| has && !record.is_virtual();
    let own_period = feeds.estimate && settings_differ(record, settings);
    let timers = Timers {
        estimates: usual(record.has(topics::ESTIMATE.name())) && !own_period,
        permits: usual(record.has(topics::SAFETY_COMMAND.name())),
    };
    let mut said = Vec::new();
    for part in &record.parts {
        let mut brains = Brains::new(settings, feeds)?;
        Schedule::new(record, part, settings, (feeds, timers)).run(&mut brains);
        said.append(&mut brains.said);
    }
    Ok(said)
}

/// Whether the estimator's period is not the one of the recorded estimates: 10 % apart.
fn settings_differ(record: &Record, settings: &Settings) -> bool {
    let stamps: Vec<u64> = record
        .of(topics::ESTIMATE.name())
        .filter_map(|kept| schedule::stamp_ns(&kept.payload))
        .take(200)
        .collect();
    // Two at a time: a turn on a sample comes early, and the timer's after it later for that.
    let mut gaps_ns: Vec<u64> =
        stamps.windows(3).map(|turns| turns[2].saturating_sub(turns[0]) / 2).collect();
    gaps_ns.sort_unstable();
    #[allow(clippy::cast_precision_loss, reason = "a period")]
    let median_s = gaps_ns.get(gaps_ns.len() / 2).map(|ns| *ns as f64 * 1e-9);
    median_s.is_some_and(|median_s| (median_s / settings.estimator.period_s - 1.0).abs() > 0.1)
}

/// What the bag says that its brains have said.
fn of_record(record: &Record) -> Vec<Said> {
    let said = record.parts.iter().flatten().filter(|kept| SAID.contains(&kept.topic));
    said.map(|kept| Said { topic: kept.topic, at_ns: kept.log_ns, payload: kept.payload.clone() }).collect()
}

/// Topic by topic. Beside a record, which ends at `end_ns`, a topic of a brain that was not replayed is left out, and so is what
/// lies beyond that end; beside another replay, `None`, nothing is.
fn beside(before: &[Said], after: &[Said], exact: bool, end_ns: Option<u64>) -> Vec<Output> {
    let always = [topics::ESTIMATE.name(), topics::CONTROL_COMMAND.name(), topics::SAFETY_COMMAND.name()];
    let mut outputs = Vec::new();
    for topic in SAID {
        let (one, mut other) = (on(topic, before), on(topic, after));
        if let Some(end_ns) = end_ns {
            leave_out_beyond(&mut other, one.len(), end_ns.saturating_sub(slack_ns(exact)));
        }
        let ceased = end_ns.is_none() && !one.is_empty();
        if !other.is_empty() || ceased || always.contains(&topic) || topic == topics::EVENTS.name() {
            outputs.push(compare(topic, &payloads(&one), &payloads(&other), exact));
        }
    }
    outputs
}

/// How far before the record's end a word may have been said that was to be logged behind it `[ns]`.
fn slack_ns(exact: bool) -> u64 {
    if exact { 1_000 } else { compare::TOGETHER_NS }
}

/// Takes away what was said at the record's end, or later, beyond what stands there: a bag that was cut off holds the
/// beginning of its last instant alone.
fn leave_out_beyond(after: &mut Vec<&Said>, recorded: usize, end_ns: u64) {
    while after.len() > recorded && after.last().is_some_and(|said| said.at_ns >= end_ns) {
        after.pop();
    }
}

fn on<'a>(topic: &str, said: &'a [Said]) -> Vec<&'a Said> {
    said.iter().filter(|said| said.topic == topic).collect()
}

fn payloads<'a>(said: &[&'a Said]) -> Vec<&'a [u8]> {
    said.iter().map(|said| said.payload.as_slice()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plan that a change of parameters ends is told; of a record it may be a brain's that is not replayed.
    #[test]
    fn what_is_said_no_more_is_told_beside_another_replay() {
        let topic = topics::CONTROL_SCHEDULE.name();
        let before = [Said { topic, at_ns: 10, payload: vec![0; 12] }];
        let told =
            |end_ns| beside(&before, &[], true, end_ns).into_iter().find(|output| output.topic == topic);
        assert!(
            told(None).is_some_and(|output| output.before == 1 && output.after == 0)
                && told(Some(20)).is_none()
        );
    }

    /// A record that ends at 20 ns, after the first of three words of that instant; what is missing before it is missing.
    #[test]
    fn what_lies_beyond_the_end_of_a_record_is_no_difference() {
        let topic = topics::CONTROL_COMMAND.name();
        let word = |(number, at_ns)| Said { topic, at_ns, payload: vec![number; 12] };
        let all: Vec<Said> = [(0, 10), (1, 20), (2, 20), (3, 20)].map(word).into();
        let left = |recorded, end_ns| {
            let mut after = on(topic, &all);
            leave_out_beyond(&mut after, recorded, end_ns);
            after.len()
        };
        assert_eq!((left(2, 20), left(4, 20), left(5, 20)), (2, 4, 4));
        assert_eq!((left(0, 20), left(2, 21)), (1, 4), "before the end");
        let output = |before: &[Said], end_ns| {
            let outputs = beside(before, &all, true, end_ns);
            outputs.into_iter().find(|output| output.topic == topic).unwrap().is_identical()
        };
        assert!(output(&all[..2], Some(20)) && !output(&all[..2], None) && !output(&all[1..3], Some(20)));
    }
}
