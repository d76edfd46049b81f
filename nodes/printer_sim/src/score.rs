//! Quality of the print so far, from the truth of the plant; those of the bead are weighted by time over deposited roads.
//!
//! The integrals stand in [`Truth`](crate::Truth), so that whoever follows it over DDS can form the figures between
//! any two moments although messages may be lost: the difference of two integrals needs no sample in between.

use models::quality::{Observed, Quality};
use serde::Serialize;

/// Integrals since the start.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Integrals {
    /// Time in which a road was deposited `[s]`.
    pub deposit_s: f64,
    /// Filament commanded, but for retractions and priming: the slicer's times the flow trim, and the advance, of which a
    /// part is pushed and withdrawn on the way from road to road `[m]`.
    pub wanted_m: f64,
    /// Filament that passed the gear meanwhile `[m]`.
    pub delivered_m: f64,
    /// Integral of the squared relative width error `[s]`.
    pub width_error_sq_s: f64,
    /// Integral of the quality function Q `[s]`.
    pub quality_s: f64,
}

/// Figures between two moments, with the names of the JSON contract.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Figures {
    /// Mean of Q.
    pub quality_mean: f64,
    /// RMS of the relative width error.
    pub width_rms_rel: f64,
    /// |delivered / commanded - 1|; `None` where nothing was commanded.
    pub feed_error_rel: Option<f64>,
}

impl Integrals {
    /// Figures of what was deposited since `earlier`; `None` where nothing was. A road for which no filament was commanded
    /// (`M221 S0`) is one: thin.
    #[must_use]
    pub fn since(&self, earlier: &Self) -> Option<Figures> {
        let deposit_s = self.deposit_s - earlier.deposit_s;
        let wanted_m = self.wanted_m - earlier.wanted_m;
        (deposit_s > 0.0).then(|| Figures {
            quality_mean: (self.quality_s - earlier.quality_s) / deposit_s,
            width_rms_rel: ((self.width_error_sq_s - earlier.width_error_sq_s) / deposit_s).max(0.0).sqrt(),
            feed_error_rel: (wanted_m > 0.0)
                .then(|| ((self.delivered_m - earlier.delivered_m) / wanted_m - 1.0).abs()),
        })
    }
}

/// A road at one moment, as it really is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment<'a> {
    /// Width, temperature, adhesion, porosity and their references.
    pub bead: Observed<'a>,
    /// Length of the step `[s]`.
    pub dt_s: f64,
}

/// Gathers the integrals.
#[derive(Debug, Clone)]
pub struct Score {
    quality: Quality,
    integrals: Integrals,
}

impl Score {
    /// Nothing gathered yet.
    #[must_use]
    pub fn new(quality: Quality) -> Self {
        Self { quality, integrals: Integrals::default() }
    }

    /// Adds the filament of one step without a retraction or priming: commanded, and delivered `[m]`.
    pub fn add_feed(&mut self, wanted_m: f64, delivered_m: f64) {
        self.integrals.wanted_m += wanted_m;
        self.integrals.delivered_m += delivered_m;
    }

    /// Adds one step in which a road was deposited.
    pub fn add_road(&mut self, moment: &Moment<'_>) {
        let error_rel = moment.bead.width_m / moment.bead.width_wanted_m - 1.0;
        let sum = &mut self.integrals;
        sum.deposit_s += moment.dt_s;
        sum.width_error_sq_s += error_rel * error_rel * moment.dt_s;
        sum.quality_s += self.quality.terms(&moment.bead).total() * moment.dt_s;
    }

    /// The integrals so far.
    #[must_use]
    pub fn integrals(&self) -> Integrals {
        self.integrals
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A print whose filament was never commanded has roads with errors all the same: only the feed has none.
    #[test]
    fn roads_without_commanded_filament_have_width_and_quality_but_no_feed_error() {
        let laid =
            Integrals { deposit_s: 4.0, width_error_sq_s: 1.0, quality_s: 8.0, ..Integrals::default() };
        let figures = laid.since(&Integrals::default());
        assert_eq!(figures, Some(Figures { quality_mean: 2.0, width_rms_rel: 0.5, feed_error_rel: None }));
        let fed = Integrals { wanted_m: 2.0, delivered_m: 1.5, ..laid };
        assert_eq!(fed.since(&Integrals::default()).and_then(|figures| figures.feed_error_rel), Some(0.25));
        assert_eq!(laid.since(&laid), None);
    }
}
