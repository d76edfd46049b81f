//! Fitting a network: Adam (Kingma and Ba 2015) on the weighted cross entropy with decay of the weights.
//!
//! Single thread, no clock; chance comes from the caller's stream, so the same examples and stream give the same file.

use super::file::{NetworkError, RawLayer, RawNetwork};
use crate::{features, seal};
use models::params::{ParamError, in_range, positive};
use nalgebra::{DMatrix, DVector};
use serde::Deserialize;

/// Weights are written to this many significant digits.
const DIGITS: usize = 7;
/// Least spread of a feature that is not constant.
const SPREAD_LEAST: f64 = 1e-6;
/// Adam's averages of gradient and squared gradient, and its floor: the paper's values.
const BETA: (f64, f64) = (0.9, 0.999);
const FLOOR: f64 = 1e-8;

/// One labelled example.
#[derive(Debug, Clone, PartialEq)]
pub struct Labelled {
    /// Features in the order of [`features::names`].
    pub values: Vec<f64>,
    /// Index of its class.
    pub class: usize,
    /// Weight against other examples, above 0.
    pub weight: f64,
}

/// How a network is fitted. Built only from a valid [`RawFit`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawFit")]
pub struct FitParams(RawFit);

/// The block `fit` of `config/models/training.yaml` as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawFit {
    /// Units of the hidden layers, first to last; none gives logistic regression.
    pub hidden: Vec<u32>,
    /// Passes over the examples.
    pub epochs: u32,
    /// Examples of a step.
    pub batch: u32,
    /// Length of the first steps; falls to zero along a cosine.
    pub rate: f64,
    /// Decay of the weights per unit of length.
    pub decay: f64,
    /// Standard deviation of the noise that each step adds to the standardised features.
    pub jitter: f64,
    /// Standardised features are cut to this on either side.
    pub clip: f64,
}

impl TryFrom<RawFit> for FitParams {
    type Error = ParamError;

    fn try_from(raw: RawFit) -> Result<Self, ParamError> {
        in_range("fit.hidden", raw.hidden.len() as f64, "layers", (0.0, 2.0))?;
        for units in &raw.hidden {
            in_range("fit.hidden", f64::from(*units), "units", (1.0, 1024.0))?;
        }
        in_range("fit.epochs", f64::from(raw.epochs), "-", (1.0, 1e5))?;
        in_range("fit.batch", f64::from(raw.batch), "examples", (1.0, 1e5))?;
        positive("fit.rate", raw.rate, "-")?;
        in_range("fit.decay", raw.decay, "-", (0.0, 1.0))?;
        in_range("fit.jitter", raw.jitter, "-", (0.0, 2.0))?;
        positive("fit.clip", raw.clip, "-")?;
        Ok(Self(raw))
    }
}

/// What a network is for, beside its examples.
#[derive(Debug, Clone, Copy)]
pub struct Purpose<'a> {
    /// `toolhead` or `photograph`.
    pub view: &'a str,
    /// The disc that the head hides in the pictures.
    pub hidden: features::Hidden,
    /// What it was trained with, for people.
    pub trained: &'a str,
    /// Names of the classes, `ok` first.
    pub classes: &'a [&'a str],
    /// Names of the features it takes.
    pub inputs: &'a [&'a str],
}

/// Fits a network and returns its file; `uniform` yields numbers from `[0, 1)`.
///
/// # Errors
/// [`NetworkError`] for unknown inputs, wrong classes, and no examples.
pub fn fit(
    purpose: &Purpose,
    examples: &[Labelled],
    params: &FitParams,
    uniform: &mut dyn FnMut() -> f64,
) -> Result<String, NetworkError> {
    let mut raw = RawNetwork::named(purpose.view, purpose.trained, purpose.classes);
    raw.inputs = purpose.inputs.iter().map(|&name| name.to_owned()).collect();
    raw.clip = params.0.clip;
    raw.hidden_share = purpose.hidden.0;
    let places = raw.places()?;
    if examples.is_empty() || examples.iter().any(|example| example.values.len() != features::COUNT) {
        return Err(NetworkError::Examples);
    }
    for place in places {
        let mean = examples.iter().map(|example| example.values[place]).sum::<f64>() / examples.len() as f64;
        let square = examples.iter().map(|example| (example.values[place] - mean).powi(2)).sum::<f64>();
        let spread = (square / examples.len() as f64).sqrt();
        raw.centre.push(rounded(mean));
        raw.scale.push(if spread > SPREAD_LEAST { rounded(spread) } else { 1.0 });
    }
    let inputs: Vec<DVector<f64>> = {
        let places = raw.places()?;
        let standard = |example: &Labelled| {
            DVector::from_iterator(
                places.len(),
                places.iter().enumerate().map(|(row, place)| {
                    ((example.values[*place] - raw.centre[row]) / raw.scale[row]).clamp(-raw.clip, raw.clip)
                }),
            )
        };
        examples.iter().map(standard).collect()
    };
    let mut learner = Learner::new(raw.inputs.len(), &params.0.hidden, raw.classes.len(), uniform);
    learner.run(&inputs, examples, &params.0, uniform);
    raw.layers = learner.layers.iter().map(Fitted::written).collect();
    Ok(seal::sealed(&serde_json::to_string_pretty(&raw.sealed()?)?))
}

/// To [`DIGITS`] significant digits.
pub(crate) fn rounded(value: f64) -> f64 {
    format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(value)
}

/// A layer with Adam's averages; the bias is the last column.
pub(crate) struct Fitted {
    pub(crate) weights: DMatrix<f64>,
    first: DMatrix<f64>,
    second: DMatrix<f64>,
    pub(crate) gradient: DMatrix<f64>,
}

impl Fitted {
    /// Weights evenly spread in `+-sqrt(6 / (inputs + outputs))` (Glorot and Bengio 2010), biases 0.
    pub(crate) fn new(inputs: usize, outputs: usize, uniform: &mut dyn FnMut() -> f64) -> Self {
        let reach = (6.0 / (inputs + outputs) as f64).sqrt();
        let zero = DMatrix::zeros(outputs, inputs + 1);
        let mut weights = zero.clone();
        for value in weights.columns_mut(0, inputs).iter_mut() {
            *value = reach * (2.0 * uniform() - 1.0);
        }
        Self { weights, first: zero.clone(), second: zero.clone(), gradient: zero }
    }

    pub(crate) fn output(&self, input: &DVector<f64>) -> DVector<f64> {
        let last = self.weights.ncols() - 1;
        self.weights.columns(0, last) * input + self.weights.column(last)
    }

    pub(crate) fn step(&mut self, rate: f64, decay: f64, steps: i32) {
        let last = self.weights.ncols() - 1;
        let (one, two) = (1.0 - BETA.0.powi(steps), 1.0 - BETA.1.powi(steps));
        for column in 0..=last {
            let decay = if column == last { 0.0 } else { decay };
            for row in 0..self.weights.nrows() {
                let at = (row, column);
                let gradient = self.gradient[at];
                self.first[at] = BETA.0 * self.first[at] + (1.0 - BETA.0) * gradient;
                self.second[at] = BETA.1 * self.second[at] + (1.0 - BETA.1) * gradient * gradient;
                let way = (self.first[at] / one) / ((self.second[at] / two).sqrt() + FLOOR);
                self.weights[at] -= rate * (way + decay * self.weights[at]);
            }
        }
        self.gradient.fill(0.0);
    }

    fn written(&self) -> RawLayer {
        let last = self.weights.ncols() - 1;
        let row = |row: usize| (0..last).map(|column| rounded(self.weights[(row, column)])).collect();
        RawLayer {
            weights: (0..self.weights.nrows()).map(row).collect(),
            bias: self.weights.column(last).iter().map(|value| rounded(*value)).collect(),
        }
    }
}

struct Learner {
    layers: Vec<Fitted>,
}

impl Learner {
    fn new(inputs: usize, hidden: &[u32], outputs: usize, uniform: &mut dyn FnMut() -> f64) -> Self {
        let mut width = inputs;
        let mut layers = vec![];
        for units in hidden.iter().map(|units| *units as usize).chain([outputs]) {
            layers.push(Fitted::new(width, units, uniform));
            width = units;
        }
        Self { layers }
    }

    fn run(
        &mut self,
        inputs: &[DVector<f64>],
        examples: &[Labelled],
        params: &RawFit,
        uniform: &mut dyn FnMut() -> f64,
    ) {
        let mut order: Vec<usize> = (0..inputs.len()).collect();
        let per_epoch = inputs.len().div_ceil(params.batch as usize);
        let total = per_epoch as f64 * f64::from(params.epochs);
        let mut steps = 0;
        for _ in 0..params.epochs {
            shuffle(&mut order, uniform);
            for batch in order.chunks(params.batch as usize) {
                let weight: f64 = batch.iter().map(|index| examples[*index].weight).sum();
                for index in batch {
                    let mut input = inputs[*index].clone();
                    input.apply(|value| *value += params.jitter * normal(uniform));
                    let example = &examples[*index];
                    self.learn(input, example.class, example.weight / weight);
                }
                steps += 1;
                let rate =
                    params.rate * 0.5 * (1.0 + (std::f64::consts::PI * f64::from(steps) / total).cos());
                self.layers.iter_mut().for_each(|layer| layer.step(rate, params.decay, steps));
            }
        }
    }

    /// Adds an example's gradient: back propagation, `dL/dlogit = weight (p - 1[class])`, `tanh' = 1 - tanh^2`.
    fn learn(&mut self, input: DVector<f64>, class: usize, weight: f64) {
        let mut signals = vec![input];
        for (place, layer) in self.layers.iter().enumerate() {
            let mut signal = layer.output(&signals[place]);
            if place + 1 < self.layers.len() {
                signal.apply(|value| *value = value.tanh());
            }
            signals.push(signal);
        }
        let Some(logits) = signals.pop() else { return };
        let Some(shares) = models::quality::softmax_of(logits.as_slice()) else { return };
        let mut back = DVector::from_vec(shares);
        back[class] -= 1.0;
        back *= weight;
        for (layer, input) in self.layers.iter_mut().zip(&signals).rev() {
            let last = layer.weights.ncols() - 1;
            layer.gradient.columns_mut(0, last).ger(1.0, &back, input, 1.0);
            layer.gradient.column_mut(last).axpy(1.0, &back, 1.0);
            back = layer.weights.columns(0, last).tr_mul(&back);
            // The input of each layer but the first is a tanh; what reaches the first is not used.
            back.zip_apply(input, |value, signal| *value *= 1.0 - signal * signal);
        }
    }
}

/// Fisher and Yates.
fn shuffle(order: &mut [usize], uniform: &mut dyn FnMut() -> f64) {
    for last in (1..order.len()).rev() {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place in the list")]
        let pick = (uniform() * (last + 1) as f64) as usize;
        order.swap(last, pick.min(last));
    }
}

/// Box and Muller.
fn normal(uniform: &mut dyn FnMut() -> f64) -> f64 {
    let radius = (-2.0 * (1.0 - uniform()).ln()).sqrt();
    radius * (std::f64::consts::TAU * uniform()).cos()
}
