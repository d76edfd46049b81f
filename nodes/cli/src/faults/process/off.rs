//! Behind SAFE_OFF and ESTOP nothing is heated and nothing goes on: by every state of the printer, and by block and bed as
//! the simulator tells them. Trials in virtual time are held to the same limits.

use super::session::Session;
use super::watcher::Watcher;
use crate::faults::trial::off::{BED_RISE_MAX_K, BLOCK_RISE_MAX_K, WATCHED_S};
use fdm_loop_msgs::{PrinterState, SimTruth};

/// Longest wait for that on a machine whose simulator lags behind the host `[s]`.
const PATIENCE_S: f64 = 20.0;
/// Time in which an order reaches the printer through DDS and is carried out `[s]`: 0.02 to 0.06 s were measured beside 1.8
/// other busy cores of two; debug programs of the gate may take as long as the reaction itself may there.
const CARRIED_OUT_S: f64 = 1.0;
/// States and truths come at 50 Hz each; a busy machine may keep back half.
const HEARD_MIN: u32 = 250;

/// What was heard of one of them.
#[derive(Debug, Clone, Copy, Default)]
struct Heard {
    count: u32,
    /// Behind the reaction `[s]`.
    newest_s: f64,
}

impl Heard {
    fn take(&mut self, behind_s: f64) {
        self.count += 1;
        self.newest_s = behind_s;
    }
}

/// What was seen from the reaction on.
#[derive(Debug, Default)]
pub(super) struct Off {
    since_s: Option<f64>,
    states: Heard,
    truths: Heard,
    /// A state has shown that the order was carried out.
    carried_out: bool,
    /// Block and bed at the reaction `[degC]`.
    at_first: Option<(f64, f64)>,
    /// The first thing that should not be.
    heated: Option<String>,
}

impl Off {
    /// Supervisor or printer has reacted; the first time counts.
    pub(super) fn react(&mut self, at_s: f64) {
        self.since_s.get_or_insert(at_s);
    }

    /// Takes a state of the printer.
    pub(super) fn on_printer(&mut self, at_s: f64, state: &PrinterState) {
        let Some(behind_s) = self.behind(at_s) else { return };
        self.states.take(behind_s);
        let told = match ordered(state) {
            None => {
                self.carried_out = true;
                return;
            }
            Some(what) if self.carried_out => format!("{what} again"),
            Some(what) if behind_s > CARRIED_OUT_S => what,
            Some(_) => return,
        };
        self.heated.get_or_insert(format!("{told} {behind_s:.2} s behind the reaction"));
    }

    /// Takes what the simulator tells of itself: a switch that conducts by itself shows in no order.
    pub(super) fn on_truth(&mut self, at_s: f64, truth: &SimTruth) {
        let Some(behind_s) = self.behind(at_s) else { return };
        self.truths.take(behind_s);
        let (block_c, bed_c) = *self.at_first.get_or_insert((truth.block_degc, truth.bed_degc));
        let (block_k, bed_k) = (truth.block_degc - block_c, truth.bed_degc - bed_c);
        if block_k > BLOCK_RISE_MAX_K || bed_k > BED_RISE_MAX_K {
            let warmer_k = block_k.max(bed_k);
            self.heated
                .get_or_insert(format!("warmer by {warmer_k:.1} K {behind_s:.2} s behind the reaction"));
        }
    }

    /// Whether it has been looked at for long enough.
    pub(super) fn is_over(&self) -> bool {
        self.states.newest_s.min(self.truths.newest_s) >= WATCHED_S
    }

    /// What was heated, or went on, so far.
    pub(super) fn heated(&self) -> Option<String> {
        self.heated.clone()
    }

    /// What is wrong behind a reaction: where there was none its own limit is missed.
    pub(super) fn miss(&self) -> Option<String> {
        self.since_s?;
        let little = !self.is_over() || self.states.count.min(self.truths.count) < HEARD_MIN;
        let seen = || format!("little was seen behind the reaction: {:?}, {:?}", self.states, self.truths);
        self.heated().or(little.then(seen))
    }

    fn behind(&self, at_s: f64) -> Option<f64> {
        self.since_s.map(|since_s| at_s - since_s).filter(|behind_s| *behind_s >= 0.0)
    }
}

/// What a printer still does that is to be off.
fn ordered(state: &PrinterState) -> Option<String> {
    // What is no number is not off.
    let off = |values: [f64; 2]| values.iter().all(|value| *value <= 0.0);
    if !off([state.hotend_duty, state.bed_duty]) {
        Some(format!("a duty of {:.2} and {:.2}", state.hotend_duty, state.bed_duty))
    } else if !off([state.hotend_target_degc, state.bed_target_degc]) {
        Some(format!("set-points of {} and {} degC", state.hotend_target_degc, state.bed_target_degc))
    } else {
        (state.phase != PrinterState::PHASE_FAILED).then(|| format!("a job in phase {}", state.phase))
    }
}

/// Looks on behind the reaction for as long as it has to stay off.
pub(super) async fn watch(session: &mut Session, watcher: &mut Watcher) -> anyhow::Result<()> {
    if watcher.off.since_s.is_some() {
        session
            .until(PATIENCE_S, |at, seen| {
                watcher.take(at, seen);
                watcher.off.is_over()
            })
            .await?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(duty: f64, target_degc: f64, phase: u8) -> PrinterState {
        PrinterState { hotend_duty: duty, bed_target_degc: target_degc, phase, ..PrinterState::default() }
    }

    /// What all states and truths of a watch make of it; the last state at 9 s is `odd`.
    fn watched(odd: PrinterState, warmer_k: f64) -> Option<String> {
        let mut off = Off::default();
        off.on_printer(0.0, &state(1.0, 60.0, PrinterState::PHASE_PRINTING));
        off.react(3.0);
        off.on_printer(3.1, &state(1.0, 60.0, PrinterState::PHASE_PRINTING));
        for step in 1..=520 {
            let at_s = 3.1 + 0.02 * f64::from(step);
            let sound = state(0.0, 0.0, PrinterState::PHASE_FAILED);
            off.on_printer(at_s, if step == 445 { &odd } else { &sound });
            let block_degc = 215.0 + if step > 445 { warmer_k } else { 0.0 };
            off.on_truth(at_s, &SimTruth { block_degc, ..SimTruth::default() });
        }
        assert!(off.is_over());
        off.miss()
    }

    #[test]
    fn one_state_that_heats_behind_the_reaction_is_a_miss() {
        let failed = PrinterState::PHASE_FAILED;
        assert_eq!(watched(state(0.0, 0.0, failed), 2.9), None);
        for (odd, warmer_k, told) in [
            (state(0.2, 0.0, failed), 0.0, "a duty of 0.20 and 0.00 again 9.00 s"),
            (state(f64::NAN, 0.0, failed), 0.0, "a duty of NaN and 0.00 again"),
            (state(0.0, 60.0, failed), 0.0, "set-points of 0 and 60 degC again"),
            (state(0.0, 0.0, PrinterState::PHASE_PRINTING), 0.0, "a job in phase 2 again"),
            (state(0.0, 0.0, failed), 3.1, "warmer by 3.1 K"),
        ] {
            let missed = watched(odd, warmer_k).unwrap();
            assert!(missed.starts_with(told), "{missed}");
        }
    }

    #[test]
    fn what_is_not_off_in_time_or_was_hardly_seen_is_a_miss() {
        let mut off = Off::default();
        assert_eq!(off.miss(), None, "no reaction");
        off.react(3.0);
        off.on_printer(4.1, &state(0.0, 0.0, PrinterState::PHASE_FAILED));
        assert!(off.miss().unwrap().starts_with("little was seen"));
        let mut off = Off::default();
        off.react(3.0);
        off.on_printer(4.1, &state(0.5, 0.0, PrinterState::PHASE_FAILED));
        assert_eq!(off.miss().as_deref(), Some("a duty of 0.50 and 0.00 1.10 s behind the reaction"));
    }
}
