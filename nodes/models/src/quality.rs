//! Quality functional, defect probabilities and their fusion with the innovation ([QC] (15)-(18), model book 1.6).

use serde::Deserialize;

use crate::params::{ParamError, in_range};

/// Weights and tolerances of Q. Built only from a valid [`RawQuality`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawQuality")]
pub struct Quality(RawQuality);

read_only!(Quality(RawQuality));

/// The `quality` block of `config/quality.yaml` as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawQuality {
    /// Weight of each term `[-]`, 0 or more.
    pub weights: Terms,
    /// What counts as one unit of each error, above 0.
    pub tolerances: Terms,
}

/// One figure for each term of Q.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Terms {
    /// Image features, in their own unit.
    pub features: f64,
    /// Bead width relative to the wanted one `[-]`.
    pub width: f64,
    /// Nozzle temperature `[K]`.
    pub temperature: f64,
    /// Missing adhesion `[-]`.
    pub adhesion: f64,
    /// Porosity `[-]`.
    pub porosity: f64,
}

impl Terms {
    /// Sum of the terms.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.features + self.width + self.temperature + self.adhesion + self.porosity
    }
}

impl TryFrom<RawQuality> for Quality {
    type Error = ParamError;

    fn try_from(raw: RawQuality) -> Result<Self, ParamError> {
        let Terms { features, width, temperature, adhesion, porosity } = raw.weights;
        in_range("weights.features", features, "-", (0.0, 1e3))?;
        in_range("weights.width", width, "-", (0.0, 1e3))?;
        in_range("weights.temperature", temperature, "-", (0.0, 1e3))?;
        in_range("weights.adhesion", adhesion, "-", (0.0, 1e3))?;
        in_range("weights.porosity", porosity, "-", (0.0, 1e3))?;
        let Terms { features, width, temperature, adhesion, porosity } = raw.tolerances;
        in_range("tolerances.features", features, "-", (0.001, 1000.0))?;
        in_range("tolerances.width", width, "-", (0.001, 1000.0))?;
        in_range("tolerances.temperature", temperature, "K", (0.001, 1000.0))?;
        in_range("tolerances.adhesion", adhesion, "-", (0.001, 1000.0))?;
        in_range("tolerances.porosity", porosity, "-", (0.001, 1000.0))?;
        Ok(Self(raw))
    }
}

/// What Q is taken from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observed<'a> {
    /// Errors of the image features; empty without a camera.
    pub feature_errors: &'a [f64],
    /// Bead width `[m]`.
    pub width_m: f64,
    /// Wanted width `[m]`, above 0.
    pub width_wanted_m: f64,
    /// Nozzle temperature less its set-point `[K]`.
    pub temperature_error_k: f64,
    /// Adhesion alpha `[-]`, in `[0, 1]`.
    pub adhesion: f64,
    /// Porosity phi `[-]`, in `[0, 1]`.
    pub porosity: f64,
}

impl Quality {
    /// Weighted terms of Q; their [`Terms::total`] is Q, 0 for a perfect bead.
    ///
    /// `Q = w_e |e/tol|^2 + w_w ((w-w*)/(tol w*))^2 + w_T ((T-T*)/tol)^2 + w_a ((1-alpha)/tol)^2 + w_p (phi/tol)^2`.
    #[must_use]
    pub fn terms(&self, seen: &Observed) -> Terms {
        let (weights, tolerances) = (&self.weights, &self.tolerances);
        let width_error = (seen.width_m - seen.width_wanted_m) / seen.width_wanted_m;
        let features: f64 =
            seen.feature_errors.iter().map(|error| (error / tolerances.features).powi(2)).sum();
        Terms {
            features: weights.features * features,
            width: weights.width * (width_error / tolerances.width).powi(2),
            temperature: weights.temperature * (seen.temperature_error_k / tolerances.temperature).powi(2),
            adhesion: weights.adhesion * ((1.0 - seen.adhesion) / tolerances.adhesion).powi(2),
            porosity: weights.porosity * (seen.porosity / tolerances.porosity).powi(2),
        }
    }
}

/// Class probabilities from logits; `None` where a logit is not finite or there is none.
#[must_use]
pub fn softmax<const CLASSES: usize>(logits: [f64; CLASSES]) -> Option<[f64; CLASSES]> {
    softmax_of(&logits)?.try_into().ok()
}

/// [`softmax`] of as many logits as a network read from a file has classes.
#[must_use]
pub fn softmax_of(logits: &[f64]) -> Option<Vec<f64>> {
    if logits.is_empty() || logits.iter().any(|logit| !logit.is_finite()) {
        return None;
    }
    // Shifted by the largest: no overflow, same ratios.
    let largest = logits.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let powers: Vec<f64> = logits.iter().map(|logit| (logit - largest).exp()).collect();
    let sum: f64 = powers.iter().sum();
    Some(powers.iter().map(|power| power / sum).collect())
}

/// Fused confidence in a defect `c = beta min(1, a/tau_a) + (1 - beta) p_det` `[-]`, in `[0, 1]`, never falling in
/// `a` or `p_det`; (17) as corrected.
///
/// `statistic` a is 0 or more, `threshold` tau_a above 0, `defect` and `share` beta in `[0, 1]`. `None` where one of
/// them is not: a confidence made of nonsense is none.
#[must_use]
pub fn fused_confidence(statistic: f64, threshold: f64, defect: f64, share: f64) -> Option<f64> {
    let unit = 0.0..=1.0;
    let sound = statistic >= 0.0 && threshold > 0.0 && threshold.is_finite();
    if !(sound && unit.contains(&defect) && unit.contains(&share)) {
        return None;
    }
    Some((share * (statistic / threshold).min(1.0) + (1.0 - share) * defect).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn quality() -> Quality {
        Quality::try_from(RawQuality {
            weights: Terms { features: 0.5, width: 1.0, temperature: 0.3, adhesion: 0.5, porosity: 1.0 },
            tolerances: Terms { features: 1.0, width: 0.05, temperature: 5.0, adhesion: 0.2, porosity: 0.05 },
        })
        .unwrap()
    }

    const PERFECT: Observed<'static> = Observed {
        feature_errors: &[],
        width_m: 4.8e-4,
        width_wanted_m: 4.8e-4,
        temperature_error_k: 0.0,
        adhesion: 1.0,
        porosity: 0.0,
    };

    /// Model book 1.6: Q of a perfect bead with alpha = 0.9 is 0.125.
    #[test]
    fn a_perfect_bead_with_adhesion_09_has_q_0125() {
        let seen = Observed { adhesion: 0.9, ..PERFECT };
        assert!((quality().terms(&seen).total() - 0.125).abs() < 1e-12);
    }

    /// By hand, of (15): twice its tolerance off, each term is four times its weight, to either side.
    #[test]
    fn each_term_is_the_square_of_its_error_in_tolerances() {
        for (seen, q) in [
            (Observed { feature_errors: &[2.0, -2.0], ..PERFECT }, 0.5 * 8.0),
            (Observed { width_m: 1.1 * 4.8e-4, ..PERFECT }, 4.0),
            (Observed { width_m: 0.9 * 4.8e-4, ..PERFECT }, 4.0),
            (Observed { temperature_error_k: 10.0, ..PERFECT }, 0.3 * 4.0),
            (Observed { temperature_error_k: -10.0, ..PERFECT }, 0.3 * 4.0),
            (Observed { adhesion: 0.6, ..PERFECT }, 0.5 * 4.0),
            (Observed { porosity: 0.1, ..PERFECT }, 4.0),
            (PERFECT, 0.0),
        ] {
            let total = quality().terms(&seen).total();
            assert!((total - q).abs() < 1e-9, "{total} for {q}: {seen:?}");
        }
    }

    #[test]
    fn nonsense_yields_no_confidence_and_no_probability() {
        for (a, tau, p, beta) in
            [(f64::NAN, 12.6, 0.3, 0.5), (-1.0, 12.6, 0.3, 0.5), (1.0, 0.0, 0.3, 0.5), (1.0, 12.6, 1.1, 0.5)]
        {
            assert_eq!(fused_confidence(a, tau, p, beta), None);
        }
        assert_eq!(softmax([0.0, f64::NAN]), None);
        assert_eq!(softmax::<0>([]), None);
    }

    proptest! {
        #[test]
        fn confidence_stays_in_the_unit_range_and_never_falls(
            a in 0.0..1e3_f64, more_a in 0.0..1e3_f64, p in 0.0..1.0_f64, more_p in 0.0..1.0_f64, beta in 0.0..1.0_f64,
        ) {
            let least = fused_confidence(a, 12.6, p, beta).unwrap();
            let most = fused_confidence(a + more_a, 12.6, (p + more_p).min(1.0), beta).unwrap();
            prop_assert!((0.0..=1.0).contains(&least) && (0.0..=1.0).contains(&most));
            // Two rounded products: equal inputs may differ in the last bit.
            prop_assert!(most >= least - 1e-15);
        }

        #[test]
        fn probabilities_sum_to_one_whatever_the_logits(logits in prop::array::uniform5(-800.0..800.0_f64)) {
            let p = softmax(logits).unwrap();
            prop_assert!((p.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            prop_assert!(p.iter().all(|p| (0.0..=1.0).contains(p)));
        }
    }
}
