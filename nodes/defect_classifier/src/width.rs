//! Width of fresh road from the picture.
//!
//! Straight stretches laid at a steady speed a moment ago are cut into pieces; on each side where no other road
//! lies as high, the grey levels across the road are averaged along the piece and its edge is found in them. One
//! side gives half the width from the commanded centre line, two give the whole, whatever the tool's place was.

pub mod combine;
pub mod edge;
pub mod facing;
mod ground;
pub mod params;
pub mod profile;
mod side;
pub mod stretch;

pub use combine::{PieceWidth, WidthMeasurement, combine};
pub use edge::{EdgeError, EdgeModel};
pub use facing::Facing;
pub use params::{RawWidth, WidthParams};

use crate::camera::Camera;
use crate::path::{PathHistory, Road};
use crate::surroundings::in_view;
use ground::Ground;
use models::units::Seconds;
use opencv::core::{Mat, MatTraitConst, MatTraitConstManual};
use profile::{Pixels, Ruler, across};
use side::{Scene, Side};
use stretch::Piece;

/// An edge that was found, for people to see.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenEdge {
    /// Its ends in the picture `[px]`.
    pub ends_px: [[f64; 2]; 2],
}

/// What one frame says about widths.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Seen {
    /// Each piece that could be measured.
    pub pieces: Vec<PieceWidth>,
    /// Their edges.
    pub edges: Vec<SeenEdge>,
}

/// Measures widths in frames. Knows no clock.
#[derive(Debug, Clone)]
pub struct WidthGauge {
    params: WidthParams,
    model: EdgeModel,
    /// Everything laid until then has been told.
    told: Option<Seconds>,
}

impl WidthGauge {
    /// A gauge that has told nothing.
    #[must_use]
    pub fn new(params: WidthParams, model: EdgeModel) -> Self {
        Self { params, model, told: None }
    }

    /// The width of what was laid since the last one told, and the edges it rests on.
    ///
    /// # Errors
    /// A picture operation that failed.
    pub fn on_frame(
        &mut self,
        grey: &Mat,
        (path, exposed): (&PathHistory, Seconds),
        view: (&Camera, [f64; 2]),
    ) -> Result<(Option<WidthMeasurement>, Seen), opencv::Error> {
        let seen = self.look(grey, (path, exposed), view)?;
        let width = combine(&seen.pieces, self.told, &self.params);
        if width.is_some() {
            let newest = seen.pieces.iter().map(|piece| piece.laid.0).fold(f64::NEG_INFINITY, f64::max);
            self.told = Some(Seconds(newest));
        }
        Ok((width, seen))
    }

    /// Every piece in the frame.
    fn look(
        &self,
        grey: &Mat,
        (path, exposed): (&PathHistory, Seconds),
        view: (&Camera, [f64; 2]),
    ) -> Result<Seen, opencv::Error> {
        let mut seen = Seen::default();
        let pieces = stretch::pieces(path, exposed, &self.params);
        if pieces.is_empty() {
            return Ok(seen);
        }
        let pixels =
            Pixels { levels: grey.data_bytes()?, columns: usize::try_from(grey.cols()).unwrap_or(0) };
        let roads: Vec<(Road, f64)> = in_view(path, exposed, view);
        let mut ground: Option<Ground> = None;
        for piece in &pieces {
            let around = match ground.take().filter(|ground| ground.serves(piece, &self.params)) {
                Some(ground) => ground,
                None => Ground::of(piece, &roads, view, &self.params)?,
            };
            let scene = Scene { view, roads: &roads, ground: ground.insert(around) };
            let sides = side::sides(&scene, piece, &self.params)?;
            self.measure(piece, &sides, (&pixels, view), &mut seen);
        }
        Ok(seen)
    }

    /// Adds what the free sides of a piece say.
    fn measure(
        &self,
        piece: &Piece,
        sides: &[Side],
        (pixels, view): (&Pixels<'_>, (&Camera, [f64; 2])),
        seen: &mut Seen,
    ) {
        let params = &self.params;
        let half_m = 0.5 * piece.width_m;
        let range_m = params.range_rel * half_m;
        let (from_m, to_m) = self.model.window_m();
        let ruler = Ruler::over(half_m - range_m + from_m, half_m + range_m + to_m, params.profile_step_m);
        let (mut halves_m, mut seen_sides) = (Vec::new(), Vec::new());
        for side in sides.iter().filter(|side| !side.stacked && side.long_enough(params)) {
            let Some(profile) = across(pixels, view, &side.stations, (side.sign, &ruler)) else { continue };
            let Some(edge_m) = self.model.locate(&profile, &ruler, (half_m, range_m)) else { continue };
            let edge_m = edge_m - params.edge_bias_m;
            halves_m.push(edge_m);
            seen_sides.push(side);
            seen.edges.extend(side.edge(edge_m, view));
        }
        let (width_m, edge_share) = match halves_m[..] {
            [one_m] => (2.0 * one_m, 2.0),
            // Errors of two edges add up as squares.
            [left_m, right_m] => (left_m + right_m, std::f64::consts::SQRT_2),
            _ => return,
        };
        let Some(facing) = Facing::of(piece, &seen_sides) else { return };
        seen.pieces.push(PieceWidth {
            laid: piece.laid,
            ratio: width_m / piece.width_m,
            sigma: edge_share * params.edge_sigma_m / piece.width_m,
            wanted_m: piece.width_m,
            height_m: piece.height_m,
            facing,
        });
    }
}
