//! Whether the estimate may be trusted: K4 and K8 of the fault catalogue.

use crate::params::RawHealth;
use models::command::EstimateHealth;

/// Divergences and mismatch over time.
#[derive(Debug, Clone)]
pub(crate) struct Watch {
    params: RawHealth,
    /// Newest divergence and the one before it `[s]`.
    diverged_s: [Option<f64>; 2],
    /// How long the model has not fitted, less how long it has since `[s]`.
    unfit_s: f64,
    before_s: Option<f64>,
}

impl Watch {
    pub(crate) fn new(params: RawHealth) -> Self {
        Self { params, diverged_s: [None; 2], unfit_s: 0.0, before_s: None }
    }

    /// Other limits from now on; what was seen stays.
    pub(crate) fn retune(&mut self, params: RawHealth) {
        self.params = params;
    }

    /// The filter broke and starts anew.
    pub(crate) fn on_divergence(&mut self, now_s: f64) {
        self.diverged_s = [Some(now_s), self.diverged_s[0]];
    }

    /// Whether the model fits now; `None` where nothing can be told.
    pub(crate) fn on_fit(&mut self, now_s: f64, fits: Option<bool>) {
        let dt_s = self.before_s.replace(now_s).map_or(0.0, |before_s| now_s - before_s);
        let most_s = self.params.mismatch_s + self.params.hold_s;
        self.unfit_s = match fits {
            Some(true) => (self.unfit_s - dt_s).max(0.0),
            Some(false) => (self.unfit_s + dt_s).min(most_s),
            None => self.unfit_s,
        };
    }

    pub(crate) fn health(&self, now_s: f64) -> EstimateHealth {
        let params = &self.params;
        let within = |at_s: Option<f64>, span_s: f64| at_s.is_some_and(|at_s| now_s - at_s <= span_s);
        let [newest_s, before_s] = self.diverged_s;
        let twice = newest_s.zip(before_s).is_some_and(|(newest, before)| newest - before <= params.again_s);
        if twice && within(newest_s, params.again_s) {
            EstimateHealth::Diverging
        } else if self.unfit_s >= params.mismatch_s {
            EstimateHealth::Mismatch
        } else if within(newest_s, params.hold_s) {
            EstimateHealth::Reset
        } else {
            EstimateHealth::Sound
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) const PARAMS: RawHealth = RawHealth {
        row_bound: 10.83,
        row: 10,
        hold_s: 2.0,
        again_s: 60.0,
        mismatch_s: 30.0,
        gain_error: 0.15,
        window_bound: 45.3,
    };

    #[test]
    fn one_divergence_is_a_reset_two_within_a_minute_are_more() {
        let mut watch = Watch::new(PARAMS);
        assert_eq!(watch.health(0.0), EstimateHealth::Sound);
        watch.on_divergence(10.0);
        assert_eq!(watch.health(10.0), EstimateHealth::Reset);
        assert_eq!(watch.health(12.1), EstimateHealth::Sound);
        watch.on_divergence(71.0);
        assert_eq!(watch.health(71.0), EstimateHealth::Reset, "61 s later");
        watch.on_divergence(130.0);
        assert_eq!(watch.health(130.0), EstimateHealth::Diverging, "59 s later");
        assert_eq!(watch.health(189.0), EstimateHealth::Diverging);
        assert_eq!(watch.health(191.0), EstimateHealth::Sound);
    }

    /// Runs in steps of 0.05 s and returns when it first told of a mismatch.
    fn told_at(end_s: u32, fits: impl Fn(f64) -> Option<bool>) -> Option<f64> {
        let mut watch = Watch::new(PARAMS);
        (0..end_s * 20).map(|step| f64::from(step) * 0.05).find(|&now_s| {
            watch.on_fit(now_s, fits(now_s));
            watch.health(now_s) == EstimateHealth::Mismatch
        })
    }

    #[test]
    fn a_model_that_never_fits_is_told_after_its_time_whatever_pauses_lie_between() {
        let at_s = told_at(60, |_| Some(false)).unwrap();
        assert!((at_s - 30.0).abs() < 0.1, "{at_s}");
        let at_s = told_at(100, |now_s| (now_s % 2.0 < 1.0).then_some(false)).unwrap();
        assert!((at_s - 60.0).abs() < 1.1, "{at_s}: half of the time nothing can be told");
        assert_eq!(told_at(600, |now_s| Some(now_s % 40.0 > 20.0)), None, "as often as not is no mismatch");
    }
}
