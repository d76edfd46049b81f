//! A nozzle that narrows: when a dip of the flow tells of one, and how laws follow it.

use models::params::{ParamError, in_range};
use serde::Deserialize;

/// A nozzle that narrows.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawClog {
    /// Largest force over that of a sound nozzle `[-]`; 1 follows none.
    pub force_max: f64,
    /// Share of the flow that lacks in a road that is sound, at most `[-]`.
    pub sound: f64,
    /// Share from which on a dip begins `[-]`.
    pub begins: f64,
    /// Share of its deepest at which it has passed `[-]`.
    pub passed: f64,
    /// Share from which on its first frame tells already, and the laws push what the nozzle does not hold yet `[-]`.
    pub deep: f64,
    /// Share of its deepest up to which one that another road cuts off tells of a force `[-]`.
    pub cut_off: f64,
    /// One that lasts longer tells of no force `[s]`.
    pub lasts_s: f64,
    /// Frames further apart do not belong together `[s]`.
    pub gap_s: f64,
    /// Nor do those at feeds that differ by a larger share `[-]`.
    pub feed_spread: f64,
    /// A frame sooner after a change of the road is left out `[s]`.
    pub steady_s: f64,
    /// So is one where the mean feed over this time until then `[s]`
    pub settles_s: f64,
    /// differs by a larger share `[-]`.
    pub settled: f64,
}

impl RawClog {
    pub(super) fn check(&self) -> Result<(), ParamError> {
        in_range("clog.force_max", self.force_max, "-", (1.0, 10.0))?;
        in_range("clog.sound", self.sound, "-", (0.0, 0.5))?;
        in_range("clog.begins", self.begins, "-", (self.sound, 1.0))?;
        in_range("clog.passed", self.passed, "-", (0.05, 0.9))?;
        in_range("clog.deep", self.deep, "-", (self.begins, 1.0))?;
        in_range("clog.cut_off", self.cut_off, "-", (0.0, 0.95))?;
        in_range("clog.lasts_s", self.lasts_s, "s", (0.5, 120.0))?;
        in_range("clog.gap_s", self.gap_s, "s", (0.1, 10.0))?;
        in_range("clog.feed_spread", self.feed_spread, "-", (0.01, 1.0))?;
        in_range("clog.steady_s", self.steady_s, "s", (0.0, 5.0))?;
        in_range("clog.settles_s", self.settles_s, "s", (0.0, 2.0))?;
        in_range("clog.settled", self.settled, "-", (0.0, 1.0))?;
        Ok(())
    }
}
