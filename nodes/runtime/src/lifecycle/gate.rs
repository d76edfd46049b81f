//! What lets the messages of a managed node through only while it is active.

use crate::clock::monotonic;
use models::units::Seconds;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// The gate; clones are one. A look costs a load of an atomic.
#[derive(Debug, Clone)]
pub(crate) struct Gate(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    open: AtomicBool,
    /// Monotonic time of the opening `[s]` as bits; 0 where nobody had to wait for it.
    opened: AtomicU64,
}

impl Gate {
    /// One that is always open: of what is not managed.
    pub(crate) fn open_always() -> Self {
        Self(Arc::new(Inner { open: AtomicBool::new(true), opened: AtomicU64::new(0) }))
    }

    /// One that is closed until it is opened.
    pub(crate) fn closed() -> Self {
        let gate = Self::open_always();
        gate.close();
        gate
    }

    /// Opens it; `waited`: what came before now does not count any more.
    pub(crate) fn open(&self, waited: bool) {
        let since = if waited { monotonic().0 } else { 0.0 };
        self.0.opened.store(since.to_bits(), Ordering::Relaxed);
        self.0.open.store(true, Ordering::Release);
    }

    /// Closes it.
    pub(crate) fn close(&self) {
        self.0.open.store(false, Ordering::Release);
    }

    /// Whether messages pass.
    pub(crate) fn is_open(&self) -> bool {
        self.0.open.load(Ordering::Relaxed)
    }

    /// Whether somebody waited for the opening: what came in meanwhile is old.
    pub(crate) fn was_waited_for(&self) -> bool {
        self.0.opened.load(Ordering::Relaxed) != 0
    }

    /// Whether what arrived `age` ago counts: not where it waited for the opening.
    pub(crate) fn takes(&self, age: Seconds) -> bool {
        self.open_for().is_none_or(|open| age <= open)
    }

    /// Time since the opening, where somebody waited for it.
    pub(crate) fn open_for(&self) -> Option<Seconds> {
        let opened = f64::from_bits(self.0.opened.load(Ordering::Relaxed));
        (opened > 0.0).then(|| monotonic() - Seconds(opened))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_waited_for_the_opening_does_not_count() {
        let gate = Gate::closed();
        assert!(!gate.is_open());
        gate.open(true);
        assert!(gate.is_open() && gate.was_waited_for());
        assert!(!gate.takes(Seconds(1.0)) && gate.takes(Seconds(0.0)));
        assert!(gate.open_for().is_some_and(|open| open < Seconds(1.0)));
        gate.close();
        gate.open(false);
        assert!(gate.takes(Seconds(1.0)) && !gate.was_waited_for() && gate.open_for().is_none());
    }
}
