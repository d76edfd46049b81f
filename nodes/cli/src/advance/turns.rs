//! Training of the network of turns: with every file, judged file by file without it.

use super::train::NetworkFile;
use super::{Settings, Setup};
use crate::config::ConfigDir;
use crate::job::BYTES_MAX;
use crate::output;
use advance_predictor::turn::assess::{Figures, Methods, assess};
use advance_predictor::turn::training::{Path, train};
use advance_predictor::turn::{Piece, TurnNetwork};
use anyhow::{Context, bail};
use models::motion::{Job, MotionParams, Step};
use serde::Serialize;
use std::path::PathBuf;

/// The planner knows no fewer moves.
const LOOKAHEAD_MIN: usize = 2;

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
        "recall {:.3} precision {:.3} F1 {:.3}; F1 of the buffer {:.3}, curvature {:.3} and {:.3}: {}",
        ours.recall,
        ours.precision,
        ours.f1,
        methods.buffer_only.f1,
        methods.curvature_line.f1,
        methods.curvature_mean.f1,
        verdict(methods)
    )
}

/// The predictor against its baselines, in words; where one of those is right at every moment nobody can be better.
fn verdict(methods: &Methods) -> &'static str {
    let ours = &methods.predictor;
    let baselines = [&methods.buffer_only, &methods.curvature_line, &methods.curvature_mean];
    if ours.hits + ours.missed == 0 {
        "no turn came"
    } else if baselines.iter().any(|other| other.missed + other.false_alarms == 0) {
        if ours.missed + ours.false_alarms == 0 {
            "a tie, nothing is left to foresee"
        } else {
            "WORSE, nothing was left to foresee"
        }
    } else if baselines.iter().all(|other| ours.f1 > other.f1) {
        "better"
    } else {
        "NOT better"
    }
}

/// A file's path, planned once per buffer.
struct File {
    name: String,
    paths: Vec<Path>,
}

/// Trains with all files of a folder and made-up paths; judges where asked. Figures and the network's file.
///
/// # Errors
/// Files that cannot be read, a folder without G-code.
pub(super) fn train_and_judge(
    (config, settings, setup): (&ConfigDir, &Settings, &Setup),
    folder: &std::path::Path,
    judge: bool,
) -> anyhow::Result<(Vec<FileFigures>, NetworkFile)> {
    let files = read(folder, &config.motion()?, settings.turn.buffers())?;
    let made = settings.turn.made(settings.seed);
    let fit = |left_out: Option<usize>| -> anyhow::Result<(String, TurnNetwork)> {
        let kept = files.iter().enumerate().filter(|(place, _)| Some(*place) != left_out);
        let paths: Vec<&Path> = kept.flat_map(|(_, file)| &file.paths).chain(&made).collect();
        let text = train(&paths, &setup.params.turn, (&settings.turn, settings.seed))?;
        let network = TurnNetwork::parse(&text)?;
        Ok((text, network))
    };
    output::note("fitting the network of turns");
    let text = fit(None)?.0;
    let mut figures = vec![];
    for (place, file) in files.iter().enumerate().filter(|_| judge) {
        output::note(&format!("fitting without {}", file.name));
        let network = fit(Some(place))?.1;
        let one = |path: &Path| assess(&network, path, &setup.params.turn);
        figures.push(FileFigures { file: file.name.clone(), buffers: file.paths.iter().map(one).collect() });
    }
    Ok((figures, ("turn.json".to_owned(), text)))
}

/// The G-code files of a folder, in the order of their names.
///
/// # Errors
/// A folder that cannot be read or has none.
pub(super) fn listed(folder: &std::path::Path) -> anyhow::Result<Vec<PathBuf>> {
    let listing = std::fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    let mut paths: Vec<_> = listing.flatten().map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "gcode"));
    paths.sort();
    if paths.is_empty() {
        bail!("{}: no *.gcode", folder.display());
    }
    Ok(paths)
}

/// The paths of all files, in the order of their names.
fn read(folder: &std::path::Path, motion: &MotionParams, buffers: &[u32]) -> anyhow::Result<Vec<File>> {
    let paths = listed(folder)?;
    let file = |path: &PathBuf| -> anyhow::Result<File> {
        let bytes = runtime::input::bytes(path, BYTES_MAX).with_context(|| path.display().to_string())?;
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let paths = buffers.iter().map(|buffered| planned(&bytes, motion, *buffered)).collect();
        Ok(File { name, paths })
    };
    paths.iter().map(file).collect()
}

/// The path under a look-ahead of the buffer alone: a longer one would tell the future by its speeds.
pub(crate) fn planned(bytes: &[u8], motion: &MotionParams, buffered: u32) -> Path {
    let lookahead_moves = (buffered as usize).max(LOOKAHEAD_MIN);
    let steps = Job::from_bytes(bytes, &MotionParams { lookahead_moves, ..*motion });
    let pieces = steps.filter_map(|step| match step {
        Step::Move(segment) => Piece::of(&segment),
        Step::Action(..) => None,
    });
    Path { buffered, pieces: pieces.collect() }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{folder, setup};
    use super::*;
    use advance_predictor::turn::assess::Score;
    use advance_predictor::turn::training::described;

    /// Counts of hits, false alarms and misses, of the predictor and of its best baseline.
    #[test]
    fn a_tie_that_nobody_can_win_is_told_as_one() {
        let score = |[hits, false_alarms, missed]: [usize; 3]| {
            let counted = Score { hits, false_alarms, missed, ..Score::default() };
            counted.with(&Score::default())
        };
        let told = |ours, best| {
            let worse = score([0, 0, 10]);
            verdict(&Methods {
                predictor: score(ours),
                buffer_only: worse,
                curvature_line: score(best),
                curvature_mean: worse,
            })
        };
        assert_eq!(told([9, 0, 1], [8, 0, 2]), "better");
        assert_eq!(told([8, 0, 2], [8, 0, 2]), "NOT better");
        assert_eq!(told([10, 0, 0], [10, 0, 0]), "a tie, nothing is left to foresee");
        assert_eq!(told([10, 1, 0], [10, 0, 0]), "WORSE, nothing was left to foresee");
        assert_eq!(told([0, 1, 0], [0, 0, 0]), "no turn came");
    }

    /// Told before any network is fitted.
    #[test]
    fn a_folder_without_gcode_is_refused_by_name() {
        let folder = folder("no_gcode");
        std::fs::write(folder.join("notes.txt"), "G1 X1").unwrap();
        let error = listed(&folder).unwrap_err().to_string();
        assert_eq!(error, format!("{}: no *.gcode", folder.display()));
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(listed(&folder).unwrap_err().to_string(), folder.display().to_string());
    }

    /// `fdm advance train --gcode tests/data/gcode` trains with the set that the committed file was made with.
    #[test]
    fn the_committed_network_of_turns_is_the_commands() {
        let (config, setup) = setup();
        let settings = Settings::load(&config).unwrap();
        let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/gcode"));
        let files = read(folder, &config.motion().unwrap(), settings.turn.buffers()).unwrap();
        let made = settings.turn.made(settings.seed);
        let paths: Vec<&Path> = files.iter().flat_map(|file| &file.paths).chain(&made).collect();
        let committed = std::fs::read_to_string(config.file("models/turn.json")).unwrap();
        let trained = described(&paths, &setup.params.turn, (&settings.turn, settings.seed));
        assert_eq!(TurnNetwork::parse(&committed).unwrap().trained(), trained);
    }
}
