//! Intervals of the encoder: each tells a speed, and several in a row whether the slip has stepped.
//!
//! A count is known to a quantum. Of a speed over one interval that is an eighth where roads are slow; but one interval ends at the
//! count with which the next one begins, so over several of them the way is known as well as over one. A step of the
//! slip is looked for in the way of the newest ones together (a generalised likelihood ratio, Willsky and Jones 1976).

use crate::history::Ring;
use crate::measurement::Observation;
use crate::params::RawEncoder;

/// Intervals that are remembered, `stretch_most` at most.
const REMEMBERED: usize = 20;

/// Those before a longer time without one are judged by a belief of long ago, and forgotten `[s]`.
const GAP_S: f64 = 2.0;

/// What motor and encoder did between two counts of the encoder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Interval {
    pub(crate) from_s: f64,
    pub(crate) to_s: f64,
    /// Filament that passed the encoder `[m]`.
    pub(crate) passed_m: f64,
    /// Way of the motor's strokes forth and back `[m]`, both 0 or more: only the former slip.
    pub(crate) forth_m: f64,
    pub(crate) back_m: f64,
    /// What is not known of the motor's position at both ends `[m]`.
    pub(crate) off_m: (f64, f64),
    /// Slowest and fastest speed of the motor `[m/s]`: the encoder's stamps may lie beside the motor's.
    pub(crate) speeds_m_s: (f64, f64),
}

/// Several intervals as one.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stretch {
    whole: Interval,
    span_s: f64,
    /// Pieces without a gap.
    pieces: f64,
}

impl Interval {
    pub(crate) fn observation(self, encoder: &RawEncoder) -> Observation {
        Stretch::of(self).observation(encoder)
    }
}

impl Stretch {
    fn of(interval: Interval) -> Self {
        Self { whole: interval, span_s: interval.to_s - interval.from_s, pieces: 1.0 }
    }

    /// With what was before it.
    fn behind(self, before: &Interval) -> Self {
        let whole = self.whole;
        let gap = before.to_s < whole.from_s;
        let inner_m = if gap { before.off_m.1 + whole.off_m.0 } else { 0.0 };
        let whole = Interval {
            from_s: before.from_s,
            passed_m: whole.passed_m + before.passed_m,
            forth_m: whole.forth_m + before.forth_m,
            back_m: whole.back_m + before.back_m,
            off_m: (before.off_m.0 + inner_m, whole.off_m.1),
            speeds_m_s: (
                whole.speeds_m_s.0.min(before.speeds_m_s.0),
                whole.speeds_m_s.1.max(before.speeds_m_s.1),
            ),
            ..whole
        };
        let span_s = self.span_s + before.to_s - before.from_s;
        Self { whole, span_s, pieces: self.pieces + if gap { 1.0 } else { 0.0 } }
    }

    /// Deviation of the way that passed `[m]`: two quantisation errors of each piece, uniform over one quantum.
    fn deviation_m(&self, encoder: &RawEncoder) -> f64 {
        let Interval { forth_m, off_m, speeds_m_s, .. } = self.whole;
        let quanta_m = encoder.quantum_m * (self.pieces / 6.0).sqrt();
        let timing_m = off_m.0 + off_m.1 + self.pieces * encoder.skew_s * (speeds_m_s.1 - speeds_m_s.0);
        quanta_m.hypot(timing_m).hypot(encoder.relative * forth_m)
    }

    fn observation(&self, encoder: &RawEncoder) -> Observation {
        let Interval { passed_m, forth_m, back_m, .. } = self.whole;
        let speeds = [passed_m, forth_m, back_m].map(|way_m| way_m / self.span_s);
        Observation::encoder(speeds, (self.deviation_m(encoder) / self.span_s).powi(2))
    }

    /// How far the way that passed is from that of a slip, in its deviation where the slip has a variance.
    fn misfit(&self, encoder: &RawEncoder, slip: Slip) -> f64 {
        let Interval { passed_m, forth_m, back_m, .. } = self.whole;
        let off_m = passed_m - ((1.0 - slip.mean) * forth_m - back_m);
        off_m.abs() / self.deviation_m(encoder).hypot(slip.variance.sqrt() * forth_m)
    }
}

/// What is believed of the slip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Slip {
    pub(crate) mean: f64,
    pub(crate) variance: f64,
}

/// The newest intervals since the last step, each with what was believed before it.
#[derive(Debug)]
pub(crate) struct Intervals(Ring<(Interval, Slip)>);

impl Intervals {
    pub(crate) fn new() -> Self {
        Self(Ring::new(REMEMBERED))
    }

    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    pub(crate) fn push(&mut self, interval: Interval, before: Slip) {
        if self.0.newest().is_some_and(|(newest, _)| interval.from_s - newest.to_s > GAP_S) {
            self.0.clear();
        }
        self.0.push((interval, before));
    }

    /// What the likeliest stretch of them up to now tells, if the slip has stepped from what was believed of it before.
    /// They are forgotten then.
    pub(crate) fn step(&mut self, encoder: &RawEncoder) -> Option<Observation> {
        let mut stretch: Option<Stretch> = None;
        let mut likeliest: Option<(f64, Stretch)> = None;
        for (count, (interval, before)) in (1..=encoder.stretch_most).zip(self.0.iter().rev()) {
            let longer = stretch.map_or(Stretch::of(*interval), |stretch| stretch.behind(interval));
            stretch = Some(longer);
            let misfit = longer.misfit(encoder, *before);
            if count >= encoder.stretch_least && likeliest.is_none_or(|(most, _)| misfit > most) {
                likeliest = Some((misfit, longer));
            }
        }
        let (_, stretch) = likeliest.filter(|(misfit, _)| *misfit > encoder.stretch_threshold)?;
        self.0.clear();
        Some(stretch.observation(encoder))
    }
}

#[cfg(test)]
mod tests;
