//! Soft and hard states of the fused confidence, model book 1.6.
//!
//! Soft after `n_soft` values in a row above the soft threshold, hard after `n_hard` in a row above the hard one.
//! Soft ends after `n_off` in a row below the soft threshold less its hysteresis. Hard is latched.

use crate::params::AttentionParams;

/// How much attention the print needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(u8)]
pub enum Level {
    /// As set.
    #[default]
    Normal = 0,
    /// Raised; corrections are held.
    Soft = 1,
    /// The job is paused.
    Hard = 2,
}

/// The state machine.
#[derive(Debug, Clone)]
pub struct Attention {
    params: AttentionParams,
    level: Level,
    above_soft: u32,
    above_hard: u32,
    calm: u32,
    newest: Option<f64>,
}

impl Attention {
    /// Starts at normal.
    #[must_use]
    pub fn new(params: AttentionParams) -> Self {
        Self { params, level: Level::Normal, above_soft: 0, above_hard: 0, calm: 0, newest: None }
    }

    /// Takes a confidence of a fault in `[0, 1]` and returns the level after it.
    pub fn on_confidence(&mut self, confidence: f64) -> Level {
        self.newest = Some(confidence);
        let count = |holds: bool, so_far: u32| if holds { so_far.saturating_add(1) } else { 0 };
        self.above_soft = count(confidence > self.params.soft, self.above_soft);
        self.above_hard = count(confidence > self.params.hard, self.above_hard);
        self.calm = count(confidence < self.params.soft - self.params.hysteresis, self.calm);
        match self.level {
            Level::Hard => {}
            _ if self.above_hard >= self.params.n_hard => self.level = Level::Hard,
            Level::Normal if self.above_soft >= self.params.n_soft => self.level = Level::Soft,
            Level::Soft if self.calm >= self.params.n_off => self.level = Level::Normal,
            Level::Normal | Level::Soft => {}
        }
        self.level
    }

    /// A hard limit was violated.
    pub fn force_hard(&mut self) {
        self.level = Level::Hard;
    }

    /// The confidence that came last.
    #[must_use]
    pub fn newest(&self) -> Option<f64> {
        self.newest
    }

    /// The level now.
    #[must_use]
    pub fn level(&self) -> Level {
        self.level
    }

    /// Starts again at normal: a person has resumed or acknowledged.
    pub fn reset(&mut self) {
        *self = Self::new(self.params);
    }
}

/// Levels after each of a list of confidences, as numbers: 0 normal, 1 soft, 2 hard.
#[must_use]
pub fn levels(params: AttentionParams, confidences: &[f64]) -> Vec<u8> {
    let mut attention = Attention::new(params);
    confidences.iter().map(|confidence| attention.on_confidence(*confidence) as u8).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn params() -> AttentionParams {
        AttentionParams { soft: 0.5, hard: 0.8, hysteresis: 0.1, n_soft: 2, n_hard: 3, n_off: 5 }
    }

    #[test]
    fn golden_sequences() {
        for (confidences, expected) in [
            (vec![0.1, 0.6, 0.6, 0.6, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3], vec![0, 0, 1, 1, 1, 1, 1, 1, 0, 0]),
            (vec![0.45, 0.55, 0.45, 0.55, 0.45, 0.55], vec![0; 6]),
            (vec![0.9, 0.9, 0.9, 0.1, 0.1], vec![0, 1, 2, 2, 2]),
            // What stands on a threshold is not above it, and what stands on the end of the hysteresis not below.
            (vec![0.5; 4], vec![0; 4]),
            (vec![0.8; 4], vec![0, 1, 1, 1]),
            (vec![0.6, 0.6, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4], vec![0, 1, 1, 1, 1, 1, 1, 1]),
            (
                vec![0.6, 0.6, 0.85, 0.85, 0.6, 0.45, 0.42, 0.41, 0.3, 0.3, 0.3, 0.3, 0.3],
                vec![0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0],
            ),
        ] {
            assert_eq!(levels(params(), &confidences), expected, "{confidences:?}");
        }
    }

    #[test]
    fn the_newest_confidence_is_told_until_a_person_has_looked() {
        let mut attention = Attention::new(params());
        assert_eq!(attention.newest(), None);
        for confidence in [0.9, 0.2] {
            attention.on_confidence(confidence);
            assert_eq!(attention.newest(), Some(confidence));
        }
        attention.reset();
        assert_eq!(attention.newest(), None);
    }

    #[test]
    fn a_value_that_is_not_a_number_breaks_every_row() {
        assert_eq!(levels(params(), &[0.9, 0.9, f64::NAN, 0.9]), [0, 1, 1, 1]);
    }
}
