//! Fits the turn network to the moments at which the buffer ends too early.

use super::curves::generate;
use super::file::{RawTurnNetwork, TurnNetwork};
use super::params::TurnParams;
use super::path::Piece;
use super::samples::Track;
use super::splines;
use crate::network::NetworkError;
use crate::network::chance::Stream;
use crate::network::training::{Example, FitParams};
use models::params::{ParamError, in_range};
use serde::Deserialize;

/// How the network is trained. Built only from a valid [`RawTraining`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawTraining")]
pub struct Training(RawTraining);

/// The block `turn` of `config/models/advance_training.yaml` as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawTraining {
    /// Moves that the buffer holds behind the current one; each is trained with.
    pub buffers: Vec<u32>,
    /// Moments of one path with one buffer at most, taken by chance.
    pub moments_max: u32,
    /// Made-up outlines in short pieces.
    pub made_paths: u32,
    /// Made-up chains of splines.
    pub made_splines: u32,
    /// Fit.
    pub fit: FitParams,
}

impl TryFrom<RawTraining> for Training {
    type Error = ParamError;

    fn try_from(raw: RawTraining) -> Result<Self, ParamError> {
        for buffered in &raw.buffers {
            in_range("turn.buffers", f64::from(*buffered), "-", (0.0, 1000.0))?;
        }
        in_range("turn.moments_max", f64::from(raw.moments_max), "-", (1.0, 1e7))?;
        in_range("turn.made_paths", f64::from(raw.made_paths), "-", (0.0, 1e5))?;
        in_range("turn.made_splines", f64::from(raw.made_splines), "-", (0.0, 1e5))?;
        Ok(Self(raw))
    }
}

impl Training {
    /// Buffers to train with.
    #[must_use]
    pub fn buffers(&self) -> &[u32] {
        &self.0.buffers
    }

    /// Made-up paths of a seed, each with every buffer.
    #[must_use]
    pub fn made(&self, seed: u64) -> Vec<Path> {
        let mut chance = Stream::new(seed);
        let outlines = generate(self.0.made_paths, &mut chance);
        let splines = splines::generate(self.0.made_splines, &mut chance);
        let paths = |pieces: Vec<Piece>| {
            self.0.buffers.iter().map(move |buffered| Path { buffered: *buffered, pieces: pieces.clone() })
        };
        paths(outlines).chain(paths(splines)).collect()
    }
}

/// A path as a printer sees it that knows so many moves behind the current one: its speeds are planned with them alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// Moves known behind the current one.
    pub buffered: u32,
    /// The path.
    pub pieces: Vec<Piece>,
}

/// Fits to paths and returns the file.
///
/// # Errors
/// No path in which a buffer ends early.
pub fn train(
    paths: &[&Path],
    params: &TurnParams,
    (training, seed): (&Training, u64),
) -> Result<String, NetworkError> {
    let mut chance = Stream::new(seed);
    let examples = examples(paths, params, training, &mut chance);
    let fit = &training.0.fit;
    if examples.is_empty() {
        return Err(NetworkError::Examples);
    }
    let scaling = fit.scaling(&examples);
    let layers = fit.fit(&scaling, &examples, &mut chance);
    let trained = text(&examples, paths.len(), seed);
    let mut raw = RawTurnNetwork::new(&trained, &scaling, layers);
    raw.threshold = threshold(&raw.check()?, &examples);
    raw.sealed()
}

/// What [`train`] would write of the set that it trains with, without training: whether a file is still the one that the
/// command makes.
#[must_use]
pub fn described(paths: &[&Path], params: &TurnParams, (training, seed): (&Training, u64)) -> String {
    text(&examples(paths, params, training, &mut Stream::new(seed)), paths.len(), seed)
}

fn text(examples: &[Example], paths: usize, seed: u64) -> String {
    let digest = crate::network::set_digest(examples);
    format!("fdm advance train: {} moments of {paths} paths, set {digest}, seed {seed}", examples.len())
}

/// The moments at which the buffer ends too early, path by path.
fn examples(paths: &[&Path], params: &TurnParams, training: &Training, chance: &mut Stream) -> Vec<Example> {
    let mut examples = vec![];
    for path in paths {
        let mut moments = vec![];
        Track::new(&path.pieces, params).run(path.buffered as usize, params, |watcher, moment| {
            if watcher.by_buffer(moment.gone_m).is_none() {
                let (inputs, _) = watcher.inputs(moment.gone_m);
                let target = f64::from(u8::from(moment.turns));
                moments.push(Example { values: inputs.to_vec(), target, weight: 1.0 });
            }
        });
        chance.shuffle(&mut moments);
        moments.truncate(training.0.moments_max as usize);
        weigh(&mut moments);
        examples.append(&mut moments);
    }
    examples
}

/// A long path counts as the root of its length: no file is to drown the others.
fn weigh(examples: &mut [Example]) {
    #[expect(clippy::cast_precision_loss, reason = "a count of moments")]
    let weight = 1.0 / (examples.len() as f64).max(1.0).sqrt();
    examples.iter_mut().for_each(|example| example.weight = weight);
}

/// The threshold with the best F1 over the examples.
fn threshold(network: &TurnNetwork, examples: &[Example]) -> f64 {
    let judged = examples.iter().map(|example| (network.of(&example.values), example.weight, example.target));
    crate::network::training::rounded(best_f1(judged.collect()))
}

/// Probability from which on `2 hits / (alarms + turns)` is best, of probabilities, weights and whether a turn came.
fn best_f1(mut judged: Vec<(f64, f64, f64)>) -> f64 {
    judged.sort_by(|a, b| b.0.total_cmp(&a.0));
    let turns: f64 = judged.iter().map(|(_, weight, turned)| weight * turned).sum();
    let (mut hits, mut alarms, mut best) = (0.0, 0.0, (0.0, 0.5));
    for (probability, weight, turned) in judged {
        alarms += weight;
        hits += weight * turned;
        let f1 = 2.0 * hits / (alarms + turns);
        if f1 > best.0 {
            best = (f1, probability);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// F1 from 0.9 on 2/3, from 0.8 on 2/4, from 0.7 on 4/5, from 0.2 on 4/6; where the false alarm at 0.8 weighs five,
    /// from 0.7 on 4/9: 0.9 is best. Without a turn it is one half.
    #[test]
    fn the_threshold_has_the_best_f1() {
        let judged =
            |false_alarm| vec![(0.2, 1.0, 0.0), (0.9, 1.0, 1.0), (0.7, 1.0, 1.0), (0.8, false_alarm, 0.0)];
        assert!((best_f1(judged(1.0)) - 0.7).abs() < 1e-15);
        assert!((best_f1(judged(5.0)) - 0.9).abs() < 1e-15);
        assert!((best_f1(vec![(0.9, 1.0, 0.0)]) - 0.5).abs() < 1e-15);
    }
}
