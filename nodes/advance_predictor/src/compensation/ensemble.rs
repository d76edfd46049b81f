//! Networks that foretell `K_A` together, and the hull of what they were trained with.

use super::{Prediction, Source};
use crate::network::{Network, Scaling};
use models::advance::{Condition, DriveKind};
use models::units::{Celsius, Seconds};
use serde::{Deserialize, Serialize};

/// Ranges of the data of one polymer; the data are a full grid over them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hull {
    /// Temperatures `[degC]`.
    pub temperature_c: [f64; 2],
    /// Layer heights `[m]`.
    pub height_m: [f64; 2],
    /// Line widths `[m]`.
    pub width_m: [f64; 2],
}

/// Rounding that two writings of the same condition may differ by, relative.
const SAME: f64 = 1e-9;

/// What of a condition lies outside of a hull.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outside {
    /// What it is.
    pub field: &'static str,
    /// Its value and the hull's ends, in the unit.
    pub value: f64,
    /// See `value`.
    pub range: [f64; 2],
    /// Unit for people: degC or mm.
    pub unit: &'static str,
}

impl Hull {
    /// Whether a condition lies inside.
    #[must_use]
    pub fn holds(&self, at: &Condition) -> bool {
        self.outside(at).is_empty()
    }

    /// The condition inside that is nearest to another one.
    #[must_use]
    pub(super) fn nearest(&self, at: &Condition) -> Condition {
        let within = |[low, high]: [f64; 2], value: f64| value.max(low).min(high);
        Condition {
            temperature: Celsius(within(self.temperature_c, at.temperature.0)),
            height_m: within(self.height_m, at.height_m),
            width_m: within(self.width_m, at.width_m),
        }
    }

    /// What of a condition lies outside.
    #[must_use]
    pub fn outside(&self, at: &Condition) -> Vec<Outside> {
        // Without what rounding adds.
        let mm = |value_m: f64| (1e9 * value_m).round() / 1e6;
        let fields = [
            ("temperature", at.temperature.0, self.temperature_c, "degC"),
            ("layer height", mm(at.height_m), self.height_m.map(mm), "mm"),
            ("line width", mm(at.width_m), self.width_m.map(mm), "mm"),
        ];
        let outside = fields.into_iter().filter(|(_, value, [low, high], _)| {
            // A NaN is in no range.
            !(low * (1.0 - SAME)..=high * (1.0 + SAME)).contains(value)
        });
        outside.map(|(field, value, range, unit)| Outside { field, value, range, unit }).collect()
    }
}

/// An ensemble, whole and checked; made by [`Ensemble::parse`] alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Ensemble {
    pub(super) drive: DriveKind,
    /// What it was trained with, for people.
    pub(super) trained: String,
    pub(super) measured: usize,
    /// Names and hulls, in the order of the inputs.
    pub(super) polymers: Vec<(String, Hull)>,
    /// Range of the output `[s]`.
    pub(super) range_s: [f64; 2],
    pub(super) floor_s: f64,
    pub(super) factor: f64,
    pub(super) scaling: Scaling,
    pub(super) members: Vec<Network>,
}

/// Inputs beside those of the polymers.
pub(crate) const SHAPE: usize = 4;

/// Inputs of the networks: one per polymer, 1 for the one in use, then temperature `[degC]`, height and width `[m]`, and
/// `1/h` `[1/m]`, since the gap to the layer holds the melt back steeply.
pub(crate) fn inputs(polymers: usize, polymer: usize, at: &Condition) -> Vec<f64> {
    let mut values: Vec<f64> = (0..polymers).map(|place| f64::from(u8::from(place == polymer))).collect();
    let shape: [f64; SHAPE] = [at.temperature.0, at.height_m, at.width_m, 1.0 / at.height_m];
    values.extend(shape);
    values
}

impl Ensemble {
    /// Its drive.
    #[must_use]
    pub fn drive(&self) -> DriveKind {
        self.drive
    }

    /// What it was trained with, as its file says.
    #[must_use]
    pub fn trained(&self) -> &str {
        &self.trained
    }

    /// A person's own lines that it was trained with.
    #[must_use]
    pub fn measured(&self) -> usize {
        self.measured
    }

    /// The hull of a polymer's data; `None` for one that it was not trained with.
    #[must_use]
    pub fn hull(&self, polymer: &str) -> Option<&Hull> {
        self.polymers.iter().find(|(name, _)| name == polymer).map(|(_, hull)| hull)
    }

    /// Mean of the members with its interval; `None` outside of the hull.
    #[must_use]
    pub fn predict(&self, polymer: &str, at: &Condition) -> Option<Prediction> {
        let place = self.polymers.iter().position(|(name, _)| name == polymer)?;
        if !self.polymers[place].1.holds(at) {
            return None;
        }
        let (advance_s, spread_s) = self.mean_and_spread(place, at);
        Some(Prediction {
            advance: Seconds(advance_s),
            half_width: Seconds(self.factor * spread_s.hypot(self.floor_s)),
            source: Source::Network,
        })
    }

    /// Mean and standard deviation of the members `[s]`.
    pub(super) fn mean_and_spread(&self, polymer: usize, at: &Condition) -> (f64, f64) {
        let input = self.scaling.of(&inputs(self.polymers.len(), polymer, at));
        let [low_s, high_s] = self.range_s;
        let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
        for member in &self.members {
            let output = member.output(&input);
            sum += output;
            squares += output * output;
            count += 1.0;
        }
        let mean = sum / count;
        let spread = (squares / count - mean * mean).max(0.0).sqrt();
        (low_s + (high_s - low_s) * mean, (high_s - low_s) * spread)
    }
}
