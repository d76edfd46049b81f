//! The figures of `fdm sim` for people.

use super::report::{AdvanceFigures, Group, Run};
use std::fmt::Write;

/// One row a control level, mean and spread over the seeds.
#[must_use]
pub fn table(groups: &[Group]) -> String {
    let mut text = String::new();
    let Some(run) = groups.first().and_then(|group| group.runs.first()) else { return text };
    // Writing to a string cannot fail.
    _ = writeln!(
        text,
        "Simulated: {} in {}, scenario {}, host {}, {} seed(s); mean +- standard deviation",
        run.gcode,
        run.material,
        run.scenario,
        run.host,
        groups.first().map_or(0, |group| group.seeds),
    );
    _ = writeln!(
        text,
        "{:<9} {:>15} {:>15} {:>15} {:>15} {:>13} {:>7} {:>9}",
        "control", "Q", "width RMS %", "feed error %", "after 2 s %", "back for 5 s", "NEES", "x real"
    );
    for group in groups {
        let cell = |name: &str, scale: f64| match (group.mean.get(name), group.spread.get(name)) {
            (Some(mean), Some(spread)) => format!("{:.3} +- {:.3}", mean * scale, spread * scale),
            _ => "-".to_owned(),
        };
        let plain = |name: &str| group.mean.get(name).map_or("-".to_owned(), |mean| format!("{mean:.1}"));
        _ = writeln!(
            text,
            "{:<9} {:>15} {:>15} {:>15} {:>15} {:>13} {:>7} {:>9}",
            group.control,
            cell("quality_mean", 1.0),
            cell("width_rms_rel", 100.0),
            cell("feed_error_rel", 100.0),
            cell("feed_error_after_2s_rel", 100.0),
            cell("recovery_5s_s", 1.0),
            plain("nees_median"),
            plain("realtime_factor"),
        );
    }
    for group in groups {
        _ = writeln!(text, "{:<9} NIS {}", group.control, nis(&group.runs));
        advance(&mut text, group);
        seen(&mut text, group);
        asked_for(&mut text, group);
        noticed(&mut text, group);
    }
    text
}

/// Pressure advance and what it is for.
fn advance(text: &mut String, group: &Group) {
    let Some(run) = group.runs.first() else { return };
    let mean = |name: &str| group.mean.get(name).copied();
    let buffer = run.buffer.map_or_else(|| "the printer's".to_owned(), |moves| format!("{moves} moves"));
    _ = writeln!(
        text,
        "{:<9} advance {}, look-ahead {buffer}: width RMS at corners {}, print time {}",
        group.control,
        run.advance,
        mean("corner_width_rms_rel").map_or_else(|| "-".to_owned(), |rms| format!("{:.2} %", 1e2 * rms)),
        mean("print_time_s").map_or_else(|| "-".to_owned(), |time_s| format!("{time_s:.1} s")),
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

/// Mean NIS by channel over the runs.
fn nis(runs: &[Run]) -> String {
    let Some(first) = runs.first() else { return String::new() };
    let channel = |name: &str| {
        let values: Vec<f64> =
            runs.iter().filter_map(|run| run.nis_mean.get(name).copied().flatten()).collect();
        #[allow(clippy::cast_precision_loss, reason = "seeds are few")]
        let count = values.len() as f64;
        if values.is_empty() { "-".to_owned() } else { format!("{:.2}", values.iter().sum::<f64>() / count) }
    };
    let parts: Vec<String> = first.nis_mean.keys().map(|name| format!("{name} {}", channel(name))).collect();
    parts.join(", ")
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
