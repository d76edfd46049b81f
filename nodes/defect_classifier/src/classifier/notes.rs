//! Lines for the print's log: what the camera does not tell, and which cause is confirmed.

use super::Classifier;
use crate::event::{Judged, Note, Weight};
use crate::frame::Unusable;
use crate::network::OK;
use models::status::{JobPhase, PrinterStatus};
use models::units::Seconds;

/// Plan's time into a print until which what was laid is little and will be laid over `[s]`.
const BEGINNING_S: f64 = 15.0;

/// Whether a good part of the print is laid already.
pub(super) fn under_way(status: &PrinterStatus) -> bool {
    matches!(status.phase, JobPhase::Printing | JobPhase::Paused)
        && (status.layer.is_some_and(|layer| layer > 0) || status.path_time_s > BEGINNING_S)
}

pub(super) fn joined_late(status: &PrinterStatus) -> Note {
    Note {
        stamp: status.stamp,
        weight: Weight::Warn,
        what: "old_part",
        why:
            "the classifier joined a print under way: layer shift and loose strands are not judged until the \
              next print"
                .into(),
        before: "unknown".into(),
        after: "unknown".into(),
    }
}

impl Classifier {
    /// A line where the camera stops or starts to tell something, or a cause is confirmed or over.
    pub(super) fn notes(
        &mut self,
        stamp: Seconds,
        judged: &Result<Judged, Unusable>,
    ) -> impl Iterator<Item = Note> + use<> {
        let why = judged.as_ref().err().map(ToString::to_string);
        let view = |why: &Option<String>| if why.is_some() { "unknown" } else { "usable" };
        let (before, after) = (view(&self.unusable), view(&why));
        let changed = before != after;
        let text = why.clone().unwrap_or_default();
        self.unusable = why;
        let of_view = changed.then(|| Note {
            stamp,
            weight: if after == "usable" { Weight::Info } else { Weight::Warn },
            what: "camera_view",
            why: text,
            before: before.into(),
            after: after.into(),
        });
        let of_cause = judged.as_ref().ok().and_then(|judged| self.cause(stamp, judged));
        [of_view, of_cause].into_iter().flatten()
    }

    fn cause(&mut self, stamp: Seconds, judged: &Judged) -> Option<Note> {
        let fused = &judged.fused;
        let cause = fused.confirmed.then(|| fused.cause.clone());
        if cause == self.confirmed {
            return None;
        }
        let before = std::mem::replace(&mut self.confirmed, cause.clone());
        // What no frame could tell of for long is forgotten, and may be there all the same.
        let over =
            if before.as_ref().is_none_or(|class| self.fusion.tells(class, stamp)) { OK } else { "unknown" };
        Some(Note {
            stamp,
            weight: if cause.is_some() { Weight::Warn } else { Weight::Info },
            what: "defect",
            why: format!(
                "{} of {} frames, confidence {:.2}",
                fused.in_favour, fused.window, fused.confidence
            ),
            before: before.unwrap_or_else(|| OK.into()),
            after: cause.unwrap_or_else(|| over.into()),
        })
    }
}
