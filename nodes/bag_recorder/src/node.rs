//! The shell: listens to every topic, hands the bytes to the writer, reports.

mod intake;
mod passed;
mod report;
mod services;

use crate::convert;
use crate::error::RecorderError;
use crate::folder::Folder;
use crate::params::{LIVE, Params};
use crate::tally::Tally;
use crate::writer::{Item, Recorded, Recorder, Settings, Wish};
use fdm_loop_msgs::{PrintEvent, PrintInfo};
use intake::Intake;
use passed::Passed;
use report::Report;
use runtime::{Node, RawSubscription, RuntimeError, Subscription, topics};
use services::Services;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tokio::task::JoinSet;
use tokio::time::{MissedTickBehavior, interval};

/// Real time between two looks at the simulated clock before its first reading.
const CLOCK_LOOK: Duration = Duration::from_millis(5);
/// Real time between two looks at the writer: a disk that fails is told within 1 s (T1).
const LOOK: Duration = Duration::from_millis(100);
/// Real time between two reports.
const REPORT: Duration = Duration::from_secs(1);

/// What the recorder itself listens to.
type Heard = (Subscription<PrintInfo>, Subscription<PrintEvent>);

/// Records until the end is demanded.
///
/// # Errors
/// [`RecorderError`]
pub async fn run(mut node: Node) -> Result<(), RecorderError> {
    let params: Params = node.parameters()?;
    let subscribed = subscribe(&mut node, &params);
    let (recorded, subscriptions) = subscribed.inspect_err(|error| {
        if matches!(error, RecorderError::NoTopic { .. } | RecorderError::NothingLeft) {
            node.refuse();
        }
    })?;
    // Before the wait for the clock, in which everybody is discovered: RustDDS 0.15.1 may hang where endpoints are made then.
    let services = Services::serve(&mut node, params.snapshot.span_ns > 0)?;
    let heard = (node.subscribe(&topics::PRINT_INFO)?, node.subscribe(&topics::EVENTS)?);
    node.activated().await;
    let tally = Arc::new(Tally::new(recorded.len()));
    let folder = Folder::open(&params.bag_dir, params.bag_name(), Arc::clone(&tally))?;
    wait_for_clock(&node, Duration::from_secs_f64(params.clock_wait.0)).await;
    let pictures: Vec<bool> =
        recorded.iter().map(|topic| convert::are_pictures(&topic.channel.type_name)).collect();
    let names: Vec<String> = recorded.iter().map(|topic| topic.channel.topic.clone()).collect();
    let settings = Settings {
        topics: recorded,
        tally: Arc::clone(&tally),
        note: convert::note_of_run(&node),
        queue_length: params.queue_length,
        sync_period: Duration::from_secs_f64(params.sync_period.0),
        late_max: params.late_max,
        split: params.split,
        room: params.room,
        snapshot: params.snapshot,
        compact_end: Duration::from_secs_f64(params.compact_end.0),
    };
    tally.paused.store(params.start_paused, Ordering::Relaxed);
    let recorder = Recorder::start(folder, settings).inspect_err(|error| {
        if matches!(error, RecorderError::OtherClock { .. }) {
            node.refuse();
        }
    })?;

    let taken = subscriptions.into_iter().enumerate().map(|(topic, subscription)| {
        let (queue, tally, work) = (recorder.queue(), Arc::clone(&tally), node.work());
        let most = if pictures[topic] { params.picture_queue } else { params.queue_length };
        (subscription, Intake { topic, queue, most, tally, work, newest: BTreeMap::new() })
    });
    let mut readers = JoinSet::new();
    readers.spawn(intake::take_all(taken.collect(), node.shutdown_handle()));
    let report = Report { names, tally, diagnostics: node.diagnostics() };
    let outcome = watch(&mut node, (&recorder, services, heard), &report, &params).await;
    // The readers end with the demand; where the writer failed, there is none.
    node.stop();
    while readers.join_next().await.is_some() {}
    let finished = recorder.finish();
    report.log();
    if let Err(error) = &finished {
        report.failed(error);
        node.reported().await;
    }
    outcome.and(finished)
}

/// Listens to every topic that is not left out.
fn subscribe(
    node: &mut Node,
    params: &Params,
) -> Result<(Vec<Recorded>, Vec<RawSubscription>), RecorderError> {
    let known = |name: &String| {
        topics::ALL.iter().any(|topic| *name == topic.name || *name == node.resolve(topic.name))
    };
    for (parameter, names) in [("leave_out", &params.leave_out), ("topics", &params.topics)] {
        if let Some(unknown) = names.iter().find(|name| !known(name)) {
            return Err(RecorderError::NoTopic { parameter, name: unknown.clone() });
        }
    }
    let (mut recorded, mut subscriptions) = (Vec::new(), Vec::new());
    for topic in topics::ALL {
        let resolved = node.resolve(topic.name);
        let named = |names: &[String]| names.iter().any(|name| *name == topic.name || *name == resolved);
        if !named(&params.leave_out) && (params.topics.is_empty() || named(&params.topics)) {
            let subscription = node.subscribe_raw(&convert::requested(topic, params))?;
            recorded.push(convert::recorded(subscription.topic().to_owned(), topic));
            subscriptions.push(subscription);
        }
    }
    if recorded.is_empty() {
        return Err(RecorderError::NothingLeft);
    }
    Ok((recorded, subscriptions))
}

/// Waits for the first reading of simulated time, so that a recorder which joins late dates its first messages; what
/// arrives in between waits in the middleware.
async fn wait_for_clock(node: &Node, longest: Duration) {
    let clock = node.clock();
    if clock.is_simulated() {
        let mut shutdown = node.shutdown_handle();
        let mut looks = interval(CLOCK_LOOK);
        let reading = async {
            while clock.now().0 <= 0.0 {
                looks.tick().await;
            }
        };
        tokio::select! {
            () = reading => {}
            () = tokio::time::sleep(longest) => {}
            () = shutdown.wait() => {}
        }
    }
}

/// Notes what is printed and what happens, does what is asked, and reports once a second, until the end is demanded or
/// the writer fails.
async fn watch(
    node: &mut Node,
    (recorder, mut services, (mut prints, mut events)): (&Recorder, Services, Heard),
    report: &Report,
    params: &Params,
) -> Result<(), RecorderError> {
    let queue = recorder.queue();
    let mut live = node.live_parameters(&LIVE);
    let mut keep_severity = params.room.keep_severity;
    let mut ticks = interval(REPORT);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let mut passed = Passed::new(node);
    let mut looks = interval(LOOK);
    looks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let hand_over = |item| {
        if !queue.offer(item) {
            report.diagnostics.count("notes_dropped");
        }
    };
    loop {
        tokio::select! {
            print = prints.recv() => hand_over(Item::Note(convert::note_of_print(&print.message))),
            event = events.recv() => if event.message.severity >= keep_severity {
                hand_over(Item::Wish(Wish::Keep));
            },
            changed = live.next() => {
                let params: Params = changed.parse().map_err(RuntimeError::from)?;
                keep_severity = params.room.keep_severity;
                hand_over(Item::Wish(Wish::SplitBy(params.split)));
            }
            asked = services.next() => services.grant(&asked, &queue, &report.tally),
            _ = ticks.tick() => {
                report.publish();
                passed.look(node);
            }
            _ = looks.tick() => if recorder.has_failed() {
                return Ok(()); // its reason comes from `finish`
            },
            () = node.shutdown() => return Ok(()),
        }
    }
}
