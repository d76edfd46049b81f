//! Quality of each layer as a bar of its terms.

use super::ink::{Ink, styled};
use fdm_loop_msgs::LayerQuality;
use maud::{Markup, PreEscaped, html};
use plotters::prelude::*;

/// Bars of a plot; more layers than that share one, and the worst of them is shown.
const BARS_MAX: usize = 120;
/// Sizes as of the plots against time.
const SIZES: [(&str, u32, u32, usize); 2] = [("wide", 920, 230, 12), ("narrow", 380, 220, 5)];

/// Terms of Q with their names and inks, in the order in which they are stacked.
type Term = (&'static str, Ink, fn(&LayerQuality) -> f64);
const TERMS: [Term; 5] = [
    ("width", Ink::Measured, |quality| quality.width_term),
    ("temperature", Ink::Estimated, |quality| quality.temperature_term),
    ("features", Ink::Fifth, |quality| quality.feature_term),
    ("adhesion", Ink::Fourth, |quality| quality.adhesion_term),
    ("porosity", Ink::Target, |quality| quality.porosity_term),
];

/// One bar: a group of layers and the worst quality in it.
struct Bar<'a> {
    first: u32,
    last: u32,
    worst: &'a LayerQuality,
}

/// The plot with its legend; `qualities` by layer, ascending.
pub(crate) fn draw(qualities: &[&LayerQuality]) -> Markup {
    let group = qualities.len().div_ceil(BARS_MAX).max(1);
    let bars: Vec<Bar> = qualities
        .chunks(group)
        .filter_map(|group| {
            let worst = group.iter().max_by(|a, b| a.quality.total_cmp(&b.quality))?;
            Some(Bar { first: group.first()?.layer, last: group.last()?.layer, worst })
        })
        .collect();
    html! {
        figure.plot {
            figcaption {
                b { "Q" sub { "k" } " by layer" } " " span.unit { "[-], 0 is perfect" }
                @for (name, ink, _) in TERMS {
                    span.key { i style=(format!("background:var(--{})", ink.style())) {} (name) }
                }
            }
            @for (class, width, height, labels) in SIZES {
                div class=(class) role="img" aria-label="quality by layer" {
                    (PreEscaped(drawing(&bars, (width, height), labels)))
                }
            }
            @if group > 1 { p.note { "Each bar is the worst of " (group) " layers." } }
        }
    }
}

fn drawing(bars: &[Bar], size: (u32, u32), labels: usize) -> String {
    let mut text = String::new();
    match draw_into(&mut text, bars, size, labels) {
        Ok(()) => styled(&text),
        Err(error) => html! { p { "not drawn: " (error) } }.into_string(),
    }
}

fn draw_into(text: &mut String, bars: &[Bar], size: (u32, u32), labels: usize) -> anyhow::Result<()> {
    let failed = |error: &dyn std::fmt::Display| anyhow::anyhow!("{error}");
    let total = |bar: &Bar| TERMS.iter().map(|(_, _, term)| term(bar.worst)).sum::<f64>();
    let highest = bars.iter().map(total).fold(0.1, f64::max).min(1e12) * 1.05;
    let from = bars.first().map_or(0.0, |bar| f64::from(bar.first)) + 0.5;
    let to = bars.last().map_or(0.0, |bar| f64::from(bar.last)) + 1.5;
    let root = SVGBackend::with_string(text, size).into_drawing_area();
    let mut chart = ChartBuilder::on(&root)
        .margin_right(8)
        .margin_top(8)
        .x_label_area_size(38)
        .y_label_area_size(46)
        .build_cartesian_2d(from..to, 0.0..highest)
        .map_err(|error| failed(&error))?;
    let letters = ("sans-serif", 15).into_font().color(&Ink::Text.stand_in());
    chart
        .configure_mesh()
        .disable_x_mesh()
        .max_light_lines(0)
        .x_labels(labels)
        .y_labels(5)
        .bold_line_style(Ink::Grid.stand_in().mix(0.5))
        .axis_style(Ink::Grid.stand_in())
        .label_style(letters.clone())
        .axis_desc_style(letters)
        .x_desc("layer")
        .x_label_formatter(&|layer| {
            if layer.fract().abs() < 1e-6 { format!("{layer:.0}") } else { String::new() }
        })
        .draw()
        .map_err(|error| failed(&error))?;
    for bar in bars {
        let (left, right) = (f64::from(bar.first) + 0.62, f64::from(bar.last) + 1.38);
        let mut below = 0.0;
        for (_, ink, term) in TERMS {
            let above = (below + term(bar.worst)).min(highest);
            if above > below {
                let style = ink.stand_in().filled();
                chart
                    .draw_series([Rectangle::new([(left, below), (right, above)], style)])
                    .map_err(|error| failed(&error))?;
            }
            below = above;
        }
    }
    drop(chart);
    root.present().map_err(|error| failed(&error))
}
