//! What is done while no plan is solved: K1, K2 and K3 of the fault catalogue.

use crate::params::RawHealth;
use crate::qp::Outcome;
use models::command::ControlHealth;

/// Where the next move comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Course {
    /// The plan: the solved one, or the last one shifted.
    Plan,
    /// The move in force stays.
    Hold,
    /// Back to the slicer's values, at the rates.
    Baseline,
}

/// Solves that have failed since the last solution, of each kind.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ladder {
    late_max: u32,
    infeasible: u32,
    late: u32,
    not_finite: bool,
}

impl Ladder {
    pub(crate) fn new(params: &RawHealth) -> Self {
        Self { late_max: params.late_max, infeasible: 0, late: 0, not_finite: false }
    }

    /// Forgets every failure: nothing is printed.
    pub(crate) fn clear(&mut self) {
        (self.infeasible, self.late, self.not_finite) = (0, 0, false);
    }

    /// One cycle is held without a solution, `late_max` go on with a shifted plan, and none with what is not finite.
    pub(crate) fn on_outcome(&mut self, outcome: Outcome) -> Course {
        self.not_finite = outcome == Outcome::NotFinite;
        match outcome {
            Outcome::Solved { .. } => {
                self.clear();
                Course::Plan
            }
            Outcome::Infeasible => {
                self.infeasible = self.infeasible.saturating_add(1);
                if self.infeasible == 1 { Course::Hold } else { Course::Baseline }
            }
            Outcome::Fallback(_) => {
                self.late = self.late.saturating_add(1);
                if self.late <= self.late_max { Course::Plan } else { Course::Baseline }
            }
            Outcome::NotFinite => Course::Baseline,
        }
    }

    pub(crate) fn health(&self) -> ControlHealth {
        if self.not_finite {
            ControlHealth::NotFinite
        } else if self.infeasible > 1 {
            ControlHealth::Infeasible
        } else if self.late >= self.late_max {
            ControlHealth::Late
        } else {
            ControlHealth::Sound
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::qp::Cause;

    const SOLVED: Outcome = Outcome::Solved { iterations: 8 };
    const LATE: Outcome = Outcome::Fallback(Cause::Iterations);

    fn run(outcomes: &[Outcome]) -> Vec<(Course, ControlHealth)> {
        let params =
            RawHealth { soften: true, late_max: 3, saturated_s: 28.0, duty_stop: 0.99, margin: 1e-3 };
        let mut ladder = Ladder::new(&params);
        outcomes.iter().map(|outcome| (ladder.on_outcome(*outcome), ladder.health())).collect()
    }

    #[test]
    fn k1_one_cycle_is_held_then_it_goes_back() {
        let seen = run(&[Outcome::Infeasible, Outcome::Infeasible, SOLVED]);
        assert_eq!(
            seen,
            [
                (Course::Hold, ControlHealth::Sound),
                (Course::Baseline, ControlHealth::Infeasible),
                (Course::Plan, ControlHealth::Sound)
            ]
        );
    }

    #[test]
    fn k2_three_cycles_go_on_with_the_shifted_plan_and_the_third_tells() {
        let seen = run(&[LATE, LATE, LATE, LATE, SOLVED, LATE]);
        let courses: Vec<Course> = seen.iter().map(|step| step.0).collect();
        let told: Vec<bool> = seen.iter().map(|step| step.1 == ControlHealth::Late).collect();
        use Course::{Baseline, Plan};
        assert_eq!(courses, [Plan, Plan, Plan, Baseline, Plan, Plan]);
        assert_eq!(told, [false, false, true, true, false, false]);
    }

    /// Failures of two kinds in turn are failures in a row.
    #[test]
    fn one_failure_does_not_excuse_another() {
        let seen = run(&[Outcome::Infeasible, LATE, Outcome::Infeasible, LATE, LATE, LATE, SOLVED]);
        let told: Vec<ControlHealth> = seen.iter().map(|step| step.1).collect();
        assert_eq!(seen[2].0, Course::Baseline);
        assert_eq!(seen[5].0, Course::Baseline);
        assert_eq!(told[1..3], [ControlHealth::Sound, ControlHealth::Infeasible]);
        assert_eq!(seen[6], (Course::Plan, ControlHealth::Sound));
    }

    #[test]
    fn k3_what_is_not_finite_is_told_at_once_and_ends_with_a_solution() {
        let seen = run(&[SOLVED, Outcome::NotFinite, SOLVED]);
        assert_eq!(seen[1], (Course::Baseline, ControlHealth::NotFinite));
        assert_eq!(seen[2], (Course::Plan, ControlHealth::Sound));
    }
}
