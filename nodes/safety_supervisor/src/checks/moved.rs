//! How far a reading must have moved since it changed last, by the energy balance and through the thermistor's lag.

/// What a reading that stands still has missed.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Moved {
    /// How far the block has come, from where the reading was when it changed `[K]`.
    block_k: f64,
    reading_k: f64,
}

impl Moved {
    /// The reading has changed; the block was `lead_k` ahead of it `[K]`, as it is in a heat-up.
    pub(super) fn begin(&mut self, lead_k: f64) {
        *self = Self { block_k: lead_k, reading_k: 0.0 };
    }

    /// The block went on for `dt_s` at `rate_k_s`; the reading follows with the lag.
    pub(super) fn step(&mut self, rate_k_s: f64, dt_s: f64, lag_s: f64) {
        self.block_k += rate_k_s * dt_s;
        self.reading_k += (self.block_k - self.reading_k) * (1.0 - (-dt_s / lag_s).exp());
    }

    /// Of the reading `[K]`.
    pub(super) fn reading_k(&self) -> f64 {
        self.reading_k
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2.4 K/s for 0.7 s: from rest `2.4 (0.7 - 4.5 (1 - e^(-0.7/4.5)))` = 0.12 K, in a heat-up with its lead of 10.8 K
    /// 2.4 K/s from the first moment on.
    #[test]
    fn a_reading_follows_with_its_lag_and_goes_on_in_a_ramp() {
        let after = |lead_k: f64| {
            let mut moved = Moved::default();
            moved.step(5.0, 1.0, 4.5);
            moved.begin(lead_k);
            (0..700).for_each(|_| moved.step(2.4, 1e-3, 4.5));
            moved.reading_k()
        };
        assert!((after(0.0) - 0.1241).abs() < 1e-3, "{}", after(0.0));
        assert!((after(10.8) - 1.68).abs() < 1e-2, "{}", after(10.8));
    }
}
