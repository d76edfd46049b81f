//! Speaks for nodes that cannot speak any more: a node that was killed or hangs is an error on `/diagnostics`.

use crate::clock::{Clock, monotonic};
use crate::diagnostics::{Level, pair, status};
use crate::error::RuntimeError;
use crate::node::Node;
use crate::publisher::Publisher;
use crate::subscription::Subscription;
use crate::topics;
use fdm_loop_msgs::{DiagnosticArray, Header, Heartbeat};
use models::units::Seconds;
use std::collections::BTreeMap;
use std::time::Duration;
use tokio::time::{MissedTickBehavior, interval};

/// Silence after which a node counts as gone `[s]`: six beats of 10 Hz, so that it is told within 1 s.
const SILENT_S: f64 = 0.6;
/// Time between two looks.
const LOOK: Duration = Duration::from_millis(100);
/// Looks between two words about a node that is gone: 1 Hz.
const LOOKS_PER_WORD: u32 = 10;
/// A node that was gone for so long is forgotten `[s]`: its place may be empty for good.
const FORGOTTEN_S: f64 = 60.0;
/// Nodes that are watched at most: names come from the network.
const MOST: usize = 64;

/// Who was heard when.
#[derive(Debug, Default)]
struct Hearts(BTreeMap<String, Heart>);

#[derive(Debug)]
struct Heart {
    heard: Seconds,
    /// Looks since its silence was told last; `None` while it beats.
    told: Option<u32>,
}

impl Hearts {
    fn beat(&mut self, now: Seconds, node: &str) {
        let full = self.0.len() >= MOST;
        match self.0.get_mut(node) {
            Some(heart) => *heart = Heart { heard: now, told: None },
            None if full => {}
            None => _ = self.0.insert(node.to_owned(), Heart { heard: now, told: None }),
        }
    }

    /// Of whom it is to be told how long they have been silent.
    fn look(&mut self, now: Seconds) -> Vec<(String, Seconds)> {
        self.0.retain(|_, heart| (now - heart.heard).0 < FORGOTTEN_S);
        let mut silent = Vec::new();
        for (node, heart) in &mut self.0 {
            let age = now - heart.heard;
            if age.0 <= SILENT_S {
                continue;
            }
            let looks = heart.told.map_or(LOOKS_PER_WORD, |looks| looks + 1);
            let due = looks >= LOOKS_PER_WORD;
            heart.told = Some(if due { 0 } else { looks });
            if due {
                silent.push((node.clone(), age));
            }
        }
        silent
    }
}

impl Node {
    /// Tells on `/diagnostics` which nodes of this namespace have gone, of `nodes`, or of all where none is named. Works
    /// beside the shell.
    ///
    /// # Errors
    /// As [`Node::subscribe`].
    pub fn witness(&mut self, nodes: &[&str]) -> Result<(), RuntimeError> {
        // One is enough, however often the shell is configured.
        if self.is_witness() {
            return Ok(());
        }
        let beats = self.listen(&topics::HEARTBEAT)?;
        let words = self.publish_on(&topics::DIAGNOSTICS)?;
        let named = nodes.iter().map(|node| self.resolve(node)).collect();
        let (clock, own) = (self.clock(), self.name());
        self.spawn(watch(beats, words, Subject { named, own, clock }));
        Ok(())
    }
}

struct Subject {
    named: Vec<String>,
    own: String,
    clock: Clock,
}

async fn watch(mut beats: Subscription<Heartbeat>, words: Publisher<DiagnosticArray>, subject: Subject) {
    let mut hearts = Hearts::default();
    let mut looks = interval(LOOK);
    looks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    loop {
        tokio::select! {
            beat = beats.recv() => {
                let node = &beat.message.node;
                let meant = subject.named.is_empty() || subject.named.contains(node);
                if meant && *node != subject.own {
                    hearts.beat(monotonic(), node);
                }
            }
            _ = looks.tick() => {
                // What came in while this process had no time is heard first.
                while let Some(beat) = beats.try_recv() {
                    if hearts.0.contains_key(&beat.message.node) {
                        hearts.beat(monotonic(), &beat.message.node);
                    }
                }
                let silent = hearts.look(monotonic());
                if !silent.is_empty() {
                    words.send(word(silent, &subject));
                }
            }
        }
    }
}

/// What is told of those who are silent, under their own names.
fn word(silent: Vec<(String, Seconds)>, subject: &Subject) -> DiagnosticArray {
    let one = |(node, age): (String, Seconds)| {
        let message = format!("not heard for {:.1} s: the process has ended or hangs", age.0);
        status(node, Level::Error, message, vec![pair("witness".to_owned(), &subject.own)])
    };
    DiagnosticArray {
        header: Header::at(subject.clock.now().0),
        status: silent.into_iter().map(one).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_that_falls_silent_is_told_within_a_second_and_then_each_second() {
        let mut hearts = Hearts::default();
        hearts.beat(Seconds(10.0), "/printer/thermistor");
        let told: Vec<u32> = (0..40)
            .filter(|tenths| !hearts.look(Seconds(10.0 + 0.1 * f64::from(*tenths))).is_empty())
            .collect();
        assert_eq!(told, [7, 17, 27, 37]);
        hearts.beat(Seconds(14.0), "/printer/thermistor");
        assert!(hearts.look(Seconds(14.5)).is_empty());
        assert!(hearts.look(Seconds(80.0)).is_empty() && hearts.0.is_empty(), "gone for good");
    }
}
