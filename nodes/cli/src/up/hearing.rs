//! Which nodes are heard: a process that hangs lives on for its parent, but its heart stands still.

use super::fleet::Happening;
use super::recipes::NODES;
use models::units::Seconds;

/// Silence that is told `[s]`: four beats of 10 Hz, to be told within the 0.5 s of C4.
const SILENT_S: f64 = 0.42;

/// Silence after which a process is given up `[s]`: twice the longest hang after which the catalogue lets it go on.
const HUNG_S: f64 = 10.0;
/// A recorder that waits for its disk goes on where it was, and ends its file by itself.
const PATIENT: &str = "bag_recorder";

#[derive(Debug)]
struct Heart {
    name: &'static str,
    /// Run of the node that was heard last; another one tells a restart.
    session: Option<u64>,
    /// When it was heard last; `None` while no beat is expected.
    heard: Option<Seconds>,
    silent: bool,
}

/// The hearts of all nodes.
#[derive(Debug)]
pub struct Hearing(Vec<Heart>);

impl Default for Hearing {
    fn default() -> Self {
        let heart = |name| Heart { name, session: None, heard: None, silent: false };
        Self(NODES.into_iter().map(heart).collect())
    }
}

impl Hearing {
    /// A beat of a run of a node was heard at `now`; names that are none of ours are passed over.
    pub fn beat(&mut self, now: Seconds, name: &str, session: u64) -> Option<Happening> {
        let heart = self.0.iter_mut().find(|heart| heart.name == name)?;
        // What a process that has ended left on its way does not count.
        if heart.heard.is_none() && heart.session == Some(session) {
            return None;
        }
        heart.session = Some(session);
        heart.heard = Some(now);
        let again = std::mem::replace(&mut heart.silent, false);
        again.then_some(Happening::HeardAgain { name: heart.name })
    }

    /// A process has ended: nothing is expected until its next run is heard.
    pub fn forget(&mut self, name: &str) {
        for heart in self.0.iter_mut().filter(|heart| heart.name == name) {
            heart.heard = None;
            heart.silent = false;
        }
    }

    /// Whose heart stands still since the last look.
    pub fn look(&mut self, now: Seconds) -> Vec<Happening> {
        let mut fallen = Vec::new();
        for heart in &mut self.0 {
            if !heart.silent && heart.heard.is_some_and(|heard| (now - heard).0 > SILENT_S) {
                heart.silent = true;
                fallen.push(Happening::Silent { name: heart.name });
            }
        }
        fallen
    }

    /// Who has hung for so long that it is to be ended and started again. Where nobody is heard it is not they.
    #[must_use]
    pub fn hung(&self, now: Seconds) -> Vec<&'static str> {
        let silent_s = |heart: &Heart| heart.heard.map(|heard| (now - heard).0);
        let hears = self.0.iter().any(|heart| silent_s(heart).is_some_and(|silent_s| silent_s <= SILENT_S));
        let hung = self.0.iter().filter(|heart| {
            hears && heart.name != PATIENT && silent_s(heart).is_some_and(|silent_s| silent_s > HUNG_S)
        });
        hung.map(|heart| heart.name).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hanging_process_is_told_once_and_told_again_when_it_beats() {
        let mut hearing = Hearing::default();
        assert_eq!(hearing.look(Seconds(9.0)), [], "never heard, never missed");
        hearing.beat(Seconds(10.0), "thermistor", 1);
        assert_eq!(hearing.look(Seconds(10.42)), []);
        assert_eq!(hearing.look(Seconds(10.43)), [Happening::Silent { name: "thermistor" }]);
        assert_eq!(hearing.look(Seconds(11.0)), []);
        let again = hearing.beat(Seconds(11.0), "thermistor", 1);
        assert_eq!(again, Some(Happening::HeardAgain { name: "thermistor" }));
    }

    #[test]
    fn a_process_that_hangs_for_long_is_given_up_unless_nobody_is_heard() {
        let mut hearing = Hearing::default();
        for name in ["safety_supervisor", "bag_recorder", "thermistor"] {
            hearing.beat(Seconds(10.0), name, 1);
        }
        assert_eq!(hearing.hung(Seconds(30.0)), [""; 0], "it is the listener who is deaf");
        hearing.beat(Seconds(20.1), "thermistor", 1);
        assert_eq!(hearing.hung(Seconds(19.9)), [""; 0]);
        assert_eq!(hearing.hung(Seconds(20.2)), ["safety_supervisor"]);
        hearing.forget("safety_supervisor");
        assert_eq!(hearing.hung(Seconds(20.3)), [""; 0]);
    }

    #[test]
    fn a_process_that_ended_is_not_missed_until_its_next_run_was_heard() {
        let mut hearing = Hearing::default();
        hearing.beat(Seconds(10.0), "thermistor", 1);
        hearing.forget("thermistor");
        hearing.beat(Seconds(10.1), "thermistor", 1);
        assert_eq!(hearing.look(Seconds(20.0)), []);
        hearing.beat(Seconds(21.0), "thermistor", 2);
        assert_eq!(hearing.look(Seconds(22.0)), [Happening::Silent { name: "thermistor" }]);
    }
}
