//! What an ensemble reaches: errors, intervals, the printed points, trends, widths, a person's own lines.

mod own;

pub use own::OwnLines;

use super::data::{DataParams, DataSet, Line, Use};
use super::ensemble::Ensemble;
use super::measured::Measured;
use crate::network::training::mean;
use models::advance::published::Published;
use models::advance::{Condition, DriveKind, Physics, VirtualLine};
use models::command::AdvanceLaw;
use models::extruder::StaticLaw;
use models::units::{Celsius, Seconds};
use serde::Serialize;

/// Largest error that counts as near `[s]`: the paper's deviation.
const NEAR_S: f64 = 0.015;
/// The same relative to the truth `[-]`, for direct drives.
const NEAR_REL: f64 = 0.1;
/// Held-out conditions that widths are printed for.
const WIDTHS: usize = 12;
/// Temperature at which the paper orders the polymers `[degC]`.
const ORDERED_C: f64 = 230.0;
/// Its order, largest first.
const ORDER: [&str; 3] = ["PETG", "ABS", "PLA"];

/// All figures of one drive.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// Drive.
    pub drive: DriveKind,
    /// Virtual lines trained with.
    pub trained: usize,
    /// A person's own lines; `None` without any of this drive. All other figures are of virtual lines then, scaled to these.
    pub own: Option<OwnLines>,
    /// Lines of the grid at inner temperatures that were never trained with.
    pub held_out: Errors,
    /// Conditions anywhere in the hull, off the grid.
    pub anywhere: Errors,
    /// The printed points.
    pub published: Vec<PublishedError>,
    /// Trends over the grid.
    pub trends: Trends,
    /// Widths of the test line.
    pub widths: Widths,
}

/// Errors over a set, in seconds unless the name says otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// Conditions.
    pub count: usize,
    /// Mean magnitude against the truth.
    pub mean_abs_s: f64,
    /// Largest magnitude.
    pub max_abs_s: f64,
    /// Share within 0.015 s.
    pub within_15_ms: f64,
    /// Share within 10 %.
    pub within_10_percent: f64,
    /// Mean magnitude against the scores, which have noise of their own.
    pub mean_abs_to_scores_s: f64,
    /// Share of the truths that the 95 % interval holds.
    pub covered: f64,
    /// Mean half width of that interval.
    pub mean_half_width_s: f64,
}

/// A printed point and what is foretold for it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PublishedError {
    /// Layer height.
    pub height_mm: f64,
    /// As printed.
    pub printed_s: f64,
    /// As foretold.
    pub foretold_s: f64,
    /// Foretold less printed.
    pub error_s: f64,
}

/// Trends over the grid: pairs of neighbours that go the wrong way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Trends {
    /// Pairs of neighbours.
    pub pairs: usize,
    /// Hotter needs no less.
    pub temperature_broken: usize,
    /// Higher layers need no less.
    pub height_broken: usize,
    /// Wider lines need no less.
    pub width_broken: usize,
    /// Shapes of line at 230 degC, and those where PETG > ABS > PLA does not hold.
    pub ordered: usize,
    /// See `ordered`.
    pub order_broken: usize,
}

/// RMS width error of the virtual test line over held-out conditions, mean `[-]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Widths {
    /// Conditions.
    pub count: usize,
    /// Without compensation.
    pub none: f64,
    /// With the best compensation.
    pub best: f64,
    /// With the foretold one.
    pub foretold: f64,
    /// With the same as a law over the feed.
    pub foretold_law: f64,
}

/// Lines that an ensemble is judged on.
#[derive(Debug, Clone, Copy)]
pub struct Judges<'a> {
    /// How virtual lines were made.
    pub data: &'a DataParams,
    /// Virtual lines, scaled to a person's printer.
    pub set: &'a DataSet,
    /// How many of them that left out.
    pub left_out: usize,
    /// The person's own lines; those of other drives are left out.
    pub measured: &'a [Measured],
}

/// Judges an ensemble on lines that it was not trained with, and on a person's own.
#[must_use]
pub fn assess(ensemble: &Ensemble, physics: &Physics, judges: Judges, published: &Published) -> Figures {
    let set = judges.set;
    let held_out: Vec<&Line> = set.lines.iter().filter(|line| line.purpose == Use::HeldOut).collect();
    let anywhere: Vec<&Line> = set.anywhere.iter().collect();
    Figures {
        drive: set.drive,
        trained: set.lines.iter().filter(|line| line.purpose == Use::Train).count(),
        own: OwnLines::of(ensemble, judges),
        held_out: errors(ensemble, &held_out),
        anywhere: errors(ensemble, &anywhere),
        published: points(ensemble, published),
        trends: trends(ensemble, &set.lines),
        widths: widths(ensemble, physics, judges.data, &held_out),
    }
}

#[expect(clippy::cast_precision_loss, reason = "counts of lines")]
fn share<T>(list: &[T], holds: impl Fn(&T) -> bool) -> f64 {
    list.iter().filter(|one| holds(one)).count() as f64 / (list.len() as f64).max(1.0)
}

fn errors(ensemble: &Ensemble, lines: &[&Line]) -> Errors {
    let judged: Vec<_> = lines
        .iter()
        .filter_map(|line| {
            let foretold = ensemble.predict(&line.polymer, &line.at)?;
            let error_s = (foretold.advance.0 - line.true_s).abs();
            Some((error_s, error_s / line.true_s, foretold, line.scored_s))
        })
        .collect();
    Errors {
        count: judged.len(),
        mean_abs_s: mean(judged.iter().map(|one| one.0)),
        max_abs_s: judged.iter().map(|one| one.0).fold(0.0, f64::max),
        within_15_ms: share(&judged, |one| one.0 <= NEAR_S),
        within_10_percent: share(&judged, |one| one.1 <= NEAR_REL),
        mean_abs_to_scores_s: mean(judged.iter().map(|one| (one.2.advance.0 - one.3).abs())),
        covered: share(&judged, |one| one.0 <= one.2.half_width.0),
        mean_half_width_s: mean(judged.iter().map(|one| one.2.half_width.0)),
    }
}

fn points(ensemble: &Ensemble, published: &Published) -> Vec<PublishedError> {
    let of_drive = published.points.iter().filter(|point| point.drive == ensemble.drive());
    of_drive
        .filter_map(|point| {
            let at = Condition {
                temperature: Celsius(published.temperature_c),
                height_m: point.height_m,
                width_m: published.width_m,
            };
            let foretold_s = ensemble.predict(&published.polymer, &at)?.advance.0;
            Some(PublishedError {
                height_mm: 1e3 * point.height_m,
                printed_s: point.advance_s,
                foretold_s,
                error_s: foretold_s - point.advance_s,
            })
        })
        .collect()
}

/// Key of a line with one of its numbers left out, and that number: neighbours share the key.
type Along = fn(&Line) -> ([u64; 2], f64);

fn trends(ensemble: &Ensemble, lines: &[Line]) -> Trends {
    let temperature: Along = |l| ([l.at.height_m.to_bits(), l.at.width_m.to_bits()], l.at.temperature.0);
    let height: Along = |l| ([l.at.temperature.0.to_bits(), l.at.width_m.to_bits()], l.at.height_m);
    let width: Along = |l| ([l.at.temperature.0.to_bits(), l.at.height_m.to_bits()], l.at.width_m);
    let counted = [temperature, height, width].map(|along| broken(ensemble, lines, along));
    let orders: Vec<bool> = lines
        .iter()
        .filter(|line| line.polymer == ORDER[0] && (line.at.temperature.0 - ORDERED_C).abs() < 1e-6)
        .map(|line| {
            let foretold = ORDER.map(|name| ensemble.predict(name, &line.at).map(|k| k.advance.0));
            foretold.windows(2).all(|pair| pair[0].zip(pair[1]).is_some_and(|(more, less)| more > less))
        })
        .collect();
    Trends {
        pairs: counted.iter().map(|(pairs, _)| pairs).sum(),
        temperature_broken: counted[0].1,
        height_broken: counted[1].1,
        width_broken: counted[2].1,
        ordered: orders.len(),
        order_broken: orders.iter().filter(|holds| !**holds).count(),
    }
}

/// Pairs of neighbours along one number, and those where `K_A` does not fall.
fn broken(ensemble: &Ensemble, lines: &[Line], along: Along) -> (usize, usize) {
    let mut sorted: Vec<(&str, [u64; 2], f64, f64)> = lines
        .iter()
        .filter_map(|line| {
            let (key, number) = along(line);
            Some((line.polymer.as_str(), key, number, ensemble.predict(&line.polymer, &line.at)?.advance.0))
        })
        .collect();
    sorted.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
    let pairs = sorted.windows(2).filter(|pair| (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1));
    pairs.fold((0, 0), |(all, broken), pair| (all + 1, broken + usize::from(pair[1].3 >= pair[0].3)))
}

fn widths(ensemble: &Ensemble, physics: &Physics, data: &DataParams, held_out: &[&Line]) -> Widths {
    // Evenly over the held-out lines.
    let stride = (held_out.len() / WIDTHS).max(1);
    let printed: Vec<[f64; 4]> = held_out
        .iter()
        .step_by(stride)
        .take(WIDTHS)
        .filter_map(|line| {
            let foretold_s = ensemble.predict(&line.polymer, &line.at)?.advance.0;
            let printer = printer(ensemble.drive(), physics, data, line)?;
            let rms = |advance_s: f64| printer.errors(advance_s).map(|errors| errors.rms);
            let law = physics.law(ensemble.drive(), &line.polymer, &line.at, Seconds(foretold_s))?;
            Some([rms(0.0)?, rms(line.true_s)?, rms(foretold_s)?, printer.errors_by_law(&law)?.rms])
        })
        .collect();
    let column = |place: usize| mean(printed.iter().map(|row| row[place]));
    Widths {
        count: printed.len(),
        none: column(0),
        best: column(1),
        foretold: column(2),
        foretold_law: column(3),
    }
}

/// The virtual printer of a line, scaled as the line is.
fn printer(drive: DriveKind, physics: &Physics, data: &DataParams, line: &Line) -> Option<VirtualLine> {
    let (polymer, drive) = (physics.polymers.get(&line.polymer)?, physics.drive(drive));
    let AdvanceLaw { linear_s, shear, index } = drive.law(polymer, &line.at).advance().scaled(line.factor);
    let law = StaticLaw::of_compression(index, shear, linear_s);
    Some(VirtualLine::of_law(law, drive.outlet_m_s(&line.at, 1.0), &physics.test_line, data.step()))
}
