//! The test line printed with the non-linear lag of a drive, and the compensation that prints it best (model book 2.4).

use super::drive::{Condition, Drive, Polymer};
use super::line::TestLine;
use super::width::{Tally, WidthErrors};
use crate::command::AdvanceLaw;
use crate::extruder::{Pressure, StaticLaw};
use crate::units::Seconds;

/// A test line on a printer with one drive, polymer and condition.
#[derive(Debug, Clone, Copy)]
pub struct VirtualLine {
    law: StaticLaw,
    /// Filament per way `[-]`.
    per_way: f64,
    line: TestLine,
    start_s: f64,
    step_s: f64,
}

/// The best compensation and what it reaches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Best {
    /// `K_A` with the least RMS width error `[s]`.
    pub advance_s: f64,
    /// Width errors with it.
    pub errors: WidthErrors,
}

/// Half widths of the parabola's three points about its centre, round by round, relative.
const ROUNDS: [f64; 3] = [0.1, 0.03, 0.01];

impl VirtualLine {
    /// A line, printed in steps of `step`.
    #[must_use]
    pub fn new(drive: &Drive, polymer: &Polymer, at: &Condition, line: &TestLine, step: Seconds) -> Self {
        Self::of_law(drive.law(polymer, at), drive.outlet_m_s(at, 1.0), line, step)
    }

    /// A line on any printer whose static law is known; `per_way` is the filament per way of the line `[-]`.
    #[must_use]
    pub fn of_law(law: StaticLaw, per_way: f64, line: &TestLine, step: Seconds) -> Self {
        let (low_m_s, high_m_s) = (per_way * line.low_m_s, per_way * line.high_m_s);
        let start_s = (law.compression_m(high_m_s) - law.compression_m(low_m_s)) / (high_m_s - low_m_s);
        Self { law, per_way, line: *line, start_s, step_s: step.0 }
    }

    /// Filament per way `[-]`.
    #[must_use]
    pub fn per_way(&self) -> f64 {
        self.per_way
    }

    /// Width errors with a compensation `K_A` `[s]`; the line starts steady at its low speed.
    ///
    /// `v_in = v0 + K_A dv0/dt`, `dx/dt = v_in - u(x)`; the error is `u/v0 - 1`. `None` where the compensation is not
    /// finite.
    #[must_use]
    pub fn errors(&self, advance_s: f64) -> Option<WidthErrors> {
        if !advance_s.is_finite() {
            return None;
        }
        let mut tally = Tally::default();
        self.print(advance_s, |_, wanted_m_s, laid_m_s, dt| {
            tally.add(laid_m_s / wanted_m_s - 1.0, wanted_m_s * dt.0 / self.per_way);
        });
        tally.errors()
    }

    /// The same with a law of the advance over the feed: `v_in = v0 + d(K_A(v0) v0)/dt`.
    #[must_use]
    pub fn errors_by_law(&self, law: &AdvanceLaw) -> Option<WidthErrors> {
        let mut tally = Tally::default();
        self.print_holding(
            |feed_m_s| law.held_m(feed_m_s),
            |_, wanted_m_s, laid_m_s, dt| {
                tally.add(laid_m_s / wanted_m_s - 1.0, wanted_m_s * dt.0 / self.per_way);
            },
        );
        tally.errors()
    }

    /// Prints the line: for each step its middle, wanted and laid outlet speed `[m/s]`, and its length.
    pub fn print(&self, advance_s: f64, step: impl FnMut(Seconds, f64, f64, Seconds)) {
        self.print_holding(|feed_m_s| advance_s * feed_m_s, step);
    }

    /// Prints it with an advance that holds so much filament compressed at a feed `[m/s]` `[m]`.
    fn print_holding(&self, held_m: impl Fn(f64) -> f64, mut step: impl FnMut(Seconds, f64, f64, Seconds)) {
        let knots = self.line.knots_m_s();
        let mut pressure = Pressure::steady(&self.law, self.per_way * knots[0]);
        let mut start_s = 0.0;
        for (part, end_s) in self.line.ends_s().into_iter().enumerate() {
            let whole_s = end_s - start_s;
            // Whole steps in each part: the jumps of the feed lie between two steps, never in one.
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of steps")]
            let steps = (whole_s / self.step_s).ceil().max(1.0) as u32;
            let dt = Seconds(whole_s / f64::from(steps));
            let slope = self.per_way * (knots[part + 1] - knots[part]) / whole_s;
            for index in 0..steps {
                let middle_s = (f64::from(index) + 0.5) * dt.0;
                let wanted_m_s = self.per_way * knots[part] + slope * middle_s;
                let half_m_s = 0.5 * slope * dt.0;
                let pushed_m = held_m(wanted_m_s + half_m_s) - held_m(wanted_m_s - half_m_s);
                let laid_m = pressure.step(&self.law, wanted_m_s + pushed_m / dt.0, dt);
                step(Seconds(start_s + middle_s), wanted_m_s, laid_m / dt.0, dt);
            }
            start_s = end_s;
        }
    }

    /// The compensation with the least RMS error: the vertex of a parabola through the mean squares at three points,
    /// round by round closer, from the secant on. The mean square is one valley in `K_A`, almost a parabola.
    #[must_use]
    pub fn best(&self) -> Option<Best> {
        let mut centre_s = self.start_s;
        for reach in ROUNDS {
            let half_s = reach * centre_s;
            let square = |advance_s: f64| self.errors(advance_s).map(|errors| errors.rms * errors.rms);
            let (low, middle, high) =
                (square(centre_s - half_s)?, square(centre_s)?, square(centre_s + half_s)?);
            let bend = low - 2.0 * middle + high;
            if bend > 0.0 {
                centre_s += (0.5 * half_s * (low - high) / bend).clamp(-2.0 * half_s, 2.0 * half_s);
            }
        }
        self.errors(centre_s).map(|errors| Best { advance_s: centre_s, errors })
    }
}
