//! `fdm gcode FILE`: opens the file, the rest is `models::gcode::survey`.

use crate::config::ConfigDir;
use crate::output::{self, Json};
use anyhow::Context;
use clap::Args;
use models::gcode::Header;
use models::gcode::survey::{self, Survey};
use models::motion::MotionParams;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

/// Bytes fetched from the file at a time: large enough that the system call does not count.
const BUFFER_BYTES: usize = 1 << 20;

/// Parses and plans a file; names every oddity with line and reason.
#[derive(Debug, Args)]
pub struct GcodeArgs {
    /// File to look at.
    file: PathBuf,
    /// Folder with the parameter files.
    #[arg(long)]
    config: Option<PathBuf>,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// A file that cannot be read; what is odd inside it is part of the figures.
pub fn run(args: &GcodeArgs) -> anyhow::Result<()> {
    let json = Json::new(args.json.as_deref());
    json.check()?;
    let motion = ConfigDir::find(args.config.as_deref())?.motion()?;
    let survey = survey(&args.file, &motion).with_context(|| args.file.display().to_string())?;
    if !json.is_stdout() {
        output::line(&text(&survey))?;
    }
    json.write(&survey)
}

/// Parses and plans a file under a printer's limits; limits stated in the file replace them.
///
/// # Errors
/// Those of opening and reading; oddities of the contents are in the [`Survey`].
pub fn survey(path: &Path, params: &MotionParams) -> io::Result<Survey> {
    let mut file = runtime::input::open(path)?;
    let header = Header::read_ends(&mut file, params.read.header_bytes)?;
    Ok(survey::survey(BufReader::with_capacity(BUFFER_BYTES, file), &header, params))
}

/// The figures for people.
fn text(survey: &Survey) -> String {
    let stated = |value: Option<f64>, unit: &str| {
        value.map_or_else(String::new, |value| format!("   (the slicer states {value:.1} {unit})"))
    };
    let mut lines = vec![
        format!("dialect      {}", survey.dialect),
        format!("layers       {}", survey.layers),
        format!("moves        {}   arcs {}   tools {}", survey.moves, survey.arcs, survey.tools),
        format!("filament     {:.1} mm{}", survey.filament_mm, stated(survey.stated_filament_mm, "mm")),
        format!(
            "time         {:.0} s without heating{}",
            survey.print_time_s,
            stated(survey.stated_time_s, "s")
        ),
        format!("oddities     {}", survey.warnings_total),
    ];
    lines.extend(survey.warnings.iter().map(|odd| format!("  line {}: {}", odd.line, odd.reason)));
    lines.extend(survey.errors.iter().map(|error| format!("  ERROR line {}: {}", error.line, error.reason)));
    lines.join("\n")
}
