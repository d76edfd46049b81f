//! The file of the turn network: JSON, with a checksum that tells a damaged one and a probe that tells one which this
//! program would compute differently.

use super::watcher::INPUTS;
use crate::network::{
    Network, NetworkError, RawLayer, Scaling, Sealed, agree, check_seal, finite, length, refuse, seal,
};
use serde::{Deserialize, Serialize};

/// First field of every file.
const FORMAT: &str = "fdm_loop turn network";
/// Changes with the fields and with the meaning of an input.
const VERSION: u32 = 4;

/// A network, whole and checked; made by [`TurnNetwork::parse`] alone.
#[derive(Debug, Clone, PartialEq)]
pub struct TurnNetwork {
    network: Network,
    scaling: Scaling,
    threshold: f64,
    trained: String,
}

/// The file as it is written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawTurnNetwork {
    pub(super) format: String,
    pub(super) version: u32,
    /// What it was trained with, for people.
    pub(super) trained: String,
    /// Probability from which on a turn is foreseen.
    pub(super) threshold: f64,
    pub(super) centre: Vec<f64>,
    pub(super) scale: Vec<f64>,
    pub(super) clip: f64,
    pub(super) layers: Vec<RawLayer>,
    /// Logit at `x_i = centre_i + scale_i sin(i + 1)`.
    pub(super) probe: f64,
    /// Of all other fields.
    #[serde(default)]
    pub(super) sha256: String,
}

impl Sealed for RawTurnNetwork {
    fn sha256(&mut self) -> &mut String {
        &mut self.sha256
    }
}

impl TurnNetwork {
    /// Reads a file.
    ///
    /// # Errors
    /// [`NetworkError`] with the field.
    pub fn parse(text: &str) -> Result<Self, NetworkError> {
        let raw: RawTurnNetwork = serde_json::from_str(text)?;
        let network = raw.check()?;
        check_seal(&raw)?;
        agree("probe", raw.probe, network.probe())?;
        Ok(network)
    }

    /// Probability of a turn behind the buffer.
    pub(super) fn probability(&self, inputs: &[f64; INPUTS]) -> f64 {
        self.of(inputs)
    }

    pub(super) fn of(&self, inputs: &[f64]) -> f64 {
        self.network.output(&self.scaling.of(inputs))
    }

    /// Probability from which on a turn is foreseen.
    #[must_use]
    pub fn threshold(&self) -> f64 {
        self.threshold
    }

    /// What it was trained with, as its file says.
    #[must_use]
    pub fn trained(&self) -> &str {
        &self.trained
    }

    fn probe(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "a small count")]
        let value =
            |(place, (centre, scale)): (usize, (&f64, &f64))| centre + scale * ((place + 1) as f64).sin();
        let pairs = self.scaling.centre.iter().zip(&self.scaling.scale);
        let values: Vec<f64> = pairs.enumerate().map(value).collect();
        self.network.logit(&self.scaling.of(&values))
    }
}

impl RawTurnNetwork {
    pub(super) fn new(trained: &str, scaling: &Scaling, layers: Vec<RawLayer>) -> Self {
        Self {
            format: FORMAT.into(),
            version: VERSION,
            trained: trained.into(),
            threshold: 0.5,
            centre: scaling.centre.clone(),
            scale: scaling.scale.clone(),
            clip: scaling.clip,
            layers,
            probe: 0.0,
            sha256: String::new(),
        }
    }

    /// Writes the probe that belongs to the weights, and the checksum.
    pub(super) fn sealed(mut self) -> Result<String, NetworkError> {
        self.probe = self.check()?.probe();
        seal(self)
    }

    pub(super) fn check(&self) -> Result<TurnNetwork, NetworkError> {
        if self.format != FORMAT || self.version != VERSION {
            let found = format!("{} {}", self.format, self.version);
            return refuse("format", found, format!("{FORMAT} {VERSION}"));
        }
        length("centre", self.centre.len(), INPUTS)?;
        length("scale", self.scale.len(), INPUTS)?;
        finite("centre", &self.centre)?;
        finite("scale", &self.scale)?;
        if let Some(place) = self.scale.iter().position(|scale| *scale <= 0.0) {
            return refuse(format!("scale[{place}]"), self.scale[place], "above 0");
        }
        if !(self.clip.is_finite() && self.clip > 0.0) {
            return refuse("clip", self.clip, "above 0");
        }
        if !(0.0..=1.0).contains(&self.threshold) {
            return refuse("threshold", self.threshold, "in [0, 1]");
        }
        Ok(TurnNetwork {
            network: Network::read("layers", INPUTS, &self.layers)?,
            scaling: Scaling { centre: self.centre.clone(), scale: self.scale.clone(), clip: self.clip },
            threshold: self.threshold,
            trained: self.trained.clone(),
        })
    }
}
