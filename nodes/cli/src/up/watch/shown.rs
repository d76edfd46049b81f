//! What a person sees of a print that is followed: a bar, or a line now and then.

use super::{PrinterState, Seconds, Watch, mode_name, output};

/// Pace of the progress where no terminal shows a bar `[s]`.
const TELL_S: f64 = 10.0;

impl Watch {
    /// A line now and then where standard error is no terminal: a log, a pipe.
    pub(super) fn tell_progress(&mut self, now: Seconds) {
        let due = self.told.is_some_and(|told| (now - told).0 >= TELL_S);
        let Some(state) = self.newest_state.as_ref().filter(|_| due) else { return };
        self.told = Some(now);
        output::note(&format!(
            "{:.1} % at {:.0} s: {}",
            state.progress * 100.0,
            self.marks.last_s,
            self.bar.message()
        ));
    }

    /// Brings the bar up to date.
    pub(super) fn show(&self) {
        let Some(state) = &self.newest_state else { return };
        // A share of the file in permille, never outside of the bar.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded here")]
        let permille = (state.progress.clamp(0.0, 1.0) * 1000.0) as u64;
        self.bar.set_position(permille);
        // What it said before it fell silent holds no longer.
        let guarded = self.newest_safety.as_ref().filter(|_| !self.guard.is_lost());
        let mode = guarded.map_or("no supervisor", |safety| mode_name(safety.mode));
        let layer = place(state);
        let factor = self.marks.last_s / self.elapsed_s().max(1e-3);
        self.bar.set_message(format!(
            "{layer}, {mode}, t = {:.0} s, {factor:.1} x real time, flow {:.3}, slip {:.3}",
            self.marks.last_s, state.flow_factor, state.slip_compensation
        ));
    }
}

/// Where the print is: its layer, or why it has none.
fn place(state: &PrinterState) -> String {
    match state.phase {
        _ if state.layer_known => format!("layer {}", state.layer + 1),
        PrinterState::PHASE_PREPARING => "heating".to_owned(),
        _ => "no layer yet".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A print that was paused before its first layer heats no more.
    #[test]
    fn only_a_print_that_is_prepared_heats() {
        let at = |phase, layer_known| {
            place(&PrinterState { phase, layer_known, layer: 2, ..PrinterState::default() })
        };
        assert_eq!(at(PrinterState::PHASE_PREPARING, false), "heating");
        assert_eq!(at(PrinterState::PHASE_PAUSED, false), "no layer yet");
        assert_eq!(at(PrinterState::PHASE_PRINTING, false), "no layer yet");
        assert_eq!(at(PrinterState::PHASE_PAUSED, true), "layer 3");
    }
}
