//! How far the flow lags behind the filament, over what the material file says, learnt from widths.
//!
//! The flow is carried a second time under a law that holds [`STEP`] more compressed. What the two differ by, over that step, is
//! how the flow depends on the factor of the law: the sensitivity of a recursive prediction error method. Each frame is then a
//! line `e = (f* - f) s` through its relative error `e` and the relative sensitivity `s` of its width; the slope is taken about
//! the means, since a constant error is the slip's or the gain's.

use crate::params::RawMeltLag;

/// Change of the factor over which the flow's sensitivity is taken `[-]`.
pub(crate) const STEP: f64 = 0.1;

/// Factor on the foretold law, and the weighted sums over frames behind it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MeltLag {
    params: RawMeltLag,
    weight: f64,
    lever: f64,
    answer: f64,
    lever_sq: f64,
    product: f64,
    factor: f64,
}

impl MeltLag {
    pub(crate) fn new(params: RawMeltLag) -> Self {
        Self { params, weight: 0.0, lever: 0.0, answer: 0.0, lever_sq: 0.0, product: 0.0, factor: 1.0 }
    }

    /// Other reach, noise and memory from now on; what was seen stays.
    pub(crate) fn retune(&mut self, params: RawMeltLag) {
        self.params = params;
        self.factor = self.found();
    }

    /// Compressed length over the foretold one `[-]`.
    pub(crate) fn factor(&self) -> f64 {
        self.factor
    }

    /// Takes a frame in: what the factor does to its relative width, and how far that is from the predicted one.
    pub(crate) fn take(&mut self, lever: f64, error: f64) {
        let most = self.params.error_max;
        // A smaller effect is that of the loop's own trims: what they answer to would teach itself.
        let lever = if lever.abs() < self.params.lever_min { 0.0 } else { lever };
        let answer = self.factor * lever + error.clamp(-most, most);
        let kept = 1.0 - 1.0 / self.params.frames;
        self.weight = kept * self.weight + 1.0;
        self.lever = kept * self.lever + lever;
        self.answer = kept * self.answer + answer;
        self.lever_sq = kept * self.lever_sq + lever * lever;
        self.product = kept * self.product + lever * answer;
        self.factor = self.found();
    }

    /// What the frames speak for beside a prior of 1 with the reach as its deviation.
    fn found(&self) -> f64 {
        let RawMeltLag { reach, width_noise, .. } = self.params;
        if reach <= 0.0 || self.weight <= 0.0 {
            return 1.0;
        }
        let prior = (width_noise / reach).powi(2);
        let spread = self.lever_sq - self.lever * self.lever / self.weight;
        let common = self.product - self.lever * self.answer / self.weight;
        ((common + prior) / (spread + prior)).clamp(1.0 - reach, 1.0 + reach)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PARAMS: RawMeltLag =
        RawMeltLag { reach: 0.4, width_noise: 0.03, frames: 200.0, lever_min: 0.05, error_max: 0.2 };

    /// Widths of a printer that lags by `truth`, all of them off by `offset` besides.
    fn after(frames: u32, truth: f64, offset: f64) -> MeltLag {
        let mut lag = MeltLag::new(PARAMS);
        for index in 0..frames {
            // evenly spread over +-0.25, in a scrambled order, about a mean of 0.1
            let lever = f64::from(index * 37 % 101) / 200.0 - 0.15;
            lag.take(lever, (truth - lag.factor()) * lever + offset);
        }
        lag
    }

    #[test]
    fn it_finds_the_lag_whatever_else_is_off() {
        for (truth, offset) in [(1.25, 0.0), (1.25, -0.09), (0.8, 0.03)] {
            let found = after(200, truth, offset).factor();
            assert!((found - truth).abs() < 0.01, "{found} for {truth}");
        }
    }

    /// Widths that answer to small levers are answers to the loop's own trims; an error beyond what is believed counts as that.
    #[test]
    fn small_effects_teach_nothing_and_large_errors_no_more_than_is_believed() {
        let wavering = |params: RawMeltLag, lever: f64, error: f64| {
            let mut lag = MeltLag::new(params);
            for sign in [1.0, -1.0] {
                lag.take(sign * lever, sign * error);
            }
            lag.factor()
        };
        assert!((wavering(PARAMS, 0.04, 0.01) - 1.0).abs() < 1e-12);
        assert!(wavering(PARAMS, 0.06, 0.01) > 1.05);
        let wary = RawMeltLag { error_max: 0.01, ..PARAMS };
        let (believed, beyond) = (wavering(wary, 0.06, 0.01), wavering(wary, 0.06, 5.0));
        assert!(believed < 1.39 && (beyond - believed).abs() < 1e-12, "{believed} {beyond}");
    }

    /// Two hundred frames are remembered: after five hundred of another nozzle a tenth of the first is left.
    #[test]
    fn a_lag_that_changes_is_followed() {
        let mut lag = after(400, 1.3, 0.0);
        for index in 0..500_u32 {
            let lever = f64::from(index * 37 % 101) / 200.0 - 0.15;
            lag.take(lever, (0.9 - lag.factor()) * lever);
        }
        assert!((lag.factor() - 0.9).abs() < 0.05, "{}", lag.factor());
    }

    /// 0.03 of noise over 0.4 against a lever of 0.15: one frame moves a fourth of the way, were it alone; about the means none.
    #[test]
    fn one_frame_tells_nothing_and_levers_of_zero_neither() {
        assert!((after(1, 1.3, 0.0).factor() - 1.0).abs() < 0.01);
        let mut lag = MeltLag::new(PARAMS);
        (0..100).for_each(|_| lag.take(0.0, 0.05));
        assert!((lag.factor() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn it_stays_within_its_reach_and_a_reach_of_zero_learns_nothing() {
        assert!((after(400, 3.0, 0.0).factor() - 1.4).abs() < 1e-12);
        assert!((after(400, 0.1, 0.0).factor() - 0.6).abs() < 1e-12);
        let mut lag = after(200, 1.3, 0.0);
        lag.retune(RawMeltLag { reach: 0.0, ..PARAMS });
        assert!((lag.factor() - 1.0).abs() < 1e-12);
        lag.retune(PARAMS);
        assert!((lag.factor() - 1.3).abs() < 0.01, "what was seen stays");
    }
}
