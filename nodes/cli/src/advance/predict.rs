//! `fdm advance predict`: K of one condition.

use super::{Place, Printed, Setup};
use crate::config::ConfigDir;
use crate::output::{self, Json};
use advance_predictor::compensation::Source;
use clap::Args;
use models::advance::DriveKind;
use serde::Serialize;

/// Foretells K.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct PredictArgs {
    #[command(flatten)]
    printed: Printed,
    #[command(flatten)]
    place: Place,
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
    /// K, for Marlin and Klipper alike.
    pub advance_s: f64,
    /// Half width of its 95 % interval.
    pub half_width_s: f64,
    /// Whether the condition lies inside the hull of the networks' data.
    pub in_hull: bool,
    /// Who answered.
    pub source: Source,
    /// What the physical model says.
    pub physics_s: Option<f64>,
}

/// Runs the command.
///
/// # Errors
/// One line with the reason.
pub fn run(args: &PredictArgs) -> anyhow::Result<()> {
    let config = ConfigDir::find(args.printed.config.as_deref())?;
    let json = Json::new(args.printed.json.as_deref());
    json.check()?;
    let figures = figures(args, &config)?;
    if !json.is_stdout() {
        output::line(&text(&figures))?;
    }
    json.write(&figures)
}

fn figures(args: &PredictArgs, config: &ConfigDir) -> anyhow::Result<Figures> {
    let setup = Setup::load(config)?;
    let drive = args.printed.drive.into();
    let (polymer, at) = (args.printed.polymer(), args.place.condition());
    let foretold = setup.predictor(config, drive)?.predict(&polymer, &at)?;
    Ok(Figures {
        drive,
        temperature_c: args.place.temperature,
        height_mm: args.place.height,
        width_mm: args.place.width,
        advance_s: foretold.advance.0,
        half_width_s: foretold.half_width.0,
        in_hull: foretold.source == Source::Network,
        source: foretold.source,
        physics_s: setup.physics.secant_s(drive, &polymer, &at),
        polymer,
    })
}

fn text(figures: &Figures) -> String {
    let source = match figures.source {
        Source::Network => "the networks, inside of their data",
        Source::Physics => "the physical model: this lies OUTSIDE of the networks' data",
    };
    let physics = figures.physics_s.map_or_else(|| "-".to_owned(), |advance_s| format!("{advance_s:.4} s"));
    format!(
        "K            {:.4} s +- {:.4} s (95 %)\n\
         from         {source}\n\
         physics      {physics}\n\
         Marlin       M900 K{:.4}\n\
         Klipper      SET_PRESSURE_ADVANCE ADVANCE={:.4}",
        figures.advance_s, figures.half_width_s, figures.advance_s, figures.advance_s
    )
}
