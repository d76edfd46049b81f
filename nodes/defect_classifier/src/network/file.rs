//! The file of a network: JSON, with everything that inference needs, a probe that the weights have to give again, and a
//! checksum.

use super::{Layer, Network, OK};
use crate::{features, seal};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// First field of every network file.
const FORMAT: &str = "fdm_loop network";
/// Changes with the meaning of a field.
const VERSION: u32 = 1;
/// More layers than this are not "small".
const LAYERS_MAX: usize = 3;
/// Agreement of the probe's logits: weights are written to seven digits, and a damaged one differs by far more.
const PROBE_TOLERANCE: f64 = 1e-9;

/// Why a network file was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// No JSON, a field missing, unknown or of another type: line and column are in the message.
    #[error("network file: {0}")]
    Json(#[from] serde_json::Error),
    /// Nothing to train with, or examples of other features than this build's.
    #[error("no examples, or examples with other features than this build's")]
    Examples,
    /// A field whose value cannot be.
    #[error("network file: {field} is {found}, must be {wanted}")]
    Field {
        /// Path of the field.
        field: String,
        /// What stands there.
        found: String,
        /// What has to.
        wanted: String,
    },
}

/// The file as it is written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawNetwork {
    pub(crate) format: String,
    pub(crate) version: u32,
    /// Of everything else in the file.
    pub(crate) sha256: String,
    pub(crate) view: String,
    /// Radius of the disc that the head hides, as share of the picture's height.
    pub(crate) hidden_share: f64,
    pub(crate) trained: String,
    pub(crate) classes: Vec<String>,
    pub(crate) inputs: Vec<String>,
    pub(crate) centre: Vec<f64>,
    pub(crate) scale: Vec<f64>,
    pub(crate) clip: f64,
    pub(crate) layers: Vec<RawLayer>,
    /// Logits of the features `f_i = centre_i + scale_i sin(i + 1)`.
    pub(crate) probe: Vec<f64>,
}

/// One layer as it is written: a row of weights per output.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawLayer {
    pub(crate) weights: Vec<Vec<f64>>,
    pub(crate) bias: Vec<f64>,
}

fn refuse<T>(
    field: impl Into<String>,
    found: impl ToString,
    wanted: impl Into<String>,
) -> Result<T, NetworkError> {
    Err(NetworkError::Field { field: field.into(), found: found.to_string(), wanted: wanted.into() })
}

fn length(field: &str, found: usize, wanted: usize) -> Result<(), NetworkError> {
    if found == wanted { Ok(()) } else { refuse(field, format!("{found} long"), format!("{wanted} long")) }
}

fn finite(field: &str, values: &[f64]) -> Result<(), NetworkError> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(place) => refuse(format!("{field}[{place}]"), values[place], "finite"),
        None => Ok(()),
    }
}

impl Network {
    /// Reads a network file.
    ///
    /// # Errors
    /// [`NetworkError`] with the field: other format, sizes that do not fit, unknown features, values that are not
    /// finite, a probe that does not come out as written, and a text that is not the one that was sealed.
    pub fn parse(text: &str) -> Result<Self, NetworkError> {
        let raw: RawNetwork = serde_json::from_str(text)?;
        let (written, found) = (raw.sha256.clone(), seal::digest(text, &raw.sha256));
        let network = Self::try_from(raw)?;
        if written == found {
            Ok(network)
        } else {
            let wanted = format!("{found} by the contents (damaged? fdm classify --train)");
            refuse("sha256", format!("'{written}'"), wanted)
        }
    }

    /// Features that the probe is taken with.
    fn probe(&self) -> Vec<f64> {
        let mut values = vec![0.0; features::names().len()];
        for (row, place) in self.inputs.iter().enumerate() {
            #[expect(clippy::cast_precision_loss, reason = "a small count")]
            let angle_rad = (row + 1) as f64;
            values[*place] = self.centre[row] + self.scale[row] * angle_rad.sin();
        }
        values
    }
}

impl RawNetwork {
    /// The head of a file: everything but what training finds.
    pub(crate) fn named(view: &str, trained: &str, classes: &[&str]) -> Self {
        Self {
            format: FORMAT.into(),
            version: VERSION,
            sha256: String::new(),
            view: view.into(),
            hidden_share: 0.0,
            trained: trained.into(),
            classes: classes.iter().map(|&class| class.to_owned()).collect(),
            inputs: vec![],
            centre: vec![],
            scale: vec![],
            clip: 0.0,
            layers: vec![],
            probe: vec![],
        }
    }

    /// Writes the probe that belongs to the weights.
    pub(crate) fn sealed(mut self) -> Result<Self, NetworkError> {
        let network = self.check()?;
        self.probe = network.logits(&network.probe()).iter().copied().collect();
        Ok(self)
    }

    fn check(&self) -> Result<Network, NetworkError> {
        if self.format != FORMAT || self.version != VERSION {
            return refuse(
                "format",
                format!("{} {}", self.format, self.version),
                format!("{FORMAT} {VERSION}"),
            );
        }
        if self.classes.len() < 2 || self.classes[0] != OK {
            return refuse("classes", self.classes.join(", "), "two or more, the first 'ok'");
        }
        if !(0.0..=0.5).contains(&self.hidden_share) {
            return refuse("hidden_share", self.hidden_share, "in [0, 0.5]");
        }
        length("centre", self.centre.len(), self.inputs.len())?;
        length("scale", self.scale.len(), self.inputs.len())?;
        finite("centre", &self.centre)?;
        finite("scale", &self.scale)?;
        if let Some(place) = self.scale.iter().position(|scale| *scale <= 0.0) {
            return refuse(format!("scale[{place}]"), self.scale[place], "above 0");
        }
        if !(self.clip.is_finite() && self.clip > 0.0) {
            return refuse("clip", self.clip, "above 0");
        }
        Ok(Network {
            view: self.view.clone(),
            hidden: features::Hidden(self.hidden_share),
            classes: self.classes.clone(),
            inputs: self.places()?,
            centre: DVector::from_column_slice(&self.centre),
            scale: DVector::from_column_slice(&self.scale),
            clip: self.clip,
            layers: self.layers()?,
        })
    }

    /// Each input's place among the features that this build computes.
    pub(crate) fn places(&self) -> Result<Vec<usize>, NetworkError> {
        let known = features::names();
        let place = |(row, name): (usize, &String)| match known.iter().position(|known| known == name) {
            Some(place) => Ok(place),
            None => refuse(format!("inputs[{row}]"), name, "a feature of this build"),
        };
        self.inputs.iter().enumerate().map(place).collect()
    }

    fn layers(&self) -> Result<Vec<Layer>, NetworkError> {
        if self.layers.is_empty() || self.layers.len() > LAYERS_MAX {
            return refuse(
                "layers",
                format!("{} long", self.layers.len()),
                format!("1 to {LAYERS_MAX} long"),
            );
        }
        let mut width = self.inputs.len();
        let mut layers = vec![];
        for (place, raw) in self.layers.iter().enumerate() {
            length(&format!("layers[{place}].bias"), raw.bias.len(), raw.weights.len())?;
            finite(&format!("layers[{place}].bias"), &raw.bias)?;
            for (row, weights) in raw.weights.iter().enumerate() {
                let field = format!("layers[{place}].weights[{row}]");
                length(&field, weights.len(), width)?;
                finite(&field, weights)?;
            }
            let flat = raw.weights.iter().flatten().copied();
            layers.push(Layer {
                weights: DMatrix::from_row_iterator(raw.weights.len(), width, flat),
                bias: DVector::from_column_slice(&raw.bias),
            });
            width = raw.weights.len();
        }
        length("layers: outputs of the last", width, self.classes.len())?;
        Ok(layers)
    }
}

impl TryFrom<RawNetwork> for Network {
    type Error = NetworkError;

    fn try_from(raw: RawNetwork) -> Result<Self, NetworkError> {
        let network = raw.check()?;
        length("probe", raw.probe.len(), network.classes.len())?;
        let logits = network.logits(&network.probe());
        for (place, (found, written)) in logits.iter().zip(&raw.probe).enumerate() {
            // A NaN on either side fails this too.
            let agrees = (found - written).abs() <= PROBE_TOLERANCE * (1.0 + written.abs());
            if !agrees {
                return refuse(format!("probe[{place}]"), written, format!("{found} by the weights"));
            }
        }
        Ok(network)
    }
}
