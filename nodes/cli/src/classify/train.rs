//! `fdm classify --train`: both networks anew, and what they reach on frames and photographs that they never saw.

use super::View;
use super::chance::{Stream, digest};
use super::figures::{PhotographFigures, RenderFigures, of_photographs, of_renders};
use super::photographs::{self, Photograph, Set};
use super::renders::{self, Render};
use super::settings::{self, Settings};
use crate::config::ConfigDir;
use crate::output;
use anyhow::Context;
use defect_classifier::features::{self, Hidden};
use defect_classifier::network::Network;
use defect_classifier::network::training::{FitParams, Labelled, Purpose, fit};
use printer_sim::camera::Style;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Where the labelled photographs lie beside a checkout.
const PHOTOGRAPHS: &str = "../shared/images/manifest.csv";
/// Classes of photographs, and the label in the manifest.
const CLASSES: [(&str, &str); 7] = [
    ("ok", "ok"),
    ("under_extrusion", "under_extrusion"),
    ("over_extrusion", "over_extrusion"),
    ("spaghetti", "spaghetti"),
    ("stringing", "stringing"),
    ("warping", "warping"),
    ("other", "failure_mixed"),
];
/// What the simulator measures apart from the picture is not an input.
const PICTURE_ONLY: [&str; 4] = ["width_known", "width_error", "offset_known", "offset_mm"];

/// What training reached.
#[derive(Debug, Serialize)]
pub(super) struct TrainFigures {
    toolhead: RenderFigures,
    photograph: Option<PhotographTraining>,
    /// Why there is none.
    photograph_reason: Option<String>,
}

#[derive(Debug, Serialize)]
struct PhotographTraining {
    trained_with: usize,
    trained_groups: usize,
    /// Pictures trained with, by source, licence and class.
    sources: BTreeMap<String, BTreeMap<String, usize>>,
    /// Groups that were never trained with, and sources that never were.
    held_out: PhotographFigures,
    /// Strands of sources that were never trained with against held-out other defects, and nothing else.
    unseen_sources: PhotographFigures,
}

impl TrainFigures {
    /// For people.
    pub(super) fn text(&self) -> String {
        let photographs = match (&self.photograph, &self.photograph_reason) {
            (Some(done), _) => format!(
                "trained with {} photographs of {} groups\n{}strands of unseen sources\n{}",
                done.trained_with,
                done.trained_groups,
                done.held_out.text(),
                done.unseen_sources.text()
            ),
            (None, reason) => reason.clone().unwrap_or_default(),
        };
        format!("{}\n{photographs}", self.toolhead.text())
    }
}

/// Trains, writes the files into `out`, judges.
///
/// # Errors
/// Files that cannot be read or written, labels that the networks do not know.
pub(super) fn run(config: &ConfigDir, manifest: Option<&Path>, out: &Path) -> anyhow::Result<TrainFigures> {
    let settings = settings::load(config)?;
    std::fs::create_dir_all(out).with_context(|| out.display().to_string())?;
    let toolhead = toolhead(config, &settings, out)?;
    let default = Path::new(PHOTOGRAPHS);
    let chosen = manifest.or_else(|| default.is_file().then_some(default));
    let Some(manifest) = chosen else {
        let reason = format!("{PHOTOGRAPHS} is absent: the network for photographs stays as it is");
        return Ok(TrainFigures { toolhead, photograph: None, photograph_reason: Some(reason) });
    };
    let photograph = Some(photograph(manifest, &settings, out)?);
    Ok(TrainFigures { toolhead, photograph, photograph_reason: None })
}

fn toolhead(config: &ConfigDir, settings: &Settings, out: &Path) -> anyhow::Result<RenderFigures> {
    let camera = renders::camera(config)?;
    output::note("rendering frames to train with");
    let frames = renders::gather(&camera, &settings.renders, Style::Training)?;
    let trained = format!(
        "fdm classify --train: {} rendered frames of the training style, seeds from {}, seed {}",
        frames.len(),
        settings.renders.first_seed,
        settings.seed
    );
    output::note("fitting the network of the toolhead's view");
    let inputs = picture_inputs();
    let purpose = Purpose {
        view: View::Toolhead.name(),
        hidden: Hidden(settings.renders.hidden_share),
        trained: &trained,
        classes: &renders::CLASSES,
        inputs: &inputs,
    };
    let examples: Vec<Labelled> =
        frames.into_iter().map(|Render { class, values }| Labelled { values, class, weight: 1.0 }).collect();
    let network = fitted(&purpose, &examples, (&settings.toolhead_fit, settings.seed), out)?;
    output::note("rendering frames to judge it by");
    let test = renders::gather(&camera, &settings.renders, Style::Test)?;
    of_renders(&network, &test, settings)
}

fn picture_inputs() -> Vec<&'static str> {
    features::names().into_iter().filter(|name| !PICTURE_ONLY.contains(name)).collect()
}

/// Fits, writes the file and reads it back.
fn fitted(
    purpose: &Purpose,
    examples: &[Labelled],
    (params, seed): (&FitParams, u64),
    out: &Path,
) -> anyhow::Result<Network> {
    let mut stream = Stream::new(seed);
    let text = fit(purpose, examples, params, &mut || stream.uniform())?;
    let path = out.join(format!("{}.json", purpose.view));
    std::fs::write(&path, &text).with_context(|| path.display().to_string())?;
    Network::parse(&text).with_context(|| path.display().to_string())
}

fn photograph(manifest: &Path, settings: &Settings, out: &Path) -> anyhow::Result<PhotographTraining> {
    output::note("reading photographs");
    let mut set = photographs::read(manifest, Hidden::default(), &[])?;
    for picture in &mut set.photographs {
        if let Some((name, _)) = CLASSES.iter().find(|(_, label)| *label == picture.class) {
            picture.class = (*name).to_owned();
        }
    }
    let unseen = |picture: &Photograph| {
        settings.photographs.unseen_sources.iter().any(|source| picture.source.starts_with(source))
    };
    let known = |picture: &Photograph| CLASSES.iter().any(|(name, _)| *name == picture.class);
    let apart =
        |picture: &Photograph| unseen(picture) || !known(picture) || settings.holds_out(&picture.group);
    let (test, train): (Vec<_>, Vec<_>) = set.photographs.into_iter().partition(apart);
    let names: Vec<&str> = CLASSES.iter().map(|(name, _)| *name).collect();
    let trained = format!(
        "fdm classify --train: {} photographs of {} groups, seed {}",
        train.len(),
        groups(&train),
        settings.seed
    );
    let inputs = picture_inputs();
    let purpose = Purpose {
        view: View::Photograph.name(),
        hidden: Hidden::default(),
        trained: &trained,
        classes: &names,
        inputs: &inputs,
    };
    let network = fitted(&purpose, &weighed(&train, &names), (&settings.photograph_fit, settings.seed), out)?;
    photographs::write_seen(out, train.iter().map(|picture| picture.digest).collect())?;
    let other = |picture: &&Photograph| {
        ["under_extrusion", "over_extrusion", "warping"].contains(&picture.class.as_str())
    };
    let strands =
        test.iter().filter(|picture| unseen(picture)).chain(test.iter().filter(other)).cloned().collect();
    let held_out = Set { photographs: test, left_out: train.len(), merged: set.merged, labels: set.labels };
    Ok(PhotographTraining {
        trained_with: train.len(),
        trained_groups: groups(&train),
        sources: sources(&train),
        held_out: of_photographs(&network, &held_out, settings)?,
        unseen_sources: of_photographs(&network, &Set { photographs: strands, ..Set::default() }, settings)?,
    })
}

fn groups(pictures: &[Photograph]) -> usize {
    pictures.iter().map(|picture| picture.group.as_str()).collect::<BTreeSet<_>>().len()
}

fn sources(pictures: &[Photograph]) -> BTreeMap<String, BTreeMap<String, usize>> {
    let mut sources: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for picture in pictures {
        let source = format!("{} ({})", picture.source, picture.licence);
        *sources.entry(source).or_default().entry(picture.class.clone()).or_default() += 1;
    }
    sources
}

/// Rare classes weigh more, by the root of their rarity; pictures of a large group weigh less.
fn weighed(pictures: &[Photograph], names: &[&str]) -> Vec<Labelled> {
    let count = |of: &dyn Fn(&Photograph) -> bool| {
        super::scored::number(pictures.iter().filter(|picture| of(picture)).count()).max(1.0)
    };
    let examples = pictures.iter().filter_map(|picture| {
        let class = names.iter().position(|name| *name == picture.class)?;
        let in_class = count(&|other| other.class == picture.class);
        let in_group = count(&|other| other.group == picture.group);
        Some(Labelled {
            values: picture.values.clone(),
            class,
            weight: 1.0 / (in_class * in_group.sqrt()).sqrt(),
        })
    });
    examples.collect()
}

impl Settings {
    /// Whether a group is never trained with.
    fn holds_out(&self, group: &str) -> bool {
        Stream::new(self.seed ^ digest(group.as_bytes())).uniform() < self.photographs.held_out_share
    }
}
