//! The receding-horizon problem of model book 1.7 on Clarabel.
//!
//! ```text
//! e_u⁺ = a e_u + (1 - a) f        e_T⁺ = a_T e_T + (1 - a_T) d        e_w = r_w (e_u + b - v)
//! ```
//! A stage has the variables `[f, v, d, e_u, e_T]`; the deviations are kept as variables, so that all matrices are
//! sparse. The problem is built once; a solve overwrites vectors in place. Clarabel has no warm start: it is asked where the
//! guess of the limits that hold (`qp/active_set.rs`) does not prove itself.

use crate::params::{RawCost, RawLimits, RawSolver};
use clarabel::solver::{
    DefaultSettings, DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus,
    ZeroConeT,
};
use clarabel::timers::Timers;

/// Index of each move in a [`Move`].
pub mod input {
    /// Feed relative to the un-trimmed feed, less one `[-]`.
    pub const FEED: usize = 0;
    /// Path speed relative to the slicer's, less one `[-]`.
    pub const SPEED: usize = 1;
    /// Offset of the hot end set-point `[K]`.
    pub const SETPOINT: usize = 2;
    /// Number of moves.
    pub const COUNT: usize = 3;
}

/// Feed, speed and set-point offset, indexed by [`input`].
pub type Move = [f64; input::COUNT];

const FLOW: usize = 3;
const TEMPERATURE: usize = 4;
const STAGE: usize = 5;
/// Rows a stage adds to the inequalities: two bounds and two rates a move.
const ROWS: usize = 4 * input::COUNT;

/// What the prediction starts from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// Flow error `u/u_nom - 1` `[-]`.
    pub flow: f64,
    /// Nozzle temperature less its reference `[K]`.
    pub temperature_k: f64,
    /// Bead gain less one `[-]`.
    pub gain: f64,
    /// Move in force.
    pub last: Move,
    /// Ceiling of the feed from the drive's force `[-]`; `None` without one.
    pub feed_cap: Option<f64>,
    /// Change of relative width per relative section `[-]`: 1.09..1.10 for usual roads.
    pub width_ratio: f64,
}

/// Time constants of the prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lags {
    /// Step `[s]`.
    pub period_s: f64,
    /// Number of steps.
    pub horizon: usize,
    /// Filament to outlet `[s]`.
    pub flow_s: f64,
    /// Set-point to nozzle `[s]`.
    pub thermal_s: f64,
}

/// How a solve ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// Optimal.
    Solved {
        /// Interior point steps; 0 where the guess of the limits that hold proved itself.
        iterations: u32,
    },
    /// Ended early: the last plan, shifted by a step, goes on.
    Fallback(Cause),
    /// The bounds contradict each other: the last move stays.
    Infeasible,
    /// Something that came in or came out is not finite: the plan is discarded.
    NotFinite,
}

/// Why a solve ended early.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Cause {
    /// Too many iterations.
    Iterations,
    /// Too long.
    Time,
    /// Numerical trouble.
    Numerical,
}

/// The problem could not be built: a fault of the parameters.
#[derive(Debug, thiserror::Error)]
#[error("the quadratic problem was refused by its solver: {0}")]
pub struct BuildError(String);

/// Receding-horizon problem with its last plan.
pub struct Qp {
    solver: DefaultSolver<f64>,
    active_set: ActiveSet,
    cost: RawCost,
    limits: RawLimits,
    lags: Lags,
    width_ratio: f64,
    linear: Vec<f64>,
    bounds: Vec<f64>,
    plan: Vec<Move>,
    soften: bool,
    softened: u64,
}

impl std::fmt::Debug for Qp {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Qp").field("lags", &self.lags).field("plan", &self.plan).finish_non_exhaustive()
    }
}

impl Qp {
    /// Builds the problem.
    ///
    /// # Errors
    /// [`BuildError`] if the solver refuses the matrices.
    pub fn new(cost: RawCost, limits: RawLimits, lags: Lags, solver: RawSolver) -> Result<Self, BuildError> {
        let n = lags.horizon;
        let width_ratio = 1.0;
        let quadratic = quadratic(&cost, n, width_ratio);
        let constraints = constraints(&lags);
        let (linear, bounds) = (vec![0.0; n * STAGE], vec![0.0; 2 * n + ROWS * n]);
        let cones = [ZeroConeT(2 * n), NonnegativeConeT(ROWS * n)];
        let active_set = ActiveSet::new(&cost, &lags, width_ratio, solver.guesses);
        let solver =
            DefaultSolver::new(&quadratic, &linear, &constraints, &bounds, &cones, settings(solver)?)
                .map_err(|error| BuildError(error.to_string()))?;
        Ok(Self {
            solver,
            active_set,
            cost,
            limits,
            lags,
            width_ratio,
            linear,
            bounds,
            plan: vec![[0.0; input::COUNT]; n],
            soften: true,
            softened: 0,
        })
    }

    /// The same problem, whose ceiling of the feed gives way where the rates cannot reach it, or does not.
    #[must_use]
    pub fn with_softening(self, soften: bool) -> Self {
        Self { soften, ..self }
    }

    /// Solves whose ceiling had to give way so far.
    #[must_use]
    pub fn softened(&self) -> u64 {
        self.softened
    }

    /// The planned moves, the next one first.
    #[must_use]
    pub fn plan(&self) -> &[Move] {
        &self.plan
    }

    /// Forgets the plan.
    pub fn clear(&mut self) {
        self.plan.fill([0.0; input::COUNT]);
    }

    /// Solves and returns the move to make now: inside bounds and rates whatever the outcome.
    pub fn solve(&mut self, start: &Start) -> (Move, Outcome) {
        let numbers =
            [start.flow, start.temperature_k, start.gain, start.width_ratio, start.feed_cap.unwrap_or(0.0)];
        let finite = numbers.iter().chain(&start.last).all(|number| number.is_finite());
        let outcome = if finite { self.optimise(start) } else { Outcome::NotFinite };
        let wish = match outcome {
            Outcome::Solved { .. } => self.plan[0],
            Outcome::Fallback(_) => self.shifted(),
            Outcome::Infeasible => start.last,
            Outcome::NotFinite => {
                self.clear();
                self.plan[0]
            }
        };
        (self.clamped(wish, start), outcome)
    }

    /// One step back towards the slicer's values.
    #[must_use]
    pub fn back(&self, start: &Start) -> Move {
        self.clamped([0.0; input::COUNT], start)
    }

    fn optimise(&mut self, start: &Start) -> Outcome {
        if !self.fill(start) {
            return Outcome::NotFinite;
        }
        #[expect(clippy::float_cmp, reason = "the same ratio as last time, bit for bit")]
        if start.width_ratio != self.width_ratio {
            self.width_ratio = start.width_ratio;
            self.active_set.set_width_ratio(start.width_ratio);
            let cost = quadratic(&self.cost, self.lags.horizon, start.width_ratio);
            if self.solver.update_P(&cost.nzval).is_err() {
                return Outcome::Fallback(Cause::Numerical);
            }
        }
        match self.active_set.solve(&self.linear, &self.bounds, &self.lags) {
            Some(moves) => {
                for (planned, stage) in self.plan.iter_mut().zip(moves.chunks_exact(input::COUNT)) {
                    planned.copy_from_slice(stage);
                }
                Outcome::Solved { iterations: 0 }
            }
            None => self.interior_point(),
        }
    }

    fn interior_point(&mut self) -> Outcome {
        if self.solver.update_q(&self.linear).is_err() || self.solver.update_b(&self.bounds).is_err() {
            return Outcome::Fallback(Cause::Numerical);
        }
        // Clarabel 0.11.1 holds its time limit against set-up and all solutions so far, which are never reset: after a slow
        // start, or some thousand solves, every further one would end at once as too late.
        self.solver.timers = Some(Timers::default());
        self.solver.solve();
        match self.solver.solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => {
                let values = &self.solver.solution.x;
                if values.iter().any(|value| !value.is_finite()) {
                    return Outcome::NotFinite;
                }
                for (planned, stage) in self.plan.iter_mut().zip(values.chunks_exact(STAGE)) {
                    planned.copy_from_slice(&stage[..input::COUNT]);
                }
                Outcome::Solved { iterations: self.solver.solution.iterations }
            }
            SolverStatus::PrimalInfeasible
            | SolverStatus::AlmostPrimalInfeasible
            | SolverStatus::DualInfeasible
            | SolverStatus::AlmostDualInfeasible => Outcome::Infeasible,
            SolverStatus::MaxIterations => Outcome::Fallback(Cause::Iterations),
            SolverStatus::MaxTime => Outcome::Fallback(Cause::Time),
            _ => Outcome::Fallback(Cause::Numerical),
        }
    }

    /// The plan made a period ago, from its second move on; the last is held.
    fn shifted(&mut self) -> Move {
        let last = self.plan.len() - 1;
        self.plan.copy_within(1.., 0);
        if last > 0 {
            self.plan[last] = self.plan[last - 1];
        }
        self.plan[0]
    }
}

impl Lags {
    fn keep_flow(&self) -> f64 {
        (-self.period_s / self.flow_s).exp()
    }

    fn keep_temperature(&self) -> f64 {
        (-self.period_s / self.thermal_s).exp()
    }
}

fn settings(solver: RawSolver) -> Result<DefaultSettings<f64>, BuildError> {
    DefaultSettingsBuilder::default()
        .verbose(false)
        .max_iter(solver.iterations)
        .time_limit(solver.time_limit_s)
        .presolve_enable(false)
        .input_sparse_dropzeros(false)
        .max_threads(1)
        // a third to a half of the time, and as exact here (`fdm bench controller`): the problem is small and well scaled
        .iterative_refinement_enable(false)
        .build()
        .map_err(|error| BuildError(error.to_string()))
}

mod active_set;
mod bounds;
mod matrices;
use active_set::ActiveSet;
use matrices::{constraints, quadratic};

#[cfg(test)]
mod tests;
