//! Top of the page: what was printed and what came of it.

use super::View;
use super::verdict::verdict;
use super::words::{breakable, bytes, clock, counted, date, percent};
use crate::report::decode::short;
use crate::report::record::events::Severity;
use crate::up::words::{self, mode_name};
use maud::{Markup, html};

/// Worst events that are named at the top.
const WORST: usize = 5;

/// Name of the print.
pub(crate) fn title(view: &View) -> String {
    described(view, "gcode_file").unwrap_or_else(|| view.bag.name.clone())
}

fn described(view: &View, name: &str) -> Option<String> {
    view.record.print.described.get(name).filter(|value| !value.is_empty()).cloned()
}

/// Title, verdict, what is missing.
pub(crate) fn head(view: &View) -> Markup {
    let (class, verdict, why) = verdict(view);
    html! {
        p.kind { "Print report" @if let Some(at) = view.record.print.began_wall_s { " · " (date(at)) } }
        h1 { (breakable(&title(view))) }
        @if !view.torn.is_empty() {
            div.verdict.warn { div {
                b { "This bag is not whole." } " The report shows what is there."
                ul { @for line in view.torn { li { (line) } } }
            } }
        }
        @for (what, more) in doubts(view) { div.verdict.warn { div { b { (what) } " " (more) } } }
        div class=(format!("verdict {class}")) { div { b { (verdict) } " " (why) } }
    }
}

/// What a reader has to know before the figures: what could not be read, what does not belong together.
fn doubts(view: &View) -> Vec<(String, String)> {
    let (tally, prints) = (&view.record.tally, &view.record.print.prints);
    let (unread, all) = (tally.unread(), tally.messages);
    let mut doubts = Vec::new();
    if unread > 0 {
        let share = percent(unread as f64 / all.max(1) as f64, 1);
        let what = format!("{unread} of {all} messages ({share}) could not be decoded.");
        let more = "They are of another version, or damaged: the report is of the others. The recorder's section names them.";
        doubts.push((what, more.to_owned()));
    }
    if let Some(counts) = view.bag.counts.as_ref().filter(|counts| counts.messages > all) {
        let what = format!("{all} of {} recorded messages were found.", counts.messages);
        doubts.push((
            what,
            "Files of the bag are missing, or end early: the report is of the others.".to_owned(),
        ));
    }
    if prints.len() > 1 || !view.record.time.jumps.is_empty() {
        let what = format!("{} went into this bag.", counted(prints.len().max(2) as u64, "print"));
        let more = "They stand one after the other on one time axis, and layers of one number share a line; \
                    single files of the bag can be reported by themselves.";
        doubts.push((what, more.to_owned()));
    }
    doubts
}

/// The next steps for a person: those of what held the print up first.
fn todo(view: &View) -> String {
    let print = &view.record.print;
    let mut told = print.ending.told();
    told.retain(|held_up| !held_up.what_to_do.is_empty());
    let steps: Vec<String> = told.iter().map(|held_up| words::todo(&held_up.what_to_do)).collect();
    match told.first() {
        None => print
            .safety
            .as_ref()
            .map(|safety| words::todo(&short(&safety.what_to_do, 300)))
            .unwrap_or_default(),
        Some(_) if steps.len() == 1 => steps.concat(),
        Some(first) => format!("{}: {}", first.code(), steps.join("; then ")),
    }
}

/// Figures of the print, the worst events.
pub(crate) fn cards(view: &View) -> Markup {
    let worst = view.record.events.worst(WORST);
    let figures = figures(view);
    html! {
        dl.cards {
            @for (name, value, more) in &figures {
                div { dt { (name) } dd { (breakable(value)) @if !more.is_empty() { small { (breakable(more)) } } } }
            }
        }
        @if !worst.is_empty() {
            h3 { "Worst events" }
            ul {
                @for line in worst {
                    li {
                        span class=(format!("tag {}", line.severity.name())) { (line.severity.name()) } " "
                        (clock(line.times_s.first().copied().unwrap_or(0.0))) ": " (line.text.what)
                        @if !line.text.after.is_empty() { " → " b { (line.text.after) } }
                        @if !line.text.why.is_empty() { ", " (line.text.why) }
                        @if line.count > 1 { " (" (line.count) " times)" }
                    }
                }
            }
        }
        @let todo = todo(view);
        @if !todo.is_empty() { p { b { "What to do: " } (todo) } }
    }
}

/// Name, value and a remark of each figure.
fn figures(view: &View) -> Vec<(&'static str, String, String)> {
    let print = &view.record.print;
    let unknown = || "not known".to_owned();
    let configured = |name: &str| print.configured.get(name).cloned().unwrap_or_else(unknown);
    let wall = view.record.wall.layers();
    let layers = wall.unwrap_or(view.record.layers.layers.len() as u64);
    let modes = print.time_in_modes(view.span_s);
    let set = print.safety.as_ref().map_or_else(unknown, |safety| mode_name(safety.set_mode).to_owned());
    let in_modes: Vec<String> =
        modes.iter().map(|(name, time_s)| format!("{name} {}", clock(*time_s))).collect();
    let deposit = print
        .first_road_s
        .map_or(String::new(), |from| format!("roads from {} to {}", clock(from), clock(print.last_road_s)));
    let [infos, warnings, errors] = view.record.events.counts;
    let severity = view.record.events.severity().map_or("no event", Severity::name);
    let (counts, read) = (view.bag.counts.as_ref(), view.record.tally.messages);
    let recorder = match counts {
        Some(counts) if counts.messages == read => format!("{read} recorded"),
        Some(counts) => format!("{read} read, {} recorded", counts.messages),
        None => format!("{read} read"),
    };
    let lost = counts.map_or(String::new(), |counts| {
        format!("{} dropped by the recorder, {} did not arrive", counts.run.dropped, counts.run.missed)
    });
    let mut figures = vec![
        ("File", title(view), described(view, "print_id").unwrap_or_default()),
        ("Material", configured("material"), host(view)),
        ("Control", configured("control"), format!("mode as set: {set}")),
        ("Duration", clock(view.span_s), deposit),
        ("Phase at the end", print.phase().map_or_else(unknown, str::to_owned), progress(view)),
        ("Layers", layers.to_string(), last_layer(view)),
        ("Modes", modes.len().to_string(), in_modes.join(", ")),
        (
            "Events",
            counted(errors, "error"),
            format!("{}, {}; worst: {severity}", counted(warnings, "warning"), counted(infos, "note")),
        ),
        ("Messages", recorder, lost),
        ("Bag", bytes(view.bag.bytes()), counted(view.bag.files.len() as u64, "file")),
    ];
    if wall.is_some() {
        // Of a wall's process neither a filament nor a level of control is known.
        figures.retain(|(name, value, _)| !(matches!(*name, "Material" | "Control") && *value == unknown()));
        figures.insert(1, ("Mode as set", set, String::new()));
    }
    let sensors = |name: &str| print.configured.get(name).filter(|names| !names.is_empty());
    let [without, with] =
        ["without", "with"].map(|name| sensors(name).map(|names| format!("{name} {names}")));
    if without.is_some() || with.is_some() {
        figures.push(("Sensors", without.unwrap_or_default(), with.unwrap_or_default()));
    }
    if let Some(scenario) = described(view, "scenario") {
        figures.push(("Scenario", scenario, "simulated printer".to_owned()));
    }
    figures
}

pub(super) fn host(view: &View) -> String {
    view.record.print.configured.get("host").map_or(String::new(), |host| format!("host {host}"))
}

fn progress(view: &View) -> String {
    view.record.print.last.as_ref().map_or(String::new(), |state| percent(state.progress, 1))
}

fn last_layer(view: &View) -> String {
    let last = view.record.layers.layers.keys().next_back();
    last.map_or(String::new(), |last| format!("last one: {}", u64::from(*last) + 1))
}

/// Origin of page and print.
pub(crate) fn foot(view: &View) -> Markup {
    html! {
        p {
            "Made by " code { "fdm report" } " " (env!("CARGO_PKG_VERSION")) " from " code { (view.bag.name) } ". "
            @if let Some(build) = described(view, "build") { "Printed with build " code { (build) } ". " }
            @if let Some(hash) = described(view, "config_sha256") { "Configuration " code { (hash) } ". " }
            @if let Some(hash) = described(view, "gcode_sha256") { "File " code { (hash) } "." }
        }
        @if !view.record.print.config.is_empty() {
            details { summary { "Configuration" } pre { (view.record.print.config) } }
        }
    }
}
