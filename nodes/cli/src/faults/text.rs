//! The figures of `fdm faults` for people.

use super::figures::{FaultFigures, Figures, TrialFigures};
use super::meaning;
use std::fmt::Write;

/// One row a trial, then what was missed.
#[must_use]
pub fn table(figures: &Figures) -> String {
    let with_told = figures.has_told();
    let mut text = heading(figures, with_told);
    for fault in &figures.faults {
        for trial in &fault.trials {
            row(&mut text, fault, trial, with_told);
            for measure in &trial.measures {
                _ = writeln!(text, "     {}", measure.text());
            }
            let figures: Vec<String> =
                trial.figures.iter().map(|(name, figure)| format!("{name} {figure:.2}")).collect();
            if !figures.is_empty() {
                _ = writeln!(text, "     {}", figures.join(", "));
            }
        }
        if let Some(why) = &fault.waiting {
            _ = writeln!(text, "{:<4} {:<34} waiting: {why}", fault.id, fault.fault);
        } else if let (true, Some(test)) = (fault.trials.is_empty(), &fault.test) {
            _ = writeln!(text, "{:<4} {:<34} test: {test}", fault.id, fault.fault);
        } else if fault.trials.is_empty() {
            _ = writeln!(text, "{:<4} {:<34} {}", fault.id, fault.fault, figures.elsewhere());
        }
    }
    for meaning in meaning::of(figures) {
        _ = writeln!(text, "{meaning}");
    }
    for fault in &figures.faults {
        for trial in &fault.trials {
            for miss in &trial.misses {
                _ = writeln!(text, "missed: {} {}, {miss}", fault.id, trial.name);
            }
        }
    }
    _ = write!(
        text,
        "false trips: {} before a fault or in {:.2} h of sound prints ({} prints, {:.2} h with the camera, {} pauses of files)",
        figures.false_trips, figures.hours, figures.sound_prints, figures.camera_hours, figures.file_pauses
    );
    for trip in &figures.false_trip_list {
        _ = write!(text, "\nfalse trip: {trip}");
    }
    text
}

/// What the columns are.
fn heading(figures: &Figures, with_told: bool) -> String {
    let mut text = format!("{}; seconds from injection to actuation", figures.title());
    if with_told {
        text += "; told: from injection until `fdm` says that a process ended, hangs or cannot write";
    }
    text.push('\n');
    // Writing to a string cannot fail.
    _ = writeln!(
        text,
        "{:<4} {:<34} {:>9} {:>7} {:>9} {:>8} {:>8} {:>10}{}  {:<5} found as",
        "ID",
        "fault",
        "reaction",
        "runs",
        "followed",
        "p50 s",
        "worst s",
        "limit",
        if with_told { format!(" {:>7} {:>6}", "told s", "limit") } else { String::new() },
        "kept"
    );
    text
}

fn row(text: &mut String, fault: &FaultFigures, trial: &TrialFigures, with_told: bool) {
    let time = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
    let in_words = || if fault.limit.is_some() { "text" } else { "-" }.to_owned();
    let limit = trial.limit().unwrap_or_else(in_words);
    let told_limit = trial.told_limit_s.map_or("-".to_owned(), |limit_s| format!("{limit_s} s"));
    let told = format!(" {:>7} {told_limit:>6}", time(trial.told_max_s));
    _ = writeln!(
        text,
        "{:<4} {:<34} {:>9} {:>7} {:>9} {:>8} {:>8} {:>10}{}  {:<5} {}",
        fault.id,
        trial.name,
        trial.action,
        trial.runs,
        trial.detected,
        time(trial.reaction_p50_s),
        time(trial.reaction_max_s),
        limit,
        if with_told { told.as_str() } else { "" },
        if trial.within_limit { "yes" } else { "NO" },
        trial.found_as.join(" "),
    );
}
