//! How part and bed look in this very frame, and how much each coarse pixel looks like the one or the other.
//!
//! Fisher's discriminant over grey level, unevenness, slope and distance from the middle (for the lens' vignetting).
//! The frame itself teaches it: far inside the predicted outline all is part, far outside all is bed. A wall too thin
//! for that looks like the roads just laid, which lie where they were commanded, whatever was lost before.

use nalgebra::{SMatrix, SVector};
use opencv::core::{CV_32F, Mat, MatTraitConst, MatTraitConstManual, Size};
use opencv::imgproc;

const FEATURES: usize = 4;
type Features = SVector<f64, FEATURES>;

/// Features of every coarse pixel.
pub(crate) struct Looks {
    planes: [Vec<f32>; 3],
    columns: usize,
    rows: usize,
}

impl Looks {
    /// Features of a grey picture reduced to `columns` x `rows`.
    pub(crate) fn of(grey: &Mat, columns: usize, rows: usize) -> Result<Self, opencv::Error> {
        let size = Size::new(i32::try_from(columns).unwrap_or(1), i32::try_from(rows).unwrap_or(1));
        let (mut small, mut float) = (Mat::default(), Mat::default());
        imgproc::resize(grey, &mut small, size, 0.0, 0.0, imgproc::INTER_AREA)?;
        small.convert_to(&mut float, CV_32F, 1.0, 0.0)?;
        let smooth = blurred(&float, 1.0)?;
        let (mut dx, mut dy) = (Mat::default(), Mat::default());
        imgproc::sobel_def(&float, &mut dx, CV_32F, 1, 0)?;
        imgproc::sobel_def(&float, &mut dy, CV_32F, 0, 1)?;
        let (dx, dy) = (dx.data_typed::<f32>()?, dy.data_typed::<f32>()?);
        let slope: Vec<f32> = dx.iter().zip(dy).map(|(x, y)| (x * x + y * y).sqrt()).collect();
        let level = smooth.data_typed::<f32>()?.to_vec();
        let uneven: Vec<f32> =
            float.data_typed::<f32>()?.iter().zip(&level).map(|(own, mean)| (own - mean).abs()).collect();
        let soft = |plane: Vec<f32>| -> Result<Vec<f32>, opencv::Error> {
            let flat = Mat::from_slice(&plane)?;
            let plane = flat.reshape(1, size.height)?;
            Ok(blurred(&plane.try_clone()?, 1.0)?.data_typed::<f32>()?.to_vec())
        };
        Ok(Self { planes: [level, soft(uneven)?, soft(slope)?], columns, rows })
    }

    /// Features of a coarse pixel.
    pub(crate) fn at(&self, place: usize) -> Features {
        let centred = |value: usize, size: usize| {
            #[expect(clippy::cast_precision_loss, reason = "coarse pixels are far below 2^52")]
            let (value, size) = (value as f64, size as f64);
            2.0 * value / size - 1.0
        };
        let (x, y) = (centred(place % self.columns, self.columns), centred(place / self.columns, self.rows));
        let [level, uneven, slope] = &self.planes;
        Features::from([
            f64::from(level[place]),
            f64::from(uneven[place]),
            f64::from(slope[place]),
            100.0 * (x * x + y * y),
        ])
    }

    /// Log likelihood ratio of part against bed for every coarse pixel; `None` where the two look alike. Part has the
    /// looks of `fresh` where the old one shows too little of itself.
    pub(crate) fn ratios(&self, teach: &[Taught], fresh: &Class, bounds: &Bounds) -> Option<Vec<f64>> {
        let mut classes = [Class::default(), Class::default()];
        for (place, taught) in teach.iter().enumerate() {
            match taught {
                Taught::Part => classes[1].add(&self.at(place)),
                Taught::Bed => classes[0].add(&self.at(place)),
                Taught::No => {}
            }
        }
        let [bed, old] = classes;
        let enough = |class: &Class| class.count >= f64::from(bounds.samples_min);
        let part = if enough(&old) { &old } else { fresh };
        if !enough(&bed) || !enough(part) {
            return None;
        }
        let (mean_bed, spread_bed) = bed.moments();
        let (mean_part, spread_part) = part.moments();
        // A grey level each of what quantisation and reduction leave keeps the inverse sound.
        let spread = (spread_bed + spread_part) * 0.5 + SMatrix::identity();
        let difference = mean_part - mean_bed;
        let direction = spread.cholesky()?.solve(&difference);
        if direction.dot(&difference) < bounds.separation_min {
            return None;
        }
        let middle = direction.dot(&(mean_part + mean_bed)) * 0.5;
        let ratio = |place: usize| {
            (direction.dot(&self.at(place)) - middle).clamp(-bounds.ratio_max, bounds.ratio_max)
        };
        Some((0..teach.len()).map(ratio).collect())
    }
}

/// What a coarse pixel is known to show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Taught {
    /// Part, wherever it lies within the range.
    Part,
    /// Bed.
    Bed,
    /// Either.
    No,
}

/// What makes a discriminant worth using.
pub(crate) struct Bounds {
    pub(crate) samples_min: u32,
    pub(crate) separation_min: f64,
    pub(crate) ratio_max: f64,
}

/// Looks of some coarse pixels.
#[derive(Debug, Clone, Default)]
pub(crate) struct Class {
    count: f64,
    sum: Features,
    products: SMatrix<f64, FEATURES, FEATURES>,
}

impl Class {
    /// Takes one more.
    pub(crate) fn add(&mut self, features: &Features) {
        self.count += 1.0;
        self.sum += features;
        self.products += features * features.transpose();
    }

    /// Keeps this share of what was taken.
    pub(crate) fn fade(&mut self, kept: f64) {
        self.count *= kept;
        self.sum *= kept;
        self.products *= kept;
    }

    fn moments(&self) -> (Features, SMatrix<f64, FEATURES, FEATURES>) {
        let mean = self.sum / self.count;
        (mean, self.products / self.count - mean * mean.transpose())
    }
}

fn blurred(plane: &Mat, sigma_px: f64) -> Result<Mat, opencv::Error> {
    let mut smooth = Mat::default();
    imgproc::gaussian_blur_def(plane, &mut smooth, Size::default(), sigma_px)?;
    Ok(smooth)
}
