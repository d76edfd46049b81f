//! What network files have in common: their layers, checks that name the field, and a checksum of all that they say.

use super::training::Example;
use super::{Layer, Network};
use nalgebra::{DMatrix, DVector};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fmt::Write;

/// More layers than this are not "small".
const LAYERS_MAX: usize = 3;
/// Agreement of a probe: weights are written to seven digits, and a damaged one differs by far more.
const PROBE_TOLERANCE: f64 = 1e-9;

/// Why a network file was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// No JSON, a field missing, unknown or of another type: line and column are in the message.
    #[error("network file: {0}")]
    Json(#[from] serde_json::Error),
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
    /// Nothing to train with.
    #[error("no examples to train with")]
    Examples,
}

/// One layer as it is written: a row of weights per output.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawLayer {
    pub(crate) weights: Vec<Vec<f64>>,
    pub(crate) bias: Vec<f64>,
}

/// A file that carries a checksum of its own contents: a probe alone misses what its inputs leave at rest.
pub(crate) trait Sealed: Clone + Serialize + DeserializeOwned {
    /// The checksum's field, 64 hexadecimal digits.
    fn sha256(&mut self) -> &mut String;
}

/// Writes a file with its checksum.
pub(crate) fn seal<T: Sealed>(mut raw: T) -> Result<String, NetworkError> {
    raw.sha256().clear();
    let text = serde_json::to_string_pretty(&raw)? + "\n";
    // Of the numbers as they are read again: those of a long text may differ in their last bit.
    let checksum = digest(serde_json::from_str::<T>(&text)?)?;
    Ok(text.replacen("\"sha256\": \"\"", &format!("\"sha256\": \"{checksum}\""), 1))
}

/// Refuses a file whose contents are not those that were sealed; its layout does not matter.
pub(crate) fn check_seal<T: Sealed>(raw: &T) -> Result<(), NetworkError> {
    let mut raw = raw.clone();
    let written = std::mem::take(raw.sha256());
    let found = digest(raw)?;
    if written == found {
        Ok(())
    } else {
        refuse(
            "sha256",
            format!("'{written}'"),
            format!("{found} by the contents (damaged? fdm advance train)"),
        )
    }
}

fn digest<T: Sealed>(mut raw: T) -> Result<String, NetworkError> {
    raw.sha256().clear();
    Ok(hexadecimal(&Sha256::digest(serde_json::to_vec(&raw)?)))
}

/// Eight digits that tell two sets of examples apart, by values to the sixth decimal: the last bits are the machine's.
pub(crate) fn set_digest(examples: &[Example]) -> String {
    let mut sum = Sha256::new();
    for example in examples {
        for value in example.values.iter().chain([&example.target]) {
            sum.update(format!("{value:.6},"));
        }
    }
    hexadecimal(&sum.finalize()[..4])
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut text, byte| {
        // Writing to a string cannot fail.
        _ = write!(text, "{byte:02x}");
        text
    })
}

pub(crate) fn refuse<T>(
    field: impl Into<String>,
    found: impl ToString,
    wanted: impl Into<String>,
) -> Result<T, NetworkError> {
    Err(NetworkError::Field { field: field.into(), found: found.to_string(), wanted: wanted.into() })
}

pub(crate) fn length(field: &str, found: usize, wanted: usize) -> Result<(), NetworkError> {
    if found == wanted { Ok(()) } else { refuse(field, format!("{found} long"), format!("{wanted} long")) }
}

pub(crate) fn finite(field: &str, values: &[f64]) -> Result<(), NetworkError> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(place) => refuse(format!("{field}[{place}]"), values[place], "finite"),
        None => Ok(()),
    }
}

/// Whether a probe comes out of the weights as it is written.
pub(crate) fn agree(field: &str, written: f64, found: f64) -> Result<(), NetworkError> {
    // A NaN on either side fails this too.
    let agrees = (found - written).abs() <= PROBE_TOLERANCE * (1.0 + written.abs());
    if agrees { Ok(()) } else { refuse(field, written, format!("{found} by the weights")) }
}

impl Network {
    /// Checks sizes and values; `inputs` wide at the entrance, one output at the end.
    pub(crate) fn read(field: &str, inputs: usize, raw: &[RawLayer]) -> Result<Self, NetworkError> {
        if raw.is_empty() || raw.len() > LAYERS_MAX {
            return refuse(field, format!("{} long", raw.len()), format!("1 to {LAYERS_MAX} long"));
        }
        let mut width = inputs;
        let mut layers = vec![];
        for (place, raw) in raw.iter().enumerate() {
            let field = format!("{field}[{place}]");
            length(&format!("{field}.bias"), raw.bias.len(), raw.weights.len())?;
            finite(&format!("{field}.bias"), &raw.bias)?;
            for (row, weights) in raw.weights.iter().enumerate() {
                let field = format!("{field}.weights[{row}]");
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
        length(&format!("{field}: outputs of the last"), width, 1)?;
        Ok(Self { layers })
    }
}
