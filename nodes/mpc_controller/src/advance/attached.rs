//! With which trim the move under way was sent. What is believed by now it may not have: a long move began before.

use models::command::MotionTrim;
use models::status::PrinterStatus;
use std::collections::VecDeque;

/// Trims of coming moves that are kept: a host looks less far ahead.
const KEPT: usize = 4096;

/// How a move was sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sent {
    /// Its line of the file.
    pub(crate) line: u64,
    /// Fastest feed of its road `[m/s]`, > 0: that for which its law is the melt's.
    pub(crate) cruise_m_s: f64,
    pub(crate) trim: MotionTrim,
}

/// Coming moves in turn, and the one under way.
#[derive(Debug, Clone, Default)]
pub(super) struct Attached {
    coming: VecDeque<Sent>,
    under_way: Option<Sent>,
}

impl Attached {
    /// A move behind all that were before; one of an earlier line begins another print.
    pub(super) fn push(&mut self, sent: Sent) {
        if self.coming.back().is_some_and(|last| sent.line < last.line) {
            self.coming.clear();
        }
        if self.coming.len() == KEPT {
            self.coming.pop_front();
        }
        self.coming.push_back(sent);
    }

    /// Follows the lines: the newest of those that the printer has reached. Where nothing is laid the last trim stands.
    pub(super) fn on_status(&mut self, status: &PrinterStatus) {
        if !status.depositing {
            return;
        }
        while let Some(sent) = self.coming.front().filter(|sent| sent.line <= status.line) {
            self.under_way = Some(*sent);
            self.coming.pop_front();
        }
    }

    /// The move under way; `None` before the first trim.
    pub(super) fn under_way(&self) -> Option<Sent> {
        self.under_way
    }
}

impl Sent {
    /// Filament that the drive holds compressed at a feed `[m/s]` `[m]`.
    pub(super) fn held_m(&self, feed_m_s: f64) -> f64 {
        self.trim.advance.held_m(feed_m_s) - self.trim.carried_m
    }
}

#[cfg(test)]
mod tests {
    use super::super::learning::tests::sent;
    use super::super::tests::status;
    use super::*;
    use models::command::AdvanceLaw;

    fn at(attached: &mut Attached, line: u64, depositing: bool) -> Option<u64> {
        attached.on_status(&PrinterStatus { line, depositing, ..status(1.0, 2e-3) });
        attached.under_way().map(|sent| sent.line)
    }

    /// Between two moves a printer reads on, comments and all: the move under way is the newest that it has reached.
    #[test]
    fn the_move_under_way_is_the_newest_that_is_reached() {
        let mut attached = Attached::default();
        for line in [25, 49, 50, 50, 60] {
            attached.push(sent(line, AdvanceLaw::constant(0.5), 0.0));
        }
        for (line, depositing, expected) in [
            (24, true, None),
            (38, true, Some(25)),
            (49, false, Some(25)),
            (49, true, Some(49)),
            (59, true, Some(50)),
        ] {
            assert_eq!(at(&mut attached, line, depositing), expected, "{line} {depositing}");
        }
        attached.push(sent(3, AdvanceLaw::constant(0.5), 0.0));
        assert_eq!(at(&mut attached, 4, true), Some(3), "another print: none of the one before is left");
        assert!(attached.coming.is_empty());
    }

    #[test]
    fn a_host_that_never_moves_fills_no_memory() {
        let mut attached = Attached::default();
        (0..10_000).for_each(|line| attached.push(sent(line, AdvanceLaw::constant(0.5), 0.0)));
        assert_eq!(attached.coming.len(), KEPT);
        assert_eq!(at(&mut attached, 9_999, true), Some(9_999), "the newest are kept");
    }

    /// What is carried is drawn back at rest.
    #[test]
    fn what_the_drive_holds_is_the_laws_less_what_is_carried() {
        let sent = sent(1, AdvanceLaw::constant(0.5), 2e-4);
        assert!((sent.held_m(2e-3) - 8e-4).abs() < 1e-15 && (sent.held_m(0.0) + 2e-4).abs() < 1e-15);
    }
}
