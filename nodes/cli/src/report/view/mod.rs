//! The page: what was gathered, as one HTML file that needs nothing else.

pub(crate) mod against;
pub(crate) mod bars;
pub(crate) mod chart;
pub(crate) mod frames;
pub(crate) mod ink;
pub(crate) mod map;
pub(crate) mod plots;
pub(crate) mod summary;
pub(crate) mod tables;
pub(crate) mod trace;
mod verdict;
pub(crate) mod wall;
pub(crate) mod words;

use super::bag::Bag;
use super::record::Record;
use super::record::events::Severity;
use ink::Ink;
use maud::{DOCTYPE, Markup, html};
use trace::Marker;

/// Markers on the time axes.
const MARKERS_MAX: usize = 24;

/// What every section needs.
pub(crate) struct View<'a> {
    pub(crate) bag: &'a Bag,
    pub(crate) record: &'a Record,
    /// What is missing or broken, said at the top.
    pub(crate) torn: &'a [String],
    /// Length of the time axes `[s]`.
    pub(crate) span_s: f64,
    pub(crate) markers: Vec<Marker>,
}

/// The page as text; with another print beside this one where there is one.
pub(crate) fn page(bag: &Bag, record: &Record, torn: &[String], other: Option<&against::Other>) -> String {
    let span_s = record.time.newest_s.max(1.0);
    let view = View { bag, record, torn, span_s, markers: markers(record) };
    let mut sections = sections(&view);
    if let Some(other) = other {
        sections.insert(1, ("against", "Against another print", against::section(&view, other)));
    }
    html! {
        (DOCTYPE)
        html lang="en" {
            (crate::html::head(&format!("{} · print report", summary::title(&view)), include_str!("style.css")))
            body {
                header { (summary::head(&view)) }
                nav { div { @for (id, name, ..) in &sections { a href=(format!("#{id}")) { (if *id == "truth" { "Truth" } else { name.split(' ').next().unwrap_or(name) }) } } } }
                main {
                    @for (id, name, content) in &sections {
                        h2 id=(id) { (name) }
                        (content)
                    }
                }
                footer { (summary::foot(&view)) }
            }
        }
    }
    .into_string()
}

/// Sections in order: anchor, name, content.
fn sections(view: &View) -> Vec<(&'static str, &'static str, Markup)> {
    let mut sections = vec![
        ("summary", "Summary", summary::cards(view)),
        ("events", "Events", tables::events(view)),
        ("temperatures", "Temperatures", plots::temperatures(view)),
        ("slip", "Slip and gain", plots::slip(view)),
        ("width", "Width of the road", plots::width(view)),
        ("commands", "Commands", plots::commands(view)),
        ("quality", "Quality by layer", plots::quality(view)),
        ("confidence", "Defects", plots::confidence(view)),
        ("pictures", "Pictures", frames::pictures(view)),
        ("layers", "Layers from above", frames::layers(view)),
        ("consistency", "Consistency", plots::consistency(view)),
        ("vibration", "Vibration", plots::vibration(view)),
    ];
    if let Some(wall) = wall::wall(view) {
        sections.retain(|(id, ..)| !wall::is_foreign(view, id));
        sections.push(("wall", "Wall", wall));
    }
    if let Some(truth) = plots::truth(view) {
        sections.push(("truth", "Simulated truth", truth));
    }
    sections.push(("recorder", "Recorder", tables::recorder(view)));
    sections.push(("diagnostics", "Diagnostics", tables::diagnostics(view)));
    sections
}

/// A topic that the bag does not hold, said where it is missed.
pub(crate) fn absent(what: &str, topic: &str) -> Markup {
    html! { p.absent { (what) ": the bag holds no usable message of " code { (topic) } "." } }
}

/// Events for the time axes: the worst first, numbered as in the table.
fn markers(record: &Record) -> Vec<Marker> {
    let mut found: Vec<(Severity, Marker)> = Vec::new();
    for (index, line) in record.events.lines().iter().enumerate().take(tables::EVENTS_MAX) {
        let ink = match line.severity {
            Severity::Info => Ink::Info,
            Severity::Warn => Ink::Warn,
            Severity::Error => Ink::Error,
        };
        let marker = |at: &f64| (line.severity, Marker { at: *at, number: index + 1, ink });
        found.extend(line.times_s.iter().take(3).map(marker));
    }
    found.sort_by_key(|(severity, _)| std::cmp::Reverse(*severity));
    found.truncate(MARKERS_MAX);
    found.sort_by(|a, b| a.1.at.total_cmp(&b.1.at));
    found.into_iter().map(|(_, marker)| marker).collect()
}
