//! `fdm advance train`: the networks anew, and what they reach on lines and files that they never saw.

mod own;

use super::measured;
use super::turns::{self, FileFigures};
use super::{Settings, Setup};
use crate::config::ConfigDir;
use crate::output::{self, Json};
use advance_predictor::compensation::Ensemble;
use advance_predictor::compensation::assess::{Errors, Figures, Judges, Widths, assess};
use advance_predictor::compensation::measured::{Factor, Measured};
use advance_predictor::compensation::training::{Material, train};
use anyhow::Context;
use clap::Args;
use models::advance::DriveKind;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Trains and judges; seconds long, the same file for the same seed.
#[derive(Debug, Args)]
pub struct TrainArgs {
    /// Your own lines: comma-separated, columns drive, polymer, `temperature_c`, `height_mm`, `width_mm`, `advance_s`.
    /// Ranges stand in config/models/README.md.
    #[arg(long)]
    measured: Option<PathBuf>,
    /// Folder with G-code that the network of turns is trained with; without it that one stays as it is.
    #[arg(long)]
    gcode: Option<PathBuf>,
    /// Judge the network of turns too: for each file one that was trained with the others.
    #[arg(long, requires = "gcode")]
    judge: bool,
    /// Where the networks go: a folder; without it they replace those of `config/models`.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Folder with the parameter files.
    #[arg(long)]
    config: Option<PathBuf>,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// What training reached.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trained {
    /// Figures of each drive's networks.
    pub compensation: Vec<Figures>,
    /// Measured lines that were trained with.
    pub measured: usize,
    /// Those of them outside of the networks' data, where the physical model answers, scaled as the networks are at the edge.
    pub measured_outside_hull: usize,
    /// Figures of the network of turns, file by file, each from a network that has not seen it.
    pub turns: Vec<FileFigures>,
}

/// Runs the command.
///
/// # Errors
/// Files that cannot be read or written, lines that are refused.
pub fn run(args: &TrainArgs) -> anyhow::Result<()> {
    let config = ConfigDir::find(args.config.as_deref())?;
    let json = Json::new(args.json.as_deref());
    json.check()?;
    Setup::check_apart(args.json.as_deref(), &config, None)?;
    let (settings, setup) = (Settings::load(&config)?, Setup::load(&config)?);
    let measured = args.measured.as_deref().map(|path| read(path, &setup)).transpose()?.unwrap_or_default();
    let out = args.out.clone().unwrap_or_else(|| config.file("models"));
    check_folder(&out)?;
    Setup::check_apart(args.json.as_deref(), &config, Some(&out))?;
    args.gcode.as_deref().map(turns::listed).transpose()?;
    let (trained, files) = trained(args, (&config, &settings, &setup), &measured)?;
    // All networks or none: what was asked for in one command belongs together.
    let files: Vec<_> = files.into_iter().map(|(name, text)| (out.join(name), text)).collect();
    output::write_all_whole(&files)?;
    if !json.is_stdout() {
        output::line(&text(&trained))?;
    }
    json.write(&trained)
}

/// Tells before the fits, which take a while, that their files could not be written.
fn check_folder(out: &Path) -> anyhow::Result<()> {
    let told = || out.display().to_string();
    std::fs::create_dir_all(out).with_context(told)?;
    let tried = out.join(format!(".fdm.{}.part", std::process::id()));
    std::fs::write(&tried, "").with_context(told)?;
    std::fs::remove_file(&tried).with_context(told)
}

/// Name and text of a network's file.
pub(super) type NetworkFile = (String, String);

fn trained(
    args: &TrainArgs,
    (config, settings, setup): (&ConfigDir, &Settings, &Setup),
    measured: &[Measured],
) -> anyhow::Result<(Trained, Vec<NetworkFile>)> {
    let (mut figures, mut files) = (vec![], vec![]);
    for drive in DriveKind::ALL {
        let (of_drive, file) = compensation(settings, setup, (drive, measured))?;
        figures.push(of_drive);
        files.push(file);
    }
    let outside = |line: &&Measured| {
        let polymer = setup.physics.polymers.get(&line.polymer);
        polymer.is_some_and(|polymer| !settings.data.hull(polymer).holds(&line.at))
    };
    let mut trained = Trained {
        compensation: figures,
        measured: measured.len(),
        measured_outside_hull: measured.iter().filter(outside).count(),
        turns: vec![],
    };
    if let Some(folder) = &args.gcode {
        let (judged, file) = turns::train_and_judge((config, settings, setup), folder, args.judge)?;
        trained.turns = judged;
        files.push(file);
    }
    Ok((trained, files))
}

fn read(path: &Path, setup: &Setup) -> anyhow::Result<Vec<Measured>> {
    let text = runtime::input::text(path).with_context(|| path.display().to_string())?;
    measured::parse(&text, setup).with_context(|| path.display().to_string())
}

fn compensation(
    settings: &Settings,
    setup: &Setup,
    (drive, measured): (DriveKind, &[Measured]),
) -> anyhow::Result<(Figures, NetworkFile)> {
    output::note(&format!("printing and scoring virtual lines, {}", drive.name()));
    let (physics, data) = (&setup.physics, &settings.data);
    let whole = setup.lines(settings, drive);
    let factor = Factor::of((physics, data), drive, measured, &settings.measured_prior);
    let set = whole.scaled(&factor, physics.drive(drive).advance_range_s);
    output::note("fitting the networks");
    let measured_weight = settings.measured_weight;
    let material = Material { physics, data, set: &set, measured, measured_weight };
    let text = train(&material, &settings.fit, settings.seed)?;
    let ensemble = Ensemble::parse(&text, drive)?;
    let judges = Judges { data, set: &set, left_out: whole.count() - set.count(), measured };
    let figures = assess(&ensemble, physics, judges, &setup.published);
    Ok((figures, (format!("advance_{}.json", drive.name()), text)))
}

fn text(trained: &Trained) -> String {
    let mut lines = vec![];
    if trained.measured == 0 {
        lines.push("synthetic lines and seven printed points; no printer was involved".to_owned());
    } else {
        let Trained { measured, measured_outside_hull: outside, .. } = trained;
        lines.push(format!(
            "measured     {measured} lines, {outside} of them outside of the networks' data, where the physical model answers, scaled as at their edge"
        ));
    }
    for figures in &trained.compensation {
        let (drive, virtuals) = (figures.drive.name(), figures.trained);
        let own = figures.own.as_ref();
        let measured = own.map_or(0, |own| own.count);
        lines.push(format!("{drive}: trained with {virtuals} virtual and {measured} measured lines"));
        lines.extend(own.into_iter().flat_map(own::text));
        lines.push(format!("  held out     {}", errors(&figures.held_out)));
        lines.push(format!("  anywhere     {}", errors(&figures.anywhere)));
        for point in &figures.published {
            lines.push(format!(
                "  printed      h {:.1} mm: {:.3} s, foretold {:.3} s ({:+.3})",
                point.height_mm, point.printed_s, point.foretold_s, point.error_s
            ));
        }
        let trends = &figures.trends;
        let broken = trends.temperature_broken + trends.height_broken + trends.width_broken;
        lines.push(format!(
            "  trends       {broken} of {} pairs broken, order at 230 degC broken at {} of {}",
            trends.pairs, trends.order_broken, trends.ordered
        ));
        lines.push(widths(&figures.widths));
    }
    lines.extend(trained.turns.iter().map(FileFigures::text));
    lines.join("\n")
}

/// In words and as a share of what is left without any advance: where the lag is not linear no constant comes to zero.
fn widths(widths: &Widths) -> String {
    let share = |rms: f64| format!("{rms:.4} ({:.3} x none)", rms / widths.none);
    format!(
        "  width RMS    none {:.4}, best constant {}, foretold constant {}, foretold law over the feed {}, over {} conditions held out",
        widths.none,
        share(widths.best),
        share(widths.foretold),
        share(widths.foretold_law),
        widths.count
    )
}

fn errors(errors: &Errors) -> String {
    format!(
        "{} conditions: mean {:.4} s, largest {:.4} s, within 15 ms {:.1} %, within 10 % {:.1} %, interval holds {:.1} %",
        errors.count,
        errors.mean_abs_s,
        errors.max_abs_s,
        1e2 * errors.within_15_ms,
        1e2 * errors.within_10_percent,
        1e2 * errors.covered
    )
}

#[cfg(test)]
mod tests {
    use super::super::tests::folder;
    use super::*;

    /// Whoever reads that the foretold constant misses a limit sees that the best constant does too, and that a law does not.
    #[test]
    fn widths_are_told_beside_what_a_constant_can_reach() {
        let figures = Widths { count: 12, none: 0.2, best: 0.01, foretold: 0.012, foretold_law: 0.003 };
        let told = widths(&figures);
        for part in [
            "best constant 0.0100 (0.050 x none)",
            "foretold constant 0.0120 (0.060 x none)",
            "law over the feed 0.0030 (0.015 x none)",
        ] {
            assert!(told.contains(part), "{told}");
        }
    }

    /// Nobody who brought own lines is told that no printer was involved.
    #[test]
    fn the_first_line_says_whether_a_printer_was_involved() {
        let trained = |measured| {
            let (compensation, turns) = (vec![], vec![]);
            text(&Trained { compensation, measured, measured_outside_hull: 1, turns })
        };
        assert!(trained(0).contains("no printer was involved") && !trained(5).contains("no printer"));
    }

    /// A file stands where the folder is to be: told before anything is trained, and nothing is left behind elsewhere.
    #[test]
    fn a_folder_that_cannot_be_written_is_told_at_once() {
        let folder = folder("train_out");
        let taken = folder.join("taken");
        std::fs::write(&taken, "x").unwrap();
        let error = check_folder(&taken.join("networks")).unwrap_err().to_string();
        assert_eq!(error, taken.join("networks").display().to_string());
        check_folder(&folder.join("new/networks")).unwrap();
        assert_eq!(std::fs::read_dir(folder.join("new/networks")).unwrap().count(), 0);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
