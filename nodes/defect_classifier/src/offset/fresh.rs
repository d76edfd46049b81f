//! Roads of the layer under way in one view: what they hide of the old part, and where they show how part looks.

use super::OffsetParams;
use super::looks::{Class, Looks};
use super::view::eroded;
use crate::camera::Camera;
use crate::path::Road;
use crate::surroundings::{Mask, REDUCTION};
use opencv::core::MatTraitConstManual;

/// Border of a road that may show what lies beside it, in coarse pixels: rounding of the drawing.
const BORDER_PX: f64 = 1.0;

/// Fresh roads in coarse pixels.
pub(super) struct Fresh {
    /// Roads and what is too near to them to show the old part.
    pub(super) hides: Mask,
    /// Roads alone.
    roads: Mask,
}

impl Fresh {
    /// None yet.
    pub(super) fn empty(camera: &Camera) -> Result<Self, opencv::Error> {
        Ok(Self { hides: Mask::empty(camera)?, roads: Mask::empty(camera)? })
    }

    /// Draws a road up to `end_m`.
    pub(super) fn draw(
        &mut self,
        (road, end_m): (&Road, [f64; 2]),
        (camera, tool_m): (&Camera, [f64; 2]),
        params: &OffsetParams,
    ) -> Result<(), opencv::Error> {
        let (from, to) = (camera.pixel(tool_m, road.from_m), camera.pixel(tool_m, end_m));
        let beside_px = 2.0 * params.beside_new_m / camera.scale_m;
        let width_px = road.width_m / camera.scale_m;
        self.hides.draw(from, to, width_px + beside_px)?;
        self.roads.draw(from, to, width_px)
    }

    /// Adds the looks of the roads, less their borders, to those of part.
    pub(super) fn teach(
        &self,
        looks: &Looks,
        part: &mut Class,
        camera: &Camera,
    ) -> Result<(), opencv::Error> {
        let inner = eroded(&self.roads.picture, BORDER_PX)?;
        let (_, columns) = self.roads.levels()?;
        for (place, _) in inner.data_bytes()?.iter().enumerate().filter(|(_, level)| **level > 0) {
            #[expect(clippy::cast_precision_loss, reason = "coarse pixels are far below 2^52")]
            let coarse = [(place % columns) as f64, (place / columns) as f64];
            if camera.sees(coarse.map(|value| (value + 0.5) * REDUCTION - 0.5), 1.0) {
                part.add(&looks.at(place));
            }
        }
        Ok(())
    }
}
