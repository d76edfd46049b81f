//! The figures of `fdm sim` for people.

mod corrected;

use super::consistency::TRUE_MEDIAN;
use super::group::Group;
use super::report::{AdvanceFigures, Run};
use corrected::corrected;
use std::fmt::Write;

const COLUMNS: usize = 9;
const HEADINGS: [&str; COLUMNS] =
    ["control", "done", "Q", "width RMS %", "feed error %", "after 2 s %", "back for 5 s", "NEES", "x real"];

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
    // Writing to a string cannot fail.
    _ = writeln!(
        text,
        "Simulated: {} in {}, scenario {}, host {}{sensors}, {} seed(s); mean +- standard deviation, (n of {}) where fewer have it",
        run.gcode, run.material, run.scenario, run.host, seeds, seeds,
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
        _ = writeln!(text, "{:<9} NIS {}", group.control, nis(&group.runs));
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
    let cell = |name: &str, scale: f64| match (group.mean.get(name), group.spread.get(name)) {
        (Some(mean), Some(spread)) => {
            format!("{:.3} +- {:.3}{}", mean * scale, spread * scale, group.share(name))
        }
        _ => "-".to_owned(),
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

/// Mean NIS over the runs, of each channel that measured something.
fn nis(runs: &[Run]) -> String {
    let Some(first) = runs.first() else { return String::new() };
    let channel = |name: &str| {
        let values: Vec<f64> =
            runs.iter().filter_map(|run| run.nis_mean.get(name).copied().flatten()).collect();
        #[allow(clippy::cast_precision_loss, reason = "seeds are few")]
        let count = values.len() as f64;
        (!values.is_empty()).then(|| format!("{name} {:.2}", values.iter().sum::<f64>() / count))
    };
    let parts: Vec<String> = first.nis_mean.keys().filter_map(|name| channel(name)).collect();
    parts.join(", ")
}

/// How often the stated 95 % intervals held, over the runs in which a road was laid.
fn covered(text: &mut String, group: &Group) {
    let shares: Vec<_> =
        group.runs.iter().filter_map(|run| Some((run.coverage_states, run.coverage?))).collect();
    let Some((names, _)) = shares.first() else { return };
    #[allow(clippy::cast_precision_loss, reason = "seeds are few")]
    let count = shares.len() as f64;
    let mean = |state: usize| shares.iter().map(|(_, coverage)| coverage[state]).sum::<f64>() / count;
    let parts: Vec<String> =
        names.iter().enumerate().map(|(state, name)| format!("{name} {:.1} %", 1e2 * mean(state))).collect();
    let list = parts.join(", ");
    _ = writeln!(
        text,
        "{:<9} within the stated 95 % interval: {list}; NEES of a true one {TRUE_MEDIAN}",
        group.control
    );
}

/// What no sensor told of, where that is more than the nozzle's temperature, which few printers show.
fn blind(text: &mut String, group: &Group) {
    let Some(run) =
        group.runs.iter().find(|run| run.states_not_observed.iter().any(|name| *name != "nozzle"))
    else {
        return;
    };
    let held = if run.states_held.is_empty() {
        String::new()
    } else {
        format!("; held at what is believed: {}", run.states_held.join(", "))
    };
    let list = run.states_not_observed.join(", ");
    _ = writeln!(text, "{:<9} no sensor tells of: {list}{held}", group.control);
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
    use crate::sim::consistency::STATE_NAMES;

    fn told(run: Run) -> String {
        table(&[Group::of("off".to_owned(), vec![run])])
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

    /// Over the two runs that laid something.
    #[test]
    fn the_coverage_is_told_state_by_state() {
        let run = |share: f64| Run {
            coverage: Some(std::array::from_fn(|state| if state == 4 { share } else { 1.0 })),
            coverage_states: STATE_NAMES,
            ..Run::default()
        };
        let told = table(&[Group::of("mpc".to_owned(), vec![run(0.5), run(0.25), Run::default()])]);
        assert!(told.contains("within the stated 95 % interval: block 100.0 %, "), "{told}");
        assert!(told.contains("slip 37.5 %, gain 100.0 %"), "{told}");
        assert!(!table(&[Group::of("mpc".to_owned(), vec![Run::default()])]).contains("interval"));
    }

    #[test]
    fn sensors_that_are_not_fitted_are_told_and_what_nothing_shows() {
        let without = vec!["encoder".to_owned()];
        let blind = told(Run {
            without,
            states_not_observed: vec!["nozzle", "flow", "slip"],
            states_held: vec!["slip"],
            ..Run::default()
        });
        assert!(blind.contains(", without encoder, 1 seed(s)"), "{blind}");
        assert!(
            blind.contains("no sensor tells of: nozzle, flow, slip; held at what is believed: slip"),
            "{blind}"
        );
        let tip = told(Run { with: vec!["nozzle".to_owned()], ..Run::default() });
        assert!(tip.contains(", with nozzle, 1 seed(s)"), "{tip}");
        let whole = told(Run { states_not_observed: vec!["nozzle"], ..Run::default() });
        assert!(!whole.contains("no sensor") && !whole.contains("without"), "{whole}");
    }
}
