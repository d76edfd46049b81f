//! How the job ended, and the wait for who says why.

use super::super::fleet::Fleet;
use super::{Ended, Watch};
use models::status::JobPhase;
use runtime::Timer;

/// Time in which somebody tells why a print ended `[s]`: ten of its states.
const LAST_WORDS_S: f64 = 0.2;

impl Watch {
    /// How the job has ended, where it has, and whether that was a person's wish.
    pub(super) fn fate(&self) -> Option<Ended> {
        match self.newest_state.as_ref()?.phase {
            phase if phase == JobPhase::Done as u8 => Some(Ended::Done),
            phase if phase == JobPhase::Failed as u8 => {
                Some(if self.failure.is_wished() { Ended::Stopped } else { Ended::Failed })
            }
            _ => None,
        }
    }

    /// A person ends the graph. With `--stay` the job may have ended long before, or just now for a reason that is on its way.
    pub(super) async fn leave(&mut self, fleet: &Fleet, ticks: &mut Timer) -> Ended {
        match self.fate() {
            Some(Ended::Failed) if self.failure.cause().is_none() => {
                self.last_words(Ended::Failed, fleet, ticks).await
            }
            fate => self.finish(fate.unwrap_or(Ended::Interrupted)),
        }
    }

    /// Why it ended may come after the end itself, by the supervisor or on `events`; then whether it was a person's wish.
    pub(super) async fn last_words(&mut self, ended: Ended, fleet: &Fleet, ticks: &mut Timer) -> Ended {
        let from = self.ears.node.clock().now();
        while (self.ears.node.clock().now() - from).0 < LAST_WORDS_S {
            _ = ticks.next().await;
            self.take_news(fleet);
            self.listen();
        }
        self.finish(if ended == Ended::Lost { ended } else { self.fate().unwrap_or(ended) })
    }

    pub(super) fn finish(&mut self, ended: Ended) -> Ended {
        self.bar.finish_and_clear();
        ended
    }
}
