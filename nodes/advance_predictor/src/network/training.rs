//! Fitting a network: Adam (Kingma and Ba 2015) on the cross entropy of its one output, with decay of the weights.
//!
//! The target may be any number in `[0, 1]`: the cross entropy is least where the output equals it, so that the same
//! loss fits probabilities and shares of a range. Single thread, no clock; the same examples and seed give the same
//! file.

use super::chance::Stream;
use super::{Layer, RawLayer, Scaling};
use models::params::{ParamError, in_range};
use nalgebra::{DMatrix, DVector};
use serde::Deserialize;

/// Weights are written to this many significant digits.
const DIGITS: usize = 7;
/// Least spread of an input that is not constant.
const SPREAD_LEAST: f64 = 1e-9;
/// Adam's averages of gradient and squared gradient, and its floor: the paper's values.
const BETA: (f64, f64) = (0.9, 0.999);
const FLOOR: f64 = 1e-8;

/// One example.
#[derive(Debug, Clone, PartialEq)]
pub struct Example {
    /// Inputs before scaling.
    pub values: Vec<f64>,
    /// What the output should be `[-]`, `[0, 1]`.
    pub target: f64,
    /// Weight against other examples, above 0.
    pub weight: f64,
}

/// How a network is fitted. Built only from a valid [`RawFit`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawFit")]
pub struct FitParams(RawFit);

/// A fit's block as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawFit {
    /// Units of the hidden layers, first to last.
    pub hidden: Vec<u32>,
    /// Networks of the ensemble.
    pub members: u32,
    /// Passes over the examples.
    pub epochs: u32,
    /// Examples of a step.
    pub batch: u32,
    /// Length of the first steps; falls to zero along a cosine.
    pub rate: f64,
    /// Decay of the weights per unit of length.
    pub decay: f64,
    /// Scaled inputs are cut to this on either side.
    pub clip: f64,
}

impl TryFrom<RawFit> for FitParams {
    type Error = ParamError;

    fn try_from(raw: RawFit) -> Result<Self, ParamError> {
        #[expect(clippy::cast_precision_loss, reason = "a small count")]
        in_range("hidden", raw.hidden.len() as f64, "layers", (0.0, 2.0))?;
        for units in &raw.hidden {
            in_range("hidden", f64::from(*units), "units", (1.0, 256.0))?;
        }
        in_range("members", f64::from(raw.members), "-", (1.0, 64.0))?;
        in_range("epochs", f64::from(raw.epochs), "-", (1.0, 1e5))?;
        in_range("batch", f64::from(raw.batch), "examples", (1.0, 1e5))?;
        in_range("rate", raw.rate, "-", (1e-6, 1.0))?;
        in_range("decay", raw.decay, "-", (0.0, 1.0))?;
        in_range("clip", raw.clip, "-", (0.5, 100.0))?;
        Ok(Self(raw))
    }
}

impl FitParams {
    /// Networks of the ensemble.
    #[must_use]
    pub fn members(&self) -> u32 {
        self.0.members
    }

    /// Scaling by mean and standard deviation of the examples.
    pub(crate) fn scaling(&self, examples: &[Example]) -> Scaling {
        let inputs = examples.first().map_or(0, |example| example.values.len());
        let mut scaling = Scaling { centre: vec![], scale: vec![], clip: self.0.clip };
        for place in 0..inputs {
            let mean = mean(examples.iter().map(|example| example.values[place]));
            let square = self::mean(examples.iter().map(|example| (example.values[place] - mean).powi(2)));
            let spread = square.sqrt();
            scaling.centre.push(rounded(mean));
            scaling.scale.push(if spread > SPREAD_LEAST { rounded(spread) } else { 1.0 });
        }
        scaling
    }

    /// Fits one network to scaled examples.
    pub(crate) fn fit(&self, scaling: &Scaling, examples: &[Example], chance: &mut Stream) -> Vec<RawLayer> {
        let inputs: Vec<DVector<f64>> = examples.iter().map(|example| scaling.of(&example.values)).collect();
        let mut learner = Learner::new(scaling.centre.len(), &self.0.hidden, chance);
        learner.run(&inputs, examples, &self.0, chance);
        learner.layers.iter().map(Fitted::written).collect()
    }
}

/// Mean of a list, 0 of an empty one.
pub(crate) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

/// To seven significant digits.
pub(crate) fn rounded(value: f64) -> f64 {
    format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(value)
}

/// A layer with Adam's averages; the bias is the last column.
struct Fitted {
    weights: DMatrix<f64>,
    first: DMatrix<f64>,
    second: DMatrix<f64>,
}

impl Fitted {
    /// Weights evenly spread in `+-sqrt(6 / inputs)`, for ReLU (He et al. 2015), biases 0.
    fn new(inputs: usize, outputs: usize, chance: &mut Stream) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "a small count")]
        let reach = (6.0 / inputs as f64).sqrt();
        let zero = DMatrix::zeros(outputs, inputs + 1);
        let mut weights = zero.clone();
        for value in weights.columns_mut(0, inputs).iter_mut() {
            *value = reach * (2.0 * chance.uniform() - 1.0);
        }
        Self { weights, first: zero.clone(), second: zero }
    }

    fn step(&mut self, gradient: &DMatrix<f64>, (rate, decay): (f64, f64), steps: i32) {
        let bias = self.weights.ncols() - 1;
        let (one, two) = (1.0 - BETA.0.powi(steps), 1.0 - BETA.1.powi(steps));
        for column in 0..=bias {
            let decay = if column == bias { 0.0 } else { decay };
            for row in 0..self.weights.nrows() {
                let at = (row, column);
                self.first[at] = BETA.0 * self.first[at] + (1.0 - BETA.0) * gradient[at];
                self.second[at] = BETA.1 * self.second[at] + (1.0 - BETA.1) * gradient[at].powi(2);
                let way = (self.first[at] / one) / ((self.second[at] / two).sqrt() + FLOOR);
                self.weights[at] -= rate * (way + decay * self.weights[at]);
            }
        }
    }

    fn written(&self) -> RawLayer {
        let last = self.weights.ncols() - 1;
        let row = |row: usize| (0..last).map(|column| rounded(self.weights[(row, column)])).collect();
        RawLayer {
            weights: (0..self.weights.nrows()).map(row).collect(),
            bias: self.weights.column(last).iter().map(|value| rounded(*value)).collect(),
        }
    }

    fn layer(&self) -> Layer {
        let last = self.weights.ncols() - 1;
        Layer { weights: self.weights.columns(0, last).into(), bias: self.weights.column(last).into() }
    }
}

struct Learner {
    layers: Vec<Fitted>,
}

impl Learner {
    fn new(inputs: usize, hidden: &[u32], chance: &mut Stream) -> Self {
        let mut width = inputs;
        let mut layers = vec![];
        for units in hidden.iter().map(|units| *units as usize).chain([1]) {
            layers.push(Fitted::new(width, units, chance));
            width = units;
        }
        Self { layers }
    }

    fn run(&mut self, inputs: &[DVector<f64>], examples: &[Example], params: &RawFit, chance: &mut Stream) {
        let mut order: Vec<usize> = (0..inputs.len()).collect();
        let per_epoch = inputs.len().div_ceil(params.batch as usize);
        #[expect(clippy::cast_precision_loss, reason = "a count of steps")]
        let total = per_epoch as f64 * f64::from(params.epochs);
        let mut steps = 0;
        for _ in 0..params.epochs {
            chance.shuffle(&mut order);
            for batch in order.chunks(params.batch as usize) {
                let columns: Vec<_> = batch.iter().map(|index| inputs[*index].clone()).collect();
                let gradients = self.gradients(DMatrix::from_columns(&columns), batch, examples);
                steps += 1;
                let rate =
                    params.rate * 0.5 * (1.0 + (std::f64::consts::PI * f64::from(steps) / total).cos());
                for (layer, gradient) in self.layers.iter_mut().zip(&gradients) {
                    layer.step(gradient, (rate, params.decay), steps);
                }
            }
        }
    }

    /// Gradient of a batch: back propagation, `dL/dlogit = weight (p - target)`, the ReLU passes where it is open.
    fn gradients(&self, inputs: DMatrix<f64>, batch: &[usize], examples: &[Example]) -> Vec<DMatrix<f64>> {
        let layers: Vec<Layer> = self.layers.iter().map(Fitted::layer).collect();
        let mut signals = vec![inputs];
        for (place, layer) in layers.iter().enumerate() {
            let mut signal = &layer.weights * &signals[place];
            signal.column_iter_mut().for_each(|mut column| column += &layer.bias);
            if place + 1 < layers.len() {
                signal.apply(|value| *value = value.max(0.0));
            }
            signals.push(signal);
        }
        let weight: f64 = batch.iter().map(|index| examples[*index].weight).sum();
        let Some(mut back) = signals.pop() else { return vec![] };
        for (logit, index) in back.iter_mut().zip(batch) {
            let example = &examples[*index];
            *logit = (super::sigmoid(*logit) - example.target) * example.weight / weight;
        }
        let mut gradients = vec![];
        for (layer, input) in layers.iter().zip(&signals).rev() {
            let last = layer.weights.ncols();
            let mut gradient = DMatrix::zeros(layer.weights.nrows(), last + 1);
            gradient.columns_mut(0, last).gemm(1.0, &back, &input.transpose(), 0.0);
            gradient.column_mut(last).copy_from(&back.column_sum());
            gradients.push(gradient);
            back = layer.weights.tr_mul(&back);
            // The input of each layer but the first is a ReLU; what reaches the first is not used.
            back.zip_apply(input, |value, signal| *value = if signal > 0.0 { *value } else { 0.0 });
        }
        gradients.reverse();
        gradients
    }
}
