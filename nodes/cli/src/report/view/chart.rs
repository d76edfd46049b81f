//! Plots against time, once for wide and once for narrow screens.

use super::ink::{Ink, styled};
use super::trace::{LETTERS, Marker, Shape, Trace};
use crate::report::series::Column;
use maud::{Markup, PreEscaped, html};
use plotters::prelude::*;

/// Size of a plot `[px]`, columns that it shows, and labels on its axes.
struct Size {
    class: &'static str,
    width: u32,
    height: u32,
    columns: usize,
    labels: (usize, usize),
}

const SIZES: [Size; 2] = [
    Size { class: "wide", width: 920, height: 250, columns: 420, labels: (10, 6) },
    Size { class: "narrow", width: 380, height: 230, columns: 170, labels: (5, 5) },
];
/// Width that the number of an event takes `[px]`: one that finds no room is left out.
const NUMBER_PX: f64 = 20.0;
/// Share of the columns whose extremes may lie beyond the value axis.
const BEYOND: f64 = 0.02;

/// A plot.
pub(crate) struct Plot<'a> {
    pub(crate) title: &'a str,
    pub(crate) unit: &'a str,
    /// Length of the time axis `[s]`.
    pub(crate) span_s: f64,
    pub(crate) traces: Vec<Trace<'a>>,
    pub(crate) markers: &'a [Marker],
    /// When a fault set in, a mark without a number.
    pub(crate) onset_s: Option<f64>,
    /// What the axis shows at least.
    pub(crate) shows: Option<(f64, f64)>,
    /// Where values belong: from, to.
    pub(crate) band: Option<(f64, f64)>,
    /// The values are logarithms to base 10.
    pub(crate) logarithm: bool,
}

impl Plot<'_> {
    /// The plot with its legend; nothing where no signal holds anything.
    pub(crate) fn draw(&self) -> Markup {
        let drawn: Vec<&Trace> = self.traces.iter().filter(|trace| !trace.series.is_empty()).collect();
        if drawn.is_empty() {
            return html! {};
        }
        let drawings = SIZES.iter().map(|size| (size.class, self.drawing(size, &drawn)));
        html! {
            figure.plot {
                figcaption {
                    b { (self.title) } " " span.unit { "[" (self.unit) "]" }
                    @for trace in &drawn {
                        span.key { i style=(format!("background:var(--{})", trace.ink.style())) {} (trace.name) }
                    }
                }
                @for (class, drawing) in drawings {
                    div class=(class) role="img" aria-label=(self.title) { (PreEscaped(drawing)) }
                }
            }
        }
    }

    fn drawing(&self, size: &Size, traces: &[&Trace]) -> String {
        let mut text = String::new();
        match self.draw_into(&mut text, size, traces) {
            Ok(()) => styled(&text),
            // The library fails only where its output does; here that is a string.
            Err(error) => maud::html! { p { "not drawn: " (error) } }.into_string(),
        }
    }

    fn draw_into(&self, text: &mut String, size: &Size, traces: &[&Trace]) -> anyhow::Result<()> {
        let (unit_s, unit) = time_unit(self.span_s);
        let (low, high) = self.range(size, traces);
        let root = SVGBackend::with_string(text, (size.width, size.height)).into_drawing_area();
        let failed = |error: &dyn std::fmt::Display| anyhow::anyhow!("{error}");
        let mut chart = ChartBuilder::on(&root)
            .margin_right(8)
            .margin_top(14)
            .x_label_area_size(38)
            .y_label_area_size(46)
            .build_cartesian_2d(0.0..(self.span_s / unit_s).max(1e-3), low..high)
            .map_err(|error| failed(&error))?;
        let letters = ("sans-serif", LETTERS).into_font().color(&Ink::Text.stand_in());
        let number = |value: &f64| if self.logarithm { power(*value) } else { number(*value, high - low) };
        chart
            .configure_mesh()
            .x_labels(size.labels.0)
            .y_labels(size.labels.1)
            .max_light_lines(0)
            .bold_line_style(Ink::Grid.stand_in().mix(0.5))
            .axis_style(Ink::Grid.stand_in())
            .label_style(letters.clone())
            .axis_desc_style(letters)
            .x_desc(unit)
            .x_label_formatter(&|at| self::number(*at, self.span_s / unit_s))
            .y_label_formatter(&number)
            .draw()
            .map_err(|error| failed(&error))?;
        let clip = |value: f64| value.clamp(low, high);
        let place = |column: &Column, value: f64| (column.at / unit_s, clip(value));
        let mut elements: Vec<Shape> = Vec::new();
        if let Some((from, to)) = self.band {
            let end = self.span_s / unit_s;
            elements.push(Shape::Filled(
                Ink::Good,
                vec![(0.0, clip(from)), (end, clip(from)), (end, clip(to)), (0.0, clip(to))],
            ));
        }
        for trace in traces {
            trace.shapes(size.columns, self.span_s, &place, &mut elements);
        }
        for at_s in self.onset_s.iter().filter(|at_s| **at_s <= self.span_s) {
            let (mark, at) = (Marker { at: *at_s, number: 0, ink: Ink::Target }, at_s / unit_s);
            elements.push(Shape::Marker(mark, false, [(at, low), (at, high)]));
        }
        let mut numbered = f64::NEG_INFINITY;
        for marker in self.markers.iter().filter(|marker| marker.at <= self.span_s) {
            let at = marker.at / unit_s;
            let apart_px = (marker.at - numbered) / self.span_s * f64::from(size.width);
            let free = apart_px > NUMBER_PX;
            numbered = if free { marker.at } else { numbered };
            elements.push(Shape::Marker(*marker, free, [(at, low), (at, high)]));
        }
        for shape in elements {
            shape.draw_on(&mut chart).map_err(|error| failed(&error))?;
        }
        drop(chart);
        root.present().map_err(|error| failed(&error))?;
        drop(root);
        Ok(())
    }

    /// Range of the value axis: all but the few furthest extremes, and what it has to show.
    fn range(&self, size: &Size, traces: &[&Trace]) -> (f64, f64) {
        let (mut lows, mut highs) = (Vec::new(), Vec::new());
        for trace in traces {
            for series in trace.drawn() {
                for column in series.columns(size.columns, self.span_s) {
                    lows.push(column.cell.low);
                    highs.push(column.cell.high);
                }
            }
        }
        lows.sort_by(f64::total_cmp);
        highs.sort_by(f64::total_cmp);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a part of a length
        let cut = (lows.len() as f64 * BEYOND) as usize;
        let cut = if traces.iter().any(|trace| trace.is_of_extremes()) { 0 } else { cut };
        let mut low = lows.get(cut).copied().unwrap_or(0.0);
        let mut high = highs.iter().rev().nth(cut).copied().unwrap_or(1.0);
        if let Some((from, to)) = self.shows {
            (low, high) = (low.min(from), high.max(to));
        }
        // Numbers as large as a float takes have no differences that could be drawn.
        (low, high) = (low.clamp(-1e12, 1e12), high.clamp(-1e12, 1e12));
        let room = ((high - low) * 0.06).max(low.abs().max(high.abs()) * 1e-6).max(1e-9);
        (low - room, high + room)
    }
}

/// Unit of a time axis of this length: its seconds and its name.
fn time_unit(span_s: f64) -> (f64, &'static str) {
    match span_s {
        s if s <= 180.0 => (1.0, "time [s]"),
        s if s <= 3.0 * 3600.0 => (60.0, "time [min]"),
        _ => (3600.0, "time [h]"),
    }
}

/// A number with the digits that an axis of this length needs.
fn number(value: f64, length: f64) -> String {
    let digits = match length {
        l if l > 5.5 => 0,
        l if l > 0.55 => 1,
        l if l > 0.055 => 2,
        _ => 4,
    };
    format!("{value:.digits$}")
}

/// A power of 10 with the digits that tell it from its neighbours.
fn power(exponent: f64) -> String {
    let value = 10_f64.powf(exponent);
    if value > 9.5 || (value - 1.0).abs() < 0.01 { format!("{value:.0}") } else { format!("{value:.1}") }
}
