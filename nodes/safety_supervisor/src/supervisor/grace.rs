//! One pause per cause: a person has looked, and resumed. What the camera says of the same thing again takes the corrections
//! back for some layers and pauses nothing. Whatever else there is does as ever: a cause that is measured, another defect,
//! a layer that has shifted once more, another print.

use std::ops::Range;

use models::status::JobPhase;
use models::units::Seconds;

use super::Supervisor;
use super::parts::Checks;
use crate::attention::Level;
use crate::cause::{Cause, Reaction};
use crate::event::{Defect, VisionReport};
use crate::modes::Raised;

/// How long a host that tells no layer believes a person `[s]`: two layers of half a minute.
const LAYERLESS_S: f64 = 60.0;

/// What a person has looked at.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grace {
    cause: Cause,
    /// The defect that carried the confidence, of which [`Cause::Confidence`] says nothing.
    defect: Option<Defect>,
    /// Largest offset of a layer that counts as the one that was seen `[m]`.
    offset_max_m: f64,
    /// Layers in which it is believed; `None` from a host that tells none.
    layers: Option<Range<u32>>,
    since: Seconds,
}

impl Grace {
    /// Whether it is believed in this layer, at this time.
    fn lasts(&self, now: Seconds, layer: Option<u32>) -> bool {
        match (&self.layers, layer) {
            (Some(layers), Some(layer)) => layers.contains(&layer),
            (Some(_), None) => false,
            (None, _) => (0.0..LAYERLESS_S).contains(&(now - self.since).0),
        }
    }

    /// Whether a confidence that this defect carries is of what was looked at. A shift is one thing, by its offset or by name.
    fn covers(&self, defect: Option<Defect>) -> bool {
        if self.cause == Cause::LayerShift && defect == Some(Defect::Shift) {
            return true;
        }
        let cause = Cause::of_defect(defect);
        cause == self.cause && (cause != Cause::Confidence || defect == self.defect)
    }

    /// Whether what the checks say of the cause just now is what was looked at.
    fn holds(&self, checks: &Checks) -> bool {
        match self.cause {
            Cause::LayerShift => checks.shift.newest_m().is_none_or(|offset_m| offset_m <= self.offset_max_m),
            Cause::Confidence => self.covers(checks.convicted),
            _ => true,
        }
    }
}

impl Supervisor {
    /// A pause for `cause` has ended: what a hand at the halted printer explains begins anew. Heaters and thermistors are
    /// watched on: no resume explains what they do, and often enough it would hide it.
    pub(super) fn resumed(&mut self, now: Seconds, cause: Option<Cause>) {
        let defect = self.checks.convicted;
        // As it was found: what was seen later may be a hand.
        let seen_m = self.evidence_of(Cause::LayerShift).map_or(0.0, |seen| 1e-3 * seen.value);
        let offset_max_m = seen_m + self.checks.shift.limit_m();
        self.checks.forget_halt();
        let layer = self.printer.and_then(|printer| printer.layer);
        let seen = cause.filter(|cause| cause.is_of_camera());
        self.grace = seen.map(|cause| {
            let layers = layer.map(|layer| layer..layer.saturating_add(self.params.modes.grace_layers));
            Grace { cause, defect, offset_max_m, layers, since: now }
        });
    }

    /// Ends the grace with its layers or its job; from then on the camera's judge has to say it anew.
    pub(super) fn follow_grace(&mut self, now: Seconds) {
        let Some(grace) = &self.grace else { return };
        let lasts = self.printer.is_some_and(|printer| {
            matches!(printer.phase, JobPhase::Preparing | JobPhase::Printing | JobPhase::Paused)
                && grace.lasts(now, printer.layer)
        });
        if !lasts {
            self.grace = None;
            self.checks.forget_pictures();
        }
    }

    /// Frames that are sure of another thing are counted by themselves: attention stands already.
    pub(super) fn look_beside(&mut self, report: &VisionReport) {
        if self.grace.as_ref().is_none_or(|grace| grace.covers(report.defect)) {
            return;
        }
        let before = self.checks.beside.level();
        if self.checks.beside.on_confidence(report.confidence) > before {
            self.checks.convicted_beside = report.defect;
        }
    }

    /// What is raised, less what a person has looked at.
    pub(super) fn graced(&self, mut raised: Raised, printing: bool) -> Raised {
        let Some(grace) = &self.grace else { return raised };
        let mut know = |cause: Cause| {
            let known = &mut raised[cause as usize];
            *known = known.map(|reaction| reaction.min(Reaction::Degrade));
        };
        if grace.holds(&self.checks) {
            know(grace.cause);
        }
        if grace.covers(self.checks.convicted) {
            know(Cause::of_defect(self.checks.convicted));
        }
        if printing && self.checks.beside.level() == Level::Hard {
            raised[Cause::of_defect(self.checks.convicted_beside) as usize] = Some(Reaction::Pause);
        }
        raised
    }
}
