//! The old part as predicted in one view, beside what the picture shows there.

use super::footprint::{Footprint, Lies};
use super::looks::{Bounds, Class, Looks, Taught};
use super::{FINENESS, OffsetParams, whole};
use crate::camera::Camera;
use crate::surroundings::{Mask, REDUCTION};
use opencv::core::{Mat, MatTraitConst, MatTraitConstManual, Size};
use opencv::imgproc;

/// The old part as predicted in one view, in coarse pixels.
pub(super) struct OldView {
    columns: usize,
    rows: usize,
    /// 1 for part, -1 for bed, 0 for what may look like either.
    signs: Vec<i16>,
    /// The pixel shows neither head nor newer road.
    counts: Vec<bool>,
}

impl OldView {
    pub(super) fn new(
        (footprint, level): (&Footprint, (f64, f64)),
        hides: &Mask,
        (camera, tool_m): (&Camera, [f64; 2]),
    ) -> Result<Self, opencv::Error> {
        let (hides, columns) = hides.levels()?;
        let rows = hides.len() / columns.max(1);
        let (mut signs, mut counts) = (Vec::with_capacity(hides.len()), Vec::with_capacity(hides.len()));
        for (place, hidden) in hides.iter().enumerate() {
            #[expect(clippy::cast_precision_loss, reason = "coarse pixels are far below 2^52")]
            let coarse = [(place % columns) as f64, (place / columns) as f64];
            let pixel = coarse.map(|value| (value + 0.5) * REDUCTION - 0.5);
            signs.push(match footprint.at(camera.bed(tool_m, pixel), level) {
                Lies::Part => 1,
                Lies::Deep => 0,
                Lies::Bed => -1,
            });
            counts.push(*hidden == 0 && camera.sees(pixel, 1.0));
        }
        Ok(Self { columns, rows, signs, counts })
    }

    /// Features of a picture at the coarse pixels.
    pub(super) fn looks(&self, grey: &Mat) -> Result<Looks, opencv::Error> {
        Looks::of(grey, self.columns, self.rows)
    }

    /// Teaches the looks and yields the ratio of every pixel, 0 where none counts. What may look like either does not
    /// count wherever the outline is moved: it would speak for every offset that makes bed of it.
    pub(super) fn ratios(
        &self,
        looks: &Looks,
        fresh: &Class,
        (params, camera): (&OffsetParams, &Camera),
    ) -> Result<Option<Vec<i16>>, opencv::Error> {
        let sure_px = params.sure_m / (camera.scale_m * REDUCTION);
        let part = self.eroded(1, sure_px)?;
        let bed = self.eroded(-1, sure_px)?;
        let taught: Vec<Taught> = (0..self.signs.len())
            .map(|place| match (self.counts[place], part[place], bed[place]) {
                (true, true, _) => Taught::Part,
                (true, _, true) => Taught::Bed,
                _ => Taught::No,
            })
            .collect();
        let bounds = Bounds {
            samples_min: params.samples_min,
            separation_min: params.separation_min,
            ratio_max: params.ratio_max,
        };
        let ratios = looks.ratios(&taught, fresh, &bounds);
        #[expect(clippy::cast_possible_truncation, reason = "bounded by ratio_max; a cast saturates")]
        let counted = |ratios: Vec<f64>| {
            let told = self.counts.iter().zip(&self.signs).map(|(counts, sign)| *counts && *sign != 0);
            ratios
                .iter()
                .zip(told)
                .map(|(ratio, told)| if told { (ratio * FINENESS) as i16 } else { 0 })
                .collect()
        };
        Ok(ratios.map(counted))
    }

    /// Takes gaps inside the part up to `gap_px`, and a fringe around it, from the bed.
    pub(super) fn leave_out(&mut self, [gap_px, fringe_px]: [f64; 2]) -> Result<(), opencv::Error> {
        let (mut closed, mut out) = (Mat::default(), Mat::default());
        imgproc::morphology_ex_def(&self.plane(1)?, &mut closed, imgproc::MORPH_CLOSE, &disc(0.5 * gap_px)?)?;
        imgproc::dilate_def(&closed, &mut out, &disc(fringe_px)?)?;
        for (sign, level) in self.signs.iter_mut().zip(out.data_bytes()?) {
            if *level > 0 && *sign < 0 {
                *sign = 0;
            }
        }
        Ok(())
    }

    /// Pixels around which all is of one sign, as far as `reach_px`.
    fn eroded(&self, sign: i16, reach_px: f64) -> Result<Vec<bool>, opencv::Error> {
        let out = eroded(&self.plane(sign)?, reach_px)?;
        Ok(out.data_bytes()?.iter().map(|level| *level > 0).collect())
    }

    /// 255 where the pixel has this sign.
    fn plane(&self, sign: i16) -> Result<Mat, opencv::Error> {
        let bytes: Vec<u8> = self.signs.iter().map(|own| if *own == sign { 255 } else { 0 }).collect();
        let flat = Mat::from_slice(&bytes)?;
        flat.reshape(1, i32::try_from(self.rows).unwrap_or(1))?.try_clone()
    }

    /// `sum ratio(q) s(q - d)` with `d` in coarse pixels; beyond the view the outline is carried on from its border.
    pub(super) fn agreement(&self, ratios: &[i16], moved: [i32; 2]) -> f64 {
        let inside =
            |value: i32, size: usize| usize::try_from(value.max(0)).unwrap_or(0).min(size.saturating_sub(1));
        let product = |ratios: &[i16], signs: &[i16]| -> i32 {
            ratios.iter().zip(signs).map(|(ratio, sign)| i32::from(*ratio) * i32::from(*sign)).sum()
        };
        let alone = |ratios: &[i16]| -> i32 { ratios.iter().map(|ratio| i32::from(*ratio)).sum() };
        let mut sum = 0.0;
        for (row, ratios) in ratios.chunks_exact(self.columns).enumerate() {
            let from = inside(i32::try_from(row).unwrap_or(0) - moved[1], self.rows) * self.columns;
            let signs = &self.signs[from..from + self.columns];
            let ahead = usize::try_from(moved[0].max(0)).unwrap_or(0).min(self.columns);
            let behind = usize::try_from((-moved[0]).max(0)).unwrap_or(0).min(self.columns);
            let middle = &ratios[ahead..self.columns - behind];
            let line = product(middle, &signs[behind..self.columns - ahead]);
            let left = alone(&ratios[..ahead]) * i32::from(signs[0]);
            let right = alone(&ratios[self.columns - behind..]) * i32::from(signs[self.columns - 1]);
            sum += f64::from(line + left + right);
        }
        sum
    }
}

/// What is left of a plane less what lies within `reach_px` of anything else.
pub(super) fn eroded(plane: &Mat, reach_px: f64) -> Result<Mat, opencv::Error> {
    let mut out = Mat::default();
    imgproc::erode_def(plane, &mut out, &disc(reach_px)?)?;
    Ok(out)
}

/// Disc of this radius as a structuring element.
fn disc(radius_px: f64) -> Result<Mat, opencv::Error> {
    let side = 2 * whole(radius_px.round()).max(0) + 1;
    imgproc::get_structuring_element_def(imgproc::MORPH_ELLIPSE, Size::new(side, side))
}
