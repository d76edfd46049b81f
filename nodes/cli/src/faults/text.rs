//! The figures of `fdm faults` for people.

use super::figures::{FaultFigures, Figures, TrialFigures};
use super::meaning;
use std::fmt::Write;

/// One row a trial, then what was missed.
#[must_use]
pub fn table(figures: &Figures) -> String {
    let mut text = format!("{}; seconds from injection to actuation\n", figures.title());
    // Writing to a string cannot fail.
    _ = writeln!(
        text,
        "{:<4} {:<34} {:>9} {:>7} {:>9} {:>8} {:>8} {:>10}  {:<5} found as",
        "ID", "fault", "action", "runs", "detected", "p50 s", "worst s", "limit", "kept"
    );
    for fault in &figures.faults {
        for trial in &fault.trials {
            row(&mut text, fault, trial);
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
        "false trips: {} before a fault or in {:.2} h of sound prints",
        figures.false_trips, figures.hours
    );
    for trip in &figures.false_trip_list {
        _ = write!(text, "\nfalse trip: {trip}");
    }
    text
}

fn row(text: &mut String, fault: &FaultFigures, trial: &TrialFigures) {
    let time = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
    let in_words = || if fault.limit.is_some() { "text" } else { "-" }.to_owned();
    let limit = trial.limit().unwrap_or_else(in_words);
    _ = writeln!(
        text,
        "{:<4} {:<34} {:>9} {:>7} {:>9} {:>8} {:>8} {:>10}  {:<5} {}",
        fault.id,
        trial.name,
        trial.action,
        trial.runs,
        trial.detected,
        time(trial.reaction_p50_s),
        time(trial.reaction_max_s),
        limit,
        if trial.within_limit { "yes" } else { "NO" },
        trial.found_as.join(" "),
    );
}
