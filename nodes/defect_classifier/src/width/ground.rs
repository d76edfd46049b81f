//! What lies around a piece of road: neighbours as high, and ground that is not closed.

use super::params::WidthParams;
use super::stretch::Piece;
use crate::camera::Camera;
use crate::path::Road;
use crate::surroundings::Mask;
use models::motion::Role;

/// Whether a road was pressed on something: a strand over a gap is as round as it likes, whatever the slicer states.
pub(crate) fn pressed(road: &Road, params: &WidthParams) -> bool {
    let over_gaps =
        matches!(road.role, Role::Bridge | Role::Overhang | Role::Support | Role::GapFill | Role::Ironing);
    !over_gaps && road.height_m <= params.height_max_rel * road.width_m
}

/// Masks around the pieces of one height.
pub(crate) struct Ground {
    /// Where the pieces' floor lies over the bed `[m]`.
    floor_m: f64,
    /// Roads that reach above it, the pieces among them.
    pub(crate) beside: Mask,
    /// Near strands and sparse infill below it: what is laid over gaps sags, and its edge is not where light shows one.
    pub(crate) open: Mask,
}

impl Ground {
    /// What lies around a piece and all others of its height.
    pub(crate) fn of(
        piece: &Piece,
        roads: &[(Road, f64)],
        view: (&Camera, [f64; 2]),
        params: &WidthParams,
    ) -> Result<Self, opencv::Error> {
        let floor_m = floor_m(piece, params);
        let mut ground = Self { floor_m, beside: Mask::empty(view.0)?, open: Mask::empty(view.0)? };
        for (road, laid_m) in roads.iter().filter(|(_, laid_m)| *laid_m > 0.0) {
            if road.top_m > floor_m {
                draw(&mut ground.beside, view, (road, *laid_m), road.width_m)?;
            } else if road.role == Role::Infill || !pressed(road, params) {
                draw(&mut ground.open, view, (road, *laid_m), road.width_m + params.open_m)?;
            }
        }
        Ok(ground)
    }

    /// Whether it is that of another piece too.
    pub(crate) fn serves(&self, piece: &Piece, params: &WidthParams) -> bool {
        (self.floor_m - floor_m(piece, params)).abs() < 1e-9
    }
}

/// A road whose top lies above this height is beside the piece or hides it; others lie below it `[m]`.
pub(crate) fn floor_m(piece: &Piece, params: &WidthParams) -> f64 {
    piece.top_m - params.beside_heights * piece.height_m
}

fn draw(
    mask: &mut Mask,
    (camera, tool_m): (&Camera, [f64; 2]),
    (road, laid_m): (&Road, f64),
    width_m: f64,
) -> Result<(), opencv::Error> {
    let (from, to) = (camera.pixel(tool_m, road.from_m), camera.pixel(tool_m, road.point_m(laid_m)));
    mask.draw(from, to, width_m / camera.scale_m)
}
