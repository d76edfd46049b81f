//! Publishes known numbers of messages and follows what the recorder says of them on `/diagnostics`.
#![allow(clippy::print_stdout)] // a pipe to the test that started this process

use crate::Counts;
use crate::process::{COUNTS, LIFE_KEY};
use fdm_loop_msgs::{BeadWidth, DiagnosticArray, Header, MotionSegment, PrintEvent, PrintInfo, PrinterState};
use runtime::{Args, Gid, Node, Publisher, RuntimeError, Subscription, topics};
use std::time::Duration;
use tokio::time::{interval, timeout};

/// SHA-256 of the configuration that is published, `a: 1\n`.
pub(crate) const CONFIG_SHA256: &str = "37b128c59f1f5097f73f82691cb519f1f568667faab5ced1b4ab979d36837eae";
/// Messages of each topic that the role `known` sends.
const KNOWN: u64 = 500;
/// Real time between two rounds, one message a topic: 500 Hz each.
const PACE: Duration = Duration::from_millis(2);
/// Longest life of this process, should its test die without a word.
const LIFE: Duration = Duration::from_secs(90);
/// Node whose diagnostics count.
const RECORDER: &str = "/printer/bag_recorder";

/// One publisher a type, of each quality of service.
struct Sources {
    widths: Publisher<BeadWidth>,
    motion: Publisher<MotionSegment>,
    events: Publisher<PrintEvent>,
    states: Publisher<PrinterState>,
}

impl Sources {
    fn new(node: &mut Node) -> Result<Self, RuntimeError> {
        Ok(Self {
            widths: node.publish_on(&topics::BEAD_WIDTH)?,
            motion: node.publish_on(&topics::PRINTER_MOTION)?,
            events: node.publish_on(&topics::EVENTS)?,
            states: node.publish_on(&topics::PRINTER_STATE)?,
        })
    }

    /// One message on each topic.
    fn round(&self, now_s: f64) {
        let header = || Header::at(now_s);
        let why = "x".repeat(200);
        self.widths.send(BeadWidth { header: header(), source: "test".into(), ..BeadWidth::default() });
        self.motion.send(MotionSegment { header: header(), ..MotionSegment::default() });
        self.events.send(PrintEvent { header: header(), why, ..PrintEvent::default() });
        self.states.send(PrinterState { header: header(), ..PrinterState::default() });
    }
}

/// The topics of [`Sources`].
fn names(node: &Node) -> Vec<String> {
    [topics::BEAD_WIDTH.name(), topics::PRINTER_MOTION.name(), topics::EVENTS.name()]
        .into_iter()
        .chain([topics::PRINTER_STATE.name()])
        .map(|name| node.resolve(name))
        .collect()
}

/// What a report of the recorder says it has written of `names`; `None` for another node's.
fn written(report: &DiagnosticArray, names: &[String]) -> Option<Counts> {
    let status = report.status.iter().find(|status| status.name == RECORDER)?;
    let count = |name: &String| {
        let key = format!("{name} written");
        let value = status.values.iter().find(|pair| pair.key == key);
        value.map_or(0, |pair| pair.value.parse().unwrap())
    };
    Some(names.iter().map(|name| (name.clone(), count(name))).collect())
}

/// The next report of the recorder, and whose it is: another life has another publisher.
async fn next_report(reports: &mut Subscription<DiagnosticArray>, names: &[String]) -> (Counts, Gid) {
    loop {
        let report = reports.recv().await;
        if let Some(counts) = written(&report.message, names) {
            return (counts, report.publisher);
        }
    }
}

/// Runs a role to its end.
pub(crate) fn run(role: &str) {
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    executor.block_on(async {
        let mut node = Node::start_with("talker", Args::default()).unwrap();
        let info = PrintInfo {
            print_id: "cube".into(),
            config: "a: 1\n".into(),
            config_sha256: CONFIG_SHA256.into(),
            ..PrintInfo::default()
        };
        let prints = node.publish_on(&topics::PRINT_INFO).unwrap();
        prints.send(info);
        let work = async {
            match role {
                "known" => known(&mut node).await,
                _ => stream(&mut node).await,
            }
        };
        timeout(LIFE, work).await.expect("the recorder writes what was sent");
    });
}

/// The recorder's counts when two reports in a row agree; they come once a second.
async fn at_rest(
    reports: &mut Subscription<DiagnosticArray>,
    names: &[String],
    mut before: Counts,
) -> Counts {
    loop {
        let (counts, _) = next_report(reports, names).await;
        if counts == before {
            return counts;
        }
        before = counts;
    }
}

/// Sends until the recorder has heard every topic; then, from counts that stand still, [`KNOWN`] more of each; ends
/// when the recorder has written them.
async fn known(node: &mut Node) {
    let names = names(node);
    let sources = Sources::new(node).unwrap();
    let mut reports = node.subscribe(&topics::DIAGNOSTICS).unwrap();
    let (mut heard, _) = next_report(&mut reports, &names).await;
    while heard.values().any(|count| *count == 0) {
        sources.round(node.clock().now().0);
        (heard, _) = next_report(&mut reports, &names).await;
    }
    let heard = at_rest(&mut reports, &names, heard).await;
    let mut pace = interval(PACE);
    for _ in 0..KNOWN {
        pace.tick().await;
        sources.round(node.clock().now().0);
    }
    let sent: Counts = heard.into_iter().map(|(name, count)| (name, count + KNOWN)).collect();
    at_rest(&mut reports, &names, Counts::new()).await;
    println!("{COUNTS}{}", serde_json::to_string(&sent).unwrap());
}

/// Sends on and on, and tells each report with the number of the recorder's life.
async fn stream(node: &mut Node) {
    let names = names(node);
    let sources = Sources::new(node).unwrap();
    let mut reports = node.subscribe(&topics::DIAGNOSTICS).unwrap();
    let mut pace = interval(PACE);
    let (mut life, mut newest) = (0, None);
    loop {
        tokio::select! {
            _ = pace.tick() => sources.round(node.clock().now().0),
            (mut counts, recorder) = next_report(&mut reports, &names) => {
                life += u64::from(newest.replace(recorder) != Some(recorder));
                counts.insert(LIFE_KEY.to_owned(), life);
                println!("{COUNTS}{}", serde_json::to_string(&counts).unwrap());
            }
        }
    }
}
