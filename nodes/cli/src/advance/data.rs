//! `fdm advance data`: the lines that the networks are trained with, for other programs.

use super::{DriveName, Settings, Setup};
use crate::config::ConfigDir;
use crate::output;
use advance_predictor::compensation::data::{DataSet, Line};
use clap::Args;
use std::fmt::Write;
use std::path::PathBuf;

/// Prints and scores the virtual lines again: the same ones for the same seed.
#[derive(Debug, Args)]
pub struct DataArgs {
    /// Drive of the extruder.
    #[arg(long, value_enum, default_value_t = DriveName::Bowden)]
    drive: DriveName,
    /// File to write; standard output without it.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Folder with the parameter files.
    #[arg(long)]
    config: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// A file that cannot be written.
pub fn run(args: &DataArgs) -> anyhow::Result<()> {
    let config = ConfigDir::find(args.config.as_deref())?;
    args.out.as_deref().map_or(Ok(()), |file| output::check_writable("--out", file))?;
    Setup::check_apart(args.out.as_deref(), &config, None)?;
    let set = Setup::load(&config)?.lines(&Settings::load(&config)?, args.drive.into());
    let text = text(&set);
    match &args.out {
        Some(path) => {
            output::write_whole(path, &text)?;
            output::note(&format!("{}: {} lines", path.display(), set.lines.len()));
            Ok(())
        }
        None => output::line(&text),
    }
}

/// The columns of a measured file, and three more.
fn text(set: &DataSet) -> String {
    let mut text = String::from(
        "# synthetic: the virtual test line of the model book, 2.4; no printer was involved\n\
         drive,polymer,temperature_c,height_mm,width_mm,advance_s,true_s,in_table_1,use\n",
    );
    for Line { polymer, at, true_s, scored_s, in_table, purpose, .. } in &set.lines {
        // Writing to a string cannot fail.
        _ = writeln!(
            text,
            "{},{polymer},{:.1},{:.2},{:.2},{scored_s:.3},{true_s:.5},{in_table},{}",
            set.drive.name(),
            at.temperature.0,
            1e3 * at.height_m,
            1e3 * at.width_m,
            purpose.name()
        );
    }
    text
}
