//! A NaN, an out-of-range and a stale message on every subscribed topic of every node is refused, counted and shown.
//!
//! The nodes are processes and speak over DDS; the pairs of node and topic come from their own `/diagnostics`, so that
//! a new subscription without an entry in the table fails. Real time passes here: DDS has no other.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "helpers of tests: a failure is the test's failure"
)]

#[path = "refusals/fleet.rs"]
mod fleet;
#[path = "refusals/parameters.rs"]
mod parameters;
#[path = "refusals/permits.rs"]
mod permits;
#[path = "refusals/shown.rs"]
mod shown;
#[path = "refusals/strangers.rs"]
mod strangers;
#[path = "refusals/table.rs"]
mod table;

use fleet::Fleet;
use models::units::Seconds;
use runtime::{Args, Node, Reason, Subscription, Timer, topics};
use shown::Shown;
use std::time::Duration;
use table::{Entry, Kind};

/// Longest wait for a counter: reports come once a second.
const PATIENCE: Duration = Duration::from_secs(15);

#[test]
fn every_bad_message_is_refused_counted_and_shown() {
    if let Some(alone) =
        system_tests::run_in_own_domain("every_bad_message_is_refused_counted_and_shown", 0).unwrap()
    {
        assert!(alone.success(), "it failed in its own domain, see above");
        return;
    }
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    executor.block_on(async {
        let mut fleet = Fleet::start();
        let mut peer = Peer::join();
        peer.find_all_nodes().await;
        let pairs = peer.pairs();
        println!("{} pairs of node and topic", pairs.len());
        peer.sound_messages_are_taken(&pairs).await;
        peer.who_else_permits_is_told().await;
        peer.a_second_source_is_refused().await;
        for kind in Kind::BAD {
            peer.bad_messages_are_counted(kind, &pairs).await;
        }
        strangers::of_type_or_quality_harm_nothing(&mut peer).await;
        parameters::are_told_and_refused(&mut peer.node).await;
        peer.the_controllers_last_word_is_neutral(&mut fleet).await;
        fleet.end();
        drop(peer);
        permits::the_simulator_refuses_bad_permits().await;
        permits::the_simulator_believes_no_copied_session().await;
        permits::the_supervisor_degrades_beside_another_one().await;
    });
}

/// A node that publishes on every topic and reads what the others show.
struct Peer {
    node: Node,
    clock: runtime::Clock,
    entries: Vec<Entry>,
    reports: Subscription<fdm_loop_msgs::DiagnosticArray>,
    commands: Subscription<fdm_loop_msgs::ControlCommand>,
    ticks: Timer,
    shown: Shown,
}

impl Peer {
    fn join() -> Self {
        let mut node = Node::start_with("peer", Args::default()).unwrap();
        Self {
            clock: node.clock(),
            entries: table::all(&mut node),
            reports: node.subscribe(&topics::DIAGNOSTICS).unwrap(),
            commands: node.subscribe(&topics::CONTROL_COMMAND).unwrap(),
            ticks: node.timer(Seconds(0.05)),
            shown: Shown::default(),
            node,
        }
    }

    /// Takes reports in, sends `kind` on every topic every 50 ms, until `done`; false when that takes too long.
    async fn until(&mut self, kind: Option<Kind>, done: impl Fn(&Shown) -> bool) -> bool {
        let entries = std::mem::take(&mut self.entries);
        let send = |now_s: f64| {
            let Some(kind) = kind else { return };
            let able = |entry: &&Entry| kind == Kind::Sound || entry.bad.contains(&kind);
            entries.iter().filter(able).for_each(|entry| (entry.send)(kind, now_s));
        };
        let done = self.while_sending(send, done).await;
        self.entries = entries;
        done
    }

    /// Takes reports in and sends every 50 ms, until `done`; false when that takes too long.
    async fn while_sending(&mut self, mut send: impl FnMut(f64), done: impl Fn(&Shown) -> bool) -> bool {
        let limit = tokio::time::sleep(PATIENCE);
        tokio::pin!(limit);
        while !done(&self.shown) {
            tokio::select! {
                report = self.reports.recv() => self.shown.take(&report.message),
                now = self.ticks.next() => send(now.0),
                () = &mut limit => return false,
            }
        }
        true
    }

    /// Until all nodes report and each entry has a subscriber, and once more: the first report of a node may come while
    /// it still subscribes.
    async fn find_all_nodes(&mut self) {
        let topics: Vec<_> = self.entries.iter().map(|entry| entry.topic.to_owned()).collect();
        for _ in 0..2 {
            self.shown = Shown::default();
            let all = |shown: &Shown| {
                fleet::NODES.iter().all(|node| shown.knows(node)) && unheard(&topics, shown).is_empty()
            };
            let found = self.until(None, all).await;
            let (nodes, unheard) = (self.shown.nodes(), unheard(&topics, &self.shown));
            assert!(found, "of all nodes only {nodes:?} report; nobody subscribes {unheard:?} of the table");
        }
    }

    /// Every pair of node and subscribed topic, each with an entry.
    fn pairs(&self) -> Vec<(String, String)> {
        let pairs = self.shown.subscriptions();
        for (node, topic) in &pairs {
            let known = self.entries.iter().any(|entry| entry.topic == topic);
            assert!(known, "{node} subscribes {topic}: add it to the table of this test");
        }
        pairs
    }

    /// What is refused below is refused for what is wrong with it. (One in ten may be late on a loaded machine.)
    async fn sound_messages_are_taken(&mut self, pairs: &[(String, String)]) {
        let taken = |shown: &Shown| pairs.iter().all(|(node, topic)| shown.received(node, topic) >= 20);
        assert!(
            self.until(Some(Kind::Sound), taken).await,
            "not every topic arrives: {}",
            self.shown.all(pairs)
        );
        for (node, topic) in pairs {
            let received = self.shown.received(node, topic);
            for kind in Kind::BAD {
                let refused = self.shown.refused(node, topic, kind.reason());
                assert!(
                    refused * 10 <= received,
                    "{node} {topic}: {refused} of {received} {}",
                    kind.reason()
                );
            }
        }
    }

    /// C8, X2: the peer's permits among the supervisor's own are counted. (What it decides then is seen where nothing else is
    /// wrong: `permits`.)
    async fn who_else_permits_is_told(&mut self) {
        let (node, topic) = ("safety_supervisor", topics::SAFETY_COMMAND.name());
        let told = |shown: &Shown| shown.refused(node, topic, Reason::Gate.name()) >= 3;
        let pairs = [(node.to_owned(), topic.to_owned())];
        assert!(self.until(Some(Kind::Sound), told).await, "not told: {}", self.shown.all(&pairs));
    }

    /// C8: the peer's readings and estimates beside those of the nodes: whoever spoke first is believed, the other refused.
    async fn a_second_source_is_refused(&mut self) {
        let topics =
            [topics::HOTEND_TEMPERATURE.name(), topics::FILAMENT_MOTION.name(), topics::ESTIMATE.name()];
        let told = |shown: &Shown| {
            topics.iter().all(|topic| shown.refused("safety_supervisor", topic, Reason::Gate.name()) >= 3)
        };
        let pairs = topics.map(|topic| ("safety_supervisor".to_owned(), topic.to_owned()));
        assert!(self.until(Some(Kind::Sound), told).await, "not told: {}", self.shown.all(&pairs));
    }

    async fn bad_messages_are_counted(&mut self, kind: Kind, pairs: &[(String, String)]) {
        let reason = kind.reason();
        let able =
            |topic: &str| self.entries.iter().any(|entry| entry.topic == topic && entry.bad.contains(&kind));
        let pairs: Vec<_> = pairs.iter().filter(|(_, topic)| able(topic)).cloned().collect();
        let before: Vec<_> = pairs
            .iter()
            .map(|(node, topic)| {
                (self.shown.refused(node, topic, reason), self.shown.refused_in_all(node, topic))
            })
            .collect();
        let risen = |shown: &Shown, index: usize| {
            let (node, topic) = &pairs[index];
            shown.refused(node, topic, reason) >= before[index].0 + 3
                && shown.refused_in_all(node, topic) >= before[index].1 + 3
        };
        self.until(Some(kind), |shown| (0..pairs.len()).all(|index| risen(shown, index))).await;
        let missed: Vec<_> = (0..pairs.len()).filter(|index| !risen(&self.shown, *index)).collect();
        let missed: Vec<_> = missed.into_iter().map(|index| &pairs[index]).collect();
        assert!(missed.is_empty(), "{reason}: not counted by {missed:?}; {}", self.shown.all(&pairs));
    }

    /// Silent until it is asked to end, the controller then takes its corrections back.
    async fn the_controllers_last_word_is_neutral(&mut self, fleet: &mut Fleet) {
        self.commands.drain_newest();
        let quiet_from = self.clock.now();
        fleet.ask_to_end("mpc_controller");
        // Nobody else speaks there any more.
        let last = tokio::time::timeout(Duration::from_secs(2), async {
            loop {
                let message = self.commands.recv().await.message;
                if message.header.stamp.seconds().unwrap() > quiet_from.0 {
                    return message;
                }
            }
        });
        let last = last.await.expect("the controller says a last word");
        let trims = (last.flow_factor, last.speed_factor, last.nozzle_setpoint_offset_k);
        assert_eq!(trims, (1.0, 1.0, 0.0));
        assert!(!last.set_advance && !last.close_extruder_loop);
    }
}

/// The topics that no node subscribes.
fn unheard<'a>(topics: &'a [String], shown: &Shown) -> Vec<&'a String> {
    let pairs = shown.subscriptions();
    topics.iter().filter(|topic| !pairs.iter().any(|(_, subscribed)| subscribed == *topic)).collect()
}
