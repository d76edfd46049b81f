//! DEGRADED takes corrections back: since when, which of them outlive their time, and when they are there again.

use models::command::{InForce, Mode, Trims};

/// Longest time in which DEGRADED takes corrections back, and a look of the printer `[s]`.
pub(super) const RAMP_S: f64 = 2.02;

/// Since when corrections have had to go back, on the printer's word and on the supervisor's.
#[derive(Debug, Default)]
pub(super) struct TakenBack {
    /// The printer has been told, without a break `[s]`.
    told_s: Option<f64>,
    /// The supervisor has gone into DEGRADED the last time `[s]`.
    begun_s: f64,
    /// The supervisor was in DEGRADED at the last look.
    lasts: bool,
}

impl TakenBack {
    /// Looks at `now_s`; for how long corrections have been on their way back `[s]`, `None` where they need not go.
    ///
    /// Of a supervisor that was well again for a moment the printer may have heard nothing: the permits of that moment
    /// were lost. What was corrected meanwhile has its own way back, from the new beginning on.
    pub(super) fn look(&mut self, now_s: f64, printer: bool, supervisor: bool) -> Option<f64> {
        if supervisor && !self.lasts {
            self.begun_s = now_s;
        }
        self.lasts = supervisor;
        self.told_s = self.told_s.or(Some(now_s)).filter(|_| printer);
        self.told_s.map(|told_s| now_s - told_s.max(self.begun_s))
    }
}

/// Corrections that are in force so long after they were to be taken back; `None` where they need not be gone.
pub(super) fn kept_too_long(degraded_s: Option<f64>, in_force: &Trims) -> Option<String> {
    let late = degraded_s.is_some_and(|degraded_s| degraded_s > RAMP_S);
    (late && *in_force != Trims::NEUTRAL).then(|| format!("corrections in force {RAMP_S} s after DEGRADED"))
}

/// Whether corrections are there again: felt by the printer where a controller has any, else allowed.
pub(super) fn is_back(control: &str, in_force: &InForce) -> bool {
    let felt = control != "mpc" || in_force.trims != Trims::NEUTRAL;
    in_force.mode == Mode::Act && !in_force.lapsed && felt
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::command::Request;

    #[test]
    fn corrections_are_back_where_the_printer_feels_them() {
        let felt = Trims { flow: 1.001, ..Trims::NEUTRAL };
        let in_force = |mode, lapsed, trims| InForce { trims, request: Request::Run, mode, lapsed };
        assert!(is_back("mpc", &in_force(Mode::Act, false, felt)));
        assert!(!is_back("mpc", &in_force(Mode::Act, false, Trims::NEUTRAL)), "neutral for ever");
        assert!(is_back("off", &in_force(Mode::Act, false, Trims::NEUTRAL)), "nothing is corrected");
        assert!(!is_back("mpc", &in_force(Mode::Degraded, false, felt)));
        assert!(!is_back("mpc", &in_force(Mode::Act, true, felt)));
    }

    /// DEGRADED takes corrections back within 2 s: what is in force later is too much, what is on its way is not.
    #[test]
    fn corrections_that_outlive_their_ramp_are_too_much() {
        let left = Trims { flow: 1.001, ..Trims::NEUTRAL };
        for (degraded_s, trims, kept) in [
            (None, left, false),
            (Some(0.0), left, false),
            (Some(RAMP_S), left, false),
            (Some(RAMP_S + 0.02), left, true),
            (Some(RAMP_S + 0.02), Trims::NEUTRAL, false),
        ] {
            assert_eq!(kept_too_long(degraded_s, &trims).is_some(), kept, "{degraded_s:?} {trims:?}");
        }
    }

    /// Looks at `[s]`, printer and supervisor in DEGRADED, and what is made of it `[s]`.
    fn looked(looks: &[(f64, bool, bool, Option<f64>)]) {
        let mut taken_back = TakenBack::default();
        for (now_s, printer, supervisor, expected_s) in looks {
            let since_s = taken_back.look(*now_s, *printer, *supervisor);
            let near = match (since_s, expected_s) {
                (Some(since_s), Some(expected_s)) => (since_s - expected_s).abs() < 1e-9,
                (since_s, expected_s) => since_s.is_none() && expected_s.is_none(),
            };
            assert!(near, "{since_s:?} at {now_s} s of {looks:?}");
        }
    }

    /// The permit is on its way until the printer is told; told of another mode, it is asked for nothing.
    #[test]
    fn the_time_runs_from_when_the_printer_is_told() {
        looked(&[
            (0.0, false, false, None),
            (1.0, false, true, None),
            (1.5, true, true, Some(0.0)),
            (4.0, true, true, Some(2.5)),
            // Well again, and the permit that says so comes late: what is kept until then is kept too long.
            (5.0, true, false, Some(3.5)),
            (5.4, false, false, None),
            (9.0, true, true, Some(0.0)),
        ]);
    }

    /// C6: the permits of a moment of health were lost. What came of it goes back from the next DEGRADED on, and not later.
    #[test]
    fn a_new_beginning_that_the_printer_has_not_heard_of_counts() {
        looked(&[
            (1.0, true, true, Some(0.0)),
            (5.0, true, false, Some(4.0)),
            (5.02, true, true, Some(0.0)),
            (7.02, true, true, Some(2.0)),
            (9.02, true, true, Some(4.0)),
        ]);
    }
}
