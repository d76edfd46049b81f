//! `fdm advance export`: tables for slicers, start code for firmware.

use super::networks::{IntervalOf, Networks};
use super::{Place, Printed, Setup};
use crate::config::ConfigDir;
use crate::output::{self, Json};
use advance_predictor::compensation::{Predictor, Source};
use anyhow::bail;
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
    /// Temperatures of the hot end `[degC]`; the start code asks for the nearest one.
    #[arg(long, value_delimiter = ',', default_values_t = [215.0])]
    temperature: Vec<f64>,
    /// Layer heights `[mm]`; the start code asks for the nearest one.
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
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
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
            let foretold = predictor.predict(&polymer, &place.condition())?;
            rows.push(Row {
                temperature_c: temperature,
                height_mm: *height,
                advance_s: foretold.advance.0,
                half_width_s: foretold.half_width.0,
                interval_of: foretold.source.into(),
                in_hull: foretold.source == Source::Network,
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
    text
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
            if row.in_hull { "" } else { "  physical model: outside of the networks' data" }
        ));
    }
    let [inside, outside] = [IntervalOf::VirtualTestLine, IntervalOf::AssumedDoubt].map(IntervalOf::text);
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
mod tests {
    use super::super::tests::setup;
    use super::*;

    fn row(temperature_c: f64, height_mm: f64, advance_s: f64) -> Row {
        let interval_of = IntervalOf::VirtualTestLine;
        Row { temperature_c, height_mm, advance_s, half_width_s: 0.01, interval_of, in_hull: true }
    }

    #[test]
    fn a_conditional_names_the_nearest_height() {
        let rows = [row(215.0, 0.1, 0.9), row(215.0, 0.2, 0.63), row(215.0, 0.3, 0.59)];
        assert_eq!(
            macro_text(PRUSASLICER, MARLIN, &rows),
            "M900 K{if layer_height<0.150}0.9000{elsif layer_height<0.250}0.6300{else}0.5900{endif}"
        );
        assert_eq!(macro_text(PRUSASLICER, MARLIN, &rows[..1]), "M900 K0.9000");
    }

    /// Every temperature that was asked for is in the start code, in the order in which a slicer meets the conditions.
    #[test]
    fn a_conditional_names_the_nearest_temperature_first() {
        let rows = [row(200.0, 0.1, 1.0), row(200.0, 0.2, 0.7), row(220.0, 0.1, 0.8), row(220.0, 0.2, 0.6)];
        assert_eq!(
            macro_text(PRUSASLICER, KLIPPER, &rows),
            "SET_PRESSURE_ADVANCE ADVANCE={if temperature[0]<210.000 and layer_height<0.150}1.0000\
             {elsif temperature[0]<210.000}0.7000{elsif layer_height<0.150}0.8000{else}0.6000{endif}"
        );
        let one_height = [rows[0], rows[2]];
        assert_eq!(
            macro_text(ORCASLICER, MARLIN, &one_height),
            "M900 K{if nozzle_temperature[0]<210.000}1.0000{else}0.8000{endif}"
        );
    }

    #[test]
    fn all_temperatures_are_exported_and_odd_ones_refused() {
        let (config, setup) = setup();
        let printed = Printed {
            drive: super::super::DriveName::Bowden,
            polymer: "PLA".to_owned(),
            config: None,
            models: None,
            json: None,
        };
        let of = |temperature: &[f64], height: &[f64]| {
            let (temperature, height) = (temperature.to_vec(), height.to_vec());
            let args = ExportArgs { printed: printed.clone(), temperature, height, width: 0.45 };
            let (predictor, networks) = args.printed.predictor(&setup, &config)?;
            export(&args, &setup, (&predictor, networks))
        };
        let whole = of(&[220.0, 200.0], &[0.2, 0.1]).unwrap();
        assert_eq!(whole.rows.len(), 4);
        for row in &whole.rows {
            assert!(whole.prusaslicer_marlin.contains(&format!("{:.4}", row.advance_s)), "{whole:?}");
        }
        let refused = |temperature: &[f64], height: &[f64]| of(temperature, height).unwrap_err().to_string();
        assert_eq!(refused(&[215.0, 20.0], &[0.2]), "--temperature 20 degC: must be in [160, 320] degC");
        assert_eq!(refused(&[215.0], &[0.2, 0.2]), "--height 0.2: is there twice");
        assert_eq!(refused(&[215.0], &[]), "--height: no value");
    }
}
