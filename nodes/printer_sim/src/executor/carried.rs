//! What the moves in the buffer of a serial host carry: the trims that were in force when they were sent.
//!
//! Nothing reaches what was sent. So such a host cuts a long move into pieces and sends each as late as the buffer allows: a
//! wall of 40 mm at 30 mm/s, sent whole behind another one, would carry a trim that is two seconds old.

use models::command::Trims;
use std::collections::VecDeque;

/// Trims of the pieces that are sent, each with the time along the plan from which it counts `[s]`.
#[derive(Debug, Clone, Default)]
pub(super) struct Carried {
    pieces: VecDeque<(f64, Trims)>,
    /// Up to where pieces are sent `[s]`.
    sent_s: f64,
}

impl Carried {
    /// At `plan_s` of the plan, of which the moves up to `known_s` are known: sends all that begins within `buffer_s`, in
    /// pieces of at most `piece_s`.
    pub(super) fn send(
        &mut self,
        (plan_s, known_s): (f64, f64),
        (buffer_s, piece_s): (f64, f64),
        trims: &Trims,
    ) {
        self.sent_s = self.sent_s.max(plan_s);
        while self.sent_s < known_s.min(plan_s + buffer_s) {
            self.pieces.push_back((self.sent_s, *trims));
            self.sent_s = (self.sent_s + piece_s).min(known_s);
        }
    }

    /// What the piece at `plan_s` carries; `None` before the first one.
    pub(super) fn at(&mut self, plan_s: f64) -> Option<Trims> {
        while self.pieces.get(1).is_some_and(|(from_s, _)| *from_s <= plan_s) {
            self.pieces.pop_front();
        }
        self.pieces.front().map(|(_, trims)| *trims)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_flow(flow: f64) -> Trims {
        Trims { flow, ..Trims::NEUTRAL }
    }

    /// A buffer of 0.3 s in pieces of 0.05 s: a trim acts 0.3 to 0.35 s after it came.
    #[test]
    fn a_piece_carries_what_was_in_force_when_it_was_sent() {
        let mut carried = Carried::default();
        assert_eq!(carried.at(0.0), None);
        for step in 0..2000 {
            let plan_s = 1e-3 * f64::from(step);
            let flow = if plan_s < 1.0 { 1.0 } else { 1.1 };
            carried.send((plan_s, 10.0), (0.3, 0.05), &of_flow(flow));
            let acts = carried.at(plan_s).unwrap().flow > 1.05;
            assert!((1.299..=1.351).contains(&plan_s) || acts == (plan_s > 1.3), "{plan_s}");
            assert!(carried.pieces.len() <= 8, "{}", carried.pieces.len());
        }
    }

    /// Nothing is sent behind a halt; what follows it carries what is in force by then.
    #[test]
    fn what_comes_after_a_halt_carries_the_trims_of_its_end() {
        let mut carried = Carried::default();
        carried.send((0.0, 0.12), (0.3, 0.05), &of_flow(1.0));
        assert!((carried.at(0.119).unwrap().flow - 1.0).abs() < 1e-12);
        carried.send((0.12, 0.4), (0.3, 0.05), &of_flow(1.2));
        assert!((carried.at(0.12).unwrap().flow - 1.2).abs() < 1e-12);
    }
}
