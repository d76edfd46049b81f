//! A small network: affine layers, ReLU between them, one output through a sigmoid.
//!
//! `y_i = max(0, W_i y_{i-1} + b_i)`, output `s(W_n y_{n-1} + b_n)` with `s(z) = 1/(1 + e^-z)`, as in [ADV].

pub mod chance;
mod file;
#[cfg(test)]
mod tests;
pub mod training;

pub use file::{NetworkError, RawLayer};
pub(crate) use file::{Sealed, agree, check_seal, finite, length, refuse, seal, set_digest};

use nalgebra::{DMatrix, DVector};

/// Layers with one output.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Network {
    pub(crate) layers: Vec<Layer>,
}

/// One affine layer.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Layer {
    /// One row per output.
    pub(crate) weights: DMatrix<f64>,
    pub(crate) bias: DVector<f64>,
}

impl Network {
    /// Output before the sigmoid.
    pub(crate) fn logit(&self, input: &DVector<f64>) -> f64 {
        let mut layers = self.layers.iter();
        let Some(first) = layers.next() else { return 0.0 };
        let mut signal = first.of(input);
        for layer in layers {
            signal.apply(|value| *value = value.max(0.0));
            signal = layer.of(&signal);
        }
        signal[0]
    }

    /// Output in `(0, 1)`.
    pub(crate) fn output(&self, input: &DVector<f64>) -> f64 {
        sigmoid(self.logit(input))
    }
}

impl Layer {
    fn of(&self, input: &DVector<f64>) -> DVector<f64> {
        let mut output = self.bias.clone();
        output.gemv(1.0, &self.weights, input, 1.0);
        output
    }
}

/// `1/(1 + e^-z)`.
pub(crate) fn sigmoid(logit: f64) -> f64 {
    1.0 / (1.0 + (-logit).exp())
}

/// How inputs are brought to a common scale: `clip((x - centre)/scale)`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Scaling {
    pub(crate) centre: Vec<f64>,
    pub(crate) scale: Vec<f64>,
    pub(crate) clip: f64,
}

impl Scaling {
    /// Inputs on the common scale; values of another length are cut or left out.
    pub(crate) fn of(&self, values: &[f64]) -> DVector<f64> {
        let scaled = values.iter().zip(self.centre.iter().zip(&self.scale));
        DVector::from_iterator(
            self.centre.len(),
            scaled.map(|(value, (centre, scale))| ((value - centre) / scale).clamp(-self.clip, self.clip)),
        )
    }
}
