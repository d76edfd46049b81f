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
    (raw.floor_s, raw.factor) = interval(&ensemble, material.set, material.own());
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

/// An error, the spread there and its weight.
type Judged = (f64, f64, f64);

/// Floor of the standard deviation, the mean spread, and the factor with which `factor * hypot(spread, floor)` holds
/// the share [`COVERED`] of the errors against lines without noise, half of them anywhere and half on the grid where it
/// gives some, and of those against a person's own lines.
fn interval<'a>(ensemble: &Ensemble, set: &DataSet, own: impl Iterator<Item = &'a Measured>) -> (f64, f64) {
    let judged = |polymer: &str, at: &Condition, true_s: f64| -> Option<Judged> {
        let place = ensemble.polymers.iter().position(|(name, _)| *name == polymer)?;
        let (advance_s, spread_s) = ensemble.mean_and_spread(place, at);
        Some(((advance_s - true_s).abs(), spread_s, 1.0))
    };
    let of_line = |line: &Line| judged(&line.polymer, &line.at, line.true_s);
    let anywhere: Vec<_> = set.calibration.iter().filter_map(of_line).collect();
    let on_grid = set.lines.iter().filter(|line| line.purpose == Use::Interval);
    let on_grid: Vec<_> = on_grid.filter_map(of_line).collect();
    #[expect(clippy::cast_precision_loss, reason = "counts of lines")]
    let weight = anywhere.len() as f64 / on_grid.len().max(1) as f64;
    let on_grid = on_grid.into_iter().map(|(error_s, spread_s, _)| (error_s, spread_s, weight));
    // Outside of the hull the networks are not asked.
    let inside = own.filter(|line| ensemble.hull(&line.polymer).is_some_and(|hull| hull.holds(&line.at)));
    let of_own: Vec<_> = inside.filter_map(|line| judged(&line.polymer, &line.at, line.advance_s)).collect();
    let floor_s = rounded(mean(anywhere.iter().map(|(_, spread_s, _)| *spread_s)).max(f64::MIN_POSITIVE));
    let virtuals: Vec<_> = anywhere.iter().copied().chain(on_grid).collect();
    let factor = covering(&virtuals, floor_s).max((1.0 + DIGITS) * covering(&of_own, floor_s));
    (floor_s, rounded(factor.max(f64::MIN_POSITIVE)))
}

/// The least factor that holds more than the share of the errors' weight, so that one more error lies within by that share
/// too; 0 for none. Of fewer than twenty of one weight it holds all.
fn covering(judged: &[Judged], floor_s: f64) -> f64 {
    let mut ratios: Vec<_> = judged
        .iter()
        .map(|(error_s, spread_s, weight)| (error_s / spread_s.hypot(floor_s), *weight))
        .collect();
    ratios.sort_by(|one, other| one.0.total_cmp(&other.0));
    let wanted = COVERED * ratios.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut held = 0.0;
    let place = ratios.iter().position(|(_, weight)| {
        held += weight;
        held > wanted
    });
    place.or(ratios.len().checked_sub(1)).map_or(0.0, |place| ratios[place].0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors(count: u32, weight: f64) -> impl Iterator<Item = Judged> {
        (1..=count).map(move |error| (f64::from(error), 0.0, weight))
    }

    /// Of 300 the 286th: 301 times 0.95 are 285.95. Of fewer than twenty the largest, of none nothing.
    #[test]
    fn the_quantile_is_that_of_one_error_more() {
        let factor = |count: u32| covering(&errors(count, 1.0).collect::<Vec<_>>(), 1.0);
        for (count, wanted) in [(300, 286.0), (20, 20.0), (19, 19.0), (1, 1.0), (0, 0.0)] {
            assert!((factor(count) - wanted).abs() < 1e-12, "{count}: {}", factor(count));
        }
    }

    /// 20 errors of 1 to 20 that weigh five each, 100 of a tenth that weigh one: the least that more than 190 of the 200 lie
    /// within is 19, for 18 holds exactly 190. Without weights 114 of 120 lie within 14.
    #[test]
    fn weights_count() {
        let small = || std::iter::repeat_n((0.1, 0.0, 1.0), 100);
        let factor = |weight: f64| covering(&errors(20, weight).chain(small()).collect::<Vec<_>>(), 1.0);
        for (weight, wanted) in [(5.0, 19.0), (1.0, 15.0)] {
            assert!((factor(weight) - wanted).abs() < 1e-12, "{weight}: {}", factor(weight));
        }
    }
}
