//! Which roads the path predicts in the picture: coarse masks of this layer, and the edges of the one below.

use crate::camera::Camera;
use crate::path::{PathHistory, Road};
use models::units::Seconds;
use opencv::core::{CV_8UC1, Mat, MatTraitConstManual, Point, Scalar};
use opencv::imgproc;

/// Pixels of the picture to one of a mask, each way: the masks tell places apart by a quarter of a road.
pub(crate) const REDUCTION: f64 = 4.0;
/// Bits of a fraction of a pixel in OpenCV's drawing.
const SHIFT: i32 = 4;
/// Largest coordinate that drawing takes without overflow `[px]`.
const FAR_PX: f64 = 3e4;

/// A picture of one byte per coarse pixel: 255 where something lies.
#[derive(Debug, Clone)]
pub(crate) struct Mask {
    pub(crate) picture: Mat,
}

impl Mask {
    pub(crate) fn empty(camera: &Camera) -> Result<Self, opencv::Error> {
        let size = |pixels: u16| (f64::from(pixels) / REDUCTION).ceil();
        let (rows, columns) = (whole(size(camera.height_px)), whole(size(camera.width_px)));
        Ok(Self { picture: Mat::new_rows_cols_with_default(rows, columns, CV_8UC1, Scalar::all(0.0))? })
    }

    /// Draws a line of `width_px` of the picture's pixels.
    pub(crate) fn draw(
        &mut self,
        from_px: [f64; 2],
        to_px: [f64; 2],
        width_px: f64,
    ) -> Result<(), opencv::Error> {
        let thickness = whole((width_px / REDUCTION).round()).max(1);
        let (from, to) = (fine(from_px), fine(to_px));
        imgproc::line(&mut self.picture, from, to, Scalar::all(255.0), thickness, imgproc::LINE_8, SHIFT)
    }

    /// Levels row by row, and the number of columns.
    pub(crate) fn levels(&self) -> Result<(&[u8], usize), opencv::Error> {
        use opencv::core::MatTraitConst;
        Ok((self.picture.data_bytes()?, usize::try_from(self.picture.cols()).unwrap_or(0)))
    }
}

/// Whether the mask has something at a pixel of the picture; nothing outside of it.
pub(crate) fn lies_at((levels, columns): (&[u8], usize), pixel: [f64; 2]) -> bool {
    let place = pixel.map(|value| (value + 0.5) / REDUCTION);
    if place.iter().any(|value| !(0.0..1e5).contains(value)) {
        return false;
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked just above")]
    let [column, row] = place.map(|value| value as usize);
    column < columns && levels.get(row * columns + column).is_some_and(|level| *level > 0)
}

/// Roads that reach into the picture, each with the part that was laid at `exposed` `[m]`.
pub(crate) fn in_view(
    path: &PathHistory,
    exposed: Seconds,
    (camera, tool_m): (&Camera, [f64; 2]),
) -> Vec<(Road, f64)> {
    let reach_m = [camera.width_px, camera.height_px].map(|pixels| f64::from(pixels) * camera.scale_m);
    let near = |road: &Road| {
        (0..2).all(|axis| {
            let (low, high) =
                (road.from_m[axis].min(road.to_m[axis]), road.from_m[axis].max(road.to_m[axis]));
            high > tool_m[axis] - reach_m[axis] && low < tool_m[axis] + reach_m[axis]
        })
    };
    path.roads(exposed).filter(|road| near(road)).map(|road| (*road, path.laid_m(road, exposed))).collect()
}

fn fine(pixel: [f64; 2]) -> Point {
    let scale = f64::from(1 << SHIFT);
    let [x, y] =
        pixel.map(|value| whole((((value + 0.5) / REDUCTION - 0.5) * scale).clamp(-FAR_PX, FAR_PX).round()));
    Point::new(x, y)
}

#[expect(clippy::cast_possible_truncation, reason = "sizes of pictures; a cast saturates")]
fn whole(value: f64) -> i32 {
    value as i32
}
