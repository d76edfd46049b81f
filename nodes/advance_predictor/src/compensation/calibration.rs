//! K from a printed pattern: test lines with different K, their widths measured, the vertex of a parabola.

use crate::network::chance::Stream;
use models::advance::VirtualLine;
use models::params::{ParamError, in_range};
use models::units::Seconds;
use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;
use std::convert::Infallible;

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
    /// Patterns at most, each about the last one's best.
    pub patterns_max: u32,
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
    /// K and mean square of the width error of each line of the last pattern, noise included.
    pub lines: Vec<[f64; 2]>,
}

/// Why a pattern says nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NoBest {
    /// The best line lies outside of every pattern that was printed.
    #[error("the best line lies outside of every pattern that was printed")]
    Outside,
    /// The lines do not differ beyond the noise of their widths.
    #[error("the lines of the pattern do not differ beyond the noise of their widths")]
    Flat,
}

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
    let mut line = |advance_s: f64| -> Result<f64, Infallible> {
        Ok(mean_square(printer, pattern.0.spacing_m, (advance_s, noise), chance))
    };
    match calibrate_by(&mut line, pattern, start) {
        Ok(found) => found,
        Err(never) => match never {},
    }
}

/// The same with lines from anywhere: `line` prints one with a K `[s]` and gives the mean square of its relative error.
///
/// # Errors
/// What `line` cannot print; inside, [`NoBest`] where no pattern brackets the best one.
pub fn calibrate_by<E>(
    line: &mut dyn FnMut(f64) -> Result<f64, E>,
    pattern: &Pattern,
    (start_s, width_m): (f64, f64),
) -> Result<Result<Calibrated, NoBest>, E> {
    let RawPattern { lines: count, reach, width_sigma_m, patterns_max, .. } = pattern.0;
    let mut centre_s = start_s;
    for _ in 0..patterns_max {
        let reach_s = reach * centre_s;
        let mut lines = Vec::new();
        for index in 0..count {
            let place = 2.0 * f64::from(index) / f64::from(count - 1) - 1.0;
            let advance_s = centre_s * (1.0 + reach * place);
            lines.push([advance_s, line(advance_s)?]);
        }
        match valley(&lines, centre_s, width_sigma_m / width_m) {
            Ok(Valley::Here { offset_s, half_width_s }) if offset_s.abs() <= reach_s => {
                return Ok(Ok(Calibrated { advance_s: centre_s + offset_s, half_width_s, lines }));
            }
            Ok(Valley::Here { offset_s, .. }) => centre_s += offset_s.clamp(-reach_s, reach_s),
            Ok(Valley::Below) => centre_s -= reach_s,
            Ok(Valley::Above) => centre_s += reach_s,
            Err(nothing) => return Ok(Err(nothing)),
        }
    }
    Ok(Err(NoBest::Outside))
}

/// Mean square of the relative errors of a virtual line, measured every `spacing_m`.
fn mean_square(
    printer: &VirtualLine,
    spacing_m: f64,
    (advance_s, noise): (f64, f64),
    chance: &mut Stream,
) -> f64 {
    let (mut way_m, mut due_m, mut squares, mut count) = (0.0, 0.0, 0.0, 0.0);
    printer.print(advance_s, |_, wanted_m_s, laid_m_s, dt| {
        way_m += wanted_m_s * dt.0 / printer.per_way();
        if way_m >= due_m {
            due_m += spacing_m;
            squares += (laid_m_s / wanted_m_s - 1.0 + noise * chance.normal()).powi(2);
            count += 1.0;
        }
    });
    squares / count
}

/// Where the mean squares are least.
enum Valley {
    /// At the vertex of a parabola, relative to the centre, with half of its 95 % interval `[s]`.
    Here { offset_s: f64, half_width_s: f64 },
    /// Towards smaller K.
    Below,
    /// Towards larger K.
    Above,
}

/// Vertex of the least-squares parabola through the mean squares.
///
/// A mean square `m` of errors with noise of variance `s^2` scatters with a variance in proportion to
/// `4 (m - s^2) s^2 + 2 s^4`: its inverse is the line's weight.
fn valley(lines: &[[f64; 2]], centre_s: f64, noise: f64) -> Result<Valley, NoBest> {
    // In units of the centre the normal equations are well scaled.
    let row = |advance_s: f64| {
        let x = advance_s / centre_s - 1.0;
        Vector3::new(1.0, x, x * x)
    };
    let floor = (noise * noise).max(f64::MIN_POSITIVE.sqrt());
    let weight =
        |square: f64| floor * floor / (4.0 * (square - floor).max(0.0) * floor + 2.0 * floor * floor);
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for [advance_s, square] in lines {
        normal += row(*advance_s) * row(*advance_s).transpose() * weight(*square);
        right += row(*advance_s) * *square * weight(*square);
    }
    let inverse = normal.try_inverse().ok_or(NoBest::Flat)?;
    let fitted = inverse * right;
    let residual = |[k, square]: &[f64; 2]| weight(*square) * (square - row(*k).dot(&fitted)).powi(2);
    #[expect(clippy::cast_precision_loss, reason = "a small count")]
    let freedom = lines.len() as f64 - 3.0;
    let variance = lines.iter().map(residual).sum::<f64>() / freedom;
    let certain = student(freedom);
    let [slope, bend] = [fitted[1], fitted[2]];
    // A slope or a bend has to stand out of its own uncertainty.
    let stands_out =
        |place: usize| fitted[place].abs() > certain * (variance * inverse[(place, place)]).sqrt();
    if bend > 0.0 && stands_out(2) {
        let gradient = Vector3::new(0.0, -0.5 / bend, 0.5 * slope / (bend * bend));
        let spread = (variance * gradient.dot(&(inverse * gradient))).sqrt();
        let (offset_s, half_width_s) = (-0.5 * slope / bend * centre_s, certain * spread * centre_s);
        return Ok(Valley::Here { offset_s, half_width_s });
    }
    match slope {
        _ if !stands_out(1) => Err(NoBest::Flat),
        rising if rising > 0.0 => Ok(Valley::Below),
        _ => Ok(Valley::Above),
    }
}

/// Two-sided 95 % quantile of Student's t: two terms about the normal's (Abramowitz and Stegun 26.7.5).
fn student(freedom: f64) -> f64 {
    let z: f64 = 1.96;
    let first = (z.powi(3) + z) / (4.0 * freedom);
    let second = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * freedom * freedom);
    z + first + second
}

#[cfg(test)]
mod tests {
    use super::super::tests::physics;
    use super::*;
    use models::advance::{Condition, DriveKind};
    use models::units::Celsius;

    fn pattern(width_sigma_m: f64) -> Pattern {
        let raw = RawPattern {
            lines: 11,
            reach: 0.15,
            spacing_m: 5e-4,
            width_sigma_m,
            patterns_max: 8,
            step_s: 1e-3,
        };
        Pattern::try_from(raw).unwrap()
    }

    fn printer() -> VirtualLine {
        let at = Condition { temperature: Celsius(215.0), height_m: 2e-4, width_m: 4e-4 };
        physics().line(DriveKind::Bowden, "PLA", &at, Seconds(1e-3)).unwrap()
    }

    /// t(0.975): 2.306 with 8 degrees of freedom, 2.776 with 4.
    #[test]
    fn the_quantile_is_students() {
        assert!((student(8.0) - 2.306).abs() < 0.01 && (student(4.0) - 2.776).abs() < 0.05);
    }

    /// 95 % of the intervals hold the truth: 40 seeds miss at most 6 (2 expected, P(> 6) < 1 %).
    #[test]
    fn the_interval_holds_the_best_line() {
        let (printer, pattern) = (printer(), pattern(1.2e-5));
        let best_s = printer.best().unwrap().advance_s;
        let missed = (0..40)
            .filter(|seed| {
                let found = calibrate(&printer, &pattern, (0.63, 4e-4), &mut Stream::new(*seed)).unwrap();
                assert!(found.half_width_s < 0.02, "{found:?}");
                (found.advance_s - best_s).abs() > found.half_width_s
            })
            .count();
        assert!(missed <= 6, "{missed} of 40");
    }

    /// Started at half and at twice the best, the pattern moves until it brackets it.
    #[test]
    fn a_bad_start_is_walked_away_from() {
        let printer = printer();
        let best_s = printer.best().unwrap().advance_s;
        for start_s in [0.5 * best_s, 2.0 * best_s] {
            let found = calibrate(&printer, &pattern(1.2e-5), (start_s, 4e-4), &mut Stream::new(1)).unwrap();
            assert!((found.advance_s - best_s).abs() < 0.02, "{found:?}");
        }
    }

    #[test]
    fn widths_that_are_all_noise_say_nothing() {
        let refused = calibrate(&printer(), &pattern(1e-3), (0.63, 4e-4), &mut Stream::new(1));
        assert!(matches!(refused, Err(NoBest::Flat | NoBest::Outside)), "{refused:?}");
    }
}
