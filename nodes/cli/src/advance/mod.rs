//! `fdm advance`: pressure advance foretold, measured, trained and written for slicers and firmware.

pub mod calibrate;
pub mod data;
pub mod export;
mod measured;
mod networks;
mod plant_line;
pub mod predict;
pub mod train;
pub(crate) mod turns;

use crate::config::ConfigDir;
use crate::{output, process};
use advance_predictor::Params;
use advance_predictor::compensation::Predictor;
use advance_predictor::compensation::data::{DataParams, DataSet};
use advance_predictor::compensation::measured::Prior;
use advance_predictor::network::training::FitParams;
use advance_predictor::turn::training::Training;
use anyhow::{Context, bail};
use clap::{Args, Subcommand, ValueEnum};
use models::advance::published::Published;
use models::advance::{Condition, DriveKind, Physics};
use models::units::Celsius;
use runtime::params::{NodePath, Parameters};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Pressure advance without printing a pattern, and with one.
#[derive(Debug, Args)]
pub struct AdvanceArgs {
    #[command(subcommand)]
    command: AdvanceCommand,
}

#[derive(Debug, Subcommand)]
enum AdvanceCommand {
    /// K of a polymer, temperature, layer height and line width, with its interval.
    Predict(predict::PredictArgs),
    /// Print a pattern on a simulated printer, measure it, find K, compare with what is foretold.
    Calibrate(calibrate::CalibrateArgs),
    /// Train the networks again, with your own lines if you have some, and print their figures.
    Train(train::TrainArgs),
    /// A table for slicers and the lines of start code for Marlin and Klipper.
    Export(export::ExportArgs),
    /// The lines that the networks are trained with, as comma-separated text.
    Data(data::DataArgs),
}

/// Runs the command.
///
/// # Errors
/// One line that says what is wrong and where.
pub fn run(args: &AdvanceArgs) -> anyhow::Result<()> {
    match &args.command {
        AdvanceCommand::Predict(args) => predict::run(args),
        AdvanceCommand::Calibrate(args) => calibrate::run(args),
        AdvanceCommand::Train(args) => train::run(args),
        AdvanceCommand::Export(args) => export::run(args),
        AdvanceCommand::Data(args) => data::run(args),
    }
}

/// A drive on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DriveName {
    /// On the frame, a tube leads to the hot end.
    Bowden,
    /// On the hot end.
    Direct,
}

impl From<DriveName> for DriveKind {
    fn from(name: DriveName) -> Self {
        match name {
            DriveName::Bowden => Self::Bowden,
            DriveName::Direct => Self::Direct,
        }
    }
}

/// What is printed.
#[derive(Debug, Clone, Args)]
pub struct Printed {
    /// Drive of the extruder.
    #[arg(long, value_enum, default_value_t = DriveName::Bowden)]
    pub drive: DriveName,
    /// A polymer of config/advance/physics.yaml.
    #[arg(long, default_value = "PLA")]
    pub polymer: String,
    /// Folder with the parameter files.
    #[arg(long)]
    pub config: Option<PathBuf>,
    /// Folder with other networks than config/models, as `fdm advance train --out` fills it.
    #[arg(long, value_name = "DIR")]
    pub models: Option<PathBuf>,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    pub json: Option<PathBuf>,
}

impl Printed {
    /// Name of the polymer as the files have it.
    #[must_use]
    pub fn polymer(&self) -> String {
        self.polymer.to_uppercase()
    }
}

/// Where it is printed.
#[derive(Debug, Clone, Copy, Args)]
pub struct Place {
    /// Temperature of the hot end `[degC]`; ranges are `bounds` of `config/advance_predictor.param.yaml`, shipped 160 to 320.
    #[arg(long)]
    pub temperature: f64,
    /// Height of the layer `[mm]`; shipped 0.05 to 1, at most the line's width.
    #[arg(long)]
    pub height: f64,
    /// Width of the line `[mm]`; shipped 0.15 to 2.
    #[arg(long)]
    pub width: f64,
}

impl Place {
    /// The same in SI units.
    #[must_use]
    pub fn condition(&self) -> Condition {
        Condition {
            temperature: Celsius(self.temperature),
            height_m: 1e-3 * self.height,
            width_m: 1e-3 * self.width,
        }
    }
}

/// `config/models/advance_training.yaml`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Seed of everything that is left to chance.
    pub seed: u64,
    /// Weight of a person's own line against a virtual one.
    pub measured_weight: f64,
    /// How far a person's printer may be from the physical model.
    pub measured_prior: Prior,
    /// How lines are made.
    pub data: DataParams,
    /// How networks are fitted.
    pub fit: FitParams,
    /// How the network of turns is trained.
    pub turn: Training,
}

impl Settings {
    /// Reads the file.
    ///
    /// # Errors
    /// File, line, field and what is wrong.
    pub fn load(config: &ConfigDir) -> anyhow::Result<Self> {
        let path = config.file("models/advance_training.yaml");
        let settings: Self = runtime::params::from_yaml(&path)?;
        models::params::in_range("measured_weight", settings.measured_weight, "-", (1e-3, 1e4))
            .with_context(|| path.display().to_string())?;
        Ok(settings)
    }
}

/// Files of the configuration folder that the commands read.
const READ: [&str; 5] = [
    "advance_predictor.param.yaml",
    "advance/physics.yaml",
    "advance/published.yaml",
    "advance/pattern.yaml",
    "models/advance_training.yaml",
];
/// Files of a folder of networks.
const NETWORKS: [&str; 3] = ["advance_bowden.json", "advance_direct.json", "turn.json"];

/// Everything that the predictor needs.
pub struct Setup {
    /// Physics.
    pub physics: Physics,
    /// Parameters of the node.
    pub params: Params,
    /// The printed points.
    pub published: Published,
}

impl Setup {
    /// Reads the files.
    ///
    /// # Errors
    /// File, line, field, value and range of what is refused.
    pub fn load(config: &ConfigDir) -> anyhow::Result<Self> {
        let path =
            NodePath { qualified: "/printer/advance_predictor".into(), base: "advance_predictor".into() };
        let files = [config.file("advance_predictor.param.yaml")];
        Ok(Self {
            physics: process::block(config, "advance/physics.yaml", "advance_physics")?,
            params: Parameters::read(&files, &[], &path)?.parse()?,
            published: process::block(config, "advance/published.yaml", "advance_published")?,
        })
    }

    /// The predictor with the networks of the configuration folder.
    ///
    /// # Errors
    /// A file that cannot be read, is damaged or of the other drive.
    pub fn predictor(&self, config: &ConfigDir, drive: DriveKind) -> anyhow::Result<Predictor> {
        Ok(networks::read(self, &config.file("models"), drive)?.0)
    }

    /// Refuses what nothing is foretold for, in the words and units of the command line.
    ///
    /// # Errors
    /// Option, value and allowed range.
    pub fn check(&self, polymer: &str, place: &Place) -> anyhow::Result<()> {
        let polymers = &self.physics.polymers;
        if !polymers.contains_key(polymer) {
            let names: Vec<&str> = polymers.keys().map(String::as_str).collect();
            bail!("--polymer {polymer}: must be one of {}", names.join(", "));
        }
        let bounds = &self.params.bounds;
        let mm = |range_m: [f64; 2]| range_m.map(measured::mm);
        for (option, value, range, unit) in [
            ("--temperature", place.temperature, bounds.temperature_c, "degC"),
            ("--height", place.height, mm(bounds.height_m), "mm"),
            ("--width", place.width, mm(bounds.width_m), "mm"),
        ] {
            let [low, high] = range;
            // A NaN is in no range.
            if !(low..=high).contains(&value) {
                bail!("{option} {value} {unit}: must be in [{low}, {high}] {unit}");
            }
        }
        if place.height > place.width {
            bail!("--height {} mm: must be at most the line's width, {} mm", place.height, place.width);
        }
        Ok(())
    }

    /// Refuses an output that would take the place of a file that is read: those of the configuration folder, and the
    /// networks of `models`.
    ///
    /// # Errors
    /// The output and the file.
    pub fn check_apart(
        output: Option<&Path>,
        config: &ConfigDir,
        models: Option<&Path>,
    ) -> anyhow::Result<()> {
        let Some(output) = output.filter(|path| *path != Path::new("-")) else { return Ok(()) };
        let mut read = READ.map(|name| config.file(name)).to_vec();
        let folder = models.map_or_else(|| config.file("models"), Path::to_path_buf);
        read.extend(NETWORKS.map(|name| folder.join(name)));
        // A network that training makes need not be there yet.
        let place = |path: &Path| {
            let absolute = std::path::absolute(path).ok()?;
            Some((std::fs::canonicalize(absolute.parent()?).ok()?, absolute.file_name()?.to_owned()))
        };
        if let Some(taken) = read.iter().find(|file| place(file).is_some_and(|at| Some(at) == place(output)))
        {
            bail!("{} would replace {}: choose another file", output.display(), taken.display());
        }
        output::check_apart(output, &read)
    }

    /// Prints and scores the lines of a drive.
    #[must_use]
    pub fn lines(&self, settings: &Settings, drive: DriveKind) -> DataSet {
        settings.data.generate(drive, &self.physics, &self.published, settings.seed)
    }
}

#[cfg(test)]
mod tests;
