//! A job that nobody permits is told: the printer goes on by itself at the slicer's own values, its heaters on.

use models::command::InForce;
use models::status::JobPhase;
use runtime::{Diagnostics, Level};

/// What `/diagnostics` says then.
const ALONE: &str =
    "a job without a permit in force: at the slicer's own values, no supervisor watches the heaters";

/// Tells it on `/diagnostics`.
pub(super) fn tell(diagnostics: &Diagnostics, in_force: &InForce, phase: JobPhase) {
    let (level, words) = if is_alone(in_force, phase) { (Level::Warn, ALONE) } else { (Level::Ok, "ok") };
    diagnostics.report(level, words);
}

fn is_alone(in_force: &InForce, phase: JobPhase) -> bool {
    in_force.lapsed && matches!(phase, JobPhase::Preparing | JobPhase::Printing | JobPhase::Paused)
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::command::{Mode, Request, Trims};

    #[test]
    fn a_job_is_alone_where_no_permit_is_in_force() {
        let in_force =
            |lapsed| InForce { trims: Trims::NEUTRAL, request: Request::Run, mode: Mode::Act, lapsed };
        for phase in [JobPhase::Preparing, JobPhase::Printing, JobPhase::Paused] {
            assert!(is_alone(&in_force(true), phase) && !is_alone(&in_force(false), phase), "{phase:?}");
        }
        for phase in [JobPhase::Idle, JobPhase::Done, JobPhase::Failed] {
            assert!(!is_alone(&in_force(true), phase), "{phase:?}: nothing is heated");
        }
    }
}
