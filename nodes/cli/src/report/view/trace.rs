//! Signals and markers as shapes of a plot.

use super::ink::Ink;
use crate::report::record::signals::Estimated;
use crate::report::series::{Cell, Column, Series};
use plotters::prelude::*;

/// Size of letters, as the library counts.
pub(crate) const LETTERS: u32 = 15;

/// An event on the time axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Marker {
    pub(crate) at: f64,
    /// Number in the table of events.
    pub(crate) number: usize,
    pub(crate) ink: Ink,
}

/// One signal of a plot.
pub(crate) struct Trace<'a> {
    pub(super) name: &'a str,
    pub(super) ink: Ink,
    pub(super) series: &'a Series,
    band: Option<(&'a Series, &'a Series)>,
    form: Form,
}

/// How a signal is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    Line,
    /// Seen beside a line on top of it.
    Broad,
    Dots,
    /// A line of the largest values.
    Peaks,
}

impl<'a> Trace<'a> {
    /// A line of the mean with a shade from the smallest to the largest value.
    pub(crate) fn line(name: &'a str, ink: Ink, series: &'a Series) -> Self {
        Self { name, ink, series, band: None, form: Form::Line }
    }

    /// A line with the band of its uncertainty.
    pub(crate) fn estimated(name: &'a str, ink: Ink, estimated: &'a Estimated) -> Self {
        let band = Some((&estimated.low, &estimated.high));
        Self { name, ink, series: &estimated.value, band, form: Form::Line }
    }

    /// A line of the largest values: what lasts for one sample is seen in a plot of hours.
    pub(crate) fn peaks(name: &'a str, ink: Ink, series: &'a Series) -> Self {
        Self { name, ink, series, band: None, form: Form::Peaks }
    }

    /// Single values.
    pub(crate) fn dots(name: &'a str, ink: Ink, series: &'a Series) -> Self {
        Self { name, ink, series, band: None, form: Form::Dots }
    }

    /// A broad line of the mean, for what another one follows.
    pub(crate) fn broad(name: &'a str, ink: Ink, series: &'a Series) -> Self {
        Self { name, ink, series, band: None, form: Form::Broad }
    }
}

impl Trace<'_> {
    /// Each of its extremes is wanted on the value axis, however few they are.
    pub(super) fn is_of_extremes(&self) -> bool {
        self.form == Form::Peaks
    }

    /// Everything of it that takes room on the value axis.
    pub(super) fn drawn(&self) -> impl Iterator<Item = &Series> {
        let (low, high) = self.band.unzip();
        [Some(self.series), low, high].into_iter().flatten()
    }

    /// Its shapes in at most about so many columns.
    pub(super) fn shapes(
        &self,
        columns: usize,
        span_s: f64,
        place: &impl Fn(&Column, f64) -> (f64, f64),
        into: &mut Vec<Shape>,
    ) {
        if self.form == Form::Dots {
            let points = self.series.columns(columns, span_s);
            into.push(Shape::Dots(
                self.ink,
                points.iter().map(|column| place(column, column.cell.mean())).collect(),
            ));
            return;
        }
        let (low, high) = self.band.unwrap_or((self.series, self.series));
        for (low, high) in low.runs(columns, span_s).iter().zip(high.runs(columns, span_s)) {
            let below = low.iter().map(|column| place(column, column.cell.low));
            let above = high.iter().rev().map(|column| place(column, column.cell.high));
            into.push(Shape::Filled(self.ink, below.chain(above).collect()));
        }
        let thickness = if self.form == Form::Broad { 6 } else { 2 };
        for run in self.series.runs(columns, span_s) {
            let value = |cell: &Cell| if self.form == Form::Peaks { cell.high } else { cell.mean() };
            let line: Vec<_> = run.iter().map(|column| place(column, value(&column.cell))).collect();
            match line[..] {
                [_] => into.push(Shape::Dots(self.ink, line)),
                _ => into.push(Shape::Line(self.ink, thickness, line)),
            }
        }
    }
}

/// What is drawn.
pub(super) enum Shape {
    Filled(Ink, Vec<(f64, f64)>),
    Line(Ink, u32, Vec<(f64, f64)>),
    Dots(Ink, Vec<(f64, f64)>),
    Marker(Marker, bool, [(f64, f64); 2]),
}

/// Axes of a plot.
type Coordinates =
    Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>;

impl Shape {
    /// Draws it.
    pub(super) fn draw_on(
        self,
        chart: &mut ChartContext<'_, SVGBackend<'_>, Coordinates>,
    ) -> anyhow::Result<()> {
        let failed = |error: &dyn std::fmt::Display| anyhow::anyhow!("{error}");
        match self {
            Self::Filled(ink, points) => {
                let style = ink.stand_in().mix(0.16).filled();
                chart.draw_series([Polygon::new(points, style)]).map_err(|error| failed(&error))?;
            }
            Self::Line(ink, thickness, points) => {
                let shade = if thickness > 2 { 0.45 } else { 1.0 };
                let style = ink.stand_in().mix(shade).stroke_width(thickness);
                chart.draw_series([PathElement::new(points, style)]).map_err(|error| failed(&error))?;
            }
            Self::Dots(ink, points) => {
                let style = ink.stand_in().filled();
                let dots = points.into_iter().map(|point| Circle::new(point, 2, style));
                chart.draw_series(dots).map_err(|error| failed(&error))?;
            }
            Self::Marker(marker, numbered, ends) => {
                let style = marker.ink.stand_in().mix(0.7).stroke_width(1);
                chart.draw_series([PathElement::new(ends, style)]).map_err(|error| failed(&error))?;
                if !numbered {
                    return Ok(());
                }
                let number = Text::new(marker.number.to_string(), (-4, -13), number_style(&marker));
                let above = EmptyElement::at(ends[1]) + number;
                chart.draw_series([above]).map_err(|error| failed(&error))?;
            }
        }
        Ok(())
    }
}

fn number_style(marker: &Marker) -> TextStyle<'static> {
    ("sans-serif", LETTERS).into_font().color(&marker.ink.stand_in())
}
