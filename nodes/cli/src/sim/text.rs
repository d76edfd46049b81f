//! The figures of `fdm sim` for people.

mod corrected;
mod stated;

use super::group::Group;
use super::report::AdvanceFigures;
use corrected::corrected;
use stated::{blind, covered, nis};
use std::fmt::Write;

const COLUMNS: usize = 9;
const HEADINGS: [&str; COLUMNS] =
    ["control", "done", "Q", "width RMS %", "feed error %", "after 2 s %", "back for 5 s", "NEES", "x real"];

/// Form of the filter that is shipped, of which nothing is told.
const USUAL_FILTER: &str = "square_root";

/// One row a control level, mean and spread over the seeds.
#[must_use]
pub fn table(groups: &[Group]) -> String {
    let mut text = String::new();
    let Some(run) = groups.first().and_then(|group| group.runs.first()) else { return text };
    let seeds = groups.first().map_or(0, |group| group.seeds);
    let listed = |word: &str, sensors: &[String]| {
        if sensors.is_empty() { String::new() } else { format!(", {word} {}", sensors.join(", ")) }
    };
    let sensors = listed("without", &run.without) + &listed("with", &run.with);
    let filter = if run.filter == USUAL_FILTER { String::new() } else { format!(", filter {}", run.filter) };
    let spread = if seeds > 1 {
        format!("; mean +- standard deviation, (n of {seeds}) where fewer have it")
    } else {
        String::new()
    };
    // Writing to a string cannot fail.
    _ = writeln!(
        text,
        "Simulated: {} in {}, scenario {}, host {}{sensors}{filter}, {seeds} seed(s){spread}",
        run.gcode, run.material, run.scenario, run.host,
    );
    let rows: Vec<[String; COLUMNS]> =
        std::iter::once(HEADINGS.map(str::to_owned)).chain(groups.iter().map(row)).collect();
    for row in &rows {
        for (column, cell) in row.iter().enumerate() {
            let width = rows.iter().map(|row| row[column].len()).max().unwrap_or(0);
            _ = if column == 0 { write!(text, "{cell:<width$}") } else { write!(text, "  {cell:>width$}") };
        }
        text.push('\n');
    }
    for group in groups {
        unfinished(&mut text, group);
    }
    for group in groups {
        _ = writeln!(text, "{:<9} NIS {}", group.control, nis(group));
        covered(&mut text, group);
        blind(&mut text, group);
        advance(&mut text, group);
        corrected(&mut text, group);
        seen(&mut text, group);
        asked_for(&mut text, group);
        noticed(&mut text, group);
    }
    text
}

/// Figures of one control level, each with the number of runs that have it where that is not all.
fn row(group: &Group) -> [String; COLUMNS] {
    // One value deviates from nothing.
    let spread =
        |name: &str| group.spread.get(name).filter(|_| group.count.get(name).is_some_and(|count| *count > 1));
    let cell = |name: &str, scale: f64| {
        let Some(mean) = group.mean.get(name) else { return "-".to_owned() };
        let spread = spread(name).map_or_else(String::new, |spread| format!(" +- {:.3}", spread * scale));
        format!("{:.3}{spread}{}", mean * scale, group.share(name))
    };
    let plain = |name: &str| {
        group.mean.get(name).map_or("-".to_owned(), |mean| format!("{mean:.1}{}", group.share(name)))
    };
    [
        group.control.clone(),
        format!("{} of {}", group.done, group.seeds),
        cell("quality_mean", 1.0),
        cell("width_rms_rel", 100.0),
        cell("feed_error_rel", 100.0),
        cell("feed_error_after_2s_rel", 100.0),
        cell("recovery_5s_s", 1.0),
        plain("nees_median"),
        plain("realtime_factor"),
    ]
}

/// Runs that did not print their file to its end, one line a seed.
fn unfinished(text: &mut String, group: &Group) {
    for run in &group.unfinished {
        let by = run.by.as_ref().map_or_else(String::new, |by| format!(" by {by}"));
        _ = writeln!(
            text,
            "{:<9} NOT FINISHED: seed {} {} at {:.1} s{by}; its figures are of what it printed until then",
            group.control, run.seed, run.ended, run.at_s
        );
    }
}

/// Pressure advance and what it is for.
fn advance(text: &mut String, group: &Group) {
    let Some(run) = group.runs.first() else { return };
    let mean = |name: &str| group.mean.get(name).copied();
    let buffer = run.buffer.map_or_else(|| "the printer's".to_owned(), |moves| format!("{moves} moves"));
    let in_force = match run.advance_in_force {
        "file" => "the file's own",
        "material" => "the material's constant",
        name => name,
    };
    let asked = if run.advance == run.advance_in_force {
        String::new()
    } else {
        format!(" (asked for: {})", run.advance)
    };
    _ = writeln!(
        text,
        "{:<9} advance {in_force}{asked}, look-ahead {buffer}: width RMS at corners {}, print time {}",
        group.control,
        mean("corner_width_rms_rel").map_or_else(
            || "-".to_owned(),
            |rms| { format!("{:.2} %{}", 1e2 * rms, group.share("corner_width_rms_rel")) }
        ),
        mean("print_time_s")
            .map_or_else(|| "-".to_owned(), |time_s| format!("{time_s:.1} s{}", group.share("print_time_s"))),
    );
    let most = |of: fn(&AdvanceFigures) -> Option<u64>| {
        group.runs.iter().filter_map(|run| of(&run.advance_control)).max().unwrap_or(0)
    };
    let [outside, unanswered] = [most(|figures| figures.outside_hull), most(|figures| figures.unanswered)];
    if outside + unanswered > 0 {
        _ = writeln!(
            text,
            "{:<9} advance foretold OUTSIDE of the networks' data: {outside} conditions by the physical model, {unanswered} not at all",
            group.control
        );
    }
}

/// What the camera saw, one line a seed.
fn seen(text: &mut String, group: &Group) {
    for (run, seen) in group.runs.iter().filter_map(|run| Some((run, run.camera?))) {
        let um = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{:.1}", value * 1e6));
        _ = writeln!(
            text,
            "  seed {}: {} frames, {} not usable; {} widths, bias {} um, sigma {} um; largest offset {:.0} um; \
             {} seams, NIS {}, darkest {:.1} sigma",
            run.seed,
            seen.frames,
            seen.unusable,
            seen.widths,
            um(seen.width_bias_m),
            um(seen.width_sigma_m),
            seen.offset_max_m * 1e6,
            seen.seams,
            seen.seam_nis.map_or("-".to_owned(), |nis| format!("{nis:.2}")),
            seen.seam_darkest_sigmas
        );
    }
}

/// Pauses that the file asks for, one line a seed.
fn asked_for(text: &mut String, group: &Group) {
    for run in group.runs.iter().filter(|run| !run.file_pauses.is_empty()) {
        let pauses: Vec<String> = run
            .file_pauses
            .iter()
            .map(|pause| format!("in line {} at {:.1} s", pause.line, pause.detected_s))
            .collect();
        let list = pauses.join(", ");
        _ = writeln!(text, "  seed {}: paused as the file asks for, {list}; ended {}", run.seed, run.ended);
    }
}

/// What the loop noticed, one line a seed.
fn noticed(text: &mut String, group: &Group) {
    for run in group.runs.iter().filter(|run| !run.detections.is_empty() || run.false_alarms > 0) {
        let found: Vec<String> = run
            .detections
            .iter()
            .chain(&run.false_alarm_list)
            .map(|found| format!("{} at {:.1} s -> {}", found.fault, found.detected_s, found.action))
            .collect();
        let list = found.join(", ");
        _ = writeln!(
            text,
            "  seed {}: {list}; false alarms {}; ended {}",
            run.seed, run.false_alarms, run.ended
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::report::Run;

    fn told(run: Run) -> String {
        table(&[Group::of("off".to_owned(), vec![run])])
    }

    /// A single seed has no deviation, nor has a figure that a single one of several seeds has.
    #[test]
    fn a_deviation_is_told_of_several_values_alone() {
        let run = |quality_mean| Run { quality_mean, ..Run::default() };
        let one = told(run(Some(1.25)));
        assert!(one.contains("  1.250  ") && !one.contains("+-") && !one.contains("deviation"), "{one}");
        let two = table(&[Group::of("off".to_owned(), vec![run(Some(1.0)), run(Some(3.0))])]);
        assert!(two.contains("2.000 +- 1.414") && two.contains("; mean +- standard deviation"), "{two}");
        let lone = table(&[Group::of("off".to_owned(), vec![run(Some(1.0)), run(None)])]);
        assert!(lone.contains("1.000 (1 of 2)"), "{lone}");
    }

    #[test]
    fn a_filter_that_is_not_the_shipped_one_is_told() {
        let with = |filter| told(Run { filter, ..Run::default() });
        assert!(with("extended").contains(", filter extended, 1 seed(s)"), "{}", with("extended"));
        assert!(!with("square_root").contains("filter"));
    }

    #[test]
    fn the_advance_in_force_is_told_and_what_was_asked_for_beside_it() {
        let run = |advance: &str, advance_in_force| Run {
            advance: advance.to_owned(),
            advance_in_force,
            ..Run::default()
        };
        assert!(
            told(run("planned", "file")).contains("advance the file's own (asked for: planned), look-ahead")
        );
        assert!(
            told(run("planned", "material"))
                .contains("advance the material's constant (asked for: planned),")
        );
        assert!(told(run("planned", "planned")).contains("advance planned, look-ahead"));
        assert!(told(run("file", "file")).contains("advance the file's own, look-ahead"));
    }
}
