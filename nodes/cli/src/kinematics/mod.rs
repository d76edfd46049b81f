//! `fdm kinematics`: what wrong axes of a five-axis machine do to the surface.

pub mod budget;
pub mod error;
pub mod map;
mod picture;
pub mod stl;
pub mod synthesize;

use crate::config::ConfigDir;
use crate::options::{in_range, needs, positive, significant};
use crate::process;
use anyhow::bail;
use clap::{Args, Subcommand};
use models::hybrid::synthesis::Choices;
use models::hybrid::{Geometry, Mesh};
use std::path::PathBuf;

/// Kinematic errors of a machine of hybrid layout.
#[derive(Debug, Args)]
pub struct KinematicsArgs {
    #[command(subcommand)]
    command: KinematicsCommand,
}

#[derive(Debug, Subcommand)]
enum KinematicsCommand {
    /// Error over height and motor angle; the paper's Tables 1 and 2 beside ours.
    Error(error::ErrorArgs),
    /// Error over a whole part: an STL file, or the paper's hemisphere.
    Map(map::MapArgs),
    /// Offset between layers that the machine alone explains, as parameters of classifier and supervisor.
    Budget(budget::BudgetArgs),
    /// Motor step, microsteps and lead for a wanted accuracy, and whether a carriage needs an encoder.
    Synthesize(synthesize::SynthesizeArgs),
}

/// Runs the command.
///
/// # Errors
/// One line that says what is wrong and where.
pub fn run(args: &KinematicsArgs) -> anyhow::Result<()> {
    match &args.command {
        KinematicsCommand::Error(args) => error::run(args),
        KinematicsCommand::Map(args) => map::run(args),
        KinematicsCommand::Budget(args) => budget::run(args),
        KinematicsCommand::Synthesize(args) => synthesize::run(args),
    }
}

/// Which machine, and where its files are.
#[derive(Debug, Args)]
pub struct MachineArgs {
    /// Machine: a file of config/machines.
    #[arg(long, default_value = "g1")]
    machine: String,
    /// Folder with the parameter files.
    #[arg(long)]
    config: Option<PathBuf>,
}

impl MachineArgs {
    fn config(&self) -> anyhow::Result<ConfigDir> {
        ConfigDir::find(self.config.as_deref())
    }

    fn file(&self, config: &ConfigDir) -> anyhow::Result<String> {
        let known: Vec<String> =
            config.names_in("machines").into_iter().filter(|name| name != "published").collect();
        if known.contains(&self.machine) {
            return Ok(format!("machines/{}.yaml", self.machine));
        }
        bail!("machine '{}' is unknown; there are {}", self.machine, known.join(", "))
    }

    fn geometry(&self, config: &ConfigDir) -> anyhow::Result<Geometry> {
        process::block(config, &self.file(config)?, "machine")
    }

    fn choices(&self, config: &ConfigDir) -> anyhow::Result<Choices> {
        process::block(config, &self.file(config)?, "synthesis")
    }
}

/// Which part, and what drives the machine.
#[derive(Debug, Args)]
pub struct PartArgs {
    /// Part: a closed mesh, binary or ASCII, placed on the middle of the table; the paper's hemisphere without it.
    #[arg(long)]
    stl: Option<PathBuf>,
    /// Length of one unit of the file `[mm]`; 1 if not given.
    #[arg(long)]
    unit: Option<f64>,
    /// Full step of the motors `[deg]`.
    #[arg(long, default_value_t = 1.8)]
    step: f64,
}

/// Longest full step `[deg]`: a stepper of one pole pair and two phases has four a turn.
const STEP_MOST_DEG: f64 = 90.0;

impl PartArgs {
    fn check(&self) -> anyhow::Result<()> {
        positive("--step", self.step, "deg")?;
        in_range("--step", self.step, "deg", (0.0, STEP_MOST_DEG))?;
        needs("--stl", self.stl.is_some(), &[("--unit", self.unit.is_some())])
    }

    /// The part; none where it is the hemisphere.
    fn mesh(&self) -> anyhow::Result<Option<Mesh>> {
        let unit_mm = in_range("--unit", self.unit.unwrap_or(1.0), "mm", (1e-6, 1e6))?;
        self.stl.as_deref().map(|path| stl::read(path, 1e-3 * unit_mm)).transpose()
    }
}

/// Parts of this share of a rod's length and up to this many rods are taken as they are.
const SIZE_IN_RODS: (f64, f64) = (0.01, 2.0);

/// What is to be said of a part whose size does not fit the machine: its file may be in another unit.
fn unlikely_size(mesh: &Mesh, geometry: &Geometry) -> Option<String> {
    let (low, high) = mesh.bounds_m();
    let longest_m = (high - low).max();
    let (least_m, most_m) = (SIZE_IN_RODS.0 * geometry.rod_m, SIZE_IN_RODS.1 * geometry.rod_m);
    (!(least_m..=most_m).contains(&longest_m)).then(|| {
        format!(
            "the part is {} mm long, the machine's rods are {} mm: is --unit right (1 mm if not given, 1000 for a file in \
             metres)?",
            significant(1e3 * longest_m, 3),
            significant(1e3 * geometry.rod_m, 3)
        )
    })
}

/// Heights on a hemisphere as they were typed `[mm]`.
fn check_heights(heights: &[f64], typed_radius_mm: Option<f64>, radius_m: f64) -> anyhow::Result<()> {
    if let Some(radius_mm) = typed_radius_mm {
        positive("--radius", radius_mm, "mm")?;
    }
    for height_mm in heights {
        in_range("--height", *height_mm, "mm", (0.0, 1e3 * radius_m))?;
    }
    Ok(())
}
