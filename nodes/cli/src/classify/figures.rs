//! What the networks reach: fields keep their names once published.

use super::photographs::Set;
use super::renders::Render;
use super::scored::{Interval, Scored, auroc, bootstrap, f1, number, recall_at, share};
use super::settings::Settings;
use defect_classifier::network::Network;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Classes of loose strands, and the label of pictures that show one or the other.
pub(super) const STRAND: [&str; 3] = ["spaghetti", "stringing", "spaghetti_or_stringing"];
/// Defects of the surface.
const SURFACE: [&str; 2] = ["under_extrusion", "over_extrusion"];
/// Five defects that photographs have labels for.
const FIVE: [&str; 5] = ["spaghetti", "stringing", "under_extrusion", "over_extrusion", "warping"];

/// One class against all others.
#[derive(Debug, Clone, Serialize)]
pub(super) struct ClassFigures {
    precision: Option<Interval>,
    recall: Option<Interval>,
    f1: Option<Interval>,
    support: usize,
}

/// Figures on labelled photographs.
#[derive(Debug, Serialize)]
pub(super) struct PhotographFigures {
    images: usize,
    /// Pictures that the network was trained with.
    left_out: usize,
    /// Rows that named a file again.
    merged: usize,
    /// Pictures with a label that the network does not have.
    other_labels: usize,
    /// Labels that nothing here knows, with their files; those left out among them.
    unknown_labels: BTreeMap<String, usize>,
    classes: BTreeMap<String, ClassFigures>,
    auroc_strand_vs_other: Option<Interval>,
    accuracy_5: Option<Interval>,
    accuracy_3: Option<Interval>,
    recall_at_5pct_fpr: Option<Interval>,
    ms_per_image: Option<f64>,
    /// Why a field is null.
    reasons: BTreeMap<&'static str, String>,
}

/// Figures on rendered frames.
#[derive(Debug, Serialize)]
pub(super) struct RenderFigures {
    images: usize,
    classes: BTreeMap<String, ClassFigures>,
    macro_f1: Option<Interval>,
    accuracy: Option<Interval>,
    auroc_failure: Option<Interval>,
    recall_at_1pct_fpr: Option<Interval>,
    /// Rows: what was shown; columns: what was said; both in the order of `order`.
    confusion: Vec<Vec<usize>>,
    order: Vec<String>,
}

/// Scores of features, one cluster per picture where `cluster` says no other.
pub(super) fn score(
    network: &Network,
    (class, cluster): (&str, u64),
    values: &[f64],
) -> anyhow::Result<Scored> {
    Ok(Scored { class: class.to_owned(), cluster, probabilities: network.score(values)?.probabilities })
}

fn of_class(
    pairs: &[(&str, &str)],
    scored: &[&Scored],
    class: &str,
    network: &Network,
    draw: (u64, u32),
) -> ClassFigures {
    let hits = pairs.iter().filter(|(truth, said)| *truth == class && *said == class).count();
    let support = pairs.iter().filter(|(truth, _)| *truth == class).count();
    let said = pairs.iter().filter(|(_, said)| *said == class).count();
    let again = |drawn: &[&Scored]| f1(&said_of(drawn, network), &class);
    ClassFigures {
        precision: share(hits, said),
        recall: share(hits, support),
        f1: bootstrap(scored, draw, &again),
        support,
    }
}

/// Truth and the most probable class.
fn said_of<'a>(scored: &[&'a Scored], network: &'a Network) -> Vec<(&'a str, &'a str)> {
    let all: Vec<usize> = (0..network.classes().len()).collect();
    let said = |item: &Scored| item.best_of(&all).map_or("", |best| network.classes()[best].as_str());
    scored.iter().map(|item| (item.class.as_str(), said(item))).collect()
}

fn by_class(scored: &[&Scored], network: &Network, draw: (u64, u32)) -> BTreeMap<String, ClassFigures> {
    let pairs = said_of(scored, network);
    let figures = |class: &String| (class.clone(), of_class(&pairs, scored, class, network, draw));
    network.classes().iter().map(figures).collect()
}

/// Figures of a network on rendered frames.
///
/// # Errors
/// Features that the network cannot take.
pub(super) fn of_renders(
    network: &Network,
    renders: &[Render],
    settings: &Settings,
) -> anyhow::Result<RenderFigures> {
    let draw = (settings.seed, settings.resamples);
    let names = super::renders::CLASSES;
    let scored = (0_u64..)
        .zip(renders)
        .map(|(cluster, render)| score(network, (names[render.class], cluster), &render.values));
    let scored = scored.collect::<anyhow::Result<Vec<_>>>()?;
    let scored: Vec<&Scored> = scored.iter().collect();
    let pairs = said_of(&scored, network);
    let order = network.classes().to_vec();
    let count = |truth: &String, said: &String| {
        pairs.iter().filter(|pair| pair.0 == truth.as_str() && pair.1 == said.as_str()).count()
    };
    let mean_f1 = |drawn: &[&Scored]| {
        let pairs = said_of(drawn, network);
        let each: Vec<f64> =
            network.classes().iter().filter_map(|class| f1(&pairs, &class.as_str())).collect();
        (!each.is_empty()).then(|| each.iter().sum::<f64>() / number(each.len()))
    };
    Ok(RenderFigures {
        images: scored.len(),
        classes: by_class(&scored, network, draw),
        macro_f1: bootstrap(&scored, draw, &mean_f1),
        accuracy: share(pairs.iter().filter(|(truth, said)| truth == said).count(), pairs.len()),
        auroc_failure: bootstrap(&scored, draw, &|drawn| auroc(&failure(drawn))),
        recall_at_1pct_fpr: bootstrap(&scored, draw, &|drawn| recall_at(&failure(drawn), 0.01)),
        confusion: order.iter().map(|truth| order.iter().map(|said| count(truth, said)).collect()).collect(),
        order,
    })
}

/// Probability of any defect, and whether there is one.
fn failure(scored: &[&Scored]) -> Vec<(f64, bool)> {
    scored.iter().map(|item| (1.0 - item.probabilities[0], item.class != "ok")).collect()
}

/// Figures of a network on labelled photographs.
///
/// # Errors
/// Features that the network cannot take.
pub(super) fn of_photographs(
    network: &Network,
    set: &Set,
    settings: &Settings,
) -> anyhow::Result<PhotographFigures> {
    let draw = (settings.seed, settings.resamples);
    let scored = set.photographs.iter().map(|picture| {
        score(network, (&picture.class, super::chance::digest(picture.group.as_bytes())), &picture.values)
    });
    let scored = scored.collect::<anyhow::Result<Vec<_>>>()?;
    let all: Vec<&Scored> = scored.iter().collect();
    let has = |name: &str| network.classes().iter().any(|class| class == name);
    let known: Vec<&Scored> = all.iter().copied().filter(|item| has(&item.class)).collect();
    let labelled = |names: &[&str]| -> Vec<&Scored> {
        all.iter().copied().filter(|item| names.contains(&item.class.as_str())).collect()
    };
    let five: Vec<usize> =
        FIVE.iter().filter_map(|name| network.classes().iter().position(|class| class == name)).collect();
    let complete = five.len() == FIVE.len();
    let defects = labelled(&[&STRAND[..], &SURFACE[..], &["warping"]].concat());
    let in_five = if complete { labelled(&FIVE) } else { vec![] };
    let said = |item: &Scored| item.best_of(&five).map_or("", |best| network.classes()[best].as_str());
    let right_5 = in_five.iter().filter(|item| said(item) == item.class).count();
    let in_three: &[&Scored] = if complete { &defects } else { &[] };
    let right_3 = in_three.iter().filter(|item| kind(said(item)) == kind(&item.class)).count();
    let strand = |drawn: &[&Scored]| {
        let scores = drawn.iter().map(|item| (strand_share(item, &five, network), kind(&item.class) == 0));
        auroc(&scores.collect::<Vec<_>>())
    };
    let took = set.photographs.iter().map(|picture| picture.took.as_secs_f64()).sum::<f64>();
    let mut figures = PhotographFigures {
        images: all.len(),
        left_out: set.left_out,
        merged: set.merged,
        other_labels: all.len() - known.len(),
        unknown_labels: set.unknown_labels(network.classes()),
        classes: by_class(&known, network, draw),
        auroc_strand_vs_other: if complete { bootstrap(&defects, draw, &strand) } else { None },
        accuracy_5: share(right_5, in_five.len()),
        accuracy_3: share(right_3, in_three.len()),
        recall_at_5pct_fpr: bootstrap(&known, draw, &|drawn| recall_at(&failure(drawn), 0.05)),
        ms_per_image: (!all.is_empty()).then(|| 1e3 * took / number(all.len())),
        reasons: BTreeMap::new(),
    };
    figures.explain(complete);
    Ok(figures)
}

/// Strand 0, surface 1, other 2.
fn kind(class: &str) -> u8 {
    if STRAND.contains(&class) {
        0
    } else if SURFACE.contains(&class) {
        1
    } else {
        2
    }
}

/// Probability of a strand among the five defects.
fn strand_share(item: &Scored, five: &[usize], network: &Network) -> f64 {
    let total: f64 = five.iter().map(|class| item.probabilities[*class]).sum();
    let strand = five.iter().filter(|class| kind(&network.classes()[**class]) == 0);
    strand.map(|class| item.probabilities[*class]).sum::<f64>() / total.max(1e-12)
}

impl PhotographFigures {
    fn explain(&mut self, complete: bool) {
        let why = if complete {
            "the set has no pictures of both sides"
        } else {
            "the network does not know the five defects"
        };
        let nulls = [
            ("auroc_strand_vs_other", self.auroc_strand_vs_other.is_none()),
            ("accuracy_5", self.accuracy_5.is_none()),
            ("accuracy_3", self.accuracy_3.is_none()),
            ("recall_at_5pct_fpr", self.recall_at_5pct_fpr.is_none()),
            ("ms_per_image", self.ms_per_image.is_none()),
        ];
        for (field, _) in nulls.into_iter().filter(|(_, null)| *null) {
            let set_alone = field == "recall_at_5pct_fpr" || field == "ms_per_image";
            let why = if set_alone { "the set has no pictures of both sides" } else { why };
            self.reasons.insert(field, why.to_owned());
        }
    }

    /// For people.
    pub(super) fn text(&self) -> String {
        let mut text = format!(
            "photographs  {} judged, {} trained with and left out, {} rows merged, {} with other labels\n",
            self.images, self.left_out, self.merged, self.other_labels
        );
        text += &super::photographs::labels_text(&self.unknown_labels);
        text += &classes_text(&self.classes);
        text += &lines(&[
            ("AUROC strand against other", self.auroc_strand_vs_other),
            ("accuracy of five", self.accuracy_5),
            ("accuracy of three", self.accuracy_3),
            ("recall at 5 % false", self.recall_at_5pct_fpr),
        ]);
        for (field, why) in &self.reasons {
            // Writing to a string cannot fail.
            _ = writeln!(text, "{field}: none, {why}");
        }
        text
    }
}

impl RenderFigures {
    /// For people.
    pub(super) fn text(&self) -> String {
        let mut text = format!("toolhead     {} frames of the test style\n", self.images);
        text += &classes_text(&self.classes);
        text += &lines(&[
            ("macro F1", self.macro_f1),
            ("accuracy", self.accuracy),
            ("AUROC failure or not", self.auroc_failure),
            ("recall at 1 % false", self.recall_at_1pct_fpr),
        ]);
        _ = writeln!(text, "rows shown, columns said: {}", self.order.join(" "));
        for (class, row) in self.order.iter().zip(&self.confusion) {
            let counts: Vec<String> = row.iter().map(|count| format!("{count:5}")).collect();
            _ = writeln!(text, "  {class:16}{}", counts.concat());
        }
        text
    }
}

fn classes_text(classes: &BTreeMap<String, ClassFigures>) -> String {
    let written =
        |value: Option<Interval>| value.map_or_else(|| "  -  ".into(), |[value, ..]| format!("{value:.3}"));
    classes.iter().fold(String::new(), |mut text, (class, figures)| {
        let [precision, recall, f1] = [figures.precision, figures.recall, figures.f1].map(written);
        let support = figures.support;
        _ = writeln!(text, "  {class:16} precision {precision}  recall {recall}  F1 {f1}  of {support}");
        text
    })
}

fn lines(figures: &[(&str, Option<Interval>)]) -> String {
    figures.iter().fold(String::new(), |mut text, (name, value)| {
        if let Some([value, low, high]) = value {
            _ = writeln!(text, "  {name:27} {value:.3} [{low:.3}, {high:.3}]");
        }
        text
    })
}
