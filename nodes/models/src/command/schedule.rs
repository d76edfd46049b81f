//! Trims attached to a coming move: what is known ahead is planned, not chased.

use super::{Refusal, Refusals};
use crate::units::Seconds;

/// Least flow index of a melt `[-]`.
const LEAST_INDEX: f64 = 0.05;

/// Trims of one coming move; a host that streams the file, or plans it, executes them with the move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionTrim {
    /// The move, as the printer counts them from the start of the print.
    pub sequence: u64,
    /// Filament per path length relative to the slicer's `[-]` that the advance was planned for; what is fed is the permit's.
    pub flow: f64,
    /// Path speed that the move is planned at, relative to the slicer's `[-]`: above one counts as one. The permit's speed
    /// acts about it.
    pub speed: f64,
    /// Pressure advance over the move's speed.
    pub advance: AdvanceLaw,
    /// Filament that is held compressed already without an advance that pushed it `[m]`, 0 or more: a nozzle that narrows takes
    /// it from the roads. The advance is less by it at every feed, and after the move too: at rest it is drawn back.
    pub carried_m: f64,
}

/// Pressure advance over the feed `u`: `K_A(u) = K_lin + a u^(n-1)`, so that `x = K_A u` is held compressed.
///
/// One `K_A` holds at one speed only: the compressed length of a shear-thinning melt is no multiple of the flow (model
/// book 1.2). A law with `a = 0` is a constant `K_A`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdvanceLaw {
    /// Linear part K_lin `[s]`, 0 or more.
    pub linear_s: f64,
    /// Scale a of the melt's part `[m (s/m)^n]`, 0 or more.
    pub shear: f64,
    /// Flow index n `[-]`, in `(0, 1]`.
    pub index: f64,
}

impl AdvanceLaw {
    /// One `K_A` `[s]` at every feed.
    #[must_use]
    pub const fn constant(advance_s: f64) -> Self {
        Self { linear_s: advance_s, shear: 0.0, index: 1.0 }
    }

    /// Filament held compressed at a feed `[m/s]` `[m]`; none at rest.
    #[must_use]
    pub fn held_m(&self, feed_m_s: f64) -> f64 {
        if feed_m_s > 0.0 { self.linear_s * feed_m_s + self.shear * feed_m_s.powf(self.index) } else { 0.0 }
    }

    /// `K_A` at a feed `[m/s]` `[s]`; 0 at rest.
    #[must_use]
    pub fn advance_s(&self, feed_m_s: f64) -> f64 {
        if feed_m_s > 0.0 { self.held_m(feed_m_s) / feed_m_s } else { 0.0 }
    }

    /// Lag of what is held at a feed `[m/s]` above 0, the slope of the law `[s]`.
    #[must_use]
    pub fn lag_s(&self, feed_m_s: f64) -> f64 {
        self.linear_s + self.shear * self.index * feed_m_s.powf(self.index - 1.0)
    }

    /// The same law with both parts times `factor` `[-]`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self { linear_s: self.linear_s * factor, shear: self.shear * factor, ..*self }
    }

    /// The same law at `at_m_s` `[m/s]`, its index greater by `offset` `[-]`, at most 1.
    #[must_use]
    pub fn bent(&self, offset: f64, at_m_s: f64) -> Self {
        let index = (self.index + offset).clamp(LEAST_INDEX, 1.0);
        Self { shear: self.shear * at_m_s.powf(self.index - index), index, ..*self }
    }

    /// Whether all of it is finite and physical.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let size = |value: f64| value.is_finite() && value >= 0.0;
        size(self.linear_s) && size(self.shear) && self.index > 0.0 && self.index <= 1.0
    }
}

impl MotionTrim {
    /// Whether all of it is finite and physical.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let carried = self.carried_m.is_finite() && self.carried_m >= 0.0;
        positive(self.flow) && positive(self.speed) && self.advance.is_valid() && carried
    }
}

/// A trim of a coming move as it is sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scheduled {
    /// Random id of the publisher's run, of its commands or permits too.
    pub session: u64,
    /// Counts up within a session.
    pub sequence: u64,
    /// How long after receipt the move must have begun.
    pub validity: Seconds,
    /// Move and trim.
    pub trim: MotionTrim,
}

/// Accepts the scheduled trims of the publisher whose command or permit is in force, in order: the silence that ends
/// its commands ends its schedule.
#[derive(Debug, Clone)]
pub struct ScheduleGate {
    validity_max: Seconds,
    /// Session and sequence of the newest one.
    newest: Option<(u64, u64)>,
    refusals: Refusals,
}

impl ScheduleGate {
    /// A gate that accepts validities up to `validity_max`.
    #[must_use]
    pub fn new(validity_max: Seconds) -> Self {
        Self { validity_max, newest: None, refusals: Refusals::default() }
    }

    /// Takes a scheduled trim, or refuses and counts it; `bound` is the session whose command is in force.
    ///
    /// # Errors
    /// The [`Refusal`]; [`Refusal::NotFinite`] too where a value is not physical.
    pub fn offer(&mut self, bound: Option<u64>, scheduled: &Scheduled) -> Result<(), Refusal> {
        if let Some(refusal) = self.objection(bound, scheduled) {
            self.refusals.count(refusal);
            return Err(refusal);
        }
        self.newest = Some((scheduled.session, scheduled.sequence));
        Ok(())
    }

    /// What was refused so far.
    #[must_use]
    pub fn refusals(&self) -> Refusals {
        self.refusals
    }

    fn objection(&self, bound: Option<u64>, scheduled: &Scheduled) -> Option<Refusal> {
        let validity_s = scheduled.validity.0;
        if !(validity_s.is_finite() && scheduled.trim.is_valid()) {
            return Some(Refusal::NotFinite);
        }
        if !(validity_s > 0.0 && validity_s <= self.validity_max.0) {
            return Some(Refusal::Validity);
        }
        if bound != Some(scheduled.session) {
            return Some(Refusal::OtherSession);
        }
        let (session, sequence) = self.newest?;
        (session == scheduled.session && scheduled.sequence <= sequence).then_some(Refusal::Sequence)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scheduled(session: u64, sequence: u64) -> Scheduled {
        let advance = AdvanceLaw { linear_s: 0.4, shear: 1e-3, index: 0.4 };
        let trim = MotionTrim { sequence: 9, flow: 1.0, speed: 1.0, advance, carried_m: 0.0 };
        Scheduled { session, sequence, validity: Seconds(5.0), trim }
    }

    #[test]
    fn a_schedule_counts_beside_commands_of_its_own_session_and_in_order() {
        let mut gate = ScheduleGate::new(Seconds(5.0));
        let nan = MotionTrim { flow: f64::NAN, ..scheduled(1, 1).trim };
        for (bound, offered, wanted) in [
            (None, scheduled(1, 1), Err(Refusal::OtherSession)),
            (Some(1), scheduled(1, 2), Ok(())),
            (Some(1), scheduled(1, 2), Err(Refusal::Sequence)),
            (Some(1), scheduled(2, 3), Err(Refusal::OtherSession)),
            (Some(1), Scheduled { validity: Seconds(5.1), ..scheduled(1, 3) }, Err(Refusal::Validity)),
            (Some(1), Scheduled { validity: Seconds(0.0), ..scheduled(1, 3) }, Err(Refusal::Validity)),
            (Some(1), Scheduled { validity: Seconds(f64::NAN), ..scheduled(1, 3) }, Err(Refusal::NotFinite)),
            (Some(1), Scheduled { trim: nan, ..scheduled(1, 3) }, Err(Refusal::NotFinite)),
            (Some(2), scheduled(2, 1), Ok(())),
        ] {
            assert_eq!(gate.offer(bound, &offered), wanted, "{offered:?} beside {bound:?}");
        }
        let refusals = Refusals { not_finite: 2, validity: 2, sequence: 1, other_session: 2 };
        assert_eq!(gate.refusals(), refusals);
    }

    #[test]
    fn a_scaled_law_holds_as_much_less_at_every_feed() {
        let law = scheduled(1, 1).trim.advance;
        for feed_m_s in [1e-4, 2e-3, 1e-2] {
            let ratio = law.scaled(0.5).advance_s(feed_m_s) / law.advance_s(feed_m_s);
            assert!((ratio - 0.5).abs() < 1e-12, "{ratio}");
            let rise_m = law.held_m(1.001 * feed_m_s) - law.held_m(0.999 * feed_m_s);
            assert!((rise_m / (2e-3 * feed_m_s) / law.lag_s(feed_m_s) - 1.0).abs() < 1e-6);
        }
        assert!(law.advance_s(0.0).abs() < f64::EPSILON);
    }

    #[test]
    fn a_bent_law_is_the_same_at_one_feed_and_steeper_beyond() {
        let law = scheduled(1, 1).trim.advance;
        let bent = law.bent(0.1, 2e-3);
        assert!(
            (bent.index - 0.5).abs() < 1e-15 && (bent.held_m(2e-3) / law.held_m(2e-3) - 1.0).abs() < 1e-12
        );
        assert!(bent.held_m(1e-3) < law.held_m(1e-3) && bent.held_m(4e-3) > law.held_m(4e-3));
        for (offset, index) in [(-1.0, LEAST_INDEX), (1.0, 1.0)] {
            let ended = law.bent(offset, 2e-3);
            assert!((ended.index - index).abs() < 1e-15 && ended.is_valid());
        }
    }

    #[test]
    fn a_law_without_a_melts_part_is_one_k_a_and_rest_holds_nothing() {
        let law = AdvanceLaw { linear_s: 0.6, shear: 0.0, index: 0.4 };
        assert!(
            (law.held_m(2e-3) - 1.2e-3).abs() < 1e-15 && law.held_m(0.0) == 0.0 && law.held_m(-1.0) == 0.0
        );
    }

    #[test]
    fn what_is_not_physical_is_no_trim() {
        let law = AdvanceLaw { linear_s: 0.4, shear: 1e-3, index: 0.4 };
        let trim = MotionTrim { sequence: 1, flow: 1.0, speed: 1.0, advance: law, carried_m: 1e-3 };
        assert!(trim.is_valid());
        for broken in [f64::NAN, -1.0, f64::INFINITY] {
            assert!(!MotionTrim { flow: broken, ..trim }.is_valid());
            assert!(!MotionTrim { speed: broken, ..trim }.is_valid());
            assert!(!MotionTrim { advance: AdvanceLaw { linear_s: broken, ..law }, ..trim }.is_valid());
            assert!(!MotionTrim { advance: AdvanceLaw { shear: broken, ..law }, ..trim }.is_valid());
            assert!(!MotionTrim { advance: AdvanceLaw { index: broken, ..law }, ..trim }.is_valid());
            assert!(!MotionTrim { carried_m: broken, ..trim }.is_valid());
        }
    }
}
