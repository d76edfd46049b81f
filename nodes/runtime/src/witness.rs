//! Speaks for nodes that cannot speak any more: a node that was killed or hangs is an error on `/diagnostics`, and so is, once,
//! one whose process was replaced before its silence could be told.

use crate::clock::{Clock, monotonic};
use crate::diagnostics::{Level, pair, status};
use crate::error::RuntimeError;
use crate::node::Node;
use crate::publisher::Publisher;
use crate::subscription::Subscription;
use crate::topics::{self, Topic};
use fdm_loop_msgs::{DiagnosticArray, Header, Heartbeat};
use models::units::Seconds;
use std::collections::BTreeMap;
use std::time::Duration;
use tokio::time::{MissedTickBehavior, interval};

/// Key of a status that another node tells in somebody's name: its value is who tells it.
pub const WITNESS: &str = "witness";
/// Silence after which a node counts as gone `[s]`: six beats of 10 Hz, so that it is told within 1 s.
const SILENT_S: f64 = 0.6;
/// Time between two looks, and how late a beat may be heard.
const LOOK: Duration = Duration::from_millis(100);
/// A look that is later than this comes of a process that had no time itself `[s]`.
const OWN_SLEEP_S: f64 = 0.3;
/// Looks between two words about a node that is gone: 1 Hz.
const LOOKS_PER_WORD: u32 = 10;
/// A node that was gone for so long is forgotten `[s]`: its place may be empty for good.
const FORGOTTEN_S: f64 = 60.0;
/// Nodes that are watched at most: names come from the network.
const MOST: usize = 64;
/// Beats that one look hears at most: of all of those nodes, and then some that were late.
const MOST_BEATS: usize = 200;

/// Who was heard when.
#[derive(Debug, Default)]
struct Hearts(BTreeMap<String, Heart>);

#[derive(Debug)]
struct Heart {
    heard: Seconds,
    session: u64,
    /// Another process has spoken in its name since the last look.
    replaced: bool,
    /// Looks since it was told of last.
    rest: u32,
}

/// What is to be told of a node.
#[derive(Debug, PartialEq)]
enum Told {
    /// Nothing was heard of it for so long.
    Silent(Seconds),
    /// Another process speaks in its name.
    Replaced,
}

impl Hearts {
    fn beat(&mut self, now: Seconds, node: &str, session: u64) {
        let full = self.0.len() >= MOST;
        match self.0.get_mut(node) {
            Some(heart) => {
                // One that was told to be gone is back; nothing new in that.
                let known_gone = heart.rest < LOOKS_PER_WORD && (now - heart.heard).0 > SILENT_S;
                let replaced = heart.replaced || (heart.session != session && !known_gone);
                *heart = Heart { heard: now, session, replaced, ..*heart };
            }
            None if full => {}
            None => {
                let heart = Heart { heard: now, session, replaced: false, rest: LOOKS_PER_WORD };
                self.0.insert(node.to_owned(), heart);
            }
        }
    }

    /// This process itself had no time for `slept`: nobody's silence counts for so long.
    fn slept(&mut self, slept: Seconds) {
        for heart in self.0.values_mut() {
            heart.heard = heart.heard + slept;
        }
    }

    /// Of whom something is to be told: of each at most at 1 Hz.
    fn look(&mut self, now: Seconds) -> Vec<(String, Told)> {
        self.0.retain(|_, heart| (now - heart.heard).0 < FORGOTTEN_S);
        let mut told = Vec::new();
        for (node, heart) in &mut self.0 {
            let age = now - heart.heard;
            heart.rest = heart.rest.saturating_add(1).min(LOOKS_PER_WORD);
            let what = if age.0 > SILENT_S {
                Told::Silent(age)
            } else if heart.replaced {
                Told::Replaced
            } else {
                continue;
            };
            if heart.rest >= LOOKS_PER_WORD {
                (heart.rest, heart.replaced) = (0, false);
                told.push((node.clone(), what));
            }
        }
        told
    }
}

impl Node {
    /// Tells on `/diagnostics` which nodes of this namespace have gone, and beats for its own witness. Works beside the shell.
    ///
    /// # Errors
    /// As [`Node::subscribe`].
    pub fn witness_all(&mut self) -> Result<(), RuntimeError> {
        // Once is enough, however often the shell is configured.
        if self.is_witness() {
            return Ok(());
        }
        self.beat_on(&topics::SAFETY_HEARTBEAT)?;
        self.witness(&topics::HEARTBEAT)
    }

    /// Tells on `/diagnostics` when the supervisor has gone, which witnesses all others. Works beside the shell.
    ///
    /// # Errors
    /// As [`Node::subscribe`].
    pub fn witness_supervisor(&mut self) -> Result<(), RuntimeError> {
        if self.is_witness() {
            return Ok(());
        }
        self.witness(&topics::SAFETY_HEARTBEAT)
    }

    fn witness(&mut self, topic: &Topic<Heartbeat>) -> Result<(), RuntimeError> {
        let beats = self.listen(topic)?;
        let words = self.publish_on(&topics::DIAGNOSTICS)?;
        let (clock, own) = (self.clock(), self.name());
        self.spawn(watch(beats, words, Subject { own, clock }));
        Ok(())
    }
}

struct Subject {
    own: String,
    clock: Clock,
}

async fn watch(mut beats: Subscription<Heartbeat>, words: Publisher<DiagnosticArray>, subject: Subject) {
    let mut hearts = Hearts::default();
    let mut looks = interval(LOOK);
    looks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let mut looked = monotonic();
    loop {
        looks.tick().await;
        let late = monotonic() - looked;
        if late.0 > OWN_SLEEP_S {
            hearts.slept(late);
        }
        looked = monotonic();
        // Not one by one: a dozen nodes beat a hundred times a second. What came while this process had no time is heard
        // first, too.
        for beat in std::iter::from_fn(|| beats.try_recv()).take(MOST_BEATS) {
            let Heartbeat { node, session_id, .. } = &beat.message;
            if *node != subject.own {
                hearts.beat(monotonic(), node, *session_id);
            }
        }
        let told = hearts.look(monotonic());
        if !told.is_empty() {
            words.send(word(told, &subject));
        }
    }
}

/// What is told of them, under their own names.
fn word(told: Vec<(String, Told)>, subject: &Subject) -> DiagnosticArray {
    let one = |(node, told): (String, Told)| {
        let message = match told {
            Told::Silent(age) => format!("not heard for {:.1} s: the process has ended or hangs", age.0),
            Told::Replaced => {
                "another process speaks in its name: it ended and was started again, or two run".into()
            }
        };
        status(node, Level::Error, message, vec![pair(WITNESS.to_owned(), &subject.own)])
    };
    DiagnosticArray {
        header: Header::at(subject.clock.stamp().0),
        status: told.into_iter().map(one).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODE: &str = "/printer/thermistor";

    /// When something was told in so many looks from 10 s on `[0.1 s]`, and whether it was silence.
    fn told(
        hearts: &mut Hearts,
        looks: u32,
        mut each: impl FnMut(&mut Hearts, u32, Seconds),
    ) -> Vec<(u32, bool)> {
        let mut told = Vec::new();
        for tenths in 0..looks {
            let now = Seconds(10.0 + 0.1 * f64::from(tenths));
            each(hearts, tenths, now);
            told.extend(hearts.look(now).into_iter().map(|(_, what)| (tenths, what != Told::Replaced)));
        }
        told
    }

    #[test]
    fn a_node_that_falls_silent_is_told_within_a_second_and_then_each_second() {
        let mut hearts = Hearts::default();
        hearts.beat(Seconds(10.0), NODE, 1);
        let silent = told(&mut hearts, 40, |_, _, _| {});
        assert_eq!(silent, [(7, true), (17, true), (27, true), (37, true)]);
        // The gap was told: who comes back is no news, whatever its process.
        hearts.beat(Seconds(14.0), NODE, 2);
        assert!(hearts.look(Seconds(14.5)).is_empty());
        assert!(hearts.look(Seconds(80.0)).is_empty() && hearts.0.is_empty(), "gone for good");
    }

    #[test]
    fn a_node_that_was_started_again_at_once_is_told_once_and_two_of_one_name_each_second() {
        let mut hearts = Hearts::default();
        let again =
            told(&mut hearts, 60, |hearts, tenths, now| hearts.beat(now, NODE, u64::from(tenths >= 23)));
        assert_eq!(again, [(23, false)]);
        let mut hearts = Hearts::default();
        let two = told(&mut hearts, 30, |hearts, tenths, now| hearts.beat(now, NODE, u64::from(tenths % 2)));
        assert_eq!(two, [(1, false), (11, false), (21, false)]);
    }

    /// Who was stopped for 6 s has heard nobody; who hangs meanwhile is told as late as if the silence had begun then.
    #[test]
    fn a_witness_that_had_no_time_itself_accuses_nobody() {
        let mut hearts = Hearts::default();
        hearts.beat(Seconds(10.0), NODE, 1);
        hearts.slept(Seconds(6.0));
        assert!(hearts.look(Seconds(16.1)).is_empty());
        assert_eq!(hearts.look(Seconds(16.7)).len(), 1);
    }
}
