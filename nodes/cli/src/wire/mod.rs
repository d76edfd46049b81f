//! `fdm wire`: metal wire molten by a laser, laid drop by drop.

pub mod closed_loop;
pub mod correct;
pub mod follow;
mod picture;
pub mod plan;
pub mod sim;
pub mod up;

use crate::config::ConfigDir;
use crate::process;
use anyhow::bail;
use clap::{Args, Subcommand, ValueEnum};
use models::wire::correction::GAIN_STABLE_BELOW;
use models::wire::{Material, Mode, Process};
use std::collections::BTreeMap;

/// The wire process: plan, correct, simulate, run.
#[derive(Debug, Args)]
pub struct WireArgs {
    #[command(subcommand)]
    command: WireCommand,
}

#[derive(Debug, Subcommand)]
enum WireCommand {
    /// Speeds of wire and head from wire, material and laser power.
    Plan(plan::PlanArgs),
    /// Speeds for a measured height, and the paper's Tables 1 and 2 beside ours.
    Correct(correct::CorrectArgs),
    /// Height error of a simulated wall layer by layer, open against closed.
    Sim(sim::SimArgs),
    /// Machine, controller and supervisor as processes over DDS.
    Up(up::UpArgs),
}

/// Runs the command.
///
/// # Errors
/// One line that says what is wrong and where.
pub fn run(args: &WireArgs) -> anyhow::Result<()> {
    match &args.command {
        WireCommand::Plan(args) => plan::run(args),
        WireCommand::Correct(args) => correct::run(args),
        WireCommand::Sim(args) => sim::run(args),
        WireCommand::Up(args) => up::run(args),
    }
}

/// Which speeds the correction moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ModeName {
    /// Wire and head.
    Both,
    /// The wire alone.
    Wire,
    /// The head alone.
    Head,
}

impl From<ModeName> for Mode {
    fn from(name: ModeName) -> Self {
        match name {
            ModeName::Both => Self::Both,
            ModeName::Wire => Self::Wire,
            ModeName::Head => Self::Head,
        }
    }
}

/// The nominal process.
///
/// # Errors
/// File, line, field, value and range of what is refused.
pub fn nominal(config: &ConfigDir) -> anyhow::Result<Process> {
    process::block(config, "wire/process.yaml", "wire_process")
}

/// A metal by name.
///
/// # Errors
/// Names the metals that there are.
pub fn material(config: &ConfigDir, name: &str) -> anyhow::Result<Material> {
    let known: BTreeMap<String, Material> = process::block(config, "wire/materials.yaml", "wire_materials")?;
    match known.get(&name.to_lowercase()) {
        Some(material) => Ok(*material),
        None => {
            let names: Vec<&str> = known.keys().map(String::as_str).collect();
            bail!("material '{name}' is unknown; there are {}", names.join(", "))
        }
    }
}

/// What is to be said beside a gain whose loop does not settle; empty where it does.
fn unstable(gain: f64, stable: bool) -> String {
    if stable {
        String::new()
    } else if gain < GAIN_STABLE_BELOW {
        ": height errors stay as they are".to_owned()
    } else {
        format!(
            ": UNSTABLE, a height error grows by |1 - gain| = {:.3} from layer to layer (stable above 0 and below \
             {GAIN_STABLE_BELOW}), until limits of section and speeds hold it",
            (1.0 - gain).abs()
        )
    }
}
