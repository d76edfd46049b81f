//! `fdm advance calibrate`: a pattern of test lines on a simulated printer, its widths measured, K found from them.

use super::measured::COLUMNS;
use super::networks::{IntervalOf, Networks, answered, outside};
use super::plant_line::PlantLine;
use super::{Place, Printed, Setup};
use crate::config::{Choice, ConfigDir};
use crate::output::{self, Json};
use crate::process;
use advance_predictor::compensation::Source;
use advance_predictor::compensation::calibration::{Calibrated, Pattern, calibrate, calibrate_by};
use advance_predictor::network::chance::Stream;
use anyhow::bail;
use clap::{Args, ValueEnum};
use models::advance::{Condition, DriveKind, VirtualLine};
use models::extruder::StaticLaw;
use models::melt::Melt;
use models::units::Kelvin;
use mpc_controller::params::{AdvanceSource, Level};
use serde::Serialize;

/// Where the pattern is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "snake_case")]
enum Printer {
    /// The virtual test line of the model book, 2.4.
    Line,
    /// The pressure of the simulated printer, with its own deviations: it has a Bowden drive.
    Simulated,
    /// The simulated printer as a whole, by G-code, seen through its width gauge alone.
    Plant,
}

/// Prints and measures a pattern.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct CalibrateArgs {
    #[command(flatten)]
    printed: Printed,
    #[command(flatten)]
    place: Place,
    /// Printer that prints the pattern.
    #[arg(long, value_enum, default_value_t = Printer::Line)]
    printer: Printer,
    /// Seed of the measurement's noise, 1 to 2^32.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=1 << 32))]
    seed: u64,
}

/// The figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// Drive.
    pub drive: DriveKind,
    /// Polymer.
    pub polymer: String,
    /// Temperature.
    pub temperature_c: f64,
    /// Layer height.
    pub height_mm: f64,
    /// Line width.
    pub width_mm: f64,
    /// Who printed the pattern.
    printer: Printer,
    /// K that the pattern gives.
    pub advance_s: f64,
    /// Half width of its 95 % interval.
    pub half_width_s: f64,
    /// Best K of this printer, which only a simulation knows: of the pressure alone with `line` and `simulated`, by its own
    /// true widths with `plant`.
    pub true_s: f64,
    /// Half width of its 95 % interval with `plant`, whose spools differ; 0 with the others.
    pub true_half_width_s: f64,
    /// Best K of its pressure alone at the set-point. The printer as a whole needs more: its nozzle is colder than its
    /// block, and its drive smooths.
    pub pressure_s: f64,
    /// K foretold.
    pub foretold_s: f64,
    /// Half width of its interval.
    pub foretold_half_width_s: f64,
    /// What the interval of the foretold K is of.
    pub foretold_interval_of: IntervalOf,
    /// Whether the condition lies inside the hull of the networks' data.
    pub in_hull: bool,
    /// What of the condition lies outside of it.
    pub outside: Vec<String>,
    /// Who foretold: the physical model outside of the hull.
    pub source: Source,
    /// The networks that were asked.
    pub networks: Networks,
    /// Foretold less measured.
    pub difference_s: f64,
    /// Whether the difference lies within both intervals together.
    pub agree: bool,
    /// K of each line of the patterns and the mean square of the relative error of its cross section, noise included.
    pub lines: Vec<[f64; 2]>,
}

/// Spools of one calibration: `2^20`.
const SPOOL_BITS: u32 = 20;

/// Runs the command.
///
/// # Errors
/// One line with the reason.
pub fn run(args: &CalibrateArgs) -> anyhow::Result<()> {
    let config = ConfigDir::find(args.printed.config.as_deref())?;
    let json = Json::new(args.printed.json.as_deref());
    json.check()?;
    let printed = &args.printed;
    Setup::check_apart(printed.json.as_deref(), &config, printed.models.as_deref())?;
    let figures = figures(args, &config)?;
    if !json.is_stdout() {
        output::line(&text(&figures))?;
    }
    json.write(&figures)
}

fn figures(args: &CalibrateArgs, config: &ConfigDir) -> anyhow::Result<Figures> {
    let setup = Setup::load(config)?;
    let pattern: Pattern = process::block(config, "advance/pattern.yaml", "advance_pattern")?;
    let drive = args.printed.drive.into();
    let (polymer, at) = (args.printed.polymer(), args.place.condition());
    setup.check(&polymer, &args.place)?;
    check_drive(args.printer, drive)?;
    let (predictor, networks) = args.printed.predictor(&setup, config)?;
    let foretold = predictor.predict(&polymer, &at)?;
    let unknown = || anyhow::anyhow!("polymer '{polymer}' is unknown");
    let printer = match args.printer {
        Printer::Line => setup.physics.line(drive, &polymer, &at, pattern.step()).ok_or_else(unknown)?,
        // Of the plant it gives the truth to compare with, nothing else.
        Printer::Simulated | Printer::Plant => simulated(config, &setup, (&polymer, &at), &pattern)?,
    };
    let no_best = || anyhow::anyhow!("no compensation is best");
    let pressure_s = printer.best().ok_or_else(no_best)?.advance_s;
    let (mut true_s, mut true_half_width_s) = (pressure_s, 0.0);
    let mut chance = Stream::new(args.seed);
    let start = (foretold.advance.0, at.width_m);
    let Calibrated { advance_s, half_width_s, lines } = match args.printer {
        Printer::Plant => {
            let choice = choice(&polymer);
            let loaded = config.load(&choice)?;
            let line = (setup.physics.test_line, at);
            let plant = PlantLine::new(loaded.simulated, loaded.motion, line, pattern.width_sigma_m());
            // No two calibrations share a spool.
            let mut spools = (args.seed << SPOOL_BITS)..;
            let mut lines = |advance_s: f64| plant.line(advance_s, spools.next().unwrap_or_default());
            let found = calibrate_by(&mut lines, &pattern, start)??;
            [true_s, true_half_width_s] = plant.best_s(pressure_s)?;
            found
        }
        _ => calibrate(&printer, &pattern, start, &mut chance)?,
    };
    let difference_s = foretold.advance.0 - advance_s;
    Ok(Figures {
        drive,
        outside: outside(predictor.ensemble(), &polymer, &at),
        polymer,
        temperature_c: args.place.temperature,
        height_mm: args.place.height,
        width_mm: args.place.width,
        printer: args.printer,
        advance_s,
        half_width_s,
        true_s,
        true_half_width_s,
        pressure_s,
        foretold_s: foretold.advance.0,
        foretold_half_width_s: foretold.half_width.0,
        foretold_interval_of: IntervalOf::of(foretold.source, predictor.ensemble()),
        in_hull: foretold.source == Source::Network,
        source: foretold.source,
        networks,
        difference_s,
        agree: difference_s.abs() <= half_width_s.hypot(foretold.half_width.0),
        lines,
    })
}

/// Refuses the other drive where the simulated printer prints: its K is ten times that one's.
fn check_drive(printer: Printer, drive: DriveKind) -> anyhow::Result<()> {
    if printer != Printer::Line && drive != DriveKind::Bowden {
        bail!(
            "--drive {}: the simulated printer has a bowden drive; --printer line has either",
            drive.name()
        );
    }
    Ok(())
}

/// The simulated printer with nobody beside it.
fn choice(polymer: &str) -> Choice {
    Choice { advance: AdvanceSource::File, ..Choice::of(polymer.to_owned(), Level::Off) }
}

/// The pressure of the simulated printer's plant at the condition's temperature.
fn simulated(
    config: &ConfigDir,
    setup: &Setup,
    (polymer, at): (&str, &Condition),
    pattern: &Pattern,
) -> anyhow::Result<VirtualLine> {
    let simulated = config.load(&choice(polymer))?.simulated;
    let (plant, extruder) = (&simulated.plant, &simulated.plant.extruder);
    let material = plant.material_deviation.apply(&simulated.material)?;
    let melt = Melt::new(&material, extruder);
    let law = StaticLaw::new(&melt, extruder, Kelvin::from(at.temperature), 1.0);
    let per_way = at.height_m * at.width_m / extruder.filament_area_m2();
    Ok(VirtualLine::of_law(law, per_way, &setup.physics.test_line, pattern.step()))
}

/// What was measured, as a line to train with.
fn row(figures: &Figures) -> [String; 3] {
    let Figures { polymer, temperature_c, height_mm, width_mm, advance_s, .. } = figures;
    let row =
        format!("{},{polymer},{temperature_c},{height_mm},{width_mm},{advance_s:.4}", figures.drive.name());
    [
        "             fdm advance train --measured FILE trains with it; the file's first line and its row:"
            .to_owned(),
        format!("             {}", COLUMNS.join(",")),
        format!("             {row}"),
    ]
}

fn text(figures: &Figures) -> String {
    let mut lines: Vec<String> = figures
        .lines
        .iter()
        .map(|[advance_s, square]| format!("{advance_s:13.4}  {:13.2}", 1e2 * square.sqrt()))
        .collect();
    lines.insert(
        0,
        format!(
            "{:>13}  {:>13}  (cross section off the wanted one; noise included)",
            "K [s]", "RMS error [%]"
        ),
    );
    lines.push(format!("K measured   {:.4} s +- {:.4} s (95 %)", figures.advance_s, figures.half_width_s));
    lines.push(format!(
        "K foretold   {:.4} s +- {:.4} s ({}) by {}: {}",
        figures.foretold_s,
        figures.foretold_half_width_s,
        figures.foretold_interval_of.text(),
        answered(&figures.outside),
        if figures.agree { "they agree" } else { "they DIFFER: take the measured one" }
    ));
    if !figures.agree {
        lines.extend(row(figures));
    }
    lines.push(format!("networks     {}", figures.networks.text()));
    lines.push(format!(
        "K in truth   {:.4} s +- {:.4} s, which a simulation alone knows",
        figures.true_s, figures.true_half_width_s
    ));
    if figures.printer == Printer::Plant {
        lines.push(format!(
            "             {:.4} s of the pressure alone at the set-point: a colder nozzle and a drive that smooths need more",
            figures.pressure_s
        ));
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests;
