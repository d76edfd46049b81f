//! What every node does beside its work: follow `/clock`, publish `/rosout` and `/diagnostics`.

use crate::clock::{Clock, monotonic};
use crate::diagnostics::Diagnostics;
use crate::heartbeat::Work;
use crate::logging;
use crate::owner::Owner;
use crate::publisher::Publisher;
use crate::self_loop::SelfLoopAge;
use crate::subscription::Subscription;
use fdm_loop_msgs::{Clock as ClockMessage, DiagnosticArray, Log, Time};
use models::units::Seconds;
use std::time::Duration;
use tokio::sync::mpsc::Receiver;
use tokio::time::{MissedTickBehavior, interval};

/// Real time between two looks at the ages of topics, and the longest until a changed level is told.
pub(crate) const LOOK: Duration = Duration::from_millis(100);
/// Looks between two reports: 1 Hz.
const LOOKS_PER_REPORT: u32 = 10;

/// Name among the alarms of the node.
const CLOCK: &str = "clock";
/// What a person is told of a second publisher of `/clock`.
const RIVAL: &str = "a second publisher of /clock: its time is not taken; stop one of the two";

/// Silence after which the time is another one's.
const CLOCK_HANDOVER: Seconds = Seconds(1.0);

/// Sets the node's clock from `/clock`, as its owner tells it.
pub(crate) async fn follow_clock(
    clock: Clock,
    mut readings: Subscription<ClockMessage>,
    diagnostics: Diagnostics,
) {
    let (mut owner, mut told) = (Owner::handing_over_after(CLOCK_HANDOVER), false);
    loop {
        let first = readings.recv().await;
        let (mut newest, mut next) = (None, Some(first));
        while let Some(reading) = next {
            if owner.takes(reading.publisher, monotonic()) {
                newest = Some(reading);
            } else {
                diagnostics.count("clock_second_publisher");
            }
            next = readings.try_recv();
        }
        let rival = owner.has_rival(monotonic());
        if rival != std::mem::replace(&mut told, rival) {
            diagnostics.alarm(CLOCK, rival.then(|| RIVAL.to_owned()));
            if rival {
                tracing::error!("{RIVAL}");
            }
        }
        let Some(reading) = newest else { continue };
        let Some(time) = reading.message.clock.seconds() else {
            diagnostics.count("clock_refused");
            continue;
        };
        let before = clock.now();
        if clock.set(Seconds(time)) {
            diagnostics.count("clock_jumps_back");
            tracing::warn!("simulated time jumped back from {:.3} s to {time:.3} s", before.0);
        }
    }
}

/// Publishes log lines.
pub(crate) async fn publish_log(clock: Clock, mut lines: Receiver<Log>, publisher: Publisher<Log>) {
    while let Some(mut line) = lines.recv().await {
        line.stamp = Time::from_seconds(clock.stamp().0);
        publisher.send(line);
    }
}

/// What `/diagnostics` reports on.
pub(crate) struct Reporter {
    pub(crate) node: String,
    pub(crate) clock: Clock,
    pub(crate) diagnostics: Diagnostics,
    pub(crate) work: Work,
    pub(crate) self_loop: SelfLoopAge,
}

/// Publishes the registry at 1 Hz of real time, and when level, message or the lateness of a topic changes.
pub(crate) async fn publish_diagnostics(reporter: Reporter, publisher: Publisher<DiagnosticArray>) {
    let mut looks = interval(LOOK);
    looks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let mut since_report = LOOKS_PER_REPORT;
    let mut changed = false;
    loop {
        tokio::select! {
            _ = looks.tick() => since_report += 1,
            () = reporter.diagnostics.changed() => changed = true,
        }
        changed |= reporter.diagnostics.ages_changed(&reporter.clock);
        // A level that flutters is reported at the pace of the looks.
        if since_report >= LOOKS_PER_REPORT || (changed && since_report >= 1) {
            publisher.send(reporter.report());
            since_report = 0;
            changed = false;
        }
    }
}

impl Reporter {
    /// The message now.
    fn report(&self) -> DiagnosticArray {
        self.diagnostics.set("work_counter", self.work.count());
        self.diagnostics.set("middleware_lines_left_out", logging::lines_left_out());
        match self.self_loop.age() {
            Some(age) => self.diagnostics.set("self_loop_age_s", format_args!("{:.2}", age.0)),
            None => self.diagnostics.set("self_loop_age_s", "not established"),
        }
        self.diagnostics.array(&self.node, &self.clock)
    }
}
