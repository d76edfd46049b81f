//! Other parameters while the controller works.

use super::{BuildError, Controller};
use crate::params::Params;
use crate::qp::{Lags, Qp};
use crate::saturation::Saturation;
use models::material::Material;

impl Controller {
    /// Other costs, limits, dead bands and gains from now on. What was seen and done stays; a move in force beyond a new
    /// limit goes to it at once.
    ///
    /// # Errors
    /// [`BuildError`] if the quadratic problem cannot be built from the parameters: then nothing changes.
    pub fn retune(&mut self, params: Params) -> Result<(), BuildError> {
        self.qp = problem(&params, &self.printer.material)?;
        let (low, high) = (params.limits.low(), params.limits.high());
        self.saturation = Saturation::new(params.health, low, high);
        for ((held, low), high) in self.held.iter_mut().zip(low).zip(high) {
            *held = held.clamp(low, high);
        }
        self.base = self.base.retuned(params.base, params.limits.feed);
        self.params = params;
        Ok(())
    }
}

/// The quadratic problem of these parameters.
pub(super) fn problem(params: &Params, material: &Material) -> Result<Qp, BuildError> {
    let lags = Lags {
        period_s: params.period_s,
        horizon: params.model.horizon as usize,
        flow_s: material.lag_s,
        thermal_s: params.model.thermal_lag_s,
    };
    let qp = Qp::new(params.cost, params.limits, lags, params.solver)?;
    Ok(qp.with_softening(params.health.soften))
}
