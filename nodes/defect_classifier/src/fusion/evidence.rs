//! What a measurement says of the classes that it can tell.

use crate::features::Measured;
use crate::network::Scores;
use models::params::{ParamError, in_range, ordered};
use serde::Deserialize;

/// The `fusion.evidence` block as it is written: below `fine` a class is excluded, from `defect` on it is certain.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawEvidence {
    /// Drift of the widths that is none `[-]`, above 0.
    pub width_fine_rel: f64,
    /// Drift of the widths that is a defect `[-]`, above `width_fine_rel`.
    pub width_defect_rel: f64,
    /// Drift of the seams' shade that is none, in standard deviations `[-]`, above 0.
    pub seam_fine_sigmas: f64,
    /// Drift of the seams' shade that is a defect `[-]`, above `seam_fine_sigmas`.
    pub seam_defect_sigmas: f64,
    /// Classes that a measurement alone can convict of: what the network says of them does not count.
    pub measured_only: Vec<String>,
    /// Unexplained share of edges that is none `[-]`, above 0.
    pub unexplained_fine: f64,
    /// Unexplained share of edges that is a tangle `[-]`, above `unexplained_fine`.
    pub unexplained_defect: f64,
    /// Offset of the layers that is none `[m]`, above 0.
    pub offset_fine_m: f64,
    /// Offset of the layers that is a defect `[m]`, above `offset_fine_m`.
    pub offset_defect_m: f64,
    /// What the machine's own kinematics explains of it `[m]`; not of this block.
    #[serde(skip)]
    pub machine_error_m: f64,
}

impl RawEvidence {
    pub(super) fn check(&self) -> Result<(), ParamError> {
        in_range("evidence.width_fine_rel", self.width_fine_rel, "-", (1e-4, 10.0))?;
        in_range("evidence.offset_fine_m", self.offset_fine_m, "m", (1e-6, 0.1))?;
        in_range("evidence.unexplained_fine", self.unexplained_fine, "-", (1e-4, 10.0))?;
        in_range("evidence.width_defect_rel", self.width_defect_rel, "-", (1e-4, 10.0))?;
        in_range("evidence.offset_defect_m", self.offset_defect_m, "m", (1e-6, 0.1))?;
        in_range("evidence.unexplained_defect", self.unexplained_defect, "-", (1e-4, 10.0))?;
        in_range("evidence.seam_defect_sigmas", self.seam_defect_sigmas, "-", (0.01, 100.0))?;
        let pair = |lower, upper| ordered(lower, upper);
        pair(
            ("evidence.width_fine_rel", self.width_fine_rel),
            ("evidence.width_defect_rel", self.width_defect_rel),
        )?;
        in_range("evidence.seam_fine_sigmas", self.seam_fine_sigmas, "-", (0.01, 100.0))?;
        pair(
            ("evidence.seam_fine_sigmas", self.seam_fine_sigmas),
            ("evidence.seam_defect_sigmas", self.seam_defect_sigmas),
        )?;
        pair(
            ("evidence.unexplained_fine", self.unexplained_fine),
            ("evidence.unexplained_defect", self.unexplained_defect),
        )?;
        pair(
            ("evidence.offset_fine_m", self.offset_fine_m),
            ("evidence.offset_defect_m", self.offset_defect_m),
        )
    }

    /// How sure a measurement is of a class `[0, 1]`; `None` where it does not tell that class, or is not known.
    fn share(&self, class: &str, measured: &Measured) -> Option<f64> {
        let ramp =
            |value: f64, (fine, defect): (f64, f64)| ((value - fine) / (defect - fine)).clamp(0.0, 1.0);
        let width = (self.width_fine_rel, self.width_defect_rel);
        let seams = (self.seam_fine_sigmas, self.seam_defect_sigmas);
        let odd =
            measured.unexplained.map(|share| ramp(share, (self.unexplained_fine, self.unexplained_defect)));
        let bounds = (self.offset_fine_m, self.offset_defect_m);
        let offset_beyond =
            |error_m: f64| measured.offset_m.map(|[x_m, y_m]| ramp(x_m.hypot(y_m) - error_m, bounds));
        match class {
            // A width is calibrated, a seam only beside its own past: the width has the word where both are known.
            "under" => measured
                .width_drift_rel
                .map(|drift| ramp(-drift, width))
                .or(measured.seam_drift_sigmas.map(|drift| ramp(drift, seams))),
            "over" => measured.width_drift_rel.map(|drift| ramp(drift, width)),
            "shift" => offset_beyond(self.machine_error_m),
            // Shifted roads leave edges where none were commanded: the offset explains those, whoever caused it.
            "spaghetti" => odd.map(|odd| odd * (1.0 - offset_beyond(0.0).unwrap_or(0.0))),
            // Without an edge too many there is no string and no lump; with some, the network may say which.
            "stringing" | "blobs" => odd.filter(|odd| *odd <= 0.0),
            _ => None,
        }
    }

    /// Scores in which a measurement's word stands for the classes that it tells: `p_class` becomes its share, and
    /// `ok` keeps what the defects leave. Defects that together exceed 1 are scaled down to it. And per class whether
    /// this frame could tell it.
    pub(super) fn weigh(
        &self,
        classes: &[String],
        scores: &Scores,
        measured: &Measured,
    ) -> (Scores, Vec<bool>) {
        let shares: Vec<Option<f64>> = classes.iter().map(|class| self.share(class, measured)).collect();
        let needed: Vec<bool> = classes.iter().map(|class| self.measured_only.contains(class)).collect();
        let mut probabilities = scores.probabilities.clone();
        for (probability, (share, needed)) in probabilities.iter_mut().zip(shares.iter().zip(&needed)) {
            *probability = share.unwrap_or(if *needed { 0.0 } else { *probability });
        }
        let defects: f64 = probabilities.iter().skip(1).sum();
        if defects > 1.0 {
            probabilities.iter_mut().for_each(|probability| *probability /= defects);
        }
        let defects: f64 = probabilities.iter().skip(1).sum();
        probabilities[0] = (1.0 - defects).clamp(0.0, 1.0);
        let told = shares.iter().zip(&needed).map(|(share, needed)| share.is_some() || !needed);
        (Scores { probabilities }, told.collect())
    }
}
