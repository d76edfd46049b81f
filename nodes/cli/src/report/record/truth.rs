//! What the simulated printer really did. It stands in a section of its own: nobody in the loop knew it.

use super::super::series::Series;
use fdm_loop_msgs::SimTruth;

/// Truth over time.
#[derive(Debug, Default)]
pub(crate) struct Truth {
    pub(crate) nozzle_degc: Series,
    pub(crate) reference_degc: Series,
    pub(crate) slip_percent: Series,
    pub(crate) gain_percent: Series,
    pub(crate) width_mm: Series,
    pub(crate) target_mm: Series,
    /// Width less target, relative.
    pub(crate) width_error_percent: Series,
    /// What leaves the nozzle, as speed of a filament of nominal section.
    pub(crate) flow_mm_s: Series,
    /// Filament delivered less commanded, over roads.
    pub(crate) ahead_mm: Series,
    /// Nozzle less what counts as right, while roads are laid.
    pub(crate) nozzle_error_k: Series,
    pub(crate) adhesion: Series,
    pub(crate) porosity: Series,
    pub(crate) shift_mm: Series,
    /// First fault on the axis.
    pub(crate) onset_s: Option<f64>,
    /// Newest message, for its integrals.
    pub(crate) last: Option<SimTruth>,
}

impl Truth {
    /// Takes a message in.
    pub(crate) fn take(&mut self, at: f64, truth: &SimTruth) {
        self.nozzle_degc.add(at, truth.nozzle_degc);
        self.reference_degc.add(at, truth.reference_degc);
        self.slip_percent.add(at, truth.slip * 100.0);
        self.gain_percent.add(at, truth.gain * 100.0);
        self.shift_mm.add(at, truth.layer_shift_m[0].hypot(truth.layer_shift_m[1]) * 1e3);
        if truth.depositing {
            self.width_mm.add(at, truth.width_m * 1e3);
            self.target_mm.add(at, truth.target_width_m * 1e3);
            self.width_error_percent.add(at, (truth.width_m / truth.target_width_m - 1.0) * 100.0);
            self.flow_mm_s.add(at, truth.outlet_speed_m_s * truth.gain * 1e3);
            self.nozzle_error_k.add(at, truth.nozzle_degc - truth.reference_degc);
            self.ahead_mm.add(at, (truth.deposit_delivered_m - truth.deposit_wanted_m) * 1e3);
            self.adhesion.add(at, truth.adhesion);
            self.porosity.add(at, truth.porosity);
        }
        if truth.fault_set_in && self.onset_s.is_none() {
            self.onset_s = Some(at);
        }
        self.last = Some(truth.clone());
    }

    /// |delivered / commanded - 1| of the roads.
    pub(crate) fn feed_error_rel(&self) -> Option<f64> {
        let last = self.last.as_ref()?;
        let error = (last.deposit_delivered_m / last.deposit_wanted_m - 1.0).abs();
        (last.deposit_wanted_m > 0.0 && error.is_finite()).then_some(error)
    }

    /// Root mean square of the relative width error.
    pub(crate) fn width_rms_rel(&self) -> Option<f64> {
        let last = self.last.as_ref()?;
        let rms = (last.width_error_sq_s / last.deposit_s).sqrt();
        (last.deposit_s > 0.0 && rms.is_finite()).then_some(rms)
    }

    /// Mean of the quality function.
    pub(crate) fn quality_mean(&self) -> Option<f64> {
        let last = self.last.as_ref()?;
        let mean = last.quality_s / last.deposit_s;
        (last.deposit_s > 0.0 && mean.is_finite()).then_some(mean)
    }
}
