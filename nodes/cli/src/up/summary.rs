//! What a print over DDS came to.

use super::ended::Ended;
use super::recipes::Plan;
use super::watch::Watch;
use super::words::text;
use printer_sim::score::Integrals;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Figures of one print; simulated ones, of the plant's own truth.
#[derive(Debug, Clone, Serialize)]
pub struct Print {
    /// File name.
    pub gcode: String,
    /// Material.
    pub material: String,
    /// Scenario.
    pub scenario: String,
    /// Control level.
    pub control: String,
    /// Host profile.
    pub host: String,
    /// Seed.
    pub seed: u64,
    /// How it ended.
    pub ended: Ended,
    /// Why, as the supervisor or `fdm` said.
    pub cause: Option<String>,
    /// Simulated time `[s]`.
    pub print_time_s: f64,
    /// Wall time `[s]`.
    pub wall_time_s: f64,
    /// Mean of Q.
    pub quality_mean: Option<f64>,
    /// RMS of the relative width error.
    pub width_rms_rel: Option<f64>,
    /// |delivered / commanded - 1|.
    pub feed_error_rel: Option<f64>,
    /// The same from 2 s after the first onset on.
    pub feed_error_after_2s_rel: Option<f64>,
    /// Process ids by node at the start.
    pub processes: BTreeMap<String, u32>,
    /// Processes that ended before they were asked to, or fell silent.
    pub happenings: Vec<String>,
    /// Modes of the supervisor: simulated time and text.
    pub modes: Vec<(f64, String)>,
    /// Folder of the bag.
    pub bag: String,
    /// Why something is missing in it.
    pub bag_not_whole: Option<String>,
    /// Folder of the nodes' messages.
    pub logs: String,
}

impl Print {
    /// Gathers the figures after the end.
    #[must_use]
    pub fn new(plan: &Plan, pids: &[(&'static str, u32)], watch: &Watch, ended: Ended) -> Self {
        let whole = watch.marks.last.since(&Integrals::default());
        let settled = watch.marks.settled.and_then(|at| watch.marks.last.since(&at));
        let name = |path: &std::path::Path| {
            path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
        };
        Self {
            gcode: name(&plan.gcode),
            material: plan.material.clone(),
            scenario: plan.scenario.clone(),
            control: plan.control.clone(),
            host: plan.host.clone(),
            seed: plan.seed,
            ended,
            cause: watch.cause(ended),
            print_time_s: watch.marks.last_s,
            wall_time_s: watch.elapsed_s(),
            quality_mean: whole.map(|figures| figures.quality_mean),
            width_rms_rel: whole.map(|figures| figures.width_rms_rel),
            feed_error_rel: whole.and_then(|figures| figures.feed_error_rel),
            feed_error_after_2s_rel: settled.and_then(|figures| figures.feed_error_rel),
            processes: pids.iter().map(|(name, pid)| ((*name).to_owned(), *pid)).collect(),
            happenings: watch.happenings.iter().map(text).collect(),
            modes: watch.modes.clone(),
            bag: plan.bag.display().to_string(),
            bag_not_whole: watch.gap().map(str::to_owned),
            logs: plan.logs().display().to_string(),
        }
    }
}

/// A short table, one row a print.
#[must_use]
pub fn table(prints: &[Print]) -> String {
    let mut text = String::new();
    let Some(first) = prints.first() else { return text };
    // Writing to a string cannot fail.
    _ = writeln!(
        text,
        "Simulated print over DDS: {} in {}, scenario {}, host {}, seed {}",
        first.gcode, first.material, first.scenario, first.host, first.seed
    );
    _ = writeln!(
        text,
        "{:<9} {:>8} {:>14} {:>19} {:>13} {:>8} {:>8}  bag",
        "control", "ended", "feed error", "2 s after the fault", "width RMS", "Q", "wall s"
    );
    let percent =
        |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{:.3} %", value * 100.0));
    for print in prints {
        _ = writeln!(
            text,
            "{:<9} {:>8} {:>14} {:>19} {:>13} {:>8} {:>8.0}  {}",
            print.control,
            format!("{:?}", print.ended).to_lowercase(),
            percent(print.feed_error_rel),
            percent(print.feed_error_after_2s_rel),
            percent(print.width_rms_rel),
            print.quality_mean.map_or("-".to_owned(), |quality| format!("{quality:.2}")),
            print.wall_time_s,
            print.bag
        );
    }
    for print in prints {
        if let Some(why) = &print.bag_not_whole {
            _ = writeln!(
                text,
                "{} is not whole: {why}; `fdm recover {}` mends what can be",
                print.bag, print.bag
            );
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bag_that_is_not_whole_is_told_below_the_table() {
        let print = |gap: Option<&str>| Print {
            gcode: "cube.gcode".to_owned(),
            material: "PLA".to_owned(),
            scenario: "nominal".to_owned(),
            control: "mpc".to_owned(),
            host: "native".to_owned(),
            seed: 1,
            ended: Ended::Done,
            cause: None,
            print_time_s: 1.0,
            wall_time_s: 1.0,
            quality_mean: None,
            width_rms_rel: None,
            feed_error_rel: None,
            feed_error_after_2s_rel: None,
            processes: BTreeMap::new(),
            happenings: Vec::new(),
            modes: Vec::new(),
            bag: "bags/one".to_owned(),
            bag_not_whole: gap.map(str::to_owned),
            logs: "bags/one_logs".to_owned(),
        };
        assert!(!table(&[print(None)]).contains("not whole"));
        let told = table(&[print(None), print(Some("the disk is nearly full"))]);
        assert!(
            told.ends_with(
                "\nbags/one is not whole: the disk is nearly full; `fdm recover bags/one` mends what can be\n"
            ),
            "{told}"
        );
    }
}
