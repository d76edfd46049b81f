//! Grey levels across a road, averaged along it.

use super::stretch::Station;
use crate::camera::Camera;
use opencv::core::{Mat, MatTraitConst, MatTraitConstManual};
use opencv::imgcodecs;

/// A grey picture as its rows of bytes.
#[derive(Debug, Clone, Copy)]
pub struct Pixels<'a> {
    /// Levels row by row.
    pub levels: &'a [u8],
    /// Pixels to a row.
    pub columns: usize,
}

/// A decoded picture, for whoever has no other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    levels: Vec<u8>,
    columns: usize,
}

impl Picture {
    /// Decodes a JPEG as the node does, without the checks of [`crate::frame::FrameGate`].
    ///
    /// # Errors
    /// A picture that cannot be decoded.
    pub fn decode(jpeg: &[u8]) -> Result<Self, opencv::Error> {
        let grey = imgcodecs::imdecode(&Mat::from_slice(jpeg)?, imgcodecs::IMREAD_GRAYSCALE)?;
        let columns = usize::try_from(grey.cols()).unwrap_or(0);
        Ok(Self { levels: grey.data_bytes()?.to_vec(), columns })
    }

    /// Its levels.
    #[must_use]
    pub fn pixels(&self) -> Pixels<'_> {
        Pixels { levels: &self.levels, columns: self.columns }
    }
}

impl Pixels<'_> {
    /// Level between pixel centres, linearly; `None` outside.
    #[must_use]
    pub fn at(&self, [u, v]: [f64; 2]) -> Option<f64> {
        if !(u >= 0.0 && v >= 0.0 && u < 1e5 && v < 1e5) {
            return None;
        }
        let (left, top) = (u.floor(), v.floor());
        let (share_u, share_v) = (u - left, v - top);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked just above")]
        let (left, top) = (left as usize, top as usize);
        if left + 1 >= self.columns {
            return None;
        }
        let from = top * self.columns + left;
        let upper = self.levels.get(from..from + 2)?;
        let lower = self.levels.get(from + self.columns..from + self.columns + 2)?;
        let row = |pair: &[u8]| f64::from(pair[0]) * (1.0 - share_u) + f64::from(pair[1]) * share_u;
        Some(row(upper) * (1.0 - share_v) + row(lower) * share_v)
    }
}

/// Where a profile is sampled: distances from the centre line `[m]`, outwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ruler {
    /// First distance `[m]`.
    pub from_m: f64,
    /// Between two distances `[m]`.
    pub step_m: f64,
    /// How many.
    pub count: usize,
}

impl Ruler {
    /// From one distance to another, or a little beyond.
    #[must_use]
    pub fn over(from_m: f64, to_m: f64, step_m: f64) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small ratio; a cast saturates"
        )]
        let count = ((to_m - from_m) / step_m).ceil() as usize + 2;
        Self { from_m, step_m, count }
    }

    /// Distance of a sample, whole or between two `[m]`.
    #[must_use]
    pub fn distance_m(&self, sample: f64) -> f64 {
        self.from_m + self.step_m * sample
    }
}

/// Mean level at each distance on one side, `side` 1 to the left and -1 to the right, over the stations.
/// `None` where a station's profile leaves the picture.
#[must_use]
pub fn across(
    pixels: &Pixels<'_>,
    (camera, tool_m): (&Camera, [f64; 2]),
    stations: &[Station],
    (side, ruler): (f64, &Ruler),
) -> Option<Vec<f64>> {
    let mut sums = vec![0.0; ruler.count];
    for station in stations {
        let centre = camera.pixel(tool_m, station.point_m);
        // Image y runs against bed y.
        let step_px = side * ruler.step_m / camera.scale_m;
        let along = [station.left[0] * step_px, -station.left[1] * step_px];
        let first = ruler.from_m / ruler.step_m;
        let mut place = [centre[0] + first * along[0], centre[1] + first * along[1]];
        for sum in &mut sums {
            *sum += pixels.at(place)?;
            place = [place[0] + along[0], place[1] + along[1]];
        }
    }
    #[expect(clippy::cast_precision_loss, reason = "a handful of stations")]
    let count = stations.len() as f64;
    (count > 0.0).then(|| sums.iter().map(|sum| sum / count).collect())
}
