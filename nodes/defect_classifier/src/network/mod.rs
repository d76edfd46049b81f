//! A small network over picture features: standardise, one or two tanh layers, softmax.
//!
//! `y_0 = clip((x - centre) / scale)`, `y_i = tanh(W_i y_{i-1} + b_i)`, `p = softmax(W_n y_{n-1} + b_n)`; model book 1.6.

mod file;
#[cfg(test)]
mod tests;
pub mod training;

pub use file::NetworkError;

use crate::features::{self, FeatureError, Hidden, Measured};
use models::quality::softmax_of;
use nalgebra::{DMatrix, DVector};
use opencv::core::Mat;

/// Name of the class that means "nothing is wrong"; the first class of every network.
pub const OK: &str = "ok";

/// A trained network, whole and checked; made by [`Network::parse`] alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Network {
    view: String,
    hidden: Hidden,
    classes: Vec<String>,
    /// For each input its place among [`features::names`].
    inputs: Vec<usize>,
    centre: DVector<f64>,
    scale: DVector<f64>,
    clip: f64,
    layers: Vec<Layer>,
}

/// One affine layer.
#[derive(Debug, Clone, PartialEq)]
struct Layer {
    /// One row per output.
    weights: DMatrix<f64>,
    bias: DVector<f64>,
}

/// What a network says of one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Scores {
    /// Softmax, one per class of [`Network::classes`], `[0, 1]`, sum 1; the first is `ok`.
    pub probabilities: Vec<f64>,
}

impl Scores {
    /// `p_det = 1 - p(ok)`, `[0, 1]` (model book 1.6).
    #[must_use]
    pub fn defect(&self) -> f64 {
        self.probabilities.first().map_or(0.0, |ok| (1.0 - ok).clamp(0.0, 1.0))
    }

    /// Index of the most probable class; the earliest of equal ones.
    #[must_use]
    pub fn best(&self) -> usize {
        let mut best = 0;
        for (class, probability) in self.probabilities.iter().enumerate() {
            if *probability > self.probabilities[best] {
                best = class;
            }
        }
        best
    }
}

/// Why a frame got no scores.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ClassifyError {
    /// The features could not be taken.
    #[error(transparent)]
    Features(#[from] FeatureError),
    /// The features lead to logits that are not finite.
    #[error("the network's outputs are not finite")]
    NotFinite,
}

impl Network {
    /// What the network is made to look at: `toolhead` or `photograph`.
    #[must_use]
    pub fn view(&self) -> &str {
        &self.view
    }

    /// The disc that the head hides in this view.
    #[must_use]
    pub fn hidden(&self) -> Hidden {
        self.hidden
    }

    /// Names of the classes; the first is [`OK`].
    #[must_use]
    pub fn classes(&self) -> &[String] {
        &self.classes
    }

    /// Scores of a frame: 8 bit, one channel. `measured` is what is known of it from elsewhere, or nothing.
    ///
    /// # Errors
    /// A picture that is empty or of another type; see [`ClassifyError`].
    pub fn classify(&self, grey: &Mat, measured: &Measured) -> Result<Scores, ClassifyError> {
        self.score(&features::extract(grey, self.hidden, measured)?)
    }

    /// Scores of features in the order of [`features::names`].
    ///
    /// # Errors
    /// Features of another length or not finite.
    pub fn score(&self, values: &[f64]) -> Result<Scores, ClassifyError> {
        if values.len() != features::names().len() {
            return Err(ClassifyError::NotFinite);
        }
        let logits = self.logits(values);
        let probabilities = softmax_of(logits.as_slice()).ok_or(ClassifyError::NotFinite)?;
        Ok(Scores { probabilities })
    }

    fn logits(&self, values: &[f64]) -> DVector<f64> {
        let picked = self.inputs.iter().enumerate().map(|(row, place)| {
            ((values[*place] - self.centre[row]) / self.scale[row]).clamp(-self.clip, self.clip)
        });
        let mut signal = DVector::from_iterator(self.inputs.len(), picked);
        for (place, layer) in self.layers.iter().enumerate() {
            signal = &layer.weights * signal + &layer.bias;
            if place + 1 < self.layers.len() {
                signal.apply(|value| *value = value.tanh());
            }
        }
        signal
    }
}
