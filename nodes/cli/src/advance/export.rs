//! `fdm advance export`: tables for slicers, start code for firmware.

use super::networks::{IntervalOf, Networks, outside};
use super::predict::BY_PHYSICS;
use super::{Place, Printed, Setup};
use crate::config::ConfigDir;
use crate::output::{self, Json};
use advance_predictor::compensation::{Predictor, Source};
use anyhow::{Context, bail};
use clap::Args;
use models::advance::DriveKind;
use serde::Serialize;
use std::fmt::Write;

/// K over temperatures and layer heights, for one polymer and line width.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct ExportArgs {
    #[command(flatten)]
    printed: Printed,
    /// Temperatures of the hot end `[degC]`, separated by commas or blanks; the start code asks for the nearest one.
    #[arg(long, num_args = 1.., value_delimiter = ',', default_values_t = [215.0])]
    temperature: Vec<f64>,
    /// Layer heights `[mm]`, separated by commas or blanks; the start code asks for the nearest one.
    #[arg(long, num_args = 1.., value_delimiter = ',', default_values_t = [0.1, 0.15, 0.2, 0.25, 0.3])]
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
    /// The networks that were asked.
    pub networks: Networks,
    /// `filament_start_gcode` in the macro language of PrusaSlicer, Marlin's command: the K of the nearest temperature and
    /// layer height.
    pub prusaslicer_marlin: String,
    /// The same with Klipper's command.
    pub prusaslicer_klipper: String,
    /// The same for OrcaSlicer, which names the temperature otherwise.
    pub orcaslicer_marlin: String,
    /// The same with Klipper's command.
    pub orcaslicer_klipper: String,
}

/// One row of the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Temperature.
    pub temperature_c: f64,
    /// Layer height.
    pub height_mm: f64,
    /// K.
    pub advance_s: f64,
    /// Half width of its interval.
    pub half_width_s: f64,
    /// What the interval is of.
    pub interval_of: IntervalOf,
    /// Inside the hull of the networks' data.
    pub in_hull: bool,
    /// What of the condition lies outside of it: the physical model answered.
    pub outside: Vec<String>,
}

/// Runs the command.
///
/// # Errors
/// One line with the reason.
pub fn run(args: &ExportArgs) -> anyhow::Result<()> {
    let config = ConfigDir::find(args.printed.config.as_deref())?;
    let json = Json::new(args.printed.json.as_deref());
    json.check()?;
    let printed = &args.printed;
    Setup::check_apart(printed.json.as_deref(), &config, printed.models.as_deref())?;
    let setup = Setup::load(&config)?;
    let (predictor, networks) = args.printed.predictor(&setup, &config)?;
    let export = export(args, &setup, (&predictor, networks))?;
    if !json.is_stdout() {
        output::line(&text(&export))?;
    }
    json.write(&export)
}

fn export(
    args: &ExportArgs,
    setup: &Setup,
    (predictor, networks): (&Predictor, Networks),
) -> anyhow::Result<Export> {
    let polymer = args.printed.polymer();
    let temperatures_c = in_order("--temperature", &args.temperature)?;
    let heights_mm = in_order("--height", &args.height)?;
    let mut rows = vec![];
    for temperature in temperatures_c {
        for height in &heights_mm {
            let place = Place { temperature, height: *height, width: args.width };
            setup.check(&polymer, &place)?;
            let foretold = predictor
                .predict(&polymer, &place.condition())
                .with_context(|| format!("--temperature {temperature} --height {height}"))?;
            rows.push(Row {
                temperature_c: temperature,
                height_mm: *height,
                advance_s: foretold.advance.0,
                half_width_s: foretold.half_width.0,
                interval_of: IntervalOf::of(foretold.source, predictor.ensemble()),
                in_hull: foretold.source == Source::Network,
                outside: outside(predictor.ensemble(), &polymer, &place.condition()),
            });
        }
    }
    let code = |slicer: &str, command: &str| macro_text(slicer, command, &rows);
    Ok(Export {
        drive: predictor.drive(),
        polymer,
        width_mm: args.width,
        networks,
        prusaslicer_marlin: code(PRUSASLICER, MARLIN),
        prusaslicer_klipper: code(PRUSASLICER, KLIPPER),
        orcaslicer_marlin: code(ORCASLICER, MARLIN),
        orcaslicer_klipper: code(ORCASLICER, KLIPPER),
        rows,
    })
}

/// The values of an option, rising.
fn in_order(option: &str, values: &[f64]) -> anyhow::Result<Vec<f64>> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.windows(2).find(|pair| pair[0] >= pair[1]) {
        Some(pair) => bail!("{option} {}: is there twice", pair[0]),
        None if sorted.is_empty() => bail!("{option}: no value"),
        None => Ok(sorted),
    }
}

/// Commands of firmware, up to their number.
const MARLIN: &str = "M900 K";
const KLIPPER: &str = "SET_PRESSURE_ADVANCE ADVANCE=";
/// The hot end's set-point in the macro languages of slicers.
const PRUSASLICER: &str = "temperature[0]";
const ORCASLICER: &str = "nozzle_temperature[0]";

/// A slicer's conditional: the K of the nearest temperature and, there, of the nearest layer height. `rows` rise by
/// temperature, then by height.
fn macro_text(temperature: &str, command: &str, rows: &[Row]) -> String {
    let mut text = command.to_owned();
    for (place, row) in rows.iter().enumerate() {
        let hotter = rows.iter().find(|other| other.temperature_c > row.temperature_c);
        let higher = rows.get(place + 1).filter(|next| next.height_mm > row.height_mm);
        let conditions: Vec<String> = [
            hotter.map(|next| (temperature, 0.5 * (row.temperature_c + next.temperature_c))),
            higher.map(|next| ("layer_height", 0.5 * (row.height_mm + next.height_mm))),
        ]
        .into_iter()
        .flatten()
        .map(|(name, middle)| format!("{name}<{middle:.3}"))
        .collect();
        // Writing to a string cannot fail.
        _ = match (place, conditions.is_empty()) {
            (0, true) => Ok(()),
            (0, false) => write!(text, "{{if {}}}", conditions.join(" and ")),
            (_, true) => write!(text, "{{else}}"),
            (_, false) => write!(text, "{{elsif {}}}", conditions.join(" and ")),
        };
        _ = write!(text, "{:.4}", row.advance_s);
    }
    if rows.len() > 1 {
        text.push_str("{endif}");
    }
    text + &by_physics(rows)
}

/// A comment that names the conditions of which the physical model answered.
fn by_physics(rows: &[Row]) -> String {
    let outside: Vec<String> = rows
        .iter()
        .filter(|row| !row.in_hull)
        .map(|row| format!("{} degC {} mm", row.temperature_c, row.height_mm))
        .collect();
    if outside.is_empty() { String::new() } else { format!("{BY_PHYSICS} at {}", outside.join(", ")) }
}

fn text(export: &Export) -> String {
    let mut lines = vec![
        format!("{}, {}, line {:.2} mm", export.polymer, export.drive.name(), export.width_mm),
        format!("networks {}", export.networks.text()),
        "temperature  layer      K          +-".to_owned(),
    ];
    for row in &export.rows {
        lines.push(format!(
            "{:7.1} degC  {:.2} mm  {:8.4} s  {:8.4} s{}",
            row.temperature_c,
            row.height_mm,
            row.advance_s,
            row.half_width_s,
            if row.in_hull { String::new() } else { format!("  physical model: {}", row.outside.join(", ")) }
        ));
    }
    let inside = export.rows.iter().find(|row| row.in_hull).map(|row| row.interval_of);
    let [inside, outside] =
        [inside.unwrap_or(IntervalOf::VirtualTestLine), IntervalOf::AssumedDoubt].map(IntervalOf::text);
    lines.push(format!("+- is {inside}; of the physical model {outside}"));
    for (slicer, firmware, code) in [
        ("PrusaSlicer", "Marlin", &export.prusaslicer_marlin),
        ("PrusaSlicer", "Klipper", &export.prusaslicer_klipper),
        ("OrcaSlicer", "Marlin", &export.orcaslicer_marlin),
        ("OrcaSlicer", "Klipper", &export.orcaslicer_klipper),
    ] {
        lines.push(format!("filament start code in {slicer}'s macro language, {firmware}\n  {code}"));
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests;
