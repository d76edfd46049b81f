//! `fdm advance export`: tables for slicers, start code for firmware.

use super::{Printed, Setup};
use crate::config::ConfigDir;
use crate::output::{self, Json};
use advance_predictor::compensation::{Predictor, Source};
use anyhow::bail;
use clap::Args;
use models::advance::{Condition, DriveKind};
use models::units::Celsius;
use serde::Serialize;
use std::fmt::Write;

/// K over layer heights, for one polymer, temperature and line width.
#[derive(Debug, Args)]
pub struct ExportArgs {
    #[command(flatten)]
    printed: Printed,
    /// Temperatures of the hot end `[degC]`; several give a table.
    #[arg(long, value_delimiter = ',', default_values_t = [215.0])]
    temperature: Vec<f64>,
    /// Layer heights `[mm]`.
    #[arg(long, value_delimiter = ',', default_values_t = [0.1, 0.15, 0.2, 0.25, 0.3])]
    height: Vec<f64>,
    /// Width of the line `[mm]`.
    #[arg(long, default_value_t = 0.45)]
    width: f64,
}

/// The figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Export {
    /// Drive.
    pub drive: DriveKind,
    /// Polymer.
    pub polymer: String,
    /// Line width.
    pub width_mm: f64,
    /// One row per temperature and layer height.
    pub rows: Vec<Row>,
    /// `filament_start_gcode` of PrusaSlicer and OrcaSlicer, Marlin's command, at the first temperature.
    pub prusaslicer_marlin: String,
    /// The same with Klipper's command.
    pub prusaslicer_klipper: String,
}

/// One row of the table.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Row {
    /// Temperature.
    pub temperature_c: f64,
    /// Layer height.
    pub height_mm: f64,
    /// K.
    pub advance_s: f64,
    /// Half width of its 95 % interval.
    pub half_width_s: f64,
    /// Inside the hull of the networks' data.
    pub in_hull: bool,
}

/// Runs the command.
///
/// # Errors
/// One line with the reason.
pub fn run(args: &ExportArgs) -> anyhow::Result<()> {
    let config = ConfigDir::find(args.printed.config.as_deref())?;
    let json = Json::new(args.printed.json.as_deref());
    json.check()?;
    let setup = Setup::load(&config)?;
    let export = export(args, &setup.predictor(&config, args.printed.drive.into())?)?;
    if !json.is_stdout() {
        output::line(&text(&export))?;
    }
    json.write(&export)
}

fn export(args: &ExportArgs, predictor: &Predictor) -> anyhow::Result<Export> {
    let polymer = args.printed.polymer();
    let mut heights_mm = args.height.clone();
    heights_mm.sort_by(f64::total_cmp);
    let mut rows = vec![];
    for temperature_c in &args.temperature {
        for height_mm in &heights_mm {
            let at = Condition {
                temperature: Celsius(*temperature_c),
                height_m: 1e-3 * height_mm,
                width_m: 1e-3 * args.width,
            };
            let foretold = predictor.predict(&polymer, &at)?;
            rows.push(Row {
                temperature_c: *temperature_c,
                height_mm: *height_mm,
                advance_s: foretold.advance.0,
                half_width_s: foretold.half_width.0,
                in_hull: foretold.source == Source::Network,
            });
        }
    }
    if rows.is_empty() {
        bail!("no temperature or no layer height");
    }
    let first = &rows[..heights_mm.len()];
    Ok(Export {
        drive: predictor.drive(),
        polymer,
        width_mm: args.width,
        prusaslicer_marlin: macro_text("M900 K", first),
        prusaslicer_klipper: macro_text("SET_PRESSURE_ADVANCE ADVANCE=", first),
        rows,
    })
}

/// A slicer's conditional: the K of the nearest layer height.
fn macro_text(command: &str, rows: &[Row]) -> String {
    let mut text = command.to_owned();
    for (place, row) in rows.iter().enumerate() {
        // Writing to a string cannot fail.
        _ = match rows.get(place + 1) {
            Some(next) => {
                let word = if place == 0 { "if" } else { "elsif" };
                let middle_mm = 0.5 * (row.height_mm + next.height_mm);
                write!(text, "{{{word} layer_height<{middle_mm:.3}}}{:.4}", row.advance_s)
            }
            None if place == 0 => write!(text, "{:.4}", row.advance_s),
            None => write!(text, "{{else}}{:.4}{{endif}}", row.advance_s),
        };
    }
    text
}

fn text(export: &Export) -> String {
    let mut lines = vec![
        format!("{}, {}, line {:.2} mm", export.polymer, export.drive.name(), export.width_mm),
        "temperature  layer      K          +- (95 %)".to_owned(),
    ];
    for row in &export.rows {
        lines.push(format!(
            "{:7.1} degC  {:.2} mm  {:8.4} s  {:8.4} s{}",
            row.temperature_c,
            row.height_mm,
            row.advance_s,
            row.half_width_s,
            if row.in_hull { "" } else { "  physical model: outside of the networks' data" }
        ));
    }
    lines.push(format!("start code for Marlin\n  {}", export.prusaslicer_marlin));
    lines.push(format!("start code for Klipper\n  {}", export.prusaslicer_klipper));
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(height_mm: f64, advance_s: f64) -> Row {
        Row { temperature_c: 215.0, height_mm, advance_s, half_width_s: 0.01, in_hull: true }
    }

    #[test]
    fn a_conditional_names_the_nearest_height() {
        let rows = [row(0.1, 0.9), row(0.2, 0.63), row(0.3, 0.59)];
        assert_eq!(
            macro_text("M900 K", &rows),
            "M900 K{if layer_height<0.150}0.9000{elsif layer_height<0.250}0.6300{else}0.5900{endif}"
        );
        assert_eq!(macro_text("M900 K", &rows[..1]), "M900 K0.9000");
    }
}
