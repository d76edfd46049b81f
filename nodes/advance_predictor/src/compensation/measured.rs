//! Lines that a person printed and scored, and how far the person's printer is from the physical model.

use super::data::DataParams;
use models::advance::{Condition, DriveKind, Physics};
use models::params::{ParamError, in_range};
use nalgebra::{Matrix4, Vector4};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One measured line.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Line of the person's file, from 1.
    pub row: usize,
    /// Drive.
    pub drive: DriveKind,
    /// Polymer, in capitals as in `config/advance/physics.yaml`.
    pub polymer: String,
    /// Condition.
    pub at: Condition,
    /// Best `K_A` of the pattern `[s]`.
    pub advance_s: f64,
}

/// How far printers are believed to be from the physical model. Built only from a valid [`RawPrior`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawPrior")]
pub struct Prior(RawPrior);

/// The block `measured_prior` of `config/models/advance_training.yaml` as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawPrior {
    /// Standard deviation of the factor about 1, of its logarithm `[-]`.
    pub factor: f64,
    /// The same of its change from the middle of the data to their edge, for each of temperature, height and width.
    pub slope: f64,
}

impl TryFrom<RawPrior> for Prior {
    type Error = ParamError;

    fn try_from(raw: RawPrior) -> Result<Self, ParamError> {
        in_range("measured_prior.factor", raw.factor, "-", (1e-3, 10.0))?;
        in_range("measured_prior.slope", raw.slope, "-", (1e-4, 10.0))?;
        Ok(Self(raw))
    }
}

/// Measured over physical model, a smooth factor for each polymer: `ln f = b0 + b1 T + b2 ln h + b3 ln w`, the conditions
/// from -1 to 1 over the polymer's data. Without a line of a polymer it is 1.
///
/// Being smooth and near 1 it leaves the physical model's trends as they are.
#[derive(Debug, Clone, PartialEq)]
pub struct Factor<'a> {
    physics: &'a Physics,
    data: &'a DataParams,
    weights: BTreeMap<&'a str, Vector4<f64>>,
    lines: usize,
}

impl<'a> Factor<'a> {
    /// The factor of one drive: the most probable one by the lines, their scores' noise and the prior about 1. Lines of
    /// other drives, and of polymers that the physics do not know, are left out.
    #[must_use]
    pub fn of(
        (physics, data): (&'a Physics, &'a DataParams),
        drive: DriveKind,
        measured: &[Measured],
        prior: &Prior,
    ) -> Self {
        let mut factor = Self { physics, data, weights: BTreeMap::new(), lines: 0 };
        let RawPrior { factor: middle, slope } = prior.0;
        let doubt = Vector4::new(middle, slope, slope, slope).map(|sigma| sigma.powi(-2));
        for name in physics.polymers.keys() {
            let (mut square, mut product) = (Matrix4::from_diagonal(&doubt), Vector4::zeros());
            for line in measured.iter().filter(|line| line.drive == drive && line.polymer == *name) {
                let (Some(place), Some(best)) =
                    (factor.place(name, &line.at), physics.best(drive, name, &line.at, data.step()))
                else {
                    continue;
                };
                // Of the logarithm: noise over the score.
                let weight = (line.advance_s / data.noise_s(drive)).powi(2);
                square += place * place.transpose() * weight;
                product += place * (line.advance_s / best.advance_s).ln() * weight;
                factor.lines += 1;
            }
            // Positive definite by the prior.
            factor.weights.extend(square.cholesky().map(|square| (name.as_str(), square.solve(&product))));
        }
        factor
    }

    /// Lines that it follows.
    #[must_use]
    pub fn lines(&self) -> usize {
        self.lines
    }

    /// The factor under a condition `[-]`.
    #[must_use]
    pub fn at(&self, polymer: &str, at: &Condition) -> f64 {
        let place = self.place(polymer, at).zip(self.weights.get(polymer));
        place.map_or(1.0, |(place, weights)| place.dot(weights).exp())
    }

    /// 1, and where a condition lies between the edges of the polymer's data, -1 and 1.
    fn place(&self, polymer: &str, at: &Condition) -> Option<Vector4<f64>> {
        let hull = self.data.hull(self.physics.polymers.get(polymer)?);
        let between = |[low, high]: [f64; 2], value: f64| (2.0 * value - low - high) / (high - low);
        let temperature = between(hull.temperature_c, at.temperature.0);
        let height = between(hull.height_m.map(f64::ln), at.height_m.ln());
        let width = between(hull.width_m.map(f64::ln), at.width_m.ln());
        Some(Vector4::new(1.0, temperature, height, width))
    }
}

/// Lines of one condition whose scores are farther apart than reading them explains.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Contradiction {
    /// Lines of the file, the least score's first.
    pub rows: [usize; 2],
    /// Their scores `[s]`.
    pub advance_s: [f64; 2],
}

/// Differences of two scores beyond this many standard deviations contradict each other.
const DEVIATIONS: f64 = 3.0;

/// Least and largest score of each condition of a drive that contradict each other.
#[must_use]
pub fn contradictions(data: &DataParams, drive: DriveKind, measured: &[Measured]) -> Vec<Contradiction> {
    let mut ends: BTreeMap<(&str, [u64; 3]), [&Measured; 2]> = BTreeMap::new();
    for line in measured.iter().filter(|line| line.drive == drive) {
        let at = [line.at.temperature.0, line.at.height_m, line.at.width_m].map(f64::to_bits);
        let [least, most] = ends.entry((&line.polymer, at)).or_insert([line; 2]);
        *least = if line.advance_s < least.advance_s { line } else { least };
        *most = if line.advance_s > most.advance_s { line } else { most };
    }
    let limit_s = DEVIATIONS * std::f64::consts::SQRT_2 * data.noise_s(drive);
    ends.into_values()
        .filter(|[least, most]| most.advance_s - least.advance_s > limit_s)
        .map(|pair| Contradiction { rows: pair.map(|line| line.row), advance_s: pair.map(|l| l.advance_s) })
        .collect()
}
