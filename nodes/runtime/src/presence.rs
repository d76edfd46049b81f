//! Sources that are lost and found again: each change is an event on `events`.

use crate::clock::Clock;
use crate::error::RuntimeError;
use crate::node::Node;
use crate::publisher::Publisher;
use crate::topics;
use fdm_loop_msgs::{Header, PrintEvent};
use models::units::Seconds;

/// Watches one source of a node: what it takes from it, and for how long there was nothing to take.
#[derive(Debug)]
pub struct Presence {
    watch: Watch,
    clock: Clock,
    events: Publisher<PrintEvent>,
    node: String,
    source: String,
    /// What the driver said last of a loss.
    reason: Option<String>,
}

impl Presence {
    /// Something sound has come from the source.
    pub fn seen(&mut self) {
        self.reason = None;
        if let Some(Change::Found { silent }) = self.watch.seen(self.clock.now()) {
            let why = silent.map_or_else(
                || format!("{} delivers", self.source),
                |silent| format!("{} delivers again after {:.1} s", self.source, silent.0),
            );
            self.tell(PrintEvent::SEVERITY_INFO, "source_found", why);
        }
    }

    /// Something has come that has yet to prove itself: a source that was not seen before is not lost meanwhile.
    pub fn expect(&mut self) {
        self.watch.expect(self.clock.now());
    }

    /// The driver has lost the source: the reason of the event that follows when the limit has passed.
    pub fn explain(&mut self, reason: &str) {
        self.reason = Some(reason.to_owned());
    }

    /// Looks at the clock; to be called several times within the limit.
    pub fn look(&mut self) {
        if let Some(Change::Lost) = self.watch.look(self.clock.now()) {
            let why = format!("nothing sound from {} for {:.1} s", self.source, self.watch.limit.0);
            let why = self.reason.as_ref().map_or(why.clone(), |reason| format!("{why}: {reason}"));
            self.tell(PrintEvent::SEVERITY_WARN, "source_lost", why);
        }
    }

    /// Words for the diagnostics while the source is lost.
    #[must_use]
    pub fn loss(&self) -> Option<String> {
        let State::Lost { .. } = self.watch.state else { return None };
        let reason = self.reason.as_deref().unwrap_or("nothing sound comes");
        Some(format!("{} is lost: {reason}", self.source))
    }

    /// What the driver said last, unless something sound has come since.
    #[must_use]
    pub fn reason(&self) -> Option<&str> {
        self.reason.as_deref()
    }

    /// Times the source was lost.
    #[must_use]
    pub fn losses(&self) -> u64 {
        self.watch.losses
    }

    fn tell(&self, severity: u8, what: &str, why: String) {
        if severity == PrintEvent::SEVERITY_INFO {
            tracing::info!("{why}");
        } else {
            tracing::warn!("{why}");
        }
        self.events.send(PrintEvent {
            header: Header::at(self.clock.now().0),
            severity,
            who: self.node.clone(),
            what: what.to_owned(),
            why,
            ..PrintEvent::default()
        });
    }
}

impl Node {
    /// Watches `source`, which is lost when nothing sound has come from it for `limit`.
    ///
    /// # Errors
    /// As [`Node::publish_on`].
    pub fn presence(&mut self, source: &str, limit: Seconds) -> Result<Presence, RuntimeError> {
        Ok(Presence {
            watch: Watch { limit, state: State::Waiting(None), losses: 0 },
            clock: self.clock(),
            events: self.publish_on(&topics::EVENTS)?,
            node: self.name(),
            source: source.to_owned(),
            reason: None,
        })
    }
}

/// Where a source stands.
#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    /// Nothing came yet, since this look.
    Waiting(Option<Seconds>),
    /// The newest came then.
    Present(Seconds),
    /// The newest came then, or waiting began then.
    Lost { newest: Seconds },
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Change {
    /// After this silence; `None` for the first time.
    Found {
        silent: Option<Seconds>,
    },
    Lost,
}

#[derive(Debug)]
struct Watch {
    limit: Seconds,
    state: State,
    losses: u64,
}

impl Watch {
    fn seen(&mut self, now: Seconds) -> Option<Change> {
        let before = std::mem::replace(&mut self.state, State::Present(now));
        match before {
            State::Present(_) => None,
            State::Waiting(_) => Some(Change::Found { silent: None }),
            State::Lost { newest } => Some(Change::Found { silent: Some(now - newest) }),
        }
    }

    fn expect(&mut self, now: Seconds) {
        if let State::Waiting(since) = &mut self.state {
            *since = Some(now);
        }
    }

    fn look(&mut self, now: Seconds) -> Option<Change> {
        match &mut self.state {
            // A simulated clock stands at zero until its first reading.
            State::Waiting(since @ None) => {
                *since = (now.0 > 0.0).then_some(now);
                None
            }
            State::Waiting(Some(newest)) | State::Present(newest) => {
                if now < *newest {
                    *newest = now; // time was set back
                    return None;
                }
                let newest = *newest;
                if (now - newest).0 <= self.limit.0 {
                    return None;
                }
                self.state = State::Lost { newest };
                self.losses += 1;
                Some(Change::Lost)
            }
            State::Lost { .. } => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn watch() -> Watch {
        Watch { limit: Seconds(1.0), state: State::Waiting(None), losses: 0 }
    }

    #[test]
    fn a_source_is_lost_once_after_the_limit_and_found_once() {
        let mut watch = watch();
        assert_eq!(watch.seen(Seconds(5.0)), Some(Change::Found { silent: None }));
        assert_eq!(watch.seen(Seconds(5.5)), None);
        assert_eq!(watch.look(Seconds(6.5)), None, "the limit has not passed");
        assert_eq!(watch.look(Seconds(6.6)), Some(Change::Lost));
        assert_eq!(watch.look(Seconds(9.0)), None, "told once");
        assert_eq!(watch.seen(Seconds(9.5)), Some(Change::Found { silent: Some(Seconds(4.0)) }));
        assert_eq!(watch.losses, 1);
    }

    #[test]
    fn what_never_came_is_lost_too_counted_from_the_first_reading_of_the_clock() {
        let mut watch = watch();
        assert_eq!(watch.look(Seconds(0.0)), None);
        assert_eq!(watch.look(Seconds(900.0)), None, "the simulated clock was read for the first time");
        assert_eq!(watch.look(Seconds(901.1)), Some(Change::Lost));
    }

    #[test]
    fn what_has_yet_to_prove_itself_is_waited_for() {
        let mut watch = watch();
        assert_eq!(watch.look(Seconds(5.0)), None);
        watch.expect(Seconds(5.8));
        assert_eq!(watch.look(Seconds(6.7)), None);
        assert_eq!(watch.look(Seconds(6.9)), Some(Change::Lost));
        watch.expect(Seconds(7.0));
        assert_eq!(watch.look(Seconds(7.1)), None, "lost until something sound comes");
        assert_eq!(watch.losses, 1);
    }

    #[test]
    fn a_clock_that_was_set_back_loses_nothing() {
        let mut watch = watch();
        watch.seen(Seconds(100.0));
        assert_eq!(watch.look(Seconds(2.0)), None);
        assert_eq!(watch.look(Seconds(2.9)), None);
        assert_eq!(watch.look(Seconds(3.1)), Some(Change::Lost));
    }
}
