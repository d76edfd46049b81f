//! What may not follow: a second publisher that is obeyed, and more than a trial allows.

use super::Reaction;
use crate::sim::printing::Printing;
use crate::sim::relay::{How, RIVAL_FLOW, RIVAL_SESSION, Tampering};
use models::command::Mode;

/// A second publisher's permit that the printer took, or its flow in force: slewed to, that needs a tenth of a second.
/// Where no second publisher speaks, that flow is the loop's own.
pub(super) fn taken_from_a_rival(relay: &[Tampering], printing: &Printing) -> Option<String> {
    if relay.iter().all(|tampering| tampering.how != How::Rival) {
        return None;
    }
    if printing.obeyed == Some(RIVAL_SESSION) {
        return Some("a permit of a second publisher was taken".to_owned());
    }
    let in_force = printing.simulator().in_force();
    let taken = !in_force.lapsed && (in_force.trims.flow - RIVAL_FLOW).abs() < 1e-6;
    taken.then(|| "the flow of a second publisher in force".to_owned())
}

/// What the supervisor does beyond `most`.
pub(super) fn worse_than(most: Reaction, printing: &Printing) -> Option<String> {
    let state = printing.safety?;
    let allowed = match most {
        Reaction::None | Reaction::Told | Reaction::Flagged | Reaction::Observe => Mode::Act,
        Reaction::Baseline | Reaction::Degraded => Mode::Degraded,
        Reaction::Paused => Mode::Paused,
        Reaction::SafeOff => Mode::SafeOff,
        Reaction::Estop => Mode::Estop,
    };
    let cause = state.cause.map_or("", |cause| cause.id());
    if most < Reaction::Observe && state.set_mode == Mode::Observe {
        return Some(format!("{cause} observe"));
    }
    (state.mode > allowed).then(|| format!("{cause} {:?}", state.mode).to_lowercase())
}
