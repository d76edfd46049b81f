//! `fdm identify`: a printer's hot end, pressure lag and noise out of a recorded heat-up and test line.
//!
//! Only what a real printer records is read. The print to record is `tests/data/gcode/identify.gcode`.

mod excitation;
mod file;
mod flow;
mod gains;
mod heat;
mod learn;
mod least_squares;
mod params;
mod readings;
mod record;
mod series;
#[cfg(test)]
mod tests;
mod text;
mod trial;

use crate::config::{Choice, ConfigDir, Setup};
use crate::output::{self, Json};
use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use learn::{Quantity, learn};
use mpc_controller::params::Level;
use params::IdentifyParams;
use record::Recorded;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Learns a printer from a recorded heat-up and test line: hot end, pressure lag, noise, each with its 95 % interval.
///
/// Record a print of tests/data/gcode/identify.gcode that begins cold, with corrections off:
/// `fdm sim tests/data/gcode/identify.gcode --control off --bag bags/cold`.
/// Capacities and losses come in units of the heater's power, which is taken from the printer's file.
#[derive(Debug, Args)]
pub struct IdentifyArgs {
    /// Folder of the bag, or one .mcap file.
    #[arg(required_unless_present = "trial", conflicts_with = "trial")]
    bag: Option<PathBuf>,
    /// Write a new printer file: it takes the place of printers/ender3.yaml in a copy of the configuration folder.
    #[arg(long, conflicts_with = "trial")]
    out: Option<PathBuf>,
    /// Replace the printer file if it is there.
    #[arg(long, requires = "out")]
    overwrite: bool,
    /// Learn only this, with the noise of its thermistor and the step of an encoder; the rest stays as the printer's file says.
    #[arg(long, value_enum)]
    only: Option<Part>,
    /// Material that was printed: as the bag says; PLA where it says nothing.
    #[arg(long)]
    material: Option<String>,
    /// Namespace of the printer; the first one in the bag by default.
    #[arg(long, conflicts_with = "trial")]
    namespace: Option<String>,
    /// Instead of a bag: simulated printers with numbers drawn by seeds A..B, what is learned beside the truth: of how many
    /// it lies in the stated interval (about 95 of 100, where the interval is true), of how many within 5 %, of how many in either.
    #[arg(long, value_name = "A..B")]
    trial: Option<String>,
    /// What they print.
    #[arg(long, requires = "trial", default_value = "tests/data/gcode/identify.gcode")]
    gcode: PathBuf,
    /// Folder with the parameter files.
    #[arg(long)]
    config: Option<PathBuf>,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// A part of a printer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Part {
    /// Hot end and thermistor: needs no camera.
    Hotend,
}

/// What is told of a bag.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Figures {
    bag: String,
    readings: usize,
    widths: usize,
    /// Messages that could not be.
    refused: u64,
    /// What somebody in the graph warned of meanwhile, and what the fit itself shows: what was learned may be a fault's.
    warned: Vec<String>,
    /// Nozzle's temperature for which the lags are told `[K]`.
    lags_at_k: Option<f64>,
    quantities: Vec<Quantity>,
}

/// Runs the command.
///
/// # Errors
/// What is no bag; a bag that does not hold enough, with what is missing; a file that cannot be written.
pub fn run(args: &IdentifyArgs) -> anyhow::Result<()> {
    let json = Json::new(args.json.as_deref());
    json.check()?;
    let config = ConfigDir::find(args.config.as_deref())?;
    let Some(bag) = &args.bag else {
        let figures = trial::run(args, args.trial.as_deref().unwrap_or_default(), &config)?;
        if !json.is_stdout() {
            output::line(&text::trial(&figures))?;
        }
        return json.write(&figures);
    };
    if let Some(out) = &args.out {
        output::check_apart(out, std::slice::from_ref(bag))?;
        check_new(out, args.overwrite)?;
        output::check_writable("--out", out)?;
    }
    let params = IdentifyParams::load(&config)?;
    let mut recorded = Recorded::read(bag, args.namespace.as_deref())?;
    let material = material(args.material.as_deref(), recorded.material(), &bag.display().to_string())?;
    let setup = config.load(&Choice::of(material, Level::Off))?;
    let with_flow = args.only != Some(Part::Hotend);
    check(&recorded, &setup, (&params, with_flow), &bag.display().to_string())?;
    let learned = learn(&recorded, (&setup.printer, &setup.material), &params, with_flow)
        .with_context(|| bag.display().to_string())?;
    recorded.warned.extend(learned.doubts(params.fit.misfit_max));
    if let Some(out) = &args.out {
        let nominal = config.file("printers/ender3.yaml");
        let nominal = runtime::input::text(&nominal).with_context(|| nominal.display().to_string())?;
        let name = bag.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let text =
            file::text(&nominal, &learned, &crate::report::decode::short(&name, 80), &recorded.warned)?;
        std::fs::write(out, text).with_context(|| out.display().to_string())?;
    }
    let figures = Figures {
        bag: bag.display().to_string(),
        readings: learned.heat.readings,
        widths: learned.flow.as_ref().map_or(0, |flow| flow.widths),
        refused: recorded.refused,
        warned: recorded.warned,
        lags_at_k: learned.flow.as_ref().map(|flow| flow.nominal.at_k),
        quantities: learned.quantities,
    };
    if !json.is_stdout() {
        output::line(&text::page(&figures))?;
        if let Some(out) = &args.out {
            output::line(&text::written(out, &config.file(""), figures.lags_at_k.is_some()))?;
        }
    }
    json.write(&figures)
}

/// Refuses a file that is there, whose numbers nobody could bring back, unless it is to be replaced.
fn check_new(out: &Path, overwrite: bool) -> anyhow::Result<()> {
    if out.is_file() && !overwrite {
        bail!("--out {}: is there already; --overwrite replaces it", out.display());
    }
    Ok(())
}

/// The material whose melt is taken as given: what the bag says was printed; what is asked for has to be the same.
fn material(asked: Option<&str>, printed: Option<&str>, bag: &str) -> anyhow::Result<String> {
    match (asked, printed) {
        (Some(asked), Some(printed)) if !asked.eq_ignore_ascii_case(printed) => {
            bail!("--material {asked}: {bag} is a print in {printed}, as its print/info says")
        }
        (asked, printed) => Ok(asked.or(printed).unwrap_or("PLA").to_owned()),
    }
}

/// Refuses a bag out of which nothing can be learned, and says everything that it lacks.
fn check(
    recorded: &Recorded,
    setup: &Setup,
    (params, with_flow): (&IdentifyParams, bool),
    name: &str,
) -> anyhow::Result<()> {
    let wanted = &params.excitation;
    let lacking = excitation::streams(recorded, wanted, with_flow);
    if !lacking.is_empty() {
        let refused = match recorded.refused {
            0 => String::new(),
            count => format!("; {count} messages say what cannot be, and were left out"),
        };
        bail!("{name}: not enough to learn from: {}{refused}", lacking.join("; "));
    }
    let lacking = excitation::print(recorded, &setup.printer.extruder, wanted, with_flow);
    if lacking.is_empty() {
        return Ok(());
    }
    let material = &setup.material;
    let in_pla = if material.fan < wanted.fan_high {
        format!(
            ", printed in PLA: {} is printed with the fan at {:.0} %, and what is learned is the printer's",
            material.name,
            100.0 * material.fan
        )
    } else {
        String::new()
    };
    bail!(
        "{name}: not enough to learn from: {}. tests/data/gcode/identify.gcode holds all of it{in_pla}",
        lacking.join("; ")
    )
}
