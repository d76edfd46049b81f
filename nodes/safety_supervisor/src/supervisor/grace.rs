//! One pause per cause: a person has looked, and resumed. What the camera says of the same thing again takes the corrections
//! back for some layers and pauses nothing; a cause that is measured, or another one, does as ever.

use models::status::JobPhase;

use super::Supervisor;
use crate::cause::{Cause, Reaction};
use crate::modes::Raised;

impl Supervisor {
    /// A pause for `cause` has ended: the filters begin anew.
    pub(super) fn resumed(&mut self, cause: Option<Cause>) {
        self.forget();
        let layer = self.printer.and_then(|printer| printer.layer);
        let seen = cause.filter(|cause| cause.is_of_camera());
        self.grace = seen.zip(layer).map(|(cause, layer)| {
            let end = layer.saturating_add(self.params.modes.grace_layers);
            (cause, end)
        });
    }

    /// Ends the grace with its layers or its job; from then on the camera's judge has to say it anew.
    pub(super) fn follow_grace(&mut self) {
        let Some((_, end)) = self.grace else { return };
        let lasts = self.printer.is_some_and(|printer| {
            matches!(printer.phase, JobPhase::Preparing | JobPhase::Printing | JobPhase::Paused)
                && printer.layer.is_some_and(|layer| layer < end)
        });
        if !lasts {
            self.grace = None;
            self.checks.forget_pictures();
        }
    }

    /// What is raised, less what a person has looked at.
    pub(super) fn graced(&self, mut raised: Raised) -> Raised {
        if let Some((cause, _)) = self.grace {
            raised[cause as usize] = raised[cause as usize].map(|reaction| reaction.min(Reaction::Degrade));
        }
        raised
    }
}
