//! With which trim the move under way was sent. What is believed by now it may not have: a long move began before.

use models::command::MotionTrim;
use models::status::PrinterStatus;
use std::collections::VecDeque;

/// Trims of coming moves that are kept: a host looks less far ahead.
const KEPT: usize = 4096;
/// Times of a plan that differ by less are one `[s]`.
const SAME_S: f64 = 1e-6;
/// A move that begins sooner than this behind the newest status is not sent anew `[s]`: a status is 20 ms old at most, and a trim
/// is some milliseconds under way.
const LEAD_S: f64 = 0.03;

/// A move that begins later than that counts as beginning then `[s]`: by then a dip has passed by itself.
const LONGEST_S: f64 = 10.0;

/// How a move was sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sent {
    /// When it begins on the slicer's own plan `[s]`.
    pub(crate) start_s: f64,
    /// The slicer's fastest feed of its road `[m/s]`, > 0.
    pub(crate) sliced_m_s: f64,
    /// Fastest feed of its road `[m/s]`, > 0: that for which its law is the melt's.
    pub(crate) cruise_m_s: f64,
    pub(crate) trim: MotionTrim,
    /// Force over that of a sound nozzle that the melt's part of its law was sent for `[-]`.
    pub(crate) force: f64,
}

/// What the drive holds for a nozzle that has narrowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Driven {
    /// Force over that of a sound nozzle that the law in force is of `[-]`.
    pub(crate) force: f64,
    /// Filament that is taken off it `[m]`.
    pub(crate) carried_m: f64,
}

impl Driven {
    /// As for a sound nozzle.
    pub(crate) const SOUND: Self = Self { force: 1.0, carried_m: 0.0 };

    /// Filament that the drive holds beyond the law of a sound nozzle where the melt's part of that holds `melt_m` `[m]`.
    pub(crate) fn beyond_m(&self, melt_m: f64) -> f64 {
        (self.force - 1.0) * melt_m - self.carried_m
    }
}

/// Coming moves in turn, and the one under way.
#[derive(Debug, Clone, Default)]
pub(crate) struct Attached {
    coming: VecDeque<Sent>,
    under_way: Option<Sent>,
}

impl Attached {
    /// A move behind all that were before; one that begins earlier is another print's.
    pub(crate) fn push(&mut self, sent: Sent) {
        if self.coming.back().is_some_and(|last| sent.start_s < last.start_s) {
            self.coming.clear();
        }
        if self.coming.len() == KEPT {
            self.coming.pop_front();
        }
        self.coming.push_back(sent);
    }

    /// Follows the plan: the newest of the moves that the printer has reached. Where nothing is laid the last trim stands.
    pub(super) fn on_status(&mut self, status: &PrinterStatus) {
        if !status.depositing {
            return;
        }
        let reached = |sent: &&Sent| sent.start_s <= status.path_time_s + SAME_S;
        while let Some(sent) = self.coming.front().filter(reached) {
            self.under_way = Some(*sent);
            self.coming.pop_front();
        }
    }

    /// Moves at whose begin a trim that is sent anew is there.
    pub(crate) fn open(&mut self, status: &PrinterStatus) -> impl Iterator<Item = &mut Sent> {
        let from_s = status.path_time_s + LEAD_S;
        self.coming.iter_mut().filter(move |sent| sent.start_s > from_s)
    }

    /// How long until the first of those begins, where trims are sent `anew`, or else the last that is known `[s]`; 0 where none is.
    pub(crate) fn acts_in_s(&self, status: &PrinterStatus, anew: bool) -> f64 {
        let mut open = self.coming.iter().filter(|sent| sent.start_s > status.path_time_s + LEAD_S);
        let next = if anew { open.next() } else { open.next_back() };
        let in_s = next.map_or(0.0, |sent| (sent.start_s - status.path_time_s) / status.trims.speed);
        if in_s.is_finite() { in_s.clamp(0.0, LONGEST_S) } else { 0.0 }
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

    /// What is held with it for a nozzle that has narrowed.
    pub(super) fn driven(&self) -> Driven {
        Driven { force: self.force, carried_m: self.trim.carried_m }
    }
}

#[cfg(test)]
mod tests {
    use super::super::learning::tests::sent;
    use super::super::tests::status;
    use super::*;
    use models::command::{AdvanceLaw, Trims};

    fn at(attached: &mut Attached, path_time_s: f64, depositing: bool) -> Option<f64> {
        attached.on_status(&PrinterStatus { path_time_s, depositing, ..status(1.0, 2e-3) });
        attached.under_way().map(|sent| sent.start_s)
    }

    fn with(starts_s: impl IntoIterator<Item = u32>) -> Attached {
        let mut attached = Attached::default();
        starts_s.into_iter().for_each(|start_s| attached.push(sent(start_s, AdvanceLaw::constant(0.5), 0.0)));
        attached
    }

    /// Its line may be far behind the one that a host has read: the plan's time tells which move is under way.
    #[test]
    fn the_move_under_way_is_the_newest_that_is_reached() {
        let mut attached = with([25, 49, 50, 60]);
        for (path_time_s, depositing, expected) in [
            (24.0, true, None),
            (38.0, true, Some(25.0)),
            (49.0, false, Some(25.0)),
            (49.0 - 1e-9, true, Some(49.0)),
            (59.0, true, Some(50.0)),
        ] {
            assert_eq!(at(&mut attached, path_time_s, depositing), expected, "{path_time_s} {depositing}");
        }
        attached.push(sent(3, AdvanceLaw::constant(0.5), 0.0));
        assert_eq!(at(&mut attached, 4.0, true), Some(3.0), "another print: none of the one before is left");
        assert!(attached.coming.is_empty());
    }

    /// What begins before a trim can be there stays as it was sent. Who cannot send anew waits for what is not known yet.
    #[test]
    fn a_move_that_begins_at_once_is_not_sent_anew() {
        let mut attached = with([25, 49, 50, 60]);
        at(&mut attached, 30.0, true);
        let slow = Trims { speed: 0.5, ..Trims::NEUTRAL };
        for (path_time_s, open, next_s, last_s) in [
            (48.9, 3, 0.2, LONGEST_S),
            (48.99, 2, 2.02, LONGEST_S),
            (59.9, 1, 0.2, 0.2),
            (59.99, 0, 0.0, 0.0),
        ] {
            let status = PrinterStatus { path_time_s, trims: slow, ..status(1.0, 2e-3) };
            assert_eq!(attached.open(&status).count(), open, "{path_time_s}");
            for (anew, in_s) in [(true, next_s), (false, last_s)] {
                let told_s = attached.acts_in_s(&status, anew);
                assert!((told_s - in_s).abs() < 1e-9, "{path_time_s} {anew}: {told_s}");
            }
        }
    }

    #[test]
    fn a_host_that_never_moves_fills_no_memory() {
        let mut attached = with(0..10_000);
        assert_eq!(attached.coming.len(), KEPT);
        assert_eq!(at(&mut attached, 9_999.0, true), Some(9_999.0), "the newest are kept");
    }

    /// What is carried is drawn back at rest.
    #[test]
    fn what_the_drive_holds_is_the_laws_less_what_is_carried() {
        let sent = sent(1, AdvanceLaw::constant(0.5), 2e-4);
        assert!((sent.held_m(2e-3) - 8e-4).abs() < 1e-15 && (sent.held_m(0.0) + 2e-4).abs() < 1e-15);
        let narrow = Sent { force: 1.5, ..sent };
        assert!(
            (narrow.driven().beyond_m(1e-3) - 3e-4).abs() < 1e-15,
            "half as much again, less what is carried"
        );
    }
}
