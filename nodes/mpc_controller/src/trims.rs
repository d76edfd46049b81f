//! Fast trims between solves: [QC] (23), integral action on the measured width.

/// Gains and bounds in absolute units, as [QC] (23) writes them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    /// Feed per width error K_w `[1/s]`.
    pub feed_1_s: f64,
    /// Feed per sum of feature errors K_phi `[m/s]`.
    pub features_m_s: f64,
    /// Speed per width error K_v `[1/s]`.
    pub speed_1_s: f64,
    /// Smallest and largest feed `[m/s]`.
    pub feed_range_m_s: (f64, f64),
    /// Smallest and largest path speed `[m/s]`.
    pub speed_range_m_s: (f64, f64),
}

/// Feed and path speed after one measurement: too wide gives less feed and more speed.
///
/// `F⁺ = F − K_w (w − w*) − K_φ Σ e_φ`, `v⁺ = v + K_v (w − w*)`, both clamped ([QC] (23), signs as printed).
#[must_use]
pub fn trimmed(
    gains: &Gains,
    (feed_m_s, speed_m_s): (f64, f64),
    width_error_m: f64,
    features: &[f64],
) -> (f64, f64) {
    let features: f64 = features.iter().sum();
    let feed_m_s = feed_m_s - gains.feed_1_s * width_error_m - gains.features_m_s * features;
    let speed_m_s = speed_m_s + gains.speed_1_s * width_error_m;
    let clamp = |value: f64, (low, high): (f64, f64)| value.max(low).min(high);
    (clamp(feed_m_s, gains.feed_range_m_s), clamp(speed_m_s, gains.speed_range_m_s))
}

/// Largest stable gain per sample of integral action under `delay` whole samples: `2 sin(π / (2 (2 d + 1)))`.
#[must_use]
pub fn loop_gain_limit(delay: f64) -> f64 {
    2.0 * (std::f64::consts::FRAC_PI_2 / (2.0 * delay + 1.0)).sin()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAINS: Gains = Gains {
        feed_1_s: 0.4,
        features_m_s: 2e-5,
        speed_1_s: 8.0,
        feed_range_m_s: (0.0, 0.006),
        speed_range_m_s: (0.01, 0.08),
    };

    #[test]
    fn too_wide_gives_less_feed_and_more_speed() {
        // golden vectors trims-1..3
        for (width_m, features, feed, speed) in [
            (0.000_5, 0.0, 0.001_992, 0.050_16),
            (0.000_45, 0.0, 0.002_012, 0.049_76),
            (0.000_48, 0.5, 0.001_99, 0.05),
        ] {
            let (got_feed, got_speed) = trimmed(&GAINS, (0.002, 0.05), width_m - 0.000_48, &[features]);
            assert!((got_feed - feed).abs() < 1e-12 && (got_speed - speed).abs() < 1e-12);
        }
    }

    #[test]
    fn the_gain_limit_is_where_the_delayed_loop_starts_to_grow() {
        assert!((loop_gain_limit(2.0) - 0.618).abs() < 1e-3);
        // e(k+1) = e(k) - g e(k-2): amplitude over 400 samples
        let amplitude = |gain: f64| {
            let mut past = [1.0_f64; 3];
            for _ in 0..400 {
                past = [past[0] - gain * past[2], past[0], past[1]];
            }
            past.iter().fold(0.0_f64, |most, value| most.max(value.abs()))
        };
        assert!(amplitude(0.95 * loop_gain_limit(2.0)) < 0.1);
        assert!(amplitude(1.05 * loop_gain_limit(2.0)) > 10.0);
    }
}
