//! Bags: what is in one, mending one, writing one, playing one.

mod info;
mod kept;
pub mod play;
mod qos;
pub mod record;
pub mod recover;
mod shown;
mod watched;

use clap::{Args, Subcommand};
use std::path::PathBuf;

/// Bags.
#[derive(Debug, Args)]
pub struct BagArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Topics, counts, times, files, and whether all of it is whole.
    Info(InfoArgs),
}

/// What is in a bag.
#[derive(Debug, Args)]
pub struct InfoArgs {
    /// Folder of the bag, or one .mcap or .mcap.active file.
    bag: PathBuf,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// One line that says what is wrong and where.
pub fn run(args: &BagArgs) -> anyhow::Result<()> {
    let What::Info(info) = &args.what;
    info::run(info)
}
