//! The picture in the sizes that the features are taken from.

use super::{FeatureError, Hidden};
use opencv::core::{CV_8UC1, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Rect, Size};
use opencv::imgproc;

/// Side of the smallest picture that is looked at `[px]`.
const LEAST_PX: i32 = 64;
/// The finer size `[px]`: a road of the toolhead's view is seven wide.
pub(super) const FINE: (usize, usize) = (320, 240);
/// The coarser size `[px]`.
pub(super) const COARSE: (usize, usize) = (160, 120);
/// Cells of the grid that local values are taken over, columns and rows.
pub(super) const CELLS: (usize, usize) = (10, 8);

/// A plane of values, row by row.
#[derive(Debug, Clone)]
pub(crate) struct Plane {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) values: Vec<f32>,
}

/// The picture, reduced.
pub(super) struct Picture {
    /// [`FINE`], 8 bit.
    pub(super) fine: Mat,
    /// [`FINE`], slightly smoothed, grey levels 0 to 1.
    pub(super) smooth: Plane,
    /// [`COARSE`], grey levels 0 to 1.
    pub(super) coarse: Plane,
    /// Variance of `smooth`, kept above that of a picture of one grey.
    pub(super) variance: f64,
}

impl Picture {
    pub(super) fn of(grey: &Mat, hidden: Hidden) -> Result<Self, FeatureError> {
        let (width, height) = (grey.cols(), grey.rows());
        if grey.typ() != CV_8UC1 || width < LEAST_PX || height < LEAST_PX {
            return Err(FeatureError::Picture { width, height, kind: grey.typ(), least: LEAST_PX });
        }
        let cut = Mat::roi(grey, four_to_three(width, height))?;
        let mut fine = reduced(&cut, FINE)?;
        even_out(&mut fine, hidden)?;
        let mut smooth = Mat::default();
        imgproc::gaussian_blur(
            &fine,
            &mut smooth,
            Size::new(3, 3),
            0.8,
            0.8,
            opencv::core::BORDER_REFLECT_101,
        )?;
        let smooth = Plane::of(&smooth)?;
        let coarse = Plane::of(&reduced(&fine, COARSE)?)?;
        let variance = smooth.variance().max(1e-5);
        Ok(Self { fine, smooth, coarse, variance })
    }
}

/// The largest part of 4:3 around the middle.
fn four_to_three(width: i32, height: i32) -> Rect {
    let (cut_width, cut_height) = (width.min(height * 4 / 3), height.min(width * 3 / 4));
    Rect::new((width - cut_width) / 2, (height - cut_height) / 2, cut_width, cut_height)
}

/// Fills the hidden disc with the mean of the ring around it, with a soft rim: the head is no part of the print.
fn even_out(fine: &mut Mat, Hidden(share): Hidden) -> opencv::Result<()> {
    /// Width of rim and ring, in radii.
    const RIM: f64 = 0.25;
    let (columns, rows) = (fine.cols(), fine.rows());
    let radius = share * f64::from(rows);
    let inside = share > 0.0 && share <= 0.5;
    if !inside {
        return Ok(());
    }
    let width = usize::try_from(columns).unwrap_or(1);
    let middle = (f64::from(columns - 1) / 2.0, f64::from(rows - 1) / 2.0);
    let places = |index: usize| {
        #[expect(clippy::cast_precision_loss, reason = "pixels of a small picture")]
        let (x, y) = ((index % width) as f64, (index / width) as f64);
        ((x - middle.0).powi(2) + (y - middle.1).powi(2)).sqrt() / radius
    };
    let pixels = fine.data_typed_mut::<u8>()?;
    let ring = pixels.iter().enumerate().filter(|(index, _)| (1.0..1.0 + RIM).contains(&places(*index)));
    let level = mean(ring.map(|(_, grey)| f64::from(*grey)));
    for (index, grey) in pixels.iter_mut().enumerate() {
        let cover = ((1.0 + RIM - places(index)) / RIM).clamp(0.0, 1.0);
        if cover > 0.0 {
            let mixed = cover * level + (1.0 - cover) * f64::from(*grey);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "between two grey levels"
            )]
            let rounded = mixed.round() as u8;
            *grey = rounded;
        }
    }
    Ok(())
}

fn reduced(from: &impl opencv::core::ToInputArray, (width, height): (usize, usize)) -> opencv::Result<Mat> {
    let side = |pixels: usize| i32::try_from(pixels).unwrap_or(i32::MAX);
    let mut to = Mat::default();
    imgproc::resize(from, &mut to, Size::new(side(width), side(height)), 0.0, 0.0, imgproc::INTER_AREA)?;
    Ok(to)
}

impl Plane {
    /// An 8 bit picture as levels from 0 to 1.
    pub(crate) fn of(grey: &Mat) -> opencv::Result<Self> {
        let side = |pixels: i32| usize::try_from(pixels).unwrap_or(0);
        let values = grey.data_typed::<u8>()?.iter().map(|level| f32::from(*level) / 255.0).collect();
        Ok(Self { width: side(grey.cols()), height: side(grey.rows()), values })
    }

    pub(crate) fn at(&self, x: usize, y: usize) -> f32 {
        self.values[y * self.width + x]
    }

    pub(super) fn mean(&self) -> f64 {
        mean(self.values.iter().map(|value| f64::from(*value)))
    }

    pub(super) fn variance(&self) -> f64 {
        let mean_level = self.mean();
        mean(self.values.iter().map(|value| (f64::from(*value) - mean_level).powi(2)))
    }

    /// Index of the cell of the grid that a pixel lies in.
    pub(super) fn cell(&self, x: usize, y: usize) -> usize {
        (y * CELLS.1 / self.height) * CELLS.0 + x * CELLS.0 / self.width
    }
}

/// Mean of values; 0 of none.
pub(super) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_u32), |(sum, count), value| (sum + value, count + 1));
    if count == 0 { 0.0 } else { sum / f64::from(count) }
}

/// Standard deviation around a mean.
pub(super) fn deviation(values: &[f64], around: f64) -> f64 {
    mean(values.iter().map(|value| (value - around).powi(2))).sqrt()
}

/// Value that `share` of the values lie below; 0 of none.
pub(super) fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "a place in a short list"
    )]
    let place = (share * values.len().saturating_sub(1) as f64).round() as usize;
    values.get(place).copied().unwrap_or(0.0)
}
