//! Where a road ends in a profile: a small network over grey levels, applied again around its own answer.
//!
//! No single feature marks the edge under every light: it lies near a dark valley whose place against the edge depends
//! on light, gloss and ground. The network sees the levels of a window around an assumed edge, their mean taken away
//! and their spread made one, and answers how far off the assumed edge is: `d = s (w_2 tanh(W_1 x + b_1) + b_2)`.
//! Moving the window by the answer and asking again makes the result independent of where it began.

#[cfg(test)]
mod tests;
pub mod training;

use super::profile::Ruler;
use crate::seal;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// First field of the file.
const FORMAT: &str = "fdm_loop road edge";
/// Times the window is moved.
const TURNS: usize = 4;
/// Most inputs and hidden units that count as small.
const SIZE_MAX: usize = 256;

/// Why an edge file was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EdgeError {
    /// Not the format.
    #[error("edge file: format is not '{FORMAT}'")]
    Format,
    /// JSON that cannot be read.
    #[error("edge file: {0}")]
    Json(String),
    /// Numbers that do not belong together, or are not finite.
    #[error("edge file: {0} cannot be")]
    Field(&'static str),
    /// Not the text that was sealed.
    #[error(
        "edge file: sha256 is '{written}', must be {found} by the contents (damaged? fdm classify --train-edge)"
    )]
    Damaged {
        /// What stands there.
        written: String,
        /// What has to.
        found: String,
    },
    /// Nothing to learn from.
    #[error("edge: no profile to learn from")]
    Profiles,
}

/// The file as it is written.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawEdge {
    format: String,
    /// Of everything else in the file.
    sha256: String,
    trained: String,
    from_m: f64,
    step_m: f64,
    scale_m: f64,
    hidden: Vec<Vec<f64>>,
    hidden_bias: Vec<f64>,
    output: Vec<f64>,
    output_bias: f64,
    /// Least fall of the levels from the road to the valley beside it, as a share of the road's `[-]`.
    contrast_min: f64,
}

/// The network, whole and checked; made by [`EdgeModel::parse`] alone.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeModel {
    from_m: f64,
    step_m: f64,
    scale_m: f64,
    hidden: DMatrix<f64>,
    hidden_bias: DVector<f64>,
    output: DVector<f64>,
    output_bias: f64,
    contrast_min: f64,
    trained: String,
}

impl EdgeModel {
    /// Reads an edge file.
    ///
    /// # Errors
    /// [`EdgeError`]
    pub fn parse(text: &str) -> Result<Self, EdgeError> {
        let raw: RawEdge = serde_json::from_str(text).map_err(|error| EdgeError::Json(error.to_string()))?;
        let (written, found) = (raw.sha256.clone(), seal::digest(text, &raw.sha256));
        let model = raw.try_into()?;
        if written == found { Ok(model) } else { Err(EdgeError::Damaged { written, found }) }
    }

    /// The same network, trained on what these words say.
    #[must_use]
    pub fn with_trained(mut self, trained: String) -> Self {
        self.trained = trained;
        self
    }

    /// The file of the network, a row of weights to a line.
    ///
    /// # Errors
    /// [`EdgeError::Json`], which numbers that were checked do not give.
    pub fn text(&self) -> Result<String, EdgeError> {
        fn json<T: Serialize + ?Sized>(value: &T) -> Result<String, EdgeError> {
            // A space after a comma, for people; no text passes here that could hold one.
            let text = serde_json::to_string(value).map_err(|error| EdgeError::Json(error.to_string()))?;
            Ok(text.replace(',', ", "))
        }
        let row = |row: usize| json(&self.hidden.row(row).iter().collect::<Vec<_>>());
        let rows = (0..self.hidden.nrows()).map(row).collect::<Result<Vec<_>, _>>()?;
        let fields = [
            ("format", serde_json::Value::from(FORMAT).to_string()),
            ("sha256", "\"\"".to_owned()),
            ("trained", serde_json::Value::from(self.trained.as_str()).to_string()),
            ("from_m", json(&self.from_m)?),
            ("step_m", json(&self.step_m)?),
            ("scale_m", json(&self.scale_m)?),
            ("contrast_min", json(&self.contrast_min)?),
            ("hidden", format!("[\n  {}\n ]", rows.join(",\n  "))),
            ("hidden_bias", json(self.hidden_bias.as_slice())?),
            ("output", json(self.output.as_slice())?),
            ("output_bias", json(&self.output_bias)?),
        ];
        let lines: Vec<String> = fields.iter().map(|(name, value)| format!(" \"{name}\": {value}")).collect();
        Ok(seal::sealed(&format!("{{\n{}\n}}\n", lines.join(",\n"))))
    }

    /// On what it was trained, in words.
    #[must_use]
    pub fn trained(&self) -> &str {
        &self.trained
    }

    /// Distances from the assumed edge that a window needs `[m]`: from, to.
    #[must_use]
    pub fn window_m(&self) -> (f64, f64) {
        #[expect(clippy::cast_precision_loss, reason = "at most SIZE_MAX")]
        let steps = self.hidden.ncols() as f64 - 1.0;
        (self.from_m, self.from_m + self.step_m * steps)
    }

    /// Distance of the edge from the centre line `[m]`, looked for around `start_m` and not farther than `range_m`
    /// from it; `None` where the profile is too short, or shows no edge: the answers do not settle, depend on where
    /// they began, or there is no valley beside the road. Without these checks bare ground would read as the width
    /// that was wanted.
    #[must_use]
    pub fn locate(&self, profile: &[f64], ruler: &Ruler, (start_m, range_m): (f64, f64)) -> Option<f64> {
        let mut edges_m = [0.0; 3];
        for (edge_m, share) in edges_m.iter_mut().zip([-0.4, 0.0, 0.4]) {
            *edge_m = self.settle(profile, ruler, (start_m, start_m + share * range_m, range_m))?;
        }
        edges_m.sort_by(f64::total_cmp);
        let [least_m, edge_m, most_m] = edges_m;
        let settled = most_m - least_m <= self.step_m;
        (settled && self.valley(profile, ruler, edge_m)?).then_some(edge_m)
    }

    /// The edge as found from one beginning.
    fn settle(
        &self,
        profile: &[f64],
        ruler: &Ruler,
        (middle_m, start_m, range_m): (f64, f64, f64),
    ) -> Option<f64> {
        let mut edge_m = start_m;
        for _ in 0..TURNS {
            edge_m =
                (edge_m + self.answer(profile, ruler, edge_m)?).clamp(middle_m - range_m, middle_m + range_m);
        }
        ((edge_m - middle_m).abs() < range_m).then_some(edge_m)
    }

    /// Whether the levels fall from the road to its edge by a share of themselves, as they do under any light.
    fn valley(&self, profile: &[f64], ruler: &Ruler, edge_m: f64) -> Option<bool> {
        let place = |away_m: f64| (edge_m + away_m - ruler.from_m) / ruler.step_m;
        let over = |from_m: f64, to_m: f64, pick: fn(f64, f64) -> f64| -> Option<f64> {
            let mut found = between(profile, place(from_m))?;
            let mut away_m = from_m;
            while away_m < to_m {
                away_m += self.step_m;
                found = pick(found, between(profile, place(away_m))?);
            }
            Some(found)
        };
        let road = over(8.0 * -self.step_m, -2.0 * self.step_m, f64::max)?;
        let valley = over(-self.step_m, 3.0 * self.step_m, f64::min)?;
        Some(road - valley >= self.contrast_min * road)
    }

    fn answer(&self, profile: &[f64], ruler: &Ruler, assumed_m: f64) -> Option<f64> {
        let window = self.window(profile, ruler, assumed_m)?;
        let signal = (&self.hidden * window + &self.hidden_bias).map(f64::tanh);
        Some(self.scale_m * (self.output.dot(&signal) + self.output_bias))
    }

    /// What the network sees around an assumed edge.
    fn window(&self, profile: &[f64], ruler: &Ruler, assumed_m: f64) -> Option<DVector<f64>> {
        let inputs = self.hidden.ncols();
        let mut window = DVector::zeros(inputs);
        let first = (assumed_m + self.from_m - ruler.from_m) / ruler.step_m;
        let step = self.step_m / ruler.step_m;
        #[expect(clippy::cast_precision_loss, reason = "at most SIZE_MAX")]
        for (place, value) in window.iter_mut().enumerate() {
            *value = between(profile, first + step * place as f64)?;
        }
        let mean = window.mean();
        window.add_scalar_mut(-mean);
        #[expect(clippy::cast_precision_loss, reason = "at most SIZE_MAX")]
        let spread = (window.norm_squared() / inputs as f64).sqrt();
        // Below one grey level there is nothing to see but noise.
        window /= spread.max(1.0);
        Some(window)
    }
}

impl TryFrom<RawEdge> for EdgeModel {
    type Error = EdgeError;

    fn try_from(raw: RawEdge) -> Result<Self, EdgeError> {
        if raw.format != FORMAT {
            return Err(EdgeError::Format);
        }
        let (units, inputs) = (raw.hidden.len(), raw.hidden.first().map_or(0, Vec::len));
        if !(1..=SIZE_MAX).contains(&units) || !(4..=SIZE_MAX).contains(&inputs) {
            return Err(EdgeError::Field("hidden"));
        }
        let even = raw.hidden.iter().all(|row| row.len() == inputs);
        if !even || raw.hidden_bias.len() != units || raw.output.len() != units {
            return Err(EdgeError::Field("the lengths of hidden, hidden_bias and output"));
        }
        let values: Vec<f64> = raw.hidden.into_iter().flatten().collect();
        let all =
            values.iter().chain(&raw.hidden_bias).chain(&raw.output).chain([&raw.output_bias, &raw.from_m]);
        if all.into_iter().any(|value| !value.is_finite()) {
            return Err(EdgeError::Field("a number that is not finite"));
        }
        if !(raw.step_m > 0.0 && raw.step_m.is_finite() && raw.scale_m > 0.0 && raw.scale_m.is_finite()) {
            return Err(EdgeError::Field("step_m or scale_m"));
        }
        if !(0.0..1.0).contains(&raw.contrast_min) {
            return Err(EdgeError::Field("contrast_min"));
        }
        Ok(Self {
            from_m: raw.from_m,
            step_m: raw.step_m,
            scale_m: raw.scale_m,
            hidden: DMatrix::from_row_slice(units, inputs, &values),
            hidden_bias: DVector::from_vec(raw.hidden_bias),
            output: DVector::from_vec(raw.output),
            output_bias: raw.output_bias,
            contrast_min: raw.contrast_min,
            trained: raw.trained,
        })
    }
}

/// Value between two samples, linearly.
fn between(profile: &[f64], place: f64) -> Option<f64> {
    if !(0.0..1e5).contains(&place) {
        return None;
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked just above")]
    let left = place as usize;
    let share = place - place.floor();
    Some(profile.get(left)? * (1.0 - share) + profile.get(left + 1)? * share)
}
