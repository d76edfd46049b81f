//! What is said of a frame in words, and where to look.

use super::{Classifier, Found};
use crate::camera::Camera;
use crate::event::Judged;
use crate::features::Measured;
use crate::frame::Unusable;
use crate::network::OK;
use models::units::Seconds;
use opencv::core::Mat;

/// Smallest share of an edge's reach by which a region is widened, so that it shows what lies around `[px]`.
const AROUND_PX: f64 = 12.0;

impl Classifier {
    /// What features, measurements and memory say together.
    pub(super) fn judge(&mut self, grey: &Mat, exposed: Seconds, found: &Found) -> Result<Judged, Unusable> {
        // What the loop corrects is wrong all the same: the width is held against what the file alone would have laid, by
        // a sound nozzle under the advance in force.
        let flow = self.status.map_or(1.0, |status| status.trims.flow);
        let width = found.width.map(|width| {
            let share = self.nozzle.share(width.laid, self.path.path_s(width.laid));
            let ratio = self.nozzle.beside_sound(width.width_m / (width.wanted_m * flow), share);
            self.usual.on_width(width.laid, ratio, width.facing)
        });
        let measured = Measured {
            width_error_rel: width.map(|width| width.error_rel),
            width_drift_rel: width.map(|width| width.drift_rel),
            offset_m: found.offset.map(|offset| offset.offset_m),
            // Not known means not judged: without a measured share the network's word on strands and lumps would stand
            // alone, and it is weak.
            unexplained: found.unexplained.or(Some(0.0)),
            seam_drift_sigmas: found.seams.map(|seams| seams.drift_sigmas),
        };
        let scores = self.network.classify(grey, &measured).map_err(|_| Unusable::Failed)?;
        let fused = self.fusion.on_frame(exposed, &scores, &measured).ok_or(Unusable::Failed)?;
        let region_px = region(&self.params.camera, found, &fused.cause);
        let unexplained = found.unexplained.unwrap_or(0.0);
        Ok(Judged {
            probabilities: scores.probabilities,
            fused,
            offset: found.offset,
            seams: found.seams,
            unexplained,
            region_px,
        })
    }
}

/// Lines over the annotated picture.
pub(super) fn captions(exposed: Seconds, found: &Found, judged: &Judged) -> Vec<String> {
    let fused = &judged.fused;
    let mut lines = vec![format!(
        "t {:.2} s  {}{}  c {:.2}  ({} of {})",
        exposed.0,
        fused.cause,
        if fused.confirmed { " (confirmed)" } else { "" },
        fused.confidence,
        fused.in_favour,
        fused.window
    )];
    if let Some(width) = found.width {
        let percent = 100.0 * (width.width_m / width.wanted_m - 1.0);
        let (width_um, sigma_um) = (1e6 * width.width_m, 1e6 * width.sigma_m);
        lines.push(format!(
            "width {width_um:.0} +- {sigma_um:.0} um ({percent:+.1} %), {} pieces",
            width.pieces
        ));
    }
    if let Some(seams) = found.seams {
        let (percent, sigma) = (100.0 * seams.shade, 100.0 * seams.sigma);
        let (cells, drift) = (seams.cells, seams.drift_sigmas);
        lines.push(format!(
            "seams {percent:+.1} +- {sigma:.1} % of the crests, {cells} places, drift {drift:.1} sigma"
        ));
    }
    if let Some(offset) = judged.offset {
        let [x_mm, y_mm] = offset.offset_m.map(|value| 1e3 * value);
        lines.push(format!("offset {x_mm:+.2}, {y_mm:+.2} +- {:.2} mm", 1e3 * offset.sigma_m));
    }
    if let Some(share) = found.unexplained {
        lines.push(format!("edges without a road {:.0} %", 100.0 * share));
    }
    lines
}

/// The rectangle around the measured edges where their road is the cause; elsewhere the features name no place.
pub(super) fn region(camera: &Camera, found: &Found, cause: &str) -> Option<[u32; 4]> {
    let of_road = cause != OK && found.width.is_some();
    let mut ends = found.seen.edges.iter().flat_map(|edge| edge.ends_px).filter(|_| of_road);
    let first = ends.next()?;
    let (mut low, mut high) = (first, first);
    for end in ends {
        for axis in 0..2 {
            low[axis] = low[axis].min(end[axis]);
            high[axis] = high[axis].max(end[axis]);
        }
    }
    let size = [camera.width_px, camera.height_px].map(|pixels| f64::from(pixels) - 1.0);
    let bound = |value: f64, axis: usize| value.clamp(0.0, size[axis]);
    let [left, top] = [0, 1].map(|axis| bound(low[axis] - AROUND_PX, axis));
    let [right, bottom] = [0, 1].map(|axis| bound(high[axis] + AROUND_PX, axis));
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "bounded by the picture's size"
    )]
    Some([left, top, right - left, bottom - top].map(|value| value as u32))
}
