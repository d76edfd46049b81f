//! Fits an ensemble to test lines and its interval to lines that it has not seen.

use super::data::{DataParams, DataSet, Line, Use};
use super::ensemble::{Ensemble, inputs};
use super::file::{RawEnsemble, RawPolymerHull};
use super::measured::Measured;
use crate::network::chance::Stream;
use crate::network::training::{Example, FitParams, mean, rounded};
use crate::network::{NetworkError, refuse};
use models::advance::{Condition, Physics};

/// Share of the truth that the interval has to hold.
const COVERED: f64 = 0.95;
/// What rounding to the file's digits may take from the interval, relative.
const DIGITS: f64 = 1e-6;

/// What an ensemble is fitted with.
#[derive(Debug, Clone, Copy)]
pub struct Material<'a> {
    /// Physics that printed the lines.
    pub physics: &'a Physics,
    /// How the lines were made.
    pub data: &'a DataParams,
    /// The lines, scaled to the person's printer.
    pub set: &'a DataSet,
    /// A person's own lines; those of other drives are left out.
    pub measured: &'a [Measured],
    /// Weight of one of them against a virtual one.
    pub measured_weight: f64,
}

impl<'a> Material<'a> {
    /// The person's lines of this drive.
    fn own(&self) -> impl Iterator<Item = &'a Measured> {
        let drive = self.set.drive;
        self.measured.iter().filter(move |line| line.drive == drive)
    }
}

/// Fits an ensemble and returns its file.
///
/// # Errors
/// [`NetworkError`] for no examples, and measured lines of an unknown polymer or out of the drive's range.
pub fn train(material: &Material, fit: &FitParams, seed: u64) -> Result<String, NetworkError> {
    let drive = material.set.drive;
    let range_s = material.physics.drive(drive).advance_range_s;
    let names: Vec<&String> = material.physics.polymers.keys().collect();
    let examples = examples(material, &names, range_s)?;
    if examples.is_empty() {
        return Err(NetworkError::Examples);
    }
    let scaling = fit.scaling(&examples);
    let trained = format!(
        "fdm advance train: {} virtual and {} measured lines, seed {seed}",
        material.set.lines.iter().filter(|line| line.purpose == Use::Train).count(),
        material.own().count()
    );
    let mut raw = RawEnsemble::new(drive, &trained, range_s, &scaling);
    raw.polymers = material
        .physics
        .polymers
        .iter()
        .map(|(name, polymer)| RawPolymerHull { name: name.clone(), hull: material.data.hull(polymer) })
        .collect();
    let mut chance = Stream::new(seed);
    raw.members = (0..fit.members()).map(|_| fit.fit(&scaling, &examples, &mut chance)).collect();
    raw.measured = Some(material.own().count()).filter(|count| *count > 0);
    let ensemble = raw.check()?;
    (raw.floor_s, raw.factor) = interval(&ensemble, &material.set.calibration, material.own());
    raw.sealed()
}

fn examples(
    material: &Material,
    names: &[&String],
    [low_s, high_s]: [f64; 2],
) -> Result<Vec<Example>, NetworkError> {
    let example = |polymer: &str, at: &Condition, advance_s: f64, weight: f64| {
        let Some(place) = names.iter().position(|name| *name == polymer) else {
            return refuse("measured polymer", polymer, "one of config/advance/physics.yaml");
        };
        let target = (advance_s - low_s) / (high_s - low_s);
        if !(0.0..=1.0).contains(&target) {
            return refuse("advance_s", advance_s, format!("in [{low_s}, {high_s}]"));
        }
        Ok(Example { values: inputs(names.len(), place, at), target, weight })
    };
    let virtual_lines = material.set.lines.iter().filter(|line| line.purpose == Use::Train);
    let weight = material.measured_weight;
    virtual_lines
        .map(|line| example(&line.polymer, &line.at, line.scored_s, 1.0))
        .chain(material.own().map(|line| example(&line.polymer, &line.at, line.advance_s, weight)))
        .collect()
}

/// Floor of the standard deviation, the mean spread, and the factor with which `factor * hypot(spread, floor)` holds
/// the share [`COVERED`] of the errors against lines without noise, and of those against a person's own lines.
fn interval<'a>(ensemble: &Ensemble, lines: &[Line], own: impl Iterator<Item = &'a Measured>) -> (f64, f64) {
    let judged = |polymer: &str, at: &Condition, true_s: f64| {
        let place = ensemble.polymers.iter().position(|(name, _)| *name == polymer)?;
        let (advance_s, spread_s) = ensemble.mean_and_spread(place, at);
        Some(((advance_s - true_s).abs(), spread_s))
    };
    let of_lines: Vec<_> =
        lines.iter().filter_map(|line| judged(&line.polymer, &line.at, line.true_s)).collect();
    // Outside of the hull the networks are not asked.
    let inside = own.filter(|line| ensemble.hull(&line.polymer).is_some_and(|hull| hull.holds(&line.at)));
    let of_own: Vec<_> = inside.filter_map(|line| judged(&line.polymer, &line.at, line.advance_s)).collect();
    let floor_s = rounded(mean(of_lines.iter().map(|(_, spread_s)| *spread_s)).max(f64::MIN_POSITIVE));
    let factor = covering(&of_lines, floor_s).max((1.0 + DIGITS) * covering(&of_own, floor_s));
    (floor_s, rounded(factor.max(f64::MIN_POSITIVE)))
}

/// The factor that holds the share of errors; 0 for none. Of fewer than twenty it holds all.
fn covering(judged: &[(f64, f64)], floor_s: f64) -> f64 {
    let mut ratios: Vec<f64> =
        judged.iter().map(|(error_s, spread_s)| error_s / spread_s.hypot(floor_s)).collect();
    ratios.sort_by(f64::total_cmp);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "a place in the list"
    )]
    let place = (COVERED * ratios.len() as f64) as usize;
    ratios.get(place.min(ratios.len().saturating_sub(1))).copied().unwrap_or(0.0)
}
