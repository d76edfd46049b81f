//! When something that is done again and again is due.

use models::units::Seconds;

/// Golden ratio less one: multiples of it, less their whole parts, fall evenly into 0..1 and never repeat.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Fires once per period.
#[derive(Debug, Clone, Copy)]
pub struct Pace {
    period_s: f64,
    /// Most by which a beat comes sooner or later `[-]`, of the period.
    dither: f64,
    beats: u64,
}

impl Pace {
    /// First beat after one period.
    #[must_use]
    pub fn new(period_s: f64) -> Self {
        Self::dithered(period_s, 0.0)
    }

    /// Beats that come sooner or later by up to `dither`, 0 to 0.5, of the period and keep its mean: what repeats with the
    /// period, as the sides of a part may, is not met at the same phase again and again.
    #[must_use]
    pub fn dithered(period_s: f64, dither: f64) -> Self {
        Self { period_s, dither, beats: 0 }
    }

    /// Whether a beat is due at `now`; a microsecond absorbs the rounding of summed steps.
    pub fn due(&mut self, now: Seconds) -> bool {
        #[allow(clippy::cast_precision_loss, reason = "beats of a print are far below 2^52")]
        let beat = (self.beats + 1) as f64;
        let shift = self.dither * (2.0 * (beat * GOLDEN).fract() - 1.0);
        let due = now.0 + 1e-6 >= (beat + shift) * self.period_s;
        self.beats += u64::from(due);
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pace_neither_loses_nor_gains_beats_over_an_hour() {
        for dither in [0.0, 0.2, 0.5] {
            let mut pace = Pace::dithered(0.01, dither);
            let beats = (1..=3_600_000_u32).filter(|&ms| pace.due(Seconds(f64::from(ms) * 1e-3))).count();
            // the last beat may be late
            assert!((359_999..=360_000).contains(&beats), "{dither}: {beats}");
        }
    }

    /// Beats of a steady pace meet what takes as long as its period in one phase, dithered ones all over what they may.
    #[test]
    fn dithered_beats_meet_all_phases_within_their_share() {
        let phases = |dither: f64| -> Vec<f64> {
            let mut pace = Pace::dithered(0.5, dither);
            let beats = (1..=100_000_u32).map(|ms| f64::from(ms) * 1e-3).filter(|&s| pace.due(Seconds(s)));
            beats
                .enumerate()
                .map(|(beat, s)| (s - 0.5 * f64::from(u32::try_from(beat).unwrap() + 1)) / 0.5)
                .collect()
        };
        assert!(phases(0.0).iter().all(|phase| phase.abs() < 1e-9));
        let mut shifts = phases(0.2);
        // a step of 1 ms is a five-hundredth of the period
        assert!(shifts.iter().all(|shift| (-0.2..0.203).contains(shift)), "{shifts:?}");
        shifts.sort_by(f64::total_cmp);
        let widest = shifts.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        assert!(widest < 0.01, "200 beats over 0.4 of a period leave a gap of {widest}");
    }
}
