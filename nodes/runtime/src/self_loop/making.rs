//! How long the middleware has been making an endpoint.
//!
//! RustDDS 0.15.1 may never end it, where many participants are discovered meanwhile: its discovery holds the database as a
//! reader and waits for room in the event loop's queue; the event loop wants to read the database, and waits behind whoever
//! makes an endpoint, who waits to write into it. The node is mute from its start on, and obeys no signal.

use crate::clock::monotonic;
use models::units::Seconds;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Most that one pass of the watchdog counts: a pass that comes late was not scheduled `[s]`.
const MOST_PER_PASS_S: f64 = 0.3;
/// Time after which an endpoint will not be made any more; it takes a millisecond, and tens of them beside a crowd `[s]`.
const LIMIT_S: f64 = 2.0;

/// When the endpoint that is being made was begun; clones share it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Making(Arc<AtomicU64>);

impl Making {
    /// An endpoint is being made as long as what is returned is kept.
    pub(crate) fn begin(&self) -> Begun<'_> {
        self.0.store(monotonic().0.to_bits(), Ordering::Relaxed);
        Begun(self)
    }
}

/// An endpoint that is being made.
#[derive(Debug)]
pub(crate) struct Begun<'a>(&'a Making);

impl Drop for Begun<'_> {
    fn drop(&mut self) {
        self.0.0.store(0, Ordering::Relaxed);
    }
}

/// The watchdog's look at it: adds up the time that one endpoint takes, as far as the watchdog ran.
#[derive(Debug)]
pub(super) struct Patience {
    making: Making,
    seen: u64,
    last_pass: Seconds,
    waited_s: f64,
}

impl Patience {
    pub(super) fn new(making: Making, now: Seconds) -> Self {
        Self { making, seen: 0, last_pass: now, waited_s: 0.0 }
    }

    /// One pass of the watchdog; true where the endpoint has taken too long.
    pub(super) fn pass(&mut self, now: Seconds) -> bool {
        let begun = self.making.0.load(Ordering::Relaxed);
        let gap_s = (now - self.last_pass).0.min(MOST_PER_PASS_S);
        self.last_pass = now;
        self.waited_s = if begun != 0 && begun == self.seen { self.waited_s + gap_s } else { 0.0 };
        self.seen = begun;
        self.waited_s > LIMIT_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Passes every 0.25 s from `from` on until patience is at its end, for a minute at most.
    fn ends_after(patience: &mut Patience, from: f64) -> Option<f64> {
        (1..240).map(|i| from + 0.25 * f64::from(i)).find(|now| patience.pass(Seconds(*now)))
    }

    #[test]
    fn an_endpoint_that_is_never_made_ends_the_process_and_one_that_was_made_does_not() {
        let making = Making::default();
        let mut patience = Patience::new(making.clone(), Seconds(0.0));
        assert_eq!(ends_after(&mut patience, 0.0), None, "none is made");
        drop(making.begin());
        assert_eq!(ends_after(&mut patience, 100.0), None, "it was made");
        let _begun = making.begin();
        let ended = ends_after(&mut patience, 200.0).unwrap();
        assert!((202.2..=202.6).contains(&ended), "{ended}");
    }

    /// Many that are made one after the other take as long as they like.
    #[test]
    fn each_endpoint_has_its_own_time() {
        let making = Making::default();
        let mut patience = Patience::new(making.clone(), Seconds(0.0));
        for round in 0..40 {
            let _begun = making.begin();
            assert!(!patience.pass(Seconds(f64::from(round))));
            std::thread::sleep(std::time::Duration::from_micros(10));
        }
    }

    /// A process that was stopped for a minute in the middle of it goes on.
    #[test]
    fn a_pass_that_was_not_scheduled_counts_little() {
        let making = Making::default();
        let mut patience = Patience::new(making.clone(), Seconds(0.0));
        let _begun = making.begin();
        assert!(!patience.pass(Seconds(0.2)));
        assert!(!patience.pass(Seconds(60.0)));
    }
}
