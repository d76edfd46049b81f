//! What estimator and controller say of their own work: K1 to K5 and K8.

use models::command::{ControlHealth, EstimateHealth, Mode};

use super::Supervisor;
use crate::cause::{Cause, Reaction};
use crate::event::{Decision, What};
use crate::modes::Refused;

/// What was said last, and what came of it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Brains {
    pub(super) estimate: EstimateHealth,
    pub(super) control: ControlHealth,
    /// Why the mode that a person had set fell to observe; `None` once one has been set again.
    fallen: Option<Cause>,
}

impl Brains {
    /// Why the set mode fell to observe, while it stands there.
    pub(super) fn fallen(&self) -> Option<Cause> {
        self.fallen
    }

    /// Doubt of the controller or of the first divergence degrades.
    pub(super) fn raised(&self, correcting: bool) -> [(Cause, Option<Reaction>); 5] {
        let of = |holds: bool| holds.then_some(Reaction::Degrade);
        let said = |health: ControlHealth| of(correcting && self.control == health);
        [
            (Cause::PlanInfeasible, said(ControlHealth::Infeasible)),
            (Cause::PlanLate, said(ControlHealth::Late)),
            (Cause::PlanNotFinite, said(ControlHealth::NotFinite)),
            (Cause::Saturated, said(ControlHealth::Saturated)),
            (Cause::EstimateReset, of(self.estimate == EstimateHealth::Reset)),
        ]
    }

    /// An estimate that no correction may rest on, until a person has looked.
    fn distrusted(&self) -> Option<Cause> {
        match self.estimate {
            EstimateHealth::Diverging => Some(Cause::EstimateDiverging),
            EstimateHealth::Mismatch => Some(Cause::ModelMismatch),
            EstimateHealth::Sound | EstimateHealth::Reset => None,
        }
    }
}

impl Supervisor {
    /// A person sets a mode. One that corrects is not granted for a moment only, while the estimate is not trusted.
    pub(super) fn set_mode(&mut self, mode: Mode) -> Result<(), Refused> {
        match self.brains.distrusted().filter(|_| mode != Mode::Observe) {
            Some(cause) => {
                let why = "no correction may rest on the estimate: ask again once the estimator has trusted it for a minute";
                Err(Refused { why, cause: Some(cause) })
            }
            None => self.modes.set(mode),
        }
    }

    /// The set mode falls to observe with the reason.
    pub(super) fn fall_to_observe(&mut self) {
        let before = self.modes.set_mode();
        if before == Mode::Observe {
            return;
        }
        self.brains.fallen = self.brains.distrusted();
        let Some(cause) = self.brains.fallen else { return };
        if self.modes.set(Mode::Observe).is_ok() {
            // of the set mode: the one in force may be degraded already
            let after = Mode::Observe;
            let (what, why) = (What::ModeChanged, cause.text());
            self.decisions.push(Decision { what, why, cause: Some((cause, None)), before, after });
        }
    }
}
