//! The last seconds of all messages in memory, bounded in time and in size.

use crate::params::Snapshot;
use std::collections::VecDeque;

/// Messages in the order of their log times.
#[derive(Debug)]
pub struct Ring<T> {
    limits: Snapshot,
    items: VecDeque<Item<T>>,
    bytes: usize,
}

#[derive(Debug)]
struct Item<T> {
    log_ns: u64,
    bytes: usize,
    message: T,
}

impl<T> Ring<T> {
    /// Nothing yet.
    #[must_use]
    pub fn new(limits: Snapshot) -> Self {
        Self { limits, items: VecDeque::new(), bytes: 0 }
    }

    /// Takes a message of `bytes` in; what is too old, or too much, goes.
    pub fn push(&mut self, log_ns: u64, bytes: usize, message: T) {
        self.items.push_back(Item { log_ns, bytes, message });
        self.bytes = self.bytes.saturating_add(bytes);
        while self.items.front().is_some_and(|oldest| {
            log_ns.saturating_sub(oldest.log_ns) > self.limits.span_ns || self.bytes > self.limits.bytes
        }) {
            self.bytes -= self.items.pop_front().map_or(0, |oldest| oldest.bytes);
        }
    }

    /// Hands everything out, oldest first.
    pub fn take(&mut self) -> impl Iterator<Item = T> + use<T> {
        self.bytes = 0;
        std::mem::take(&mut self.items).into_iter().map(|item| item.message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_seconds_stay_within_their_memory() {
        let mut ring = Ring::new(Snapshot { span_ns: 10, bytes: 100 });
        for at in 0..20 {
            ring.push(at, 1, at);
        }
        // 9 to 19: a span of 10.
        assert_eq!(ring.take().collect::<Vec<_>>(), (9..20).collect::<Vec<_>>());
        assert_eq!(ring.take().count(), 0);
        for at in 20..25 {
            ring.push(at, 40, at);
        }
        assert_eq!(ring.take().collect::<Vec<_>>(), [23, 24]);
        ring.push(30, 101, 30);
        assert_eq!(ring.take().count(), 0, "one that is larger than all memory for it");
    }
}
