//! The shell: listens to every topic, hands the bytes to the writer, reports.

use crate::convert;
use crate::error::RecorderError;
use crate::folder::Folder;
use crate::params::Params;
use crate::tally::Tally;
use crate::writer::{Item, Queue, Recorded, Recorder, Sample, Settings};
use runtime::{Diagnostics, Gid, Level, Node, RawMessage, RawSubscription, Shutdown, Work, topics};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;
use tokio::task::JoinSet;
use tokio::time::{MissedTickBehavior, interval};

/// Real time between two looks at the simulated clock before its first reading.
const CLOCK_LOOK: Duration = Duration::from_millis(5);
/// Real time between two looks at the writer: a disk that fails is told within 1 s (T1).
const LOOK: Duration = Duration::from_millis(100);

/// Records until the end is demanded.
pub async fn run(mut node: Node) -> Result<(), RecorderError> {
    let params: Params = node.parameters()?;
    let (recorded, subscriptions) = subscribe(&mut node, &params)?;
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
    };
    let recorder = Recorder::start(folder, settings)?;

    let mut readers = JoinSet::new();
    for (topic, subscription) in subscriptions.into_iter().enumerate() {
        let (queue, tally, work) = (recorder.queue(), Arc::clone(&tally), node.work());
        let most = if pictures[topic] { params.picture_queue } else { params.queue_length };
        let intake = Intake { topic, queue, most, tally, work, newest: BTreeMap::new() };
        readers.spawn(read(subscription, intake, node.shutdown_handle()));
    }
    let report = Report { names, tally, diagnostics: node.diagnostics() };
    let outcome = watch(&mut node, &recorder, &report, params.sync_period.0).await;
    // The readers end with the demand; where the writer failed, there is none.
    node.stop();
    while readers.join_next().await.is_some() {}
    let finished = recorder.finish();
    report.log();
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
    if let Some(unknown) = params.leave_out.iter().find(|name| !known(name)) {
        return Err(RecorderError::NoTopic(unknown.clone()));
    }
    let (mut recorded, mut subscriptions) = (Vec::new(), Vec::new());
    for topic in topics::ALL {
        let resolved = node.resolve(topic.name);
        if !params.leave_out.iter().any(|name| *name == topic.name || *name == resolved) {
            let subscription = node.subscribe_raw(&convert::requested(topic, params))?;
            recorded.push(convert::recorded(subscription.topic().to_owned(), topic));
            subscriptions.push(subscription);
        }
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

/// Where the messages of one topic go.
struct Intake {
    topic: usize,
    queue: Queue,
    /// Nothing is handed over where so many wait.
    most: usize,
    tally: Arc<Tally>,
    work: Work,
    /// Newest number of each publisher.
    newest: BTreeMap<Gid, i64>,
}

impl Intake {
    /// Hands a message to the writer, or drops it where too many wait. Never waits itself.
    fn take(&mut self, message: RawMessage) {
        let counts = &self.tally.topics[self.topic];
        counts.received.add(1);
        if let Some(before) = self.newest.insert(message.publisher, message.sequence) {
            let gap = message.sequence.saturating_sub(before).saturating_sub(1);
            counts.missed.add(u64::try_from(gap).unwrap_or(0));
        }
        let sample = Sample {
            topic: self.topic,
            received: message.received,
            publish_ns: message.sent_ns.and_then(|sent| u64::try_from(sent).ok()),
            sequence: convert::sequence(message.sequence),
            payload: message.payload,
        };
        if self.queue.waiting() < self.most && self.queue.offer(Item::Message(sample)) {
            self.work.done();
        } else {
            counts.dropped.add(1);
        }
    }
}

/// Reads one topic until the end is demanded, and then what is already here.
async fn read(mut subscription: RawSubscription, mut intake: Intake, mut shutdown: Shutdown) {
    loop {
        tokio::select! {
            message = subscription.recv() => intake.take(message),
            () = shutdown.wait() => break,
        }
        // A topic that never runs dry must not keep the others waiting.
        tokio::task::consume_budget().await;
    }
    while let Some(message) = subscription.try_recv() {
        intake.take(message);
    }
}

/// Notes what is printed, and reports once a period, until the end is demanded or the writer fails.
async fn watch(
    node: &mut Node,
    recorder: &Recorder,
    report: &Report,
    period_s: f64,
) -> Result<(), RecorderError> {
    let mut prints = node.subscribe(&topics::PRINT_INFO)?;
    let queue = recorder.queue();
    let mut ticks = interval(Duration::from_secs_f64(period_s));
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let mut looks = interval(LOOK);
    looks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    loop {
        tokio::select! {
            print = prints.recv() => {
                if !queue.offer(Item::Note(convert::note_of_print(&print.message))) {
                    report.diagnostics.count("notes_dropped");
                }
            }
            _ = ticks.tick() => report.publish(),
            _ = looks.tick() => if recorder.has_failed() {
                return Ok(()); // its reason comes from `finish`
            },
            () = node.shutdown() => return Ok(()),
        }
    }
}

/// What is told of the counts.
struct Report {
    names: Vec<String>,
    tally: Arc<Tally>,
    diagnostics: Diagnostics,
}

impl Report {
    /// To `/diagnostics`.
    fn publish(&self) {
        for (name, counts) in self.names.iter().zip(&self.tally.topics) {
            if counts.received.get() > 0 {
                self.diagnostics.set(&format!("{name} written"), counts.written.get());
                self.diagnostics.set(&format!("{name} dropped"), counts.dropped.get());
            }
        }
        let tally = &self.tally;
        self.diagnostics.set("written", tally.written());
        self.diagnostics.set("dropped", tally.dropped());
        self.diagnostics.set("missed", tally.missed());
        self.diagnostics.set("log_time_raised", tally.raised.get());
        self.diagnostics.set("files_recovered", tally.recovered.get());
        self.diagnostics.set("files_unreadable", tally.unreadable.get());
        self.diagnostics.set("sync_failed", tally.sync_failed.get());
        let (level, message) = match () {
            () if tally.sync_failed.get() > 0 => (Level::Error, "the disk failed"),
            () if tally.dropped() > 0 => (Level::Warn, "messages were dropped"),
            () if tally.unreadable.get() > 0 => (Level::Warn, "an earlier file is not readable"),
            () => (Level::Ok, "recording"),
        };
        self.diagnostics.report(level, message);
    }

    /// To the log, at the end.
    fn log(&self) {
        for (name, counts) in self.names.iter().zip(&self.tally.topics) {
            let (received, written) = (counts.received.get(), counts.written.get());
            let (dropped, missed) = (counts.dropped.get(), counts.missed.get());
            if received > 0 {
                tracing::info!(
                    "{name}: {received} received, {written} written, {dropped} dropped, {missed} missed"
                );
            }
        }
        if self.tally.dropped() > 0 {
            tracing::warn!("{} messages were dropped", self.tally.dropped());
        }
    }
}
