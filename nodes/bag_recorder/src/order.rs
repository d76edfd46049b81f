//! Log time of each message: time of receipt on the node's clock, never falling within a file.
//!
//! Readers refuse an unindexed file whose times fall. Messages of several topics reach the recorder in nearly the order
//! of their receipt: one that is a little late gets the time of the one before it. Where time itself jumped back (the
//! simulation began anew), a new file begins; where it jumps to and fro, as with two who drive the clock, not with every
//! jump.

use models::units::Seconds;

/// Where a message goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// In order, with its own time `[ns]`.
    InOrder(u64),
    /// A little late: gets the newest time `[ns]`.
    Raised(u64),
    /// Time jumped back to this `[ns]`: first message of a new file.
    NewFile(u64),
}

/// Nanoseconds of a time on the node's clock; what is below zero, or not a number, becomes zero.
#[must_use]
pub fn nanoseconds(time: Seconds) -> u64 {
    // A float to integer cast saturates, and NaN becomes 0.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let nanos = (time.0 * 1e9).round() as u64;
    nanos
}

/// So many jumps begin a file whatever lies between them.
const FREE_JUMPS: u32 = 8;
/// Messages between two further ones.
const APART: u64 = 4096;

/// Watches the log times of a file.
#[derive(Debug, Clone, Copy)]
pub struct Order {
    newest_ns: u64,
    late_max_ns: u64,
    jumps: u32,
    /// Messages since the last jump that began a file.
    since: u64,
}

impl Order {
    /// No message yet; one that is later than `late_max` behind the newest is a jump of time.
    #[must_use]
    pub fn new(late_max: Seconds) -> Self {
        Self { newest_ns: 0, late_max_ns: nanoseconds(late_max), jumps: 0, since: 0 }
    }

    /// Places the next message.
    pub fn place(&mut self, received: Seconds) -> Place {
        let received_ns = nanoseconds(received);
        let late_ns = self.newest_ns.saturating_sub(received_ns);
        self.since += 1;
        if late_ns == 0 {
            self.newest_ns = received_ns;
            Place::InOrder(received_ns)
        } else if late_ns <= self.late_max_ns || self.jumps >= FREE_JUMPS && self.since <= APART {
            Place::Raised(self.newest_ns)
        } else {
            self.newest_ns = received_ns;
            (self.jumps, self.since) = (self.jumps.saturating_add(1), 0);
            Place::NewFile(received_ns)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_late_message_is_raised_and_a_jump_begins_a_file() {
        let mut order = Order::new(Seconds(0.5));
        assert_eq!(order.place(Seconds(2.0)), Place::InOrder(2_000_000_000));
        assert_eq!(order.place(Seconds(1.75)), Place::Raised(2_000_000_000));
        assert_eq!(order.place(Seconds(2.0)), Place::InOrder(2_000_000_000));
        assert_eq!(order.place(Seconds(0.25)), Place::NewFile(250_000_000));
        assert_eq!(order.place(Seconds(0.5)), Place::InOrder(500_000_000));
    }

    /// Two who drive the clock: with every message it jumps. The first jumps begin a file each, then thousands of messages
    /// lie between two; once it stands, a jump is one again.
    #[test]
    fn a_flood_of_jumps_is_no_flood_of_files() {
        let mut order = Order::new(Seconds(0.5));
        let is_file = |place: Place| matches!(place, Place::NewFile(_));
        let files = |order: &mut Order, count: u32| {
            (0..count).filter(|i| is_file(order.place(Seconds(if i % 2 == 0 { 100.0 } else { 1.0 })))).count()
        };
        assert_eq!(files(&mut order, 16), 8);
        assert_eq!(files(&mut order, 41_000), 10);
        assert!((0..5000).all(|_| !is_file(order.place(Seconds(200.0)))));
        assert_eq!(order.place(Seconds(3.0)), Place::NewFile(3_000_000_000));
    }

    #[test]
    fn a_time_that_is_none_does_not_move_the_order() {
        let mut order = Order::new(Seconds(f64::MAX));
        order.place(Seconds(1.0));
        assert_eq!(order.place(Seconds(f64::NAN)), Place::Raised(1_000_000_000));
        assert_eq!(order.place(Seconds(-3.0)), Place::Raised(1_000_000_000));
    }

    proptest! {
        /// Within a file log times never fall, whatever comes.
        #[test]
        fn log_times_never_fall_within_a_file(times in proptest::collection::vec(0.0..100.0_f64, 1..100)) {
            let mut order = Order::new(Seconds(10.0));
            let mut last_ns = 0;
            for time_s in times {
                match order.place(Seconds(time_s)) {
                    Place::InOrder(log_ns) | Place::Raised(log_ns) => {
                        prop_assert!(log_ns >= last_ns);
                        last_ns = log_ns;
                    }
                    Place::NewFile(log_ns) => last_ns = log_ns,
                }
            }
        }
    }
}
