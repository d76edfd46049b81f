//! Heat maps: a part seen from above at an angle, and the hemisphere over height and motor angle.

use super::map::Spot;
use crate::process::{Canvas, Picture};
use anyhow::anyhow;
use models::hybrid::{ErrorMap, Mesh};
use nalgebra::{Rotation3, Vector3};
use plotters::prelude::*;

/// Where the machine does not work.
const REFUSED: RGBColor = RGBColor(190, 190, 190);
/// Direction of the view: turned about the vertical, then tipped `[rad]`.
const VIEW: (f64, f64) = (0.6, -1.0);
/// Width and height of the pictures.
const SIZE: (u32, u32) = (900, 720);

/// Colours of errors on a logarithmic scale `[mm]`.
struct Scale {
    low: f64,
    high: f64,
}

impl Scale {
    fn of(errors_mm: impl Iterator<Item = f64>) -> Self {
        let positive = errors_mm.filter(|error| *error > 0.0);
        let (low, high) =
            positive.fold((f64::INFINITY, 0.0_f64), |(low, high), error| (low.min(error), high.max(error)));
        if high <= 0.0 {
            Self { low: 1e-3, high: 1.0 }
        } else {
            // One error alone still gets a scale around it.
            Self { low: low.min(high / 1.2), high }
        }
    }

    fn share(&self, error_mm: f64) -> f64 {
        ((error_mm / self.low).ln() / (self.high / self.low).ln()).clamp(0.0, 1.0)
    }

    fn colour(&self, error_mm: Option<f64>) -> RGBColor {
        error_mm.map_or(REFUSED, |error_mm| ViridisRGB::get_color_normalized(self.share(error_mm), 0.0, 1.0))
    }

    /// A bar with five figures.
    fn draw(&self, canvas: &Canvas<'_>) -> anyhow::Result<()> {
        let style = ("sans-serif", 13).into_font().color(&BLACK);
        canvas.draw(&Text::new("error, mm", (8, 12), style.clone())).map_err(|error| anyhow!("{error}"))?;
        for step in 0..100 {
            let colour = ViridisRGB::get_color_normalized(f64::from(step) / 99.0, 0.0, 1.0);
            let top = 600 - 5 * step;
            let bar = Rectangle::new([(8, top), (32, top + 5)], colour.filled());
            canvas.draw(&bar).map_err(|error| anyhow!("{error}"))?;
        }
        for quarter in 0..=4 {
            let error_mm = self.low * (self.high / self.low).powf(f64::from(quarter) / 4.0);
            let label = Text::new(format!("{error_mm:.4}"), (38, 598 - 125 * quarter), style.clone());
            canvas.draw(&label).map_err(|error| anyhow!("{error}"))?;
        }
        canvas
            .draw(&Rectangle::new([(8, 630), (32, 650)], REFUSED.filled()))
            .and_then(|()| canvas.draw(&Text::new("refused", (38, 634), style)))
            .map_err(|error| anyhow!("{error}"))
    }
}

/// A part; triangles that look away are left out, and hidden ones are painted over by those before them.
pub(super) fn part(picture: &Picture, mesh: &Mesh, map: &ErrorMap) -> anyhow::Result<()> {
    let errors: Vec<Option<f64>> =
        map.cells.iter().map(|cell| cell.outcome.ok().map(|at| 1e3 * at.extremal.largest_m)).collect();
    let scale = Scale::of(errors.iter().copied().flatten());
    let view = Rotation3::from_axis_angle(&Vector3::x_axis(), VIEW.1)
        * Rotation3::from_axis_angle(&Vector3::z_axis(), VIEW.0);
    let mut seen: Vec<([Vector3<f64>; 3], Option<f64>)> = mesh
        .triangles()
        .iter()
        .zip(errors)
        .map(|(triangle, error)| (triangle.map(|corner| 1e3 * (view * corner)), error))
        .filter(|(triangle, _)| (triangle[1] - triangle[0]).cross(&(triangle[2] - triangle[0])).z > 0.0)
        .collect();
    let depth = |triangle: &[Vector3<f64>; 3]| triangle.iter().map(|corner| corner.z).sum::<f64>();
    seen.sort_by(|one, other| depth(&one.0).total_cmp(&depth(&other.0)));
    let corners = || seen.iter().flat_map(|(triangle, _)| triangle);
    let low = corners().fold(Vector3::repeat(f64::INFINITY), |low, corner| low.inf(corner));
    let high = corners().fold(Vector3::repeat(f64::NEG_INFINITY), |high, corner| high.sup(corner));
    // One scale in both directions; 700 by 660 pixels are left of the colour bar.
    let scale_px = (660.0 / (high.x - low.x)).min(640.0 / (high.y - low.y));
    #[allow(clippy::cast_possible_truncation, reason = "inside of the picture")]
    let pixel = |corner: &Vector3<f64>| {
        let across = 40.0 + scale_px * (corner.x - low.x);
        (across.round() as i32, (40.0 + scale_px * (high.y - corner.y)).round() as i32)
    };
    picture.draw("Worst kinematic error over the part", SIZE, |canvas| {
        let (main, bar) = canvas.split_horizontally(780);
        for (triangle, error) in &seen {
            let shape = Polygon::new(triangle.iter().map(pixel).collect::<Vec<_>>(), scale.colour(*error));
            main.draw(&shape).map_err(|error| anyhow!("{error}"))?;
        }
        scale.draw(&bar)
    })
}

/// The hemisphere: heights to the right, angles upward in steps of two.
pub(super) fn hemisphere(picture: &Picture, spots: &[Spot]) -> anyhow::Result<()> {
    let scale = Scale::of(spots.iter().filter_map(|spot| spot.error_mm));
    let heights: Vec<f64> = spots
        .iter()
        .take_while(|spot| (spot.angle_deg - spots[0].angle_deg).abs() < f64::EPSILON)
        .map(|spot| spot.height_mm)
        .collect();
    let half = heights.get(1).map_or(1.0, |second| 0.5 * (second - heights[0]));
    let top = heights.last().copied().unwrap_or(1.0) + half;
    let (finest, coarsest) =
        (spots.last().map_or(1e-3, |spot| spot.angle_deg), spots.first().map_or(1.0, |spot| spot.angle_deg));
    let root = std::f64::consts::SQRT_2;
    picture.draw("Worst kinematic error over the hemisphere", SIZE, |canvas| {
        let (main, bar) = canvas.split_horizontally(780);
        let mut chart = ChartBuilder::on(&main)
            .margin(16)
            .x_label_area_size(40)
            .y_label_area_size(64)
            .build_cartesian_2d(-half..top, (finest / root..coarsest * root).log_scale())
            .map_err(|error| anyhow!("{error}"))?;
        chart
            .configure_mesh()
            .disable_mesh()
            .x_desc("height on the hemisphere [mm]")
            .y_desc("every motor wrong by [deg]")
            .draw()
            .map_err(|error| anyhow!("{error}"))?;
        let cells = spots.iter().map(|spot| {
            let low = (spot.height_mm - half, spot.angle_deg / root);
            let high = (spot.height_mm + half, spot.angle_deg * root);
            Rectangle::new([low, high], scale.colour(spot.error_mm).filled())
        });
        chart.draw_series(cells).map_err(|error| anyhow!("{error}"))?;
        scale.draw(&bar)
    })
}
