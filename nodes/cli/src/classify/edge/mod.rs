//! `fdm classify --train-edge`: the network that finds the edge of a road, and what it does for cameras that it never
//! saw, of the style that it was trained with and of the other one.

mod scene;
mod settings;
#[cfg(test)]
mod tests;

use super::chance::Stream;
use crate::config::ConfigDir;
use crate::output;
use anyhow::{Context, bail};
use clap::Args;
use defect_classifier::width::EdgeModel;
use defect_classifier::width::edge::training::{EdgeFigures, KnownEdge, fit, judge};
use indicatif::ProgressBar;
use printer_sim::camera::Style;
use scene::Optics;
use serde::Serialize;
use settings::{SceneSettings, Settings};
use std::ops::Range;
use std::path::Path;

/// What belongs to the edge network alone.
#[derive(Debug, Args)]
pub(super) struct EdgeArgs {
    /// Train the network that finds the edge of a road again; `--out` is its file then.
    #[arg(long, conflicts_with_all = ["images", "manifest", "train"])]
    pub(super) train_edge: bool,
    /// Looks to train with, the last one left out; without it those of `config/models/edge_training.yaml`.
    #[arg(long, value_name = "A..B", value_parser = seeds, requires = "train_edge", conflicts_with_all = ["images", "manifest", "train"])]
    pub(super) seeds: Option<Range<u64>>,
}

fn seeds(text: &str) -> Result<Range<u64>, String> {
    let wanted = || "two whole numbers A..B, A below B, B at most 1e15".to_owned();
    let (from, to) = text.split_once("..").ok_or_else(wanted)?;
    let number = |text: &str| text.parse::<u64>().map_err(|_| wanted());
    let seeds = number(from)?..number(to)?;
    if seeds.is_empty() || seeds.end > 1_000_000_000_000_000 { Err(wanted()) } else { Ok(seeds) }
}

/// What training reached.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct EdgeTraining {
    /// What all of it says, as it stands in the file.
    trained: String,
    /// Seeds of the looks of training: first, and the one after the last.
    looks: [u64; 2],
    /// Profiles trained with.
    profiles: usize,
    /// On further looks of the style of training.
    own_style: EdgeFigures,
    /// On looks of the style that it never saw.
    other_style: EdgeFigures,
}

impl EdgeTraining {
    /// For people.
    pub(super) fn text(&self) -> &str {
        &self.trained
    }

    fn words(&self, style: Style) -> String {
        let judged = |style: Style, figures: &EdgeFigures| {
            let [least_um, most_um] = figures.bias_by_look_m.map(|bias_m| 1e6 * bias_m);
            format!(
                "on {} further cameras of style '{}' an edge found in {} of {} profiles, {:+.1} um off, sd \
                 {:.1} um, by camera {least_um:+.1} to {most_um:+.1} um",
                figures.looks,
                name(style),
                figures.located,
                figures.profiles,
                1e6 * figures.bias_m,
                1e6 * figures.sd_m
            )
        };
        format!(
            "fdm classify --train-edge: looks {} to {} of the simulated printer's style '{}', {} profiles; {}; {}",
            self.looks[0],
            self.looks[1] - 1,
            name(style),
            self.profiles,
            judged(style, &self.own_style),
            judged(other(style), &self.other_style)
        )
    }
}

/// Trains, judges, writes the file.
///
/// # Errors
/// Files that cannot be read or written, looks without a profile.
pub(super) fn run(config: &ConfigDir, args: &EdgeArgs, out: Option<&Path>) -> anyhow::Result<EdgeTraining> {
    let settings = settings::load(config)?;
    let optics = Optics::load(config)?;
    let path = out.map_or_else(|| config.file("models/road_edge.json"), Path::to_path_buf);
    if path.is_dir() {
        bail!("{}: is a folder, --train-edge writes a file", path.display());
    }
    let looks = args
        .seeds
        .clone()
        .unwrap_or_else(|| settings.looks.first..settings.looks.first + u64::from(settings.looks.count));
    let (figures, model) = train(&optics, &settings, looks)?;
    let text = model.with_trained(figures.trained.clone()).text()?;
    std::fs::write(&path, text).with_context(|| path.display().to_string())?;
    Ok(figures)
}

/// The network of these looks, and its figures.
fn train(
    optics: &Optics,
    settings: &Settings,
    looks: Range<u64>,
) -> anyhow::Result<(EdgeTraining, EdgeModel)> {
    let style = settings.looks.style;
    let ruler = optics.ruler(&settings.scene);
    let seen = |style: Style, looks: Range<u64>| gather(optics, settings, (style, looks));
    let profiles = seen(style, looks.clone())?;
    let mut stream = Stream::new(settings.seed);
    let bar = output::bar(u64::from(settings.fit.epochs()), "epochs");
    let mut tell = |epoch: u32, error_m: f64| {
        bar.set_position(u64::from(epoch));
        bar.set_message(format!("rms {:.1} um", 1e6 * error_m));
    };
    let model = fit(&profiles, &ruler, &settings.fit, &mut || stream.uniform(), &mut tell)?;
    bar.finish();
    // Cameras that nothing was learnt from: their seeds follow.
    let further = looks.end..looks.end + u64::from(settings.looks.judged);
    let figures = |style: Style| {
        let unseen = seen(style, further.clone())?;
        anyhow::Ok(judge(&model, &unseen, &ruler, optics.width.range_rel))
    };
    let mut training = EdgeTraining {
        trained: String::new(),
        looks: [looks.start, looks.end],
        profiles: profiles.len(),
        own_style: figures(style)?,
        other_style: figures(other(style))?,
    };
    training.trained = training.words(style);
    Ok((training, model))
}

/// Profiles of all looks, in the order of their seeds whatever the number of threads.
fn gather(
    optics: &Optics,
    settings: &Settings,
    (style, looks): (Style, Range<u64>),
) -> anyhow::Result<Vec<KnownEdge>> {
    let bar = output::bar(looks.end - looks.start, "looks");
    bar.set_message(format!("style {}", name(style)));
    let threads = u64::from(settings.threads);
    let parts = std::thread::scope(|scope| {
        let (bar, scene) = (&bar, &settings.scene);
        let start = |part: u64| {
            let seeds = (looks.start + part..looks.end).step_by(settings.threads as usize);
            scope.spawn(move || some(optics, (scene, style), seeds, bar))
        };
        let running: Vec<_> = (0..threads).map(start).collect();
        let finish = |part: std::thread::ScopedJoinHandle<'_, anyhow::Result<_>>| match part.join() {
            Ok(done) => done,
            Err(_) => bail!("a thread that renders ended early"),
        };
        running.into_iter().map(finish).collect::<anyhow::Result<Vec<_>>>()
    })?;
    bar.finish();
    let mut all: Vec<KnownEdge> = parts.into_iter().flatten().collect();
    // Stable: the profiles of a look keep their order.
    all.sort_by_key(|known| known.look);
    Ok(all)
}

/// Profiles of some of the looks.
fn some(
    optics: &Optics,
    (scene, style): (&SceneSettings, Style),
    seeds: impl Iterator<Item = u64>,
    bar: &ProgressBar,
) -> anyhow::Result<Vec<KnownEdge>> {
    let mut found = vec![];
    for seed in seeds {
        found.extend(optics.profiles(scene, (style, seed))?);
        bar.inc(1);
    }
    Ok(found)
}

fn name(style: Style) -> &'static str {
    match style {
        Style::Training => "training",
        Style::Test => "test",
    }
}

/// The style whose ranges the network has not seen.
fn other(style: Style) -> Style {
    match style {
        Style::Training => Style::Test,
        Style::Test => Style::Training,
    }
}
