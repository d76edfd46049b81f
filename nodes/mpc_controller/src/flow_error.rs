//! Slow mean of the flow's error.
//!
//! Excess and nominal flow are averaged apart and divided at the end, `mean(q - q0) / mean(q0)`, so that what counts is the
//! plastic that is missing. A mean of `q / q0 - 1` overrates what follows a fast move: the nominal flow is small then, and
//! a rest of the lag is a large share of it. In an infill of short moves that mean stood at -6 % where nothing was missing.

/// Mean error of the outlet's flow `[-]`.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FlowError {
    excess_m_s: f64,
    nominal_m_s: f64,
}

impl FlowError {
    /// A flow over its nominal one, both `[m/s]` of filament, over `dt_s` of an average of `averaging_s`.
    pub(crate) fn follow(&mut self, (flow_m_s, nominal_m_s): (f64, f64), dt_s: f64, averaging_s: f64) {
        if self.nominal_m_s <= 0.0 {
            // No error is assumed until there is an average to speak of.
            self.nominal_m_s = nominal_m_s;
        }
        let share = 1.0 - (-dt_s / averaging_s).exp();
        self.excess_m_s += share * (flow_m_s - nominal_m_s - self.excess_m_s);
        self.nominal_m_s += share * (nominal_m_s - self.nominal_m_s);
    }

    /// Mean excess over mean nominal flow `[-]`.
    pub(crate) fn mean(&self) -> f64 {
        if self.nominal_m_s > 0.0 { self.excess_m_s / self.nominal_m_s } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_share_is_known_after_a_few_averaging_times() {
        let mut error = FlowError::default();
        assert!(error.mean().abs() < 1e-15);
        (0..20).for_each(|_| error.follow((1.9e-3, 2e-3), 0.05, 5.0));
        assert!((-0.012..-0.006).contains(&error.mean()), "one second of five: {}", error.mean());
        (0..500).for_each(|_| error.follow((1.9e-3, 2e-3), 0.05, 5.0));
        assert!((error.mean() + 0.05).abs() < 1e-3);
    }

    /// 0.1 s of 2 mm/s and 0.1 s of 0.4 mm/s behind a lag: what one lacks the other has.
    #[test]
    fn what_is_late_is_not_missing() {
        let mut error = FlowError::default();
        for step in 0..2000 {
            let fast = step % 4 < 2;
            let (nominal_m_s, late_m_s) = if fast { (2.0e-3, -2.0e-4) } else { (4.0e-4, 2.0e-4) };
            error.follow((nominal_m_s + late_m_s, nominal_m_s), 0.05, 5.0);
        }
        assert!(error.mean().abs() < 2e-3, "{}", error.mean());
    }
}
