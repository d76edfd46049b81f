//! The largest error across the extruder's axis over a part: what two layers may lie apart that wrong motors explain.

use super::error::AxisError;
use super::geometry::Geometry;
use super::pose::SurfacePoint;
use super::sampling::Sampling;

/// Where the largest error lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ends {
    /// Inside of the surface that is looked at.
    Inside,
    /// At the height below which nothing is looked at.
    Cut,
    /// At the end of what the machine can work on: its limits, or the guard before singular poses, decide the figure.
    Reach,
}

/// What was looked at of a surface, and the largest error across the extruder's axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Laterals {
    /// Pieces that were looked at.
    pub counted: usize,
    /// Pieces below the height, not counted.
    pub below: usize,
    /// Pieces of the face on the table, not counted.
    pub on_table: usize,
    /// Pieces above the height that the machine refuses, or where a combination of signs loses the nominal branch.
    pub refused: usize,
    /// Share of the area above the height and off the table that these are `[-]`.
    pub refused_share: f64,
    /// Largest error `[m]` and where it lies; none where nothing could be looked at.
    pub largest: Option<(f64, Ends)>,
}

/// Heights nearer to the cut than this lie at it `[m]`.
const AT_M: f64 = 1e-5;

impl Geometry {
    /// Largest error across the extruder's axis over the pieces from `lowest_m` up, at their middles and at the end of
    /// what can be worked on.
    #[must_use]
    pub fn laterals(&self, sampling: &Sampling, lowest_m: f64, error: &AxisError) -> Laterals {
        let mut found = Laterals::NONE;
        let lateral_m = |point: &SurfacePoint| self.station(point).ok()?.lateral_m(error);
        let can = |point: &SurfacePoint| point.position_m.z >= lowest_m && self.station(point).is_ok();
        let (mut area_m2, mut refused_m2) = (0.0, 0.0);
        for sample in &sampling.samples {
            if sample.is_on_the_table() {
                found.on_table += 1;
                continue;
            }
            let middle = sample.middle();
            let above = middle.position_m.z >= lowest_m;
            let here_m = if above { lateral_m(&middle) } else { None };
            found.below += usize::from(!above);
            found.counted += usize::from(here_m.is_some());
            if above {
                area_m2 += sample.area_m2();
                if here_m.is_none() {
                    found.refused += 1;
                    refused_m2 += sample.area_m2();
                }
            }
            found.take(here_m, Ends::Inside);
            for last in sample.last_points(&can) {
                let ends = if last.position_m.z - lowest_m < AT_M { Ends::Cut } else { Ends::Reach };
                found.take(lateral_m(&last), ends);
            }
        }
        found.refused_share = if area_m2 > 0.0 { refused_m2 / area_m2 } else { 0.0 };
        found
    }
}

impl Geometry {
    /// The same over points of a surface whose whole outline they are, the first of them at the height below which nothing
    /// is looked at.
    #[must_use]
    pub fn laterals_of(&self, points: &[SurfacePoint], error: &AxisError) -> Laterals {
        let mut found = Laterals::NONE;
        for (index, point) in points.iter().enumerate() {
            let here_m = self.station(point).ok().and_then(|station| station.lateral_m(error));
            found.counted += usize::from(here_m.is_some());
            found.refused += usize::from(here_m.is_none());
            found.take(here_m, if index == 0 { Ends::Cut } else { Ends::Inside });
        }
        #[allow(clippy::cast_precision_loss, reason = "few points")]
        let share = found.refused as f64 / points.len().max(1) as f64;
        Laterals { refused_share: share, ..found }
    }
}

impl Laterals {
    const NONE: Self =
        Self { counted: 0, below: 0, on_table: 0, refused: 0, refused_share: 0.0, largest: None };

    fn take(&mut self, error_m: Option<f64>, ends: Ends) {
        if let Some(error_m) =
            error_m.filter(|error_m| self.largest.is_none_or(|(most_m, _)| *error_m > most_m))
        {
            self.largest = Some((error_m, ends));
        }
    }
}

#[cfg(test)]
mod tests;
