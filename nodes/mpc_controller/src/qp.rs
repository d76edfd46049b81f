//! The receding-horizon problem of model book 1.7 on Clarabel.
//!
//! ```text
//! e_u⁺ = a e_u + (1 - a) f        e_T⁺ = a_T e_T + (1 - a_T) d        e_w = r_w (e_u + b - v)
//! ```
//! A stage has the variables `[f, v, d, e_u, e_T]`; the deviations are kept as variables, so that all matrices are
//! sparse. The problem is built once; a solve overwrites vectors in place.

use crate::params::{RawCost, RawLimits, RawSolver};
use clarabel::solver::{
    DefaultSettings, DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus,
    ZeroConeT,
};

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
        /// Interior point steps.
        iterations: u32,
    },
    /// Ended early: the last plan, shifted by a step, goes on.
    Fallback(Cause),
    /// The last plan goes on, since the bounds contradict each other.
    Infeasible,
    /// Something that came in is not finite: the last plan goes on.
    Refused,
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
    cost: RawCost,
    limits: RawLimits,
    lags: Lags,
    width_ratio: f64,
    linear: Vec<f64>,
    bounds: Vec<f64>,
    plan: Vec<Move>,
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
        let solver =
            DefaultSolver::new(&quadratic, &linear, &constraints, &bounds, &cones, settings(solver)?)
                .map_err(|error| BuildError(error.to_string()))?;
        Ok(Self {
            solver,
            cost,
            limits,
            lags,
            width_ratio,
            linear,
            bounds,
            plan: vec![[0.0; input::COUNT]; n],
        })
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
        let outcome = if finite { self.optimise(start) } else { Outcome::Refused };
        if !matches!(outcome, Outcome::Solved { .. }) {
            self.shift();
        }
        (self.clamped(self.plan[0], start), outcome)
    }

    fn optimise(&mut self, start: &Start) -> Outcome {
        if self.fill(start).is_err() {
            return Outcome::Fallback(Cause::Numerical);
        }
        self.solver.solve();
        match self.solver.solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => {
                let values = &self.solver.solution.x;
                if values.iter().any(|value| !value.is_finite()) {
                    return Outcome::Fallback(Cause::Numerical);
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
    fn shift(&mut self) {
        let last = self.plan.len() - 1;
        self.plan.copy_within(1.., 0);
        if last > 0 {
            self.plan[last] = self.plan[last - 1];
        }
    }

    /// Inside bounds and rates, with the ceiling where the rates allow it.
    fn clamped(&self, wish: Move, start: &Start) -> Move {
        let (low, high, rate) = (self.limits.low(), self.limits.high(), self.limits.rate());
        std::array::from_fn(|index| {
            let last = if start.last[index].is_finite() { start.last[index] } else { 0.0 };
            let last = last.clamp(low[index], high[index]);
            let high =
                if index == input::FEED { self.feed_high(start.feed_cap, last, 0) } else { high[index] };
            let (least, most) = ((last - rate[index]).max(low[index]), (last + rate[index]).min(high));
            if wish[index].is_finite() { wish[index].max(least).min(most) } else { last.min(most) }
        })
    }

    /// Ceiling of the feed at a step: what the force allows, as soon as the rate lets it be reached.
    fn feed_high(&self, cap: Option<f64>, last: f64, step: u32) -> f64 {
        let reachable = last - self.limits.feed_rate * (f64::from(step) + 1.0);
        let cap = cap.filter(|cap| cap.is_finite()).unwrap_or(self.limits.feed);
        cap.max(reachable).clamp(-self.limits.feed, self.limits.feed)
    }

    fn fill(&mut self, start: &Start) -> Result<(), clarabel::solver::DataUpdateError> {
        #[expect(clippy::float_cmp, reason = "the same ratio as last time, bit for bit")]
        if start.width_ratio != self.width_ratio {
            self.width_ratio = start.width_ratio;
            self.solver.update_P(&quadratic(&self.cost, self.lags.horizon, start.width_ratio).nzval)?;
        }
        let width = 2.0 * (start.width_ratio / self.cost.width_scale).powi(2) * start.gain;
        for stage in self.linear.chunks_exact_mut(STAGE) {
            stage.copy_from_slice(&[0.0, -width, 0.0, width, 0.0]);
        }
        let low = self.limits.low();
        let high = self.limits.high();
        let last: Move = std::array::from_fn(|index| start.last[index].clamp(low[index], high[index]));
        for (index, weight) in self.cost.change_weights().into_iter().enumerate() {
            self.linear[index] -= 2.0 * weight * last[index];
        }
        let n = self.lags.horizon;
        self.bounds[..2 * n].fill(0.0);
        self.bounds[0] = self.lags.keep_flow() * start.flow;
        self.bounds[1] = self.lags.keep_temperature() * start.temperature_k;
        let rate = self.limits.rate();
        for (step, rows_at) in (0_u32..).zip((2 * n..self.bounds.len()).step_by(ROWS)) {
            for index in 0..input::COUNT {
                let most = if index == input::FEED {
                    self.feed_high(start.feed_cap, last[index], step)
                } else {
                    high[index]
                };
                let from = if step == 0 { last[index] } else { 0.0 };
                let at = rows_at + 4 * index;
                self.bounds[at..at + 4].copy_from_slice(&[
                    most,
                    -low[index],
                    rate[index] + from,
                    rate[index] - from,
                ]);
            }
        }
        self.solver.update_q(&self.linear)?;
        self.solver.update_b(&self.bounds)
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
        .build()
        .map_err(|error| BuildError(error.to_string()))
}

mod matrices;
use matrices::{constraints, quadratic};

#[cfg(test)]
mod tests;
