//! `fdm wire sim`: height error of a simulated wall, layer by layer, open against closed.

use super::closed_loop::{Built, Wall, mean};
use super::picture;
use crate::config::ConfigDir;
use crate::options::{in_range, significant};
use crate::output::{self, Json};
use crate::process::{self, Picture};
use clap::{Args, ValueEnum};
use models::wire::correction::{GAIN_RANGE, GAIN_STABLE_BELOW};
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;

/// Simulates walls; every figure is one of the simulated process of config/plants/wire.yaml.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct SimArgs {
    /// Layers of the wall.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1000))]
    layers: u32,
    /// Gain in place of the configured one `[-]`; the loop is stable in (0, 2).
    #[arg(long)]
    gain: Option<f64>,
    /// Noise of the height sensor in place of the configured one `[mm]`.
    #[arg(long)]
    noise: Option<f64>,
    /// Which layers get dips and bumps: each, or the first alone. Drops scatter in all of them, and the open wall drifts.
    #[arg(long, value_enum, default_value = "every")]
    dips: Dips,
    /// Seeds: A..B, both included.
    #[arg(long, default_value = "1..40")]
    seeds: String,
    /// Draw into a file that ends in .svg or .html.
    #[arg(long)]
    picture: Option<PathBuf>,
    /// Folder with the parameter files.
    #[arg(long)]
    config: Option<PathBuf>,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// Layers with dips and bumps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Dips {
    /// Every layer.
    Every,
    /// The first layer.
    First,
}

/// Mean, spread and least of a figure over the seeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Over {
    /// Mean.
    pub mean: f64,
    /// Sample standard deviation.
    pub spread: f64,
    /// Least.
    pub least: f64,
}

/// Walls of one kind.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Group {
    /// `open` or `closed`.
    pub control: &'static str,
    /// One wall a seed.
    pub runs: Vec<Built>,
    /// Height RMS of each layer, mean over the seeds.
    pub rms_by_layer_mm: Vec<f64>,
    /// Height RMS over all layers.
    pub rms_mm: Over,
    /// Height RMS of the last layer.
    pub last_rms_mm: Over,
    /// As `rms_mm`, about each layer's mean.
    pub roughness_mm: Over,
    /// As `last_rms_mm`, about the layer's mean.
    pub last_roughness_mm: Over,
    /// Share of the time of laying in which a limit held the correction, mean over the seeds.
    pub limited_share: f64,
    /// Share of the height samples that were refused.
    pub refused_share: f64,
}

/// The figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// Layers of a wall.
    pub layers: u32,
    /// Gain of the law.
    pub gain: f64,
    /// Whether height errors fade from layer to layer with it: above 0 and below 2.
    pub stable: bool,
    /// Noise of the height sensor.
    pub noise_mm: f64,
    /// Open and closed.
    pub results: Vec<Group>,
    /// Open over closed, all layers, seed by seed.
    pub ratio: Over,
    /// Open over closed, last layer.
    pub last_ratio: Over,
    /// Open over closed, all layers, about each layer's mean.
    pub roughness_ratio: Over,
    /// Open over closed, last layer, about its mean.
    pub last_roughness_ratio: Over,
}

/// Runs the command.
///
/// # Errors
/// One line that says what is wrong and where.
pub fn run(args: &SimArgs) -> anyhow::Result<()> {
    let seeds = process::seeds("--seeds", &args.seeds)?;
    let json = Json::new(args.json.as_deref());
    json.check()?;
    let picture = args.picture.as_deref().map(Picture::new).transpose()?;
    let (wall, noise_m) = wall(args)?;
    let progress = output::bar(2 * seeds.len() as u64, "walls");
    let build = |closed| -> Vec<Built> {
        let build = |seed: &u64| {
            progress.inc(1);
            wall.build(closed, *seed)
        };
        seeds.iter().map(build).collect()
    };
    let (open, closed) = (build(false), build(true));
    progress.finish_and_clear();
    let ratio = |figure: fn(&Built) -> f64| {
        let ratios = open.iter().zip(&closed).map(|(open, closed)| figure(open) / figure(closed));
        Over::of(&ratios.collect::<Vec<_>>())
    };
    let figures = Figures {
        layers: args.layers,
        gain: wall.process.law.gain,
        stable: wall.process.law.is_stable(),
        noise_mm: 1e3 * noise_m,
        ratio: ratio(|wall| wall.rms_mm),
        last_ratio: ratio(|wall| wall.last_rms_mm),
        roughness_ratio: ratio(|wall| wall.roughness_mm),
        last_roughness_ratio: ratio(|wall| wall.last_roughness_mm),
        results: vec![Group::of("open", open), Group::of("closed", closed)],
    };
    if let Some(picture) = picture {
        picture::draw(&picture, &figures, wall.plant.wall_length_m)?;
    }
    if !json.is_stdout() {
        output::line(&text(&figures))?;
    }
    json.write(&figures)
}

/// Noises of a sensor `[mm]`: the range of `sensor.sigma_m`, which config/plants/wire.yaml states.
const NOISE_RANGE_MM: (f64, f64) = (0.0, 10.0);

fn wall(args: &SimArgs) -> anyhow::Result<(Wall, f64)> {
    let config = ConfigDir::find(args.config.as_deref())?;
    let mut believed = super::nominal(&config)?;
    if let Some(gain) = args.gain {
        in_range("--gain", gain, "-", GAIN_RANGE)?;
        believed.law = believed.law.with_gain(gain)?;
    }
    let mut plant: printer_sim::wire::Params = process::block(&config, "plants/wire.yaml", "wire_plant")?;
    if let Some(noise_mm) = args.noise {
        in_range("--noise", noise_mm, "mm", NOISE_RANGE_MM)?;
        plant = plant.with_noise(1e-3 * noise_mm)?;
    }
    let wall = Wall {
        process: believed,
        controller: process::block(&config, "wire/controller.yaml", "wire_controller")?,
        plant,
        layers: args.layers,
        features_until: if args.dips == Dips::First { 1 } else { u32::MAX },
    };
    Ok((wall, plant.sensor.sigma_m))
}

impl Over {
    fn of(values: &[f64]) -> Self {
        let average = mean(values);
        let squares: f64 = values.iter().map(|value| (value - average).powi(2)).sum();
        #[allow(clippy::cast_precision_loss, reason = "seeds are few")]
        let freedom = (values.len() as f64 - 1.0).max(1.0);
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        Self { mean: average, spread: (squares / freedom).sqrt(), least }
    }
}

impl Group {
    fn of(control: &'static str, runs: Vec<Built>) -> Self {
        let over = |figure: fn(&Built) -> f64| Over::of(&runs.iter().map(figure).collect::<Vec<_>>());
        let layers = runs.first().map_or(0, |run| run.layers.len());
        let by_layer =
            |layer: usize| mean(&runs.iter().map(|run| run.layers[layer].rms_mm).collect::<Vec<_>>());
        Self {
            control,
            rms_by_layer_mm: (0..layers).map(by_layer).collect(),
            rms_mm: over(|wall| wall.rms_mm),
            last_rms_mm: over(|wall| wall.last_rms_mm),
            roughness_mm: over(|wall| wall.roughness_mm),
            last_roughness_mm: over(|wall| wall.last_roughness_mm),
            limited_share: over(|wall| wall.limited_share).mean,
            refused_share: over(Built::refused_share).mean,
            runs,
        }
    }
}

/// What the figures below do not show by themselves.
fn caveats(figures: &Figures) -> String {
    let mut text = String::new();
    let closed = figures.results.last();
    let of = |share: fn(&Group) -> f64| 100.0 * closed.map_or(0.0, share);
    // Writing to a string cannot fail.
    if !figures.stable {
        _ = writeln!(text, "gain {:.3}{}", figures.gain, super::unstable(figures.gain, figures.stable));
    }
    if !figures.stable && figures.gain > GAIN_STABLE_BELOW {
        let grown = (figures.gain - 1.0).powf(f64::from(figures.layers) - 1.0);
        _ = writeln!(
            text,
            "without limits an error of the first layer would be {} times as large in layer {}; here limits held the \
             correction in {:.1} % of the time, so the figures below do not show the growth",
            significant(grown, 3),
            figures.layers,
            of(|group| group.limited_share)
        );
    }
    let refused = of(|group| group.refused_share);
    if refused > 0.0 {
        let all = if refused > 99.95 { "; all: closed is open" } else { "" };
        _ = writeln!(
            text,
            "heights: {refused:.1} % refused, farther from the plan than error_max_m of config/wire/controller.yaml{all}"
        );
    }
    text
}

fn text(figures: &Figures) -> String {
    let cell = |over: &Over| format!("{:.3} +- {:.3}", over.mean, over.spread);
    let mut text = String::new();
    // Writing to a string cannot fail.
    _ = writeln!(
        text,
        "Simulated walls of {} layers, gain {:.3}, height noise {:.2} mm, {} seed(s); mean +- standard deviation, mm",
        figures.layers,
        figures.gain,
        figures.noise_mm,
        figures.results.first().map_or(0, |group| group.runs.len()),
    );
    text.push_str(&caveats(figures));
    _ = writeln!(
        text,
        "{:<8} {:>16} {:>16} {:>16} {:>16}",
        "control", "RMS all layers", "RMS last", "rough all", "rough last"
    );
    for group in &figures.results {
        _ = writeln!(
            text,
            "{:<8} {:>16} {:>16} {:>16} {:>16}",
            group.control,
            cell(&group.rms_mm),
            cell(&group.last_rms_mm),
            cell(&group.roughness_mm),
            cell(&group.last_roughness_mm)
        );
    }
    let ratios =
        [&figures.ratio, &figures.last_ratio, &figures.roughness_ratio, &figures.last_roughness_ratio];
    let cells: Vec<String> = ratios.iter().map(|ratio| format!("{:>16}", cell(ratio))).collect();
    _ = writeln!(text, "{:<8} {}", "ratio", cells.join(" "));
    let least: Vec<String> = ratios.iter().map(|ratio| format!("{:>16.2}", ratio.least)).collect();
    _ = writeln!(text, "{:<8} {}", "least", least.join(" "));
    _ = writeln!(
        text,
        "RMS: height error against the plan; rough: about each layer's mean; ratio: open over closed, seed by seed; \
         least: smallest ratio of a seed"
    );
    _ = writeln!(text, "{:<8} {:>10} {:>10}", "layer", "open", "closed");
    let column = |index: usize, layer: usize| figures.results[index].rms_by_layer_mm[layer];
    for layer in 0..figures.results.first().map_or(0, |group| group.rms_by_layer_mm.len()) {
        _ = writeln!(text, "{:<8} {:>10.3} {:>10.3}", layer + 1, column(0, layer), column(1, layer));
    }
    text
}
