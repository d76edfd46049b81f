//! `K_A` foretold: an ensemble of small networks inside the hull of its data, the physical model outside, scaled as a
//! person's own lines say.

pub mod assess;
pub mod calibration;
pub mod data;
mod ensemble;
mod file;
pub mod measured;
#[cfg(test)]
mod own_tests;
#[cfg(test)]
pub(crate) mod tests;
pub mod training;

pub use ensemble::{Ensemble, Hull, Outside};

use crate::network::{NetworkError, refuse};
use models::advance::{Condition, DriveKind, Physics};
use models::command::AdvanceLaw;
use models::extruder::StaticLaw;
use models::params::{ParamError, in_range, ordered};
use models::units::Seconds;
use serde::{Deserialize, Serialize};

/// Bounds of what is answered at all. Built only from a valid [`RawBounds`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawBounds")]
pub struct Bounds(RawBounds);

/// The block `bounds` as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawBounds {
    /// Temperatures that the physical model is asked for `[degC]`.
    pub temperature_c: [f64; 2],
    /// Layer heights `[m]`.
    pub height_m: [f64; 2],
    /// Line widths `[m]`.
    pub width_m: [f64; 2],
    /// Half width of its interval, relative to its answer `[-]`.
    pub physics_doubt: f64,
}

impl TryFrom<RawBounds> for Bounds {
    type Error = ParamError;

    fn try_from(raw: RawBounds) -> Result<Self, ParamError> {
        for value in raw.temperature_c {
            in_range("bounds.temperature_c", value, "degC", (100.0, 500.0))?;
        }
        for value in raw.height_m {
            in_range("bounds.height_m", value, "m", (1e-5, 5e-3))?;
        }
        for value in raw.width_m {
            in_range("bounds.width_m", value, "m", (1e-5, 1e-2))?;
        }
        let [low_c, high_c] = raw.temperature_c;
        ordered(("bounds.temperature_c[0]", low_c), ("bounds.temperature_c[1]", high_c))?;
        let [low_m, high_m] = raw.height_m;
        ordered(("bounds.height_m[0]", low_m), ("bounds.height_m[1]", high_m))?;
        let [low_m, high_m] = raw.width_m;
        ordered(("bounds.width_m[0]", low_m), ("bounds.width_m[1]", high_m))?;
        in_range("bounds.physics_doubt", raw.physics_doubt, "-", (0.0, 1.0))?;
        Ok(Self(raw))
    }
}

impl std::ops::Deref for Bounds {
    type Target = RawBounds;
    fn deref(&self) -> &RawBounds {
        &self.0
    }
}

impl Bounds {
    fn check(&self, at: &Condition) -> Result<(), Unanswered> {
        for (field, value, [low, high], unit) in [
            ("temperature", at.temperature.0, self.temperature_c, "degC"),
            ("layer height", at.height_m, self.height_m, "m"),
            ("line width", at.width_m, self.width_m, "m"),
        ] {
            // A NaN is in no range.
            if !(low..=high).contains(&value) {
                return Err(Unanswered::Bounds { field, value, low, high, unit });
            }
        }
        Ok(())
    }
}

/// Who answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// The ensemble, inside the hull of its data.
    Network,
    /// The physical model: the condition lies outside of the hull.
    Physics,
}

/// A `K_A` with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// `K_A`.
    pub advance: Seconds,
    /// Half width of the interval.
    pub half_width: Seconds,
    /// Who answered.
    pub source: Source,
}

/// Why there is no answer.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Unanswered {
    /// Neither network nor physics know the polymer.
    #[error("the polymer is unknown")]
    Polymer,
    /// A value that is not finite, or one that no printer prints at.
    #[error("{field} is {value} {unit}, must be in [{low}, {high}] {unit}")]
    Bounds {
        /// What is out of bounds.
        field: &'static str,
        /// Its value.
        value: f64,
        /// Least value that is answered.
        low: f64,
        /// Largest one.
        high: f64,
        /// Unit of all three.
        unit: &'static str,
    },
    /// The physical model's answer is none that such a drive can need.
    #[error("no answer: K {advance_s:.3} s by the physical model is outside of {low_s} to {high_s} s of a {} drive", .drive.name())]
    Range {
        /// Its answer `[s]`.
        advance_s: f64,
        /// Least that the drive can need `[s]`.
        low_s: f64,
        /// Largest `[s]`.
        high_s: f64,
        /// Drive.
        drive: DriveKind,
    },
}

/// Foretells `K_A` for one drive.
#[derive(Debug, Clone)]
pub struct Predictor {
    physics: Physics,
    bounds: Bounds,
    ensemble: Ensemble,
}

impl Predictor {
    /// A predictor; the ensemble's drive is the predictor's.
    ///
    /// # Errors
    /// [`NetworkError`] for networks that answer beyond the range of that drive.
    pub fn new(physics: Physics, bounds: Bounds, ensemble: Ensemble) -> Result<Self, NetworkError> {
        let ([low_s, high_s], [least_s, most_s]) =
            (physics.drive(ensemble.drive()).advance_range_s, ensemble.range_s);
        if least_s < low_s || most_s > high_s {
            let wanted = format!("within [{low_s}, {high_s}], advance_range_s of the drive");
            return refuse("range_s", format!("[{least_s}, {most_s}]"), wanted);
        }
        Ok(Self { physics, bounds, ensemble })
    }

    /// Its drive.
    #[must_use]
    pub fn drive(&self) -> DriveKind {
        self.ensemble.drive()
    }

    /// Its networks.
    #[must_use]
    pub fn ensemble(&self) -> &Ensemble {
        &self.ensemble
    }

    /// `K_A` of a polymer under a condition.
    ///
    /// # Errors
    /// [`Unanswered`] with the reason.
    pub fn predict(&self, polymer: &str, at: &Condition) -> Result<Prediction, Unanswered> {
        self.bounds.check(at)?;
        if let Some(foretold) = self.ensemble.predict(polymer, at) {
            return Ok(foretold);
        }
        let drive = self.drive();
        let physics_s = self.physics.secant_s(drive, polymer, at).ok_or(Unanswered::Polymer)?;
        let advance_s = physics_s * self.own_factor(polymer, at);
        let [low_s, high_s] = self.physics.drive(drive).advance_range_s;
        if !(low_s..=high_s).contains(&advance_s) {
            return Err(Unanswered::Range { advance_s, low_s, high_s, drive });
        }
        Ok(Prediction {
            advance: Seconds(advance_s),
            half_width: Seconds(advance_s * self.bounds.0.physics_doubt),
            source: Source::Physics,
        })
    }

    /// What the physical model is scaled by outside of the hull `[-]`: with a person's own lines the networks over it where
    /// the hull is nearest, so that no step lies at its edge; else 1.
    fn own_factor(&self, polymer: &str, at: &Condition) -> f64 {
        let hull = self.ensemble.hull(polymer).filter(|_| self.ensemble.measured() > 0);
        let factor = hull.map(|hull| hull.nearest(at)).and_then(|nearest| {
            let foretold = self.ensemble.predict(polymer, &nearest)?;
            Some(foretold.advance.0 / self.secant_s(polymer, &nearest)?)
        });
        factor.unwrap_or(1.0)
    }

    /// An answer as a law over the feed, see [`Physics::law`].
    #[must_use]
    pub fn law(&self, polymer: &str, at: &Condition, advance: Seconds) -> Option<AdvanceLaw> {
        self.physics.law(self.drive(), polymer, at, advance)
    }

    /// Static law and outlet speed over head speed of a condition; `None` for a polymer that is not known.
    pub(crate) fn static_law(&self, polymer: &str, at: &Condition) -> Option<(StaticLaw, f64)> {
        let drive = self.physics.drive(self.drive());
        Some((drive.law(self.physics.polymers.get(polymer)?, at), drive.outlet_m_s(at, 1.0)))
    }

    /// Lag of the test line by the physical model `[s]`.
    pub(crate) fn secant_s(&self, polymer: &str, at: &Condition) -> Option<f64> {
        self.physics.secant_s(self.drive(), polymer, at)
    }
}
