//! Who sets the pressure advance, and how it passes from one to the next without a jump.
//!
//! A drive holds `K_A u` of filament compressed. Where `K_A` jumps, all of that is drawn back or pushed at once: a gap, or a
//! lump, as long as the flow's lag. A break in the road does not help: what was held is still there when the next one
//! begins. Along a straight line the same filament is spread over a time T, and the width is off by `K_A / T` meanwhile.
//! Nobody has to be alive for it: what a permit brought is gone at the end of the line, in any case.

use super::AdvanceLaw;
use crate::units::Seconds;

/// Who sets the pressure advance, and to what.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AdvanceOf {
    /// The file, or the firmware before it: the slicer's own `K_A` `[s]`.
    File,
    /// The permit in force: its `K_A` `[s]`.
    Permit(f64),
    /// The trims of coming moves; `None` between two of them: the law of the last one stands.
    Schedule(Option<AdvanceLaw>),
}

const FILE: usize = 0;
const PERMIT: usize = 1;
const SCHEDULE: usize = 2;

/// The advance in force: what each has set, and the share of each.
#[derive(Debug, Clone, PartialEq)]
pub struct AdvanceHandover {
    laws: [AdvanceLaw; 3],
    shares: [f64; 3],
}

impl AdvanceHandover {
    /// The file's own advance `[s]`.
    #[must_use]
    pub fn new(file_s: f64) -> Self {
        Self { laws: [AdvanceLaw::constant(file_s); 3], shares: [1.0, 0.0, 0.0] }
    }

    /// One step of `dt`: `of` sets the advance now, `file_s` is the slicer's own `[s]`, whoever sets it. A whole handover
    /// lasts `within`; where that is not positive it is over at once.
    pub fn step(&mut self, of: AdvanceOf, file_s: f64, within: Seconds, dt: Seconds) {
        self.laws[FILE] = AdvanceLaw::constant(file_s);
        let heir = match of {
            AdvanceOf::File => FILE,
            AdvanceOf::Permit(advance_s) => {
                self.laws[PERMIT] = AdvanceLaw::constant(advance_s);
                PERMIT
            }
            AdvanceOf::Schedule(law) => {
                self.laws[SCHEDULE] = law.unwrap_or(self.laws[SCHEDULE]);
                SCHEDULE
            }
        };
        let before = self.shares[heir];
        let after = if within.0 > 0.0 { (before + dt.0.max(0.0) / within.0).min(1.0) } else { 1.0 };
        let left = if after < 1.0 { (1.0 - after) / (1.0 - before) } else { 0.0 };
        self.shares = self.shares.map(|share| share * left);
        self.shares[heir] = after;
    }

    /// Whether who sets the advance now sets it alone.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        self.shares.iter().any(|share| *share >= 1.0)
    }

    /// Share of trims of coming moves in it `[-]`.
    #[must_use]
    pub fn scheduled(&self) -> f64 {
        self.shares[SCHEDULE]
    }

    /// `K_A` in force at a feed `[m/s]` `[s]`; at rest the linear parts alone.
    #[must_use]
    pub fn advance_s(&self, feed_m_s: f64) -> f64 {
        let of = |law: &AdvanceLaw| if feed_m_s > 0.0 { law.advance_s(feed_m_s) } else { law.linear_s };
        self.laws.iter().zip(self.shares).map(|(law, share)| share * of(law)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FEED_M_S: f64 = 2e-3;
    const FILE_S: f64 = 0.1;
    const AT_ONCE: Seconds = Seconds(0.0);
    const WITHIN: Seconds = Seconds(2.0);
    const STEP: Seconds = Seconds(1e-3);

    fn handed_to_a_permit() -> AdvanceHandover {
        let mut handover = AdvanceHandover::new(FILE_S);
        handover.step(AdvanceOf::Permit(0.5), FILE_S, AT_ONCE, STEP);
        handover
    }

    #[test]
    fn without_a_time_it_is_over_at_once() {
        let handover = handed_to_a_permit();
        assert!(handover.is_settled() && (handover.advance_s(FEED_M_S) - 0.5).abs() < 1e-12);
    }

    /// Back at the slicer's value after 2 s, along a straight line: 0.5 to 0.1 s.
    #[test]
    fn it_goes_along_a_straight_line() {
        let mut handover = handed_to_a_permit();
        for (after_s, wanted_s) in [(0.5, 0.4), (1.0, 0.3), (1.5, 0.2), (2.0, 0.1), (2.5, 0.1)] {
            handover.step(AdvanceOf::File, FILE_S, WITHIN, Seconds(0.5));
            let got_s = handover.advance_s(FEED_M_S);
            assert!((got_s - wanted_s).abs() < 1e-12, "{got_s} after {after_s} s");
            assert_eq!(handover.is_settled(), after_s >= 2.0);
        }
    }

    /// The permit may come back in the midst of it, and a schedule after it: a step of 1 ms moves the advance by that
    /// share of the way between two of them.
    #[test]
    fn nobody_who_comes_between_makes_it_jump() {
        let law = AdvanceLaw { linear_s: 0.3, shear: 1e-3, index: 0.4 };
        let (file, permit) = (AdvanceOf::File, AdvanceOf::Permit(0.5));
        let schedule = AdvanceOf::Schedule(Some(law));
        let mut handover = handed_to_a_permit();
        let mut before_s = handover.advance_s(FEED_M_S);
        // all three lie within 0.1..0.5 s at this feed
        assert!((0.1..0.5).contains(&law.advance_s(FEED_M_S)));
        let turns = [(file, 700), (permit, 300), (schedule, 900), (file, 100), (schedule, 5), (file, 3000)];
        for (of, steps) in turns {
            for _ in 0..steps {
                handover.step(of, FILE_S, WITHIN, STEP);
                let now_s = handover.advance_s(FEED_M_S);
                assert!((now_s - before_s).abs() <= 0.4 * 1e-3 / 2.0 + 1e-12, "{before_s} {now_s}");
                assert!((0.0..=1.0).contains(&handover.scheduled()));
                before_s = now_s;
            }
        }
        assert!((before_s - FILE_S).abs() < 1e-12 && handover.is_settled());
    }

    #[test]
    fn the_files_own_counts_as_it_is_now_and_a_schedule_keeps_its_law_between_moves() {
        let mut handover = AdvanceHandover::new(FILE_S);
        handover.step(AdvanceOf::File, 0.3, WITHIN, STEP);
        assert!((handover.advance_s(FEED_M_S) - 0.3).abs() < 1e-12);
        assert!((handover.advance_s(0.0) - 0.3).abs() < 1e-12);
        handover.step(AdvanceOf::Schedule(Some(AdvanceLaw::constant(0.6))), 0.3, AT_ONCE, STEP);
        assert!((handover.scheduled() - 1.0).abs() < 1e-15);
        handover.step(AdvanceOf::Schedule(None), 0.3, WITHIN, STEP);
        assert!((handover.advance_s(FEED_M_S) - 0.6).abs() < 1e-12);
    }
}
