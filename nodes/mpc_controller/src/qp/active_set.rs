//! A plan without the interior point: which limits hold is guessed, and a guess proves itself.
//!
//! Condensed to its moves the problem is `min ½ uᵀ H u + gᵀ u, A u <= b`. With the rows `W` of `A` held as equalities
//! `u = u₀ - H⁻¹ Wᵀ λ`, `(W H⁻¹ Wᵀ) λ = W u₀ - b_W`, `u₀ = -H⁻¹ g`. Rows that this breaks are held from then on, rows with
//! λ < 0 let go (primal-dual active set: Hintermüller, Ito and Kunisch, SIAM J. Optim. 13, 2002). A guess that changes nothing
//! meets all conditions of an optimum. One that goes on changing, or holds what contradicts itself, is left to Clarabel.

use super::matrices::{quadratic, responses};
use super::{Lags, ROWS, STAGE, input};
use crate::params::RawCost;
use clarabel::algebra::CscMatrix;
use nalgebra::{DMatrix, DVector};

/// Overstepping that counts as none: shares of feed and speed, kelvin.
const KEPT: f64 = 1e-9;

/// The condensed problem, and the last guess.
pub(super) struct ActiveSet {
    guesses_max: u32,
    /// From moves to all variables.
    map: DMatrix<f64>,
    /// Cost of all variables, without the width's and the width's at a ratio of one.
    costs: [DMatrix<f64>; 2],
    /// The same condensed to the moves.
    condensed: [DMatrix<f64>; 2],
    /// The cost at `width_ratio`, and the inverse of its condensed form.
    cost: DMatrix<f64>,
    inverse: Option<DMatrix<f64>>,
    held: Vec<usize>,
    moves: DVector<f64>,
}

impl ActiveSet {
    pub(super) fn new(cost: &RawCost, lags: &Lags, width_ratio: f64, guesses_max: u32) -> Self {
        let map = moves_to_variables(lags);
        let without_width = dense(&quadratic(cost, lags.horizon, 0.0));
        let width = dense(&quadratic(cost, lags.horizon, 1.0)) - &without_width;
        let costs = [without_width, width];
        let condensed = costs.each_ref().map(|cost| map.tr_mul(cost) * &map);
        let moves = DVector::zeros(map.ncols());
        let mut set = Self {
            guesses_max,
            map,
            cost: costs[0].clone(),
            costs,
            condensed,
            inverse: None,
            held: Vec::new(),
            moves,
        };
        set.set_width_ratio(width_ratio);
        set
    }

    /// Takes over another road's ratio.
    pub(super) fn set_width_ratio(&mut self, width_ratio: f64) {
        let at_ratio = |[fixed, width]: &[DMatrix<f64>; 2]| fixed + width * width_ratio.powi(2);
        self.cost = at_ratio(&self.costs);
        self.inverse = at_ratio(&self.condensed).cholesky().map(|factor| factor.inverse());
    }

    /// The optimal moves, stage by stage, for the linear cost and the right sides of prediction and limits; `None` where no
    /// guess has proved itself.
    pub(super) fn solve(&mut self, linear: &[f64], bounds: &[f64], lags: &Lags) -> Option<&[f64]> {
        let inverse = self.inverse.as_ref()?;
        let free = free_response(bounds, lags);
        let gradient = self.map.tr_mul(&(&self.cost * free + DVector::from_column_slice(linear)));
        let unlimited = -(inverse * gradient);
        let limits = &bounds[2 * lags.horizon..];
        self.held.clear();
        for _ in 0..self.guesses_max {
            self.moves.copy_from(&unlimited);
            let pulls = pull(inverse, &self.held, limits, &mut self.moves)?;
            let before = self.held.len();
            let mut pull_of = pulls.iter();
            self.held.retain(|_| pull_of.next().is_some_and(|pull| *pull > 0.0));
            let is_kept = self.held.len() == before;
            // a row that is held and broken still is taken twice, and contradicts itself
            let broken = broken(limits, &self.moves);
            if is_kept && broken.is_empty() {
                return self.moves.iter().all(|part| part.is_finite()).then_some(self.moves.as_slice());
            }
            self.held.extend(broken);
        }
        None
    }
}

/// Holds rows as equalities and returns how hard each pulls, its λ; `None` where they contradict each other or say the same.
fn pull(
    inverse: &DMatrix<f64>,
    held: &[usize],
    limits: &[f64],
    moves: &mut DVector<f64>,
) -> Option<DVector<f64>> {
    let across = DMatrix::from_fn(held.len(), held.len(), |row, column| {
        let along = Row::new(held[column]);
        Row::new(held[row]).times(|index| along.times(|other| inverse[(index, other)]))
    });
    let beyond = held.iter().map(|row| Row::new(*row).times(|index| moves[index]) - limits[*row]);
    let pulls = across.cholesky()?.solve(&DVector::from_iterator(held.len(), beyond));
    for (row, pull) in held.iter().zip(&pulls) {
        let along = Row::new(*row);
        for (index, moved) in moves.iter_mut().enumerate() {
            *moved -= pull * along.times(|other| inverse[(other, index)]);
        }
    }
    Some(pulls)
}

/// Rows that the moves overstep. A first rate and a first bound are the same row: the tighter counts.
fn broken(limits: &[f64], moves: &DVector<f64>) -> Vec<usize> {
    let beyond = |row: usize| Row::new(row).times(|index| moves[index]) - limits[row];
    let is_looser = |row: usize| {
        let twin = if row % 4 < 2 { row + 2 } else { row - 2 };
        row < ROWS && (limits[twin], twin) < (limits[row], row)
    };
    (0..limits.len()).filter(|row| !(beyond(*row) <= KEPT || is_looser(*row))).collect()
}

/// A row of the limits: `± u` or `± (u - u of the stage before)`.
#[derive(Clone, Copy)]
struct Row {
    sign: f64,
    at: usize,
    before: Option<usize>,
}

impl Row {
    /// In the order of the limits: per stage and move upper bound, lower bound, rise, fall.
    fn new(row: usize) -> Self {
        let (at, kind) = (row / 4, row % 4);
        let before = if kind < 2 { None } else { at.checked_sub(input::COUNT) };
        Self { sign: if kind.is_multiple_of(2) { 1.0 } else { -1.0 }, at, before }
    }

    fn times(self, of: impl Fn(usize) -> f64) -> f64 {
        self.sign * (of(self.at) - self.before.map_or(0.0, of))
    }
}

/// All variables without any move: what the start leaves of itself in each stage.
fn free_response(bounds: &[f64], lags: &Lags) -> DVector<f64> {
    let mut variables = DVector::zeros(lags.horizon * STAGE);
    for (offset, (deviation, _, keep)) in responses(lags).into_iter().enumerate() {
        let mut left = bounds[offset];
        for stage in 0..lags.horizon {
            variables[stage * STAGE + deviation] = left;
            left *= keep;
        }
    }
    variables
}

/// What each move makes of all variables.
fn moves_to_variables(lags: &Lags) -> DMatrix<f64> {
    let n = lags.horizon;
    let mut map = DMatrix::zeros(n * STAGE, n * input::COUNT);
    for stage in 0..n {
        for index in 0..input::COUNT {
            map[(stage * STAGE + index, stage * input::COUNT + index)] = 1.0;
        }
        for (deviation, cause, keep) in responses(lags) {
            let mut share = 1.0 - keep;
            for later in stage..n {
                map[(later * STAGE + deviation, stage * input::COUNT + cause)] = share;
                share *= keep;
            }
        }
    }
    map
}

/// All entries of a symmetric matrix of which the upper triangle is told.
fn dense(upper: &CscMatrix<f64>) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(upper.m, upper.n);
    for column in 0..upper.n {
        for at in upper.colptr[column]..upper.colptr[column + 1] {
            matrix[(upper.rowval[at], column)] = upper.nzval[at];
            matrix[(column, upper.rowval[at])] = upper.nzval[at];
        }
    }
    matrix
}
