//! Fitting the edge network: windows laid beside edges that are known, Adam on the squared error with a bounded pull.
//!
//! Single thread, no clock; chance comes from the caller's stream, so the same profiles and stream give the same file.

use super::{EdgeError, EdgeModel, FORMAT, RawEdge, Ruler};
use crate::network::training::{Fitted, rounded};
use models::params::{ParamError, in_range, ordered, positive};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A profile whose edge is known.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownEdge {
    /// Which camera saw it.
    pub look: u64,
    /// Mean levels across the road.
    pub levels: Vec<f64>,
    /// Where the edge is, from the centre line `[m]`.
    pub edge_m: f64,
    /// Half the width that was wanted: where a measurement begins `[m]`.
    pub half_m: f64,
}

/// How the network is fitted. Built only from a valid [`RawEdgeFit`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawEdgeFit")]
pub struct EdgeFit(RawEdgeFit);

/// The block `fit` of `config/models/edge_training.yaml` as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawEdgeFit {
    /// First distance of the window from the assumed edge `[m]`.
    pub from_m: f64,
    /// Between two inputs `[m]`.
    pub step_m: f64,
    /// Inputs of the network.
    pub inputs: u32,
    /// Hidden units.
    pub hidden: u32,
    /// Length that an answer of one means `[m]`.
    pub scale_m: f64,
    /// Least fall of the levels at an edge, written into the file `[-]`.
    pub contrast_min: f64,
    /// As many draws as there are profiles, so many times.
    pub epochs: u32,
    /// Draws of a step.
    pub batch: u32,
    /// Length of the first steps; falls with the square of what is left.
    pub rate: f64,
    /// Length of the last steps.
    pub rate_least: f64,
    /// Share of the windows that are laid far from the edge `[-]`.
    pub far_share: f64,
    /// How far they are laid at most `[m]`.
    pub far_m: f64,
    /// How far the others are `[m]`.
    pub near_m: f64,
    /// A larger error pulls no more than this one, as a share of `scale_m` `[-]`.
    pub pull_max: f64,
}

impl TryFrom<RawEdgeFit> for EdgeFit {
    type Error = ParamError;

    fn try_from(raw: RawEdgeFit) -> Result<Self, ParamError> {
        in_range("fit.from_m", raw.from_m, "m", (-2e-3, 0.0))?;
        in_range("fit.step_m", raw.step_m, "m", (1e-6, 1e-3))?;
        in_range("fit.inputs", f64::from(raw.inputs), "-", (4.0, 256.0))?;
        in_range("fit.hidden", f64::from(raw.hidden), "units", (1.0, 256.0))?;
        in_range("fit.scale_m", raw.scale_m, "m", (1e-6, 1e-3))?;
        in_range("fit.contrast_min", raw.contrast_min, "-", (0.0, 0.99))?;
        in_range("fit.epochs", f64::from(raw.epochs), "-", (1.0, 1e5))?;
        in_range("fit.batch", f64::from(raw.batch), "profiles", (1.0, 1e5))?;
        positive("fit.rate_least", raw.rate_least, "-")?;
        ordered(("fit.rate_least", raw.rate_least), ("fit.rate", raw.rate))?;
        in_range("fit.rate", raw.rate, "-", (0.0, 1.0))?;
        in_range("fit.far_share", raw.far_share, "-", (0.0, 1.0))?;
        positive("fit.near_m", raw.near_m, "m")?;
        ordered(("fit.near_m", raw.near_m), ("fit.far_m", raw.far_m))?;
        in_range("fit.far_m", raw.far_m, "m", (0.0, 1e-3))?;
        positive("fit.pull_max", raw.pull_max, "-")?;
        Ok(Self(raw))
    }
}

impl EdgeFit {
    /// How often all profiles are gone through.
    #[must_use]
    pub fn epochs(&self) -> u32 {
        self.0.epochs
    }
}

/// Fits a network; `uniform` yields numbers from `[0, 1)`, `tell` hears after each epoch its number and the root mean
/// square error of its answers `[m]`.
///
/// # Errors
/// [`EdgeError::Profiles`] without a profile that holds a window beside its edge.
pub fn fit(
    profiles: &[KnownEdge],
    ruler: &Ruler,
    EdgeFit(params): &EdgeFit,
    uniform: &mut dyn FnMut() -> f64,
    tell: &mut dyn FnMut(u32, f64),
) -> Result<EdgeModel, EdgeError> {
    let mut learner = Learner::new(params, uniform);
    let mut windows = vec![];
    let mut steps = 0;
    for epoch in 0..params.epochs {
        let left = 1.0 - f64::from(epoch) / f64::from(params.epochs);
        let rate = params.rate * left.powi(2) + params.rate_least;
        let (mut sum, mut count) = (0.0, 0_u32);
        for _ in 0..profiles.len() {
            // A window that leaves its profile teaches nothing.
            let Some(drawn) = learner.draw(profiles, ruler, uniform) else { continue };
            windows.push(drawn);
            if windows.len() < params.batch as usize {
                continue;
            }
            steps += 1;
            count += params.batch;
            sum += learner.step(&mut windows, rate, steps);
        }
        tell(epoch + 1, params.scale_m * (sum / f64::from(count.max(1))).sqrt());
    }
    if steps == 0 {
        return Err(EdgeError::Profiles);
    }
    learner.model()
}

/// The network while it learns.
struct Learner<'a> {
    params: &'a RawEdgeFit,
    /// Knows how a window is cut; its weights are not used.
    shape: EdgeModel,
    hidden: Fitted,
    output: Fitted,
}

impl<'a> Learner<'a> {
    fn new(params: &'a RawEdgeFit, uniform: &mut dyn FnMut() -> f64) -> Self {
        let (inputs, units) = (params.inputs as usize, params.hidden as usize);
        let shape = EdgeModel {
            from_m: params.from_m,
            step_m: params.step_m,
            scale_m: params.scale_m,
            hidden: DMatrix::zeros(units, inputs),
            hidden_bias: DVector::zeros(units),
            output: DVector::zeros(units),
            output_bias: 0.0,
            contrast_min: params.contrast_min,
            trained: String::new(),
        };
        let hidden = Fitted::new(inputs, units, uniform);
        Self { params, shape, hidden, output: Fitted::new(units, 1, uniform) }
    }

    /// A window beside the edge of one of the profiles, and how far off it is as a share of `scale_m`.
    fn draw(
        &self,
        profiles: &[KnownEdge],
        ruler: &Ruler,
        uniform: &mut dyn FnMut() -> f64,
    ) -> Option<(DVector<f64>, f64)> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            clippy::cast_precision_loss,
            reason = "a place in the list"
        )]
        let pick = (uniform() * profiles.len() as f64) as usize;
        let known = profiles.get(pick)?;
        let reach_m = if uniform() < self.params.far_share { self.params.far_m } else { self.params.near_m };
        let away_m = reach_m * (2.0 * uniform() - 1.0);
        let window = self.shape.window(&known.levels, ruler, known.edge_m - away_m)?;
        Some((window, away_m / self.params.scale_m))
    }

    /// One step of Adam; takes the windows, returns the sum of their squared errors.
    fn step(&mut self, windows: &mut Vec<(DVector<f64>, f64)>, rate: f64, steps: i32) -> f64 {
        let share = 1.0 / f64::from(self.params.batch);
        let sum = windows.drain(..).map(|(window, away)| self.learn(&window, away, share).powi(2)).sum();
        self.hidden.step(rate, 0.0, steps);
        self.output.step(rate, 0.0, steps);
        sum
    }

    /// Adds a window's gradient, `dL/dy = share clamp(y - away)`, `tanh' = 1 - tanh^2`; returns `y - away`.
    fn learn(&mut self, window: &DVector<f64>, away: f64, share: f64) -> f64 {
        let signal = self.hidden.output(window).map(f64::tanh);
        let error = self.output.output(&signal)[0] - away;
        let pull = share * error.clamp(-self.params.pull_max, self.params.pull_max);
        let (inputs, units) = (window.len(), signal.len());
        let row = self.output.weights.row(0);
        let back = DVector::from_iterator(
            units,
            signal.iter().zip(row.iter()).map(|(signal, weight)| pull * weight * (1.0 - signal * signal)),
        );
        for (place, signal) in signal.iter().enumerate() {
            self.output.gradient[(0, place)] += pull * signal;
        }
        self.output.gradient[(0, units)] += pull;
        self.hidden.gradient.columns_mut(0, inputs).ger(1.0, &back, window, 1.0);
        self.hidden.gradient.column_mut(inputs).axpy(1.0, &back, 1.0);
        error
    }

    /// The network with the digits that its file will have, so that what is judged is what is written.
    fn model(&self) -> Result<EdgeModel, EdgeError> {
        let (inputs, units) = (self.params.inputs as usize, self.params.hidden as usize);
        let row = |row: usize| (0..inputs).map(|at| rounded(self.hidden.weights[(row, at)])).collect();
        EdgeModel::try_from(RawEdge {
            sha256: String::new(),
            format: FORMAT.to_owned(),
            trained: String::new(),
            from_m: self.params.from_m,
            step_m: self.params.step_m,
            scale_m: self.params.scale_m,
            contrast_min: self.params.contrast_min,
            hidden: (0..units).map(row).collect(),
            hidden_bias: (0..units).map(|at| rounded(self.hidden.weights[(at, inputs)])).collect(),
            output: (0..units).map(|at| rounded(self.output.weights[(0, at)])).collect(),
            output_bias: rounded(self.output.weights[(0, units)]),
        })
    }
}

/// What a network does on profiles whose edges are known, through the same search as in a print.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EdgeFigures {
    /// Cameras.
    pub looks: usize,
    /// Profiles of theirs.
    pub profiles: usize,
    /// Profiles in which an edge was found.
    pub located: usize,
    /// Mean of found less true `[m]`; not a number where none was found, as what follows.
    pub bias_m: f64,
    /// Standard deviation of found less true `[m]`.
    pub sd_m: f64,
    /// Least and largest of the cameras' own means `[m]`.
    pub bias_by_look_m: [f64; 2],
}

/// Judges a network, with the range of [`crate::width::RawWidth::range_rel`].
#[must_use]
pub fn judge(model: &EdgeModel, profiles: &[KnownEdge], ruler: &Ruler, range_rel: f64) -> EdgeFigures {
    let mut by_look: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for known in profiles {
        let errors = by_look.entry(known.look).or_default();
        let found = model.locate(&known.levels, ruler, (known.half_m, range_rel * known.half_m));
        errors.extend(found.map(|edge_m| edge_m - known.edge_m));
    }
    let all: Vec<f64> = by_look.values().flatten().copied().collect();
    let bias_m = mean(&all);
    let squares: Vec<f64> = all.iter().map(|error_m| (error_m - bias_m).powi(2)).collect();
    let own = || by_look.values().filter(|errors| !errors.is_empty()).map(|errors| mean(errors));
    EdgeFigures {
        looks: by_look.len(),
        profiles: profiles.len(),
        located: all.len(),
        bias_m,
        sd_m: mean(&squares).sqrt(),
        bias_by_look_m: [own().fold(f64::NAN, f64::min), own().fold(f64::NAN, f64::max)],
    }
}

#[expect(clippy::cast_precision_loss, reason = "a number of profiles")]
fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
