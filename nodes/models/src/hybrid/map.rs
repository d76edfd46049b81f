//! The error over the surface of a real part.

use nalgebra::Vector3;

use super::error::{AxisError, Extremal};
use super::geometry::{Geometry, Refused};
use super::mesh::{Mesh, Triangle, doubled_area};
use super::pose::SurfacePoint;
use super::sampling::Sampling;

/// One triangle of the part, or a piece of one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// Centre in the part's frame `[m]`.
    pub centre_m: Vector3<f64>,
    /// Area `[m2]`.
    pub area_m2: f64,
    /// Error at the centre, or why the machine does not work there.
    pub outcome: Result<At, Refused>,
}

impl Cell {
    /// Area of a triangle `[m2]`.
    pub(super) fn area_m2(triangle: &Triangle) -> f64 {
        0.5 * doubled_area(triangle).norm()
    }
}

/// The error at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct At {
    /// Worst combination, exact.
    pub extremal: Extremal,
    /// Sum of the carriages' gains `[-]`.
    pub gain: f64,
    /// Tilt of the platform `[rad]`.
    pub tilt_rad: f64,
}

/// The error over a part.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorMap {
    /// One cell a triangle or piece, in their order.
    pub cells: Vec<Cell>,
    /// Largest error at the end of what the machine can work on `[m]`, and its place in the part's frame `[m]`; none where
    /// that end was not looked for, or there is none.
    pub edge: Option<(f64, Vector3<f64>)>,
}

/// What a map comes to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    /// Whole surface `[m2]`.
    pub area_m2: f64,
    /// Share of it that the machine can work on `[-]`.
    pub workable: f64,
    /// Mean of the worst error over the workable area `[m]`.
    pub mean_m: f64,
    /// Error that 95 % of the workable area stay below `[m]`.
    pub most_m: f64,
    /// Largest error `[m]`, and its cell.
    pub largest: Option<(f64, usize)>,
}

impl Geometry {
    /// Worst error at the middle of every triangle, with all combinations of signs solved exactly.
    #[must_use]
    pub fn error_map(&self, mesh: &Mesh, error: &AxisError) -> ErrorMap {
        let cell = |triangle| self.cell(&SurfacePoint::on_triangle(triangle), Cell::area_m2(triangle), error);
        ErrorMap { cells: mesh.triangles().iter().map(cell).collect(), edge: None }
    }

    /// The same at the middle of every piece of a sampling of that mesh, and where the machine's reach ends; whole
    /// triangles are taken from its map.
    #[must_use]
    pub fn error_map_of(&self, sampling: &Sampling, whole: &ErrorMap, error: &AxisError) -> ErrorMap {
        let cells = sampling.samples.iter().map(|sample| match whole.cells.get(sample.triangle) {
            Some(cell) if sample.whole => *cell,
            _ => self.cell(&sample.middle(), sample.area_m2(), error),
        });
        let can = |point: &SurfacePoint| self.station(point).is_ok();
        let last = sampling.samples.iter().flat_map(|sample| sample.last_points(&can));
        let errors = last.filter_map(|point| {
            let worst = self.station(&point).ok()?.extremal(error);
            Some((worst.largest_m, point.position_m))
        });
        ErrorMap { cells: cells.collect(), edge: errors.max_by(|one, other| one.0.total_cmp(&other.0)) }
    }

    fn cell(&self, point: &SurfacePoint, area_m2: f64, error: &AxisError) -> Cell {
        let outcome = self.station(point).map(|station| At {
            extremal: station.extremal(error),
            gain: station.gain().carriage_sum(),
            tilt_rad: station.target.pose.tilt_rad,
        });
        Cell { centre_m: point.position_m, area_m2, outcome }
    }
}

impl ErrorMap {
    /// Figures weighted by area.
    #[must_use]
    pub fn summary(&self) -> Summary {
        let area_m2: f64 = self.cells.iter().map(|cell| cell.area_m2).sum();
        let mut known: Vec<(f64, f64, usize)> = self
            .cells
            .iter()
            .enumerate()
            .filter_map(|(index, cell)| Some((cell.outcome.ok()?.extremal.largest_m, cell.area_m2, index)))
            .collect();
        known.sort_by(|one, other| one.0.total_cmp(&other.0));
        // The sum of nothing is -0.
        let workable_m2: f64 = known.iter().map(|(_, area, _)| area).sum::<f64>() + 0.0;
        let weighted: f64 = known.iter().map(|(error, area, _)| error * area).sum();
        let mut below_m2 = 0.0;
        let most = known.iter().find(|(_, area, _)| {
            below_m2 += area;
            below_m2 >= 0.95 * workable_m2
        });
        Summary {
            area_m2,
            workable: workable_m2 / area_m2,
            mean_m: if workable_m2 > 0.0 { weighted / workable_m2 } else { 0.0 },
            most_m: most.map_or(0.0, |(error, _, _)| *error),
            largest: known.last().map(|(error, _, index)| (*error, *index)),
        }
    }
}

#[cfg(test)]
mod tests;
