//! Training of the network of turns: with every file, judged file by file without it.

use super::{Settings, Setup};
use crate::config::ConfigDir;
use crate::output;
use advance_predictor::turn::assess::{Figures, Methods, assess};
use advance_predictor::turn::training::train;
use advance_predictor::turn::{Piece, TurnNetwork};
use anyhow::{Context, bail};
use models::motion::{Job, MotionParams, Step};
use serde::Serialize;
use std::path::Path;

/// Buffers that are judged: moves behind the current one.
const BUFFERS: [u32; 3] = [4, 8, 16];

/// Figures of one file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FileFigures {
    /// File that the network was not trained with.
    pub file: String,
    /// Figures by buffer.
    pub buffers: Vec<Figures>,
}

impl FileFigures {
    /// For people.
    pub(super) fn text(&self) -> String {
        let mut lines = vec![format!("turns in {}, never trained with", self.file)];
        for figures in &self.buffers {
            lines.push(format!(
                "  N {:2}: {} moments, {} starved; {} turns behind short moves, lead {:.0} ms (buffer alone {:.0} ms)",
                figures.buffered,
                figures.moments,
                figures.starved,
                figures.short_turns,
                1e3 * figures.lead_median_s,
                1e3 * figures.buffer_lead_median_s
            ));
            lines.push(format!("    all     {}", methods(&figures.all)));
            lines.push(format!("    starved {}", methods(&figures.when_starved)));
        }
        lines.join("\n")
    }
}

fn methods(methods: &Methods) -> String {
    let ours = &methods.predictor;
    format!(
        "recall {:.3} precision {:.3} F1 {:.3}; F1 of the buffer {:.3}, curvature {:.3} and {:.3}",
        ours.recall,
        ours.precision,
        ours.f1,
        methods.buffer_only.f1,
        methods.curvature_line.f1,
        methods.curvature_mean.f1
    )
}

/// Trains with all files of a folder and made-up paths, writes the network; judges where asked.
///
/// # Errors
/// Files that cannot be read or written, a folder without G-code.
pub(super) fn train_and_judge(
    (config, settings, setup): (&ConfigDir, &Settings, &Setup),
    folder: &Path,
    out: &Path,
    judge: bool,
) -> anyhow::Result<Vec<FileFigures>> {
    let files = read(folder, &config.motion()?)?;
    let made = settings.turn.made(settings.seed);
    let fit = |left_out: Option<usize>| -> anyhow::Result<(String, TurnNetwork)> {
        let kept = files.iter().enumerate().filter(|(place, _)| Some(*place) != left_out);
        let mut paths: Vec<&[Piece]> = kept.map(|(_, (_, pieces))| pieces.as_slice()).collect();
        paths.push(&made);
        let text = train(&paths, &setup.params.turn, (&settings.turn, settings.seed))?;
        let network = TurnNetwork::parse(&text)?;
        Ok((text, network))
    };
    output::note("fitting the network of turns");
    let path = out.join("turn.json");
    std::fs::write(&path, fit(None)?.0).with_context(|| path.display().to_string())?;
    let mut figures = vec![];
    for (place, (name, pieces)) in files.iter().enumerate().filter(|_| judge) {
        output::note(&format!("fitting without {name}"));
        let network = fit(Some(place))?.1;
        let one = |buffered| assess(&network, pieces, buffered, &setup.params.turn);
        figures.push(FileFigures { file: name.clone(), buffers: BUFFERS.into_iter().map(one).collect() });
    }
    Ok(figures)
}

/// The paths of all files, in the order of their names.
fn read(folder: &Path, motion: &MotionParams) -> anyhow::Result<Vec<(String, Vec<Piece>)>> {
    let listing = std::fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    let mut paths: Vec<_> = listing.flatten().map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "gcode"));
    paths.sort();
    if paths.is_empty() {
        bail!("{}: no *.gcode", folder.display());
    }
    let file = |path: &std::path::PathBuf| -> anyhow::Result<(String, Vec<Piece>)> {
        let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
        let steps = Job::from_bytes(&bytes, motion);
        let pieces = steps.filter_map(|step| match step {
            Step::Move(segment) => Piece::of(&segment),
            Step::Action(..) => None,
        });
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Ok((name, pieces.collect()))
    };
    paths.iter().map(file).collect()
}
