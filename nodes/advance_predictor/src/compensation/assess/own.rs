//! How a person's own lines are met.

use super::Judges;
use crate::compensation::Ensemble;
use crate::compensation::measured::{Contradiction, Measured, contradictions};
use crate::network::training::mean;
use serde::Serialize;

/// How a person's own lines are met, in seconds unless the name says otherwise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OwnLines {
    /// Lines of this drive.
    pub count: usize,
    /// Those of them outside of the networks' data, where the physical model answers whatever was measured: not judged.
    pub outside_hull: usize,
    /// Mean magnitude of what is foretold less what was measured.
    pub mean_abs_s: f64,
    /// Largest magnitude.
    pub max_abs_s: f64,
    /// Lines that the interval holds.
    pub covered: usize,
    /// Mean half width of that interval.
    pub mean_half_width_s: f64,
    /// Virtual lines that on this printer would lie outside of the drive's range: left out.
    pub virtual_left_out: usize,
    /// Lines of one condition that contradict each other.
    pub contradictions: Vec<Contradiction>,
}

impl OwnLines {
    pub(super) fn of(ensemble: &Ensemble, judges: Judges) -> Option<Self> {
        let drive = ensemble.drive();
        let lines: Vec<&Measured> = judges.measured.iter().filter(|line| line.drive == drive).collect();
        let judged: Vec<[f64; 2]> = lines
            .iter()
            .filter_map(|line| {
                let foretold = ensemble.predict(&line.polymer, &line.at)?;
                Some([(foretold.advance.0 - line.advance_s).abs(), foretold.half_width.0])
            })
            .collect();
        (!lines.is_empty()).then(|| Self {
            count: lines.len(),
            outside_hull: lines.len() - judged.len(),
            mean_abs_s: mean(judged.iter().map(|[error_s, _]| *error_s)),
            max_abs_s: judged.iter().map(|[error_s, _]| *error_s).fold(0.0, f64::max),
            covered: judged.iter().filter(|[error_s, half_s]| error_s <= half_s).count(),
            mean_half_width_s: mean(judged.iter().map(|[_, half_s]| *half_s)),
            virtual_left_out: judges.left_out,
            contradictions: contradictions(judges.data, drive, judges.measured),
        })
    }
}
