//! Picture of a simulated wall: height RMS by layer, and the last layer's profile.

use super::sim::{Figures, Group};
use crate::process::{Canvas, Picture};
use anyhow::anyhow;
use plotters::prelude::*;

/// Open and closed.
const COLOURS: [RGBColor; 2] = [RGBColor(200, 80, 40), RGBColor(30, 90, 170)];

/// Draws both charts.
pub(super) fn draw(picture: &Picture, figures: &Figures, length_m: f64) -> anyhow::Result<()> {
    picture.draw("Simulated wire wall, height error", (900, 700), |canvas| {
        let (upper, lower) = canvas.split_vertically(350);
        let by_layer = |group: &Group| numbered(&group.rms_by_layer_mm, 1.0, 1.0);
        chart(&upper, ("height RMS by layer, mean of the seeds [mm]", "layer"), figures, by_layer)?;
        let profile = |group: &Group| {
            let heights = group.runs.first().map_or(&[][..], |run| &run.profile_mm);
            #[allow(clippy::cast_precision_loss, reason = "few cells")]
            let cell_mm = 1e3 * length_m / heights.len().max(1) as f64;
            numbered(heights, 0.5 * cell_mm, cell_mm)
        };
        chart(
            &lower,
            ("height error of the last layer, first seed [mm]", "along the wall [mm]"),
            figures,
            profile,
        )
    })
}

#[allow(clippy::cast_precision_loss, reason = "few points")]
fn numbered(values: &[f64], first: f64, step: f64) -> Vec<(f64, f64)> {
    values.iter().enumerate().map(|(index, value)| (first + step * index as f64, *value)).collect()
}

fn chart(
    canvas: &Canvas<'_>,
    (title, axis): (&str, &str),
    figures: &Figures,
    points: impl Fn(&Group) -> Vec<(f64, f64)>,
) -> anyhow::Result<()> {
    let lines: Vec<Vec<(f64, f64)>> = figures.results.iter().map(points).collect();
    let all = || lines.iter().flatten();
    let bounds = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((0.0_f64, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)))
    };
    let (x, y) = (bounds(&mut all().map(|point| point.0)), bounds(&mut all().map(|point| point.1)));
    let margin = 0.05 * (y.1 - y.0).max(1e-3);
    let mut chart = ChartBuilder::on(canvas)
        .margin(12)
        .caption(title, ("sans-serif", 18))
        .x_label_area_size(36)
        .y_label_area_size(56)
        .build_cartesian_2d(x.0..x.1, y.0 - margin..y.1 + margin)
        .map_err(|error| anyhow!("{error}"))?;
    chart.configure_mesh().x_desc(axis).draw().map_err(|error| anyhow!("{error}"))?;
    for ((group, line), colour) in figures.results.iter().zip(lines).zip(COLOURS) {
        chart
            .draw_series([PathElement::new(line, colour.stroke_width(2))])
            .map_err(|error| anyhow!("{error}"))?
            .label(group.control)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2)));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .border_style(BLACK.mix(0.3))
        .background_style(WHITE)
        .draw()
        .map_err(|error| anyhow!("{error}"))?;
    Ok(())
}
