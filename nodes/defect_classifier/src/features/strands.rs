//! Thin things: lines brighter or darker than what is around them, found by a top hat or a black hat, as components.

use super::picture::{FINE, Picture};
use opencv::core::{Mat, MatTraitConst, MatTraitConstManual, Point, Size};
use opencv::imgproc;

pub(super) const NAMES: [&str; 12] = [
    "bright_height",
    "bright_share",
    "bright_count",
    "bright_largest",
    "bright_fill",
    "bright_long",
    "dark_height",
    "dark_share",
    "dark_count",
    "dark_largest",
    "dark_fill",
    "dark_long",
];
/// Side of what is still thin `[px]` of the fine size.
const THIN_PX: i32 = 9;
/// Components below are specks `[px]`.
const SPECK_PX: i32 = 12;
/// Diagonal of the box of a long component `[px]`.
const LONG_PX: f64 = 40.0;
/// Least height of a line above its surroundings, in standard deviations of the picture.
const HEIGHT: f64 = 0.6;

pub(super) fn of(picture: &Picture) -> opencv::Result<[f64; 12]> {
    let mut values = [0.0; 12];
    let spread = 255.0 * picture.variance.sqrt();
    values[..6].copy_from_slice(&lines(&picture.fine, imgproc::MORPH_TOPHAT, spread)?);
    values[6..].copy_from_slice(&lines(&picture.fine, imgproc::MORPH_BLACKHAT, spread)?);
    Ok(values)
}

/// Mean height, share of the picture, number, share of the largest in all, fill of their boxes, share of long ones.
fn lines(grey: &Mat, hat: i32, spread: f64) -> opencv::Result<[f64; 6]> {
    let kernel = imgproc::get_structuring_element(
        imgproc::MORPH_ELLIPSE,
        Size::new(THIN_PX, THIN_PX),
        Point::new(-1, -1),
    )?;
    let mut heights = Mat::default();
    let border = imgproc::morphology_default_border_value()?;
    let anchor = Point::new(-1, -1);
    imgproc::morphology_ex(
        grey,
        &mut heights,
        hat,
        &kernel,
        anchor,
        1,
        opencv::core::BORDER_REFLECT_101,
        border,
    )?;
    let height = opencv::core::mean(&heights, &opencv::core::no_array())?[0];
    let mut thin = Mat::default();
    imgproc::threshold(&heights, &mut thin, (HEIGHT * spread).max(3.0), 255.0, imgproc::THRESH_BINARY)?;
    let (mut labels, mut stats, mut centres) = (Mat::default(), Mat::default(), Mat::default());
    let count = imgproc::connected_components_with_stats(
        &thin,
        &mut labels,
        &mut stats,
        &mut centres,
        8,
        opencv::core::CV_32S,
    )?;
    let [share, number, largest, fill, long] = components(&stats, count)?;
    Ok([height / spread, share, number, largest, fill, long])
}

/// Figures of the components but the first, which is the ground.
fn components(stats: &Mat, count: i32) -> opencv::Result<[f64; 5]> {
    let (mut area, mut number, mut largest, mut fill, mut long) = (0.0, 0.0_f64, 0.0_f64, 0.0, 0.0);
    let columns = usize::try_from(stats.cols()).unwrap_or(0).max(1);
    let rows = stats.data_typed::<i32>()?.chunks_exact(columns);
    for row in rows.take(usize::try_from(count).unwrap_or(0)).skip(1) {
        // Left, top, width, height, area.
        let &[_, _, width, height, pixels] = row else { continue };
        if pixels < SPECK_PX {
            continue;
        }
        let (width, height, pixels) = (f64::from(width), f64::from(height), f64::from(pixels));
        area += pixels;
        number += 1.0;
        largest = largest.max(pixels);
        fill += pixels / (width * height);
        if width.hypot(height) > LONG_PX {
            long += pixels;
        }
    }
    #[expect(clippy::cast_precision_loss, reason = "pixels of a small picture")]
    let all = (FINE.0 * FINE.1) as f64;
    let covered: f64 = area;
    Ok([
        covered / all,
        number.ln_1p(),
        largest / covered.max(1.0),
        fill / number.max(1.0),
        long / covered.max(1.0),
    ])
}
