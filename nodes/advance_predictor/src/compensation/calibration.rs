//! K from printed patterns: test lines with different K, their widths measured, the least of a curve through them.
//!
//! A first pattern finds where to look; patterns about that, each of lines of their own, tell K and how sure it is.

mod look;
mod valley;

use crate::network::chance::Stream;
use crate::network::training::mean;
pub use look::Line;
use look::look;
use models::advance::VirtualLine;
use models::params::{ParamError, in_range};
use models::units::Seconds;
use serde::Deserialize;
use std::convert::Infallible;
use valley::{Valley, cubic_least, student, valley};

/// A pattern. Built only from a valid [`RawPattern`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawPattern")]
pub struct Pattern(RawPattern);

/// The block `advance_pattern` as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawPattern {
    /// Lines.
    pub lines: u32,
    /// Half width of the range of K about its middle, relative `[-]`.
    pub reach: f64,
    /// Way between two measured widths `[m]`.
    pub spacing_m: f64,
    /// Standard deviation of a measured width `[m]`.
    pub width_sigma_m: f64,
    /// Patterns at most until one brackets the best, each about the last one's best.
    pub patterns_max: u32,
    /// Patterns about that: their scatter is part of the interval.
    pub repeats: u32,
    /// How much thinner the fast stretch may be than the slow ones at the best K `[-]`: a drive that slips there, or a
    /// melt that is not warm, makes it so, and no K mends that.
    pub thin_max: f64,
    /// Step of the simulated printer `[s]`.
    pub step_s: f64,
}

impl TryFrom<RawPattern> for Pattern {
    type Error = ParamError;

    fn try_from(raw: RawPattern) -> Result<Self, ParamError> {
        in_range("lines", f64::from(raw.lines), "-", (5.0, 1000.0))?;
        in_range("reach", raw.reach, "-", (0.01, 0.9))?;
        in_range("spacing_m", raw.spacing_m, "m", (1e-5, 0.01))?;
        in_range("width_sigma_m", raw.width_sigma_m, "m", (0.0, 1e-3))?;
        in_range("patterns_max", f64::from(raw.patterns_max), "-", (1.0, 100.0))?;
        in_range("repeats", f64::from(raw.repeats), "-", (2.0, 100.0))?;
        in_range("thin_max", raw.thin_max, "-", (0.0, 1.0))?;
        in_range("step_s", raw.step_s, "s", (1e-5, 1e-2))?;
        Ok(Self(raw))
    }
}

impl Pattern {
    /// Standard deviation of a measured width `[m]`.
    #[must_use]
    pub fn width_sigma_m(&self) -> f64 {
        self.0.width_sigma_m
    }

    /// Step of the simulated printer.
    #[must_use]
    pub fn step(&self) -> Seconds {
        Seconds(self.0.step_s)
    }
}

/// What a pattern says.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibrated {
    /// Best K `[s]`.
    pub advance_s: f64,
    /// Half width of its 95 % interval `[s]`.
    pub half_width_s: f64,
    /// K and mean square of the width error of each line of the patterns about it, noise included.
    pub lines: Vec<[f64; 2]>,
}

/// Why a pattern says nothing.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NoBest {
    /// The best line lies at the edge of every pattern that was printed, or outside.
    #[error(
        "the best line lies at the edge or outside of every pattern that was printed, the last of them from {low_s:.4} to {high_s:.4} s"
    )]
    Outside {
        /// Least K of the last pattern `[s]`.
        low_s: f64,
        /// Largest one `[s]`.
        high_s: f64,
    },
    /// The fast stretch is too thin at the best K as well.
    #[error(
        "at the best K, {advance_s:.4} s, the fast stretch is {:.1} % thinner than the slow ones, more than {:.1} %: the drive \
         slips or the melt is not warm at this flow, which no advance mends; print a lower or narrower line, or hotter",
        1e2 * thin, 1e2 * thin_max
    )]
    Thin {
        /// Best K of such lines `[s]`.
        advance_s: f64,
        /// How much thinner.
        thin: f64,
        /// How much thinner it may be.
        thin_max: f64,
    },
    /// The lines do not differ beyond the noise of their widths.
    #[error("the lines of the pattern do not differ beyond the noise of their widths")]
    Flat,
}

/// Share of a pattern's half width within which its best has to lie: near the edge there is no other side to compare with.
const INNER: f64 = 0.5;

/// Prints patterns about `start_s`, measures the widths of lines `width_m` wide, and finds the best K.
///
/// # Errors
/// [`NoBest`] where no pattern brackets one.
pub fn calibrate(
    printer: &VirtualLine,
    pattern: &Pattern,
    start: (f64, f64),
    chance: &mut Stream,
) -> Result<Calibrated, NoBest> {
    let noise = pattern.0.width_sigma_m / start.1;
    let mut line = |advance_s: f64| -> Result<Line, Infallible> {
        Ok(look(printer, pattern.0.spacing_m, (advance_s, noise), chance))
    };
    match calibrate_by(&mut line, pattern, start) {
        Ok(found) => found,
        Err(never) => match never {},
    }
}

/// The same with lines from anywhere: `line` prints one with a K `[s]`.
///
/// # Errors
/// What `line` cannot print; inside, [`NoBest`] where no pattern brackets the best one.
pub fn calibrate_by<E>(
    line: &mut dyn FnMut(f64) -> Result<Line, E>,
    pattern: &Pattern,
    (start_s, width_m): (f64, f64),
) -> Result<Result<Calibrated, NoBest>, E> {
    let RawPattern { reach, width_sigma_m, patterns_max, repeats, .. } = pattern.0;
    let noise = width_sigma_m / width_m;
    let mut centre_s = start_s;
    let (mut lines, mut nothing) = (vec![], NoBest::Flat);
    for _ in 0..patterns_max {
        let reach_s = reach * centre_s;
        lines.extend(print(line, pattern, centre_s)?.lines);
        let change_s = match valley(&lines, centre_s, noise) {
            Ok(Valley::Here { offset_s, .. }) if offset_s.abs() <= INNER * reach_s => {
                centre_s += offset_s;
                let mut patterns = vec![];
                for _ in 0..repeats {
                    patterns.push(print(line, pattern, centre_s)?);
                }
                return Ok(weigh(&patterns, (centre_s, pattern), noise));
            }
            Ok(Valley::Here { offset_s, .. }) => offset_s.clamp(-reach_s, reach_s),
            Ok(Valley::Below) => -reach_s,
            Ok(Valley::Above) => reach_s,
            Err(flat) => {
                // Spools differ: more lines of the same may stand out of that.
                nothing = flat;
                continue;
            }
        };
        nothing = outside(centre_s, reach_s);
        centre_s += change_s;
        lines.clear();
    }
    Ok(Err(nothing))
}

fn outside(centre_s: f64, reach_s: f64) -> NoBest {
    NoBest::Outside { low_s: centre_s - reach_s, high_s: centre_s + reach_s }
}

/// A printed pattern.
struct Printed {
    /// K and mean square of each line.
    lines: Vec<[f64; 2]>,
    /// How much thinner the fast stretches are, over all lines: it falls evenly with K, so that this is the middle one's.
    thin: f64,
}

/// Prints a pattern.
fn print<E>(
    line: &mut dyn FnMut(f64) -> Result<Line, E>,
    pattern: &Pattern,
    centre_s: f64,
) -> Result<Printed, E> {
    let RawPattern { lines: count, reach, .. } = pattern.0;
    let (mut lines, mut thin) = (vec![], 0.0);
    for index in 0..count {
        let place = 2.0 * f64::from(index) / f64::from(count - 1) - 1.0;
        let advance_s = centre_s * (1.0 + reach * place);
        let seen = line(advance_s)?;
        lines.push([advance_s, seen.square]);
        thin += seen.thin / f64::from(count);
    }
    Ok(Printed { lines, thin })
}

/// K of all patterns together, and the half width of its 95 % interval.
fn weigh(
    patterns: &[Printed],
    (centre_s, pattern): (f64, &Pattern),
    noise: f64,
) -> Result<Calibrated, NoBest> {
    let RawPattern { reach, thin_max, .. } = pattern.0;
    let reach_s = reach * centre_s;
    let thin = mean(patterns.iter().map(|pattern| pattern.thin));
    let patterns: Vec<Vec<[f64; 2]>> = patterns.iter().map(|pattern| pattern.lines.clone()).collect();
    let lines: Vec<[f64; 2]> = patterns.concat();
    if thin > thin_max {
        return Err(NoBest::Thin { advance_s: centre_s, thin, thin_max });
    }
    let Valley::Here { offset_s: parabola_s, .. } = valley(&lines, centre_s, noise)? else {
        return Err(outside(centre_s, reach_s));
    };
    let [offset_s, error_s] = cubic_least(&lines, centre_s, noise).ok_or(NoBest::Flat)?;
    if offset_s.abs() > INNER * reach_s {
        return Err(outside(centre_s, reach_s));
    }
    let half_width_s = half_width_s(&patterns, (offset_s, error_s), parabola_s, (centre_s, noise));
    Ok(Calibrated { advance_s: centre_s + offset_s, half_width_s, lines })
}

/// Half width of the 95 % interval: the scatter of the lines about the curve or that of the patterns about each other,
/// whichever is larger, and what another curve through the same lines would say.
fn half_width_s(
    patterns: &[Vec<[f64; 2]>],
    (offset_s, error_s): (f64, f64),
    parabola_s: f64,
    (centre_s, noise): (f64, f64),
) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "small counts")]
    let (lines, count) = (patterns.concat().len() as f64, patterns.len() as f64);
    let vertices: Vec<f64> = patterns
        .iter()
        .filter_map(|lines| match valley(lines, centre_s, noise) {
            Ok(Valley::Here { offset_s, .. }) => Some(offset_s),
            _ => None,
        })
        .collect();
    let mean_s = mean(vertices.iter().copied());
    let squares = vertices.iter().map(|vertex_s| (vertex_s - mean_s).powi(2)).sum::<f64>();
    let between_s = student(count - 1.0) * (squares / (count - 1.0) / count).sqrt();
    (student(lines - 4.0) * error_s).max(between_s).hypot(offset_s - parabola_s)
}

#[cfg(test)]
mod tests;
