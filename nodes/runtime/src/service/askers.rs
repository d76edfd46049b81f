//! Which answers go at once, and which wait until their reader is matched.

use std::collections::VecDeque;
use std::time::Duration;
use tokio::time::Instant;

/// Longest wait with an answer for the asker's reader: the answer to one that never comes would be lost anyway, and one
/// whose reader cannot be told (a bridge asks for others) gets it then. The ROS middlewares wait as well, up to 0.1 s.
const HELD: Duration = Duration::from_millis(500);
/// Answers that wait at most; who floods a node with requests from nowhere fills no memory.
const MOST_HELD: usize = 64;
/// Askers that are remembered at most.
const MOST_HEARD: usize = 64;

/// Answers that wait, and participants that need no wait. An asker is named by its participant.
#[derive(Debug)]
pub(super) struct Askers<A> {
    held: Vec<Held<A>>,
    /// Who was found to hear answers, or waited in vain to be found: a match can go untold, and nobody waits twice.
    heard: VecDeque<u64>,
}

/// An answer that waits for its reader.
#[derive(Debug)]
struct Held<A> {
    asker: u64,
    answer: A,
    until: Instant,
}

impl<A> Default for Askers<A> {
    fn default() -> Self {
        Self { held: Vec::new(), heard: VecDeque::new() }
    }
}

impl<A> Askers<A> {
    /// Takes an answer; gives it back where it is to be sent at once. The look for a match is not free: it is made for new
    /// askers only.
    pub(super) fn take(
        &mut self,
        asker: u64,
        answer: A,
        now: Instant,
        matched: impl Fn(u64) -> bool,
    ) -> Option<A> {
        if self.held.len() >= MOST_HELD || self.hears(asker, matched) {
            return Some(answer);
        }
        self.held.push(Held { asker, answer, until: now + HELD });
        None
    }

    /// Answers that may go, of which the reader is matched by now or the wait over.
    pub(super) fn due(&mut self, now: Instant, matched: impl Fn(u64) -> bool) -> Vec<A> {
        let (due, wait): (Vec<_>, Vec<_>) = std::mem::take(&mut self.held)
            .into_iter()
            .partition(|held| held.until <= now || self.hears(held.asker, &matched));
        self.held = wait;
        due.into_iter()
            .map(|held| {
                self.remember(held.asker);
                held.answer
            })
            .collect()
    }

    /// When the first wait is over.
    pub(super) fn next(&self) -> Option<Instant> {
        self.held.iter().map(|held| held.until).min()
    }

    fn hears(&mut self, asker: u64, matched: impl Fn(u64) -> bool) -> bool {
        let hears = self.heard.contains(&asker) || matched(asker);
        if hears {
            self.remember(asker);
        }
        hears
    }

    fn remember(&mut self, asker: u64) {
        if self.heard.contains(&asker) {
            return;
        }
        if self.heard.len() >= MOST_HEARD {
            self.heard.pop_front();
        }
        self.heard.push_back(asker);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn never(_: u64) -> bool {
        false
    }

    #[test]
    fn an_answer_waits_for_its_reader_alone() {
        let (mut askers, now) = (Askers::default(), Instant::now());
        assert_eq!(askers.take(1, "a", now, |_| true), Some("a"));
        assert_eq!(askers.take(2, "b", now, |asker| asker == 1), None);
        assert_eq!(askers.due(now, |asker| asker == 1), Vec::<&str>::new());
        assert_eq!(askers.next(), Some(now + HELD));
        assert_eq!(askers.due(now, |asker| asker == 2), ["b"]);
        assert_eq!((askers.next(), askers.take(2, "c", now, never)), (None, Some("c")));
    }

    /// Under load the middleware told no match of a client's reader: every one of 100 answers came 0.5 s late.
    #[test]
    fn nobody_waits_twice_for_a_match_that_nobody_tells() {
        let (mut askers, now) = (Askers::default(), Instant::now());
        assert_eq!(askers.take(1, "first", now, never), None);
        assert!(askers.due(now + HELD / 2, never).is_empty());
        assert_eq!(askers.due(now + HELD, never), ["first"]);
        assert_eq!(askers.take(1, "second", now + HELD, never), Some("second"));
    }

    #[test]
    fn requests_from_nowhere_fill_no_memory() {
        let (mut askers, now) = (Askers::default(), Instant::now());
        let held = (0..1000).filter(|asker| askers.take(*asker, (), now, never).is_none()).count();
        assert_eq!(held, MOST_HELD);
        assert_eq!(askers.due(now + HELD, never).len(), MOST_HELD);
        (1000..2000).for_each(|asker| _ = askers.take(asker, (), now, |_| true));
        assert_eq!(askers.heard.len(), MOST_HEARD);
        assert_eq!(askers.take(1999, (), now, never), Some(()), "the newest is known");
        assert_eq!(askers.take(1000, (), now, never), None, "the oldest is forgotten");
    }
}
