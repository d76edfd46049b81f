//! `fdm classify`: probabilities of pictures, metrics on a labelled set, and the training of the committed networks.

mod chance;
mod edge;
mod figures;
mod photographs;
mod renders;
mod scored;
mod settings;
mod train;

use crate::config::ConfigDir;
use crate::output::{self, Json};
use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use defect_classifier::features::{self, Measured};
use defect_classifier::network::{Network, Scores};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Judges pictures with the committed networks.
#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("training").args(["train", "train_edge"]))]
pub struct ClassifyArgs {
    /// Pictures to judge.
    #[arg(required_unless_present_any = ["manifest", "train", "train_edge"])]
    images: Vec<PathBuf>,
    /// Labelled set: a CSV file with at least the columns file, class and group; files lie beside it.
    #[arg(long, conflicts_with = "images")]
    manifest: Option<PathBuf>,
    /// Judge pictures of the set that the network was trained with too.
    #[arg(long, requires = "manifest")]
    all: bool,
    /// Train the networks again and print their figures; with `--manifest` the one for photographs too.
    #[arg(long, conflicts_with = "images")]
    train: bool,
    /// Where the trained networks go: a folder; without it they replace those of `config/models`.
    #[arg(long, requires = "training", conflicts_with = "images")]
    out: Option<PathBuf>,
    #[command(flatten)]
    edge: edge::EdgeArgs,
    /// Network to judge with.
    #[arg(long, value_enum, default_value_t = View::Photograph)]
    view: View,
    /// Folder with the parameter files.
    #[arg(long)]
    config: Option<PathBuf>,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// Said wherever a network speaks for itself: what it reaches stands with its file.
const CAUTION: &str = "Caution: far from reliable by itself; of pictures it was not trained with it names about every second one \
                       wrong (config/models/README.md has the figures). Look at the picture before acting on this.";

/// What a picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum View {
    /// The camera on the toolhead, straight down.
    Toolhead,
    /// A whole print from anywhere.
    Photograph,
}

impl View {
    /// Name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Toolhead => "toolhead",
            Self::Photograph => "photograph",
        }
    }
}

/// Runs the command.
///
/// # Errors
/// One line that says what is wrong and where.
pub fn run(args: &ClassifyArgs) -> anyhow::Result<()> {
    let json = Json::new(args.json.as_deref());
    json.check()?;
    let config = ConfigDir::find(args.config.as_deref())?;
    if args.edge.train_edge {
        let figures = edge::run(&config, &args.edge, args.out.as_deref())?;
        return report(&json, &figures, figures.text());
    }
    if args.train {
        let out = args.out.clone().unwrap_or_else(|| config.file("models"));
        let figures = train::run(&config, args.manifest.as_deref(), &out)?;
        return report(&json, &figures, &figures.text());
    }
    let network = network(&config, args.view)?;
    if let Some(manifest) = &args.manifest {
        let seen = if args.all { Vec::new() } else { photographs::seen(&config.file("models"))? };
        let set = photographs::read(manifest, network.hidden(), &seen)?;
        set.check_labels(network.classes()).with_context(|| manifest.display().to_string())?;
        let figures = figures::of_photographs(&network, &set, &settings::load(&config)?)?;
        return report(&json, &figures, &format!("{}{CAUTION}", figures.text()));
    }
    let judged = args.images.iter().map(|path| judge(&network, path)).collect::<anyhow::Result<Vec<_>>>()?;
    let text: Vec<String> = judged.iter().map(Judged::text).chain([CAUTION.to_owned()]).collect();
    report(&json, &judged, &text.join("\n"))
}

/// The committed network of a view.
///
/// # Errors
/// The file and the field that is refused.
pub fn network(config: &ConfigDir, view: View) -> anyhow::Result<Network> {
    let path = config.file(&format!("models/{}.json", view.name()));
    let text = runtime::input::text(&path).with_context(|| path.display().to_string())?;
    Network::parse(&text).with_context(|| path.display().to_string())
}

fn report<T: Serialize>(json: &Json, figures: &T, text: &str) -> anyhow::Result<()> {
    if !json.is_stdout() {
        output::line(text)?;
    }
    json.write(figures)
}

/// What the network says of a picture.
#[derive(Debug, Serialize)]
struct Judged {
    image: String,
    class: String,
    probabilities: BTreeMap<String, f64>,
}

impl Judged {
    fn text(&self) -> String {
        let mut sorted: Vec<(&String, &f64)> = self.probabilities.iter().collect();
        sorted.sort_by(|one, other| other.1.total_cmp(one.1));
        let listed: Vec<String> =
            sorted.iter().map(|(class, p)| format!("{class} {:.1} %", 100.0 * *p)).collect();
        format!("{}: {}", self.image, listed.join(", "))
    }
}

/// Largest picture file that is opened `[byte]`.
const PICTURE_BYTES_MAX: u64 = 64 << 20;

/// A picture file, not larger than anything sensible.
fn read_picture(path: &Path) -> anyhow::Result<Vec<u8>> {
    let bytes = runtime::input::bytes(path, PICTURE_BYTES_MAX).with_context(|| path.display().to_string())?;
    if bytes.is_empty() {
        bail!("{}: an empty file is no picture", path.display());
    }
    Ok(bytes)
}

fn judge(network: &Network, path: &Path) -> anyhow::Result<Judged> {
    let context = || path.display().to_string();
    let values = features::extract_encoded(&read_picture(path)?, network.hidden(), &Measured::default())
        .with_context(context)?;
    let Scores { probabilities } = network.score(&values).with_context(context)?;
    let best = Scores { probabilities: probabilities.clone() }.best();
    Ok(Judged {
        image: context(),
        class: network.classes()[best].clone(),
        probabilities: network.classes().iter().cloned().zip(probabilities).collect(),
    })
}
