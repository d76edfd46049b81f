//! What widths this printer and spool usually lay: a bead gain a few percent off is no defect, and hides none.
//!
//! A printer that lays 7 % too much and then loses a fifth of its melt is 14 % short of what the file wanted, and 20 %
//! short of itself. Both errors count, the larger one is told. The usual width is learned from widths that are no
//! defect by either, slowly, within a bound: a defect from the first road on stays one by what the file wanted.

use models::params::{ParamError, in_range};
use serde::Deserialize;

/// How the usual width is learned. Built only from a valid [`RawUsual`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawUsual")]
pub struct UsualParams(RawUsual);

/// The `usual` block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawUsual {
    /// Widths until the usual one counts.
    pub widths_min: u32,
    /// Share of a new width in the usual one `[-]`.
    pub rate: f64,
    /// Farthest that the usual width may lie from the wanted one, relative `[-]`.
    pub range_rel: f64,
    /// Widths farther from what is wanted or usual are not learned `[-]`.
    pub learn_max_rel: f64,
}

impl TryFrom<RawUsual> for UsualParams {
    type Error = ParamError;

    fn try_from(raw: RawUsual) -> Result<Self, ParamError> {
        in_range("usual.widths_min", f64::from(raw.widths_min), "widths", (1.0, 1e4))?;
        in_range("usual.rate", raw.rate, "-", (0.0, 1.0))?;
        in_range("usual.range_rel", raw.range_rel, "-", (0.0, 0.3))?;
        in_range("usual.learn_max_rel", raw.learn_max_rel, "-", (0.0, 0.5))?;
        Ok(Self(raw))
    }
}

/// The usual width over the wanted one, without the loop's own corrections.
#[derive(Debug, Clone)]
pub struct Usual {
    params: RawUsual,
    ratio: f64,
    widths: u32,
}

impl Usual {
    /// Nothing learned: the file's own width is the usual one.
    #[must_use]
    pub fn new(params: UsualParams) -> Self {
        Self { params: params.0, ratio: 1.0, widths: 0 }
    }

    /// The error of a width, relative `[-]`: to what the file wanted or to what is usual, whichever is larger. `ratio` is
    /// the width over the wanted one, without the loop's corrections.
    pub fn error_rel(&mut self, ratio: f64) -> f64 {
        let of_file = ratio - 1.0;
        if self.widths < self.params.widths_min {
            self.learn(ratio, of_file);
            return of_file;
        }
        let of_itself = ratio / self.ratio - 1.0;
        self.learn(ratio, of_itself);
        if of_itself.abs() > of_file.abs() { of_itself } else { of_file }
    }

    fn learn(&mut self, ratio: f64, error_rel: f64) {
        if error_rel.is_nan() || error_rel.abs() > self.params.learn_max_rel {
            return;
        }
        self.widths = self.widths.saturating_add(1);
        // The mean of the first ones, then slower and slower until `rate`.
        let share = self.params.rate.max(1.0 / f64::from(self.widths));
        let learned = self.ratio + share * (ratio - self.ratio);
        self.ratio = learned.clamp(1.0 - self.params.range_rel, 1.0 + self.params.range_rel);
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn params() -> UsualParams {
        RawUsual { widths_min: 20, rate: 0.02, range_rel: 0.1, learn_max_rel: 0.1 }.try_into().unwrap()
    }

    fn after(ratios: impl IntoIterator<Item = f64>) -> Usual {
        let mut usual = Usual::new(params());
        ratios.into_iter().for_each(|ratio| _ = usual.error_rel(ratio));
        usual
    }

    /// 1.07 * 0.8 is 0.856: 14 % short of the file, a fifth short of itself.
    #[test]
    fn a_fifth_is_a_fifth_on_a_printer_that_lays_too_much() {
        let error_rel = after([1.07; 40]).error_rel(0.856);
        assert!((error_rel + 0.2).abs() < 1e-9, "{error_rel}");
        assert!((after([]).error_rel(0.856) + 0.144).abs() < 1e-9);
    }

    #[test]
    fn a_defect_does_not_become_usual() {
        let mut usual = after([1.0; 40]);
        for _ in 0..1000 {
            assert!((usual.error_rel(0.82) + 0.18).abs() < 1e-9);
        }
        let from_the_first = after([0.8; 1000]).error_rel(0.8);
        assert!((from_the_first + 0.2).abs() < 1e-9, "{from_the_first}");
    }

    #[test]
    fn what_creeps_stays_a_defect_by_the_file() {
        let creeping = (0..4000).map(|width| 1.0 - 5e-5 * f64::from(width));
        assert!((after(creeping).error_rel(0.8) + 0.2).abs() < 1e-9);
    }

    #[test]
    fn nothing_is_learned_from_a_nan() {
        let mut usual = after([1.05; 40]);
        assert!(usual.error_rel(f64::NAN).is_nan());
        assert!(usual.error_rel(1.05).abs() < 0.051);
    }
}
