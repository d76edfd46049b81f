//! Page's cumulative sum of the width error: few widths far off convict as surely as many that are less so.
//!
//! `s+ = max(0, s + |e| - e0)` on the side where the width `e` lies, `s+ = max(0, s - e0 - |e|)` on the other
//! (Page 1954); e0 lies halfway between a sound width and a defect's. No width counts for more than a defect's, so one
//! gap where a road begins convicts nobody. Frames without a width leave the sum as it is.

use models::params::{ParamError, positive};
use serde::Deserialize;

/// The `fusion.width_sum` block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawWidthSum {
    /// e0, error from which on a width adds to the sum `[-]`, above 0.
    pub beyond_rel: f64,
    /// Sum that convicts `[-]`, above 0.
    pub limit_rel: f64,
}

impl RawWidthSum {
    pub(super) fn check(&self) -> Result<(), ParamError> {
        positive("width_sum.beyond_rel", self.beyond_rel, "-")?;
        positive("width_sum.limit_rel", self.limit_rel, "-").map(|_| ())
    }
}

/// The sums towards thin and wide roads.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct WidthSums {
    under: f64,
    over: f64,
}

impl WidthSums {
    /// Takes a width's relative error. A sum is held at twice its limit: what was wrong for long is forgotten as soon.
    pub(super) fn add(&mut self, error_rel: f64, params: &RawWidthSum) {
        let defect_rel = 2.0 * params.beyond_rel;
        let next = |sum: f64, error: f64| {
            (sum + error.min(defect_rel) - params.beyond_rel).clamp(0.0, 2.0 * params.limit_rel)
        };
        self.under = next(self.under, -error_rel);
        self.over = next(self.over, error_rel);
    }

    /// Whether the widths convict of this class.
    pub(super) fn convict(&self, class: &str, params: &RawWidthSum) -> bool {
        match class {
            "under" => self.under >= params.limit_rel,
            "over" => self.over >= params.limit_rel,
            _ => false,
        }
    }
}
