//! What the estimator states of itself, beside what is so.

use crate::sim::consistency::{STATE_NAMES, TRUE_MEDIAN};
use crate::sim::group::Group;
use std::fmt::Write;
use std::ops::RangeInclusive;

/// Least share of the time that a stated 95 % interval has to hold for `[-]`: below it is marked, as the NEES of six states
/// hides a single one's.
const HOLDS: f64 = 0.9;

/// Mean NIS that is asked for where no sensor lies (model book 1.5): with less the filter is too cautious, with more too sure `[-]`.
const CONSISTENT: RangeInclusive<f64> = 0.3..=1.5;

/// Mean NIS over the runs, of each channel that measured something.
pub(super) fn nis(group: &Group) -> String {
    let Some(first) = group.runs.first() else { return String::new() };
    let channel = |name: &str| {
        let values: Vec<f64> =
            group.runs.iter().filter_map(|run| run.nis_mean.get(name).copied().flatten()).collect();
        #[allow(clippy::cast_precision_loss, reason = "seeds are few")]
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let mark = if CONSISTENT.contains(&mean) { "" } else { " OUTSIDE" };
        (!values.is_empty()).then(|| format!("{name} {mean:.2}{mark}"))
    };
    let parts: Vec<String> = first.nis_mean.keys().filter_map(|name| channel(name)).collect();
    parts.join(", ")
}

/// How often the stated 95 % intervals held, over the runs in which a road was laid.
pub(super) fn covered(text: &mut String, group: &Group) {
    let shares: Vec<_> =
        group.runs.iter().filter_map(|run| Some((run.coverage_states, run.coverage?))).collect();
    let Some((names, _)) = shares.first() else { return };
    #[allow(clippy::cast_precision_loss, reason = "seeds are few")]
    let count = shares.len() as f64;
    let mean = |state: usize| shares.iter().map(|(_, coverage)| coverage[state]).sum::<f64>() / count;
    let parts: Vec<String> = names.iter().enumerate().map(|(state, name)| told(name, mean(state))).collect();
    let list = parts.join(", ");
    let told = told_of(group).unwrap_or_default();
    _ = writeln!(
        text,
        "{:<9} within the stated 95 % interval: {list}; NEES of a true one {TRUE_MEDIAN}{told}",
        group.control
    );
}

/// NEES of what sensors tell of, where that is less than all and the same in all runs: its mean over them, and the band that holds 95 %.
fn told_of(group: &Group) -> Option<String> {
    let first = group.runs.iter().find_map(|run| run.nees_told.as_ref())?;
    let told: Vec<_> = group.runs.iter().filter_map(|run| run.nees_told.as_ref()).collect();
    if first.states.len() == STATE_NAMES.len() || told.iter().any(|told| told.states != first.states) {
        return None;
    }
    #[allow(clippy::cast_precision_loss, reason = "seeds are few")]
    let mean = told.iter().map(|told| told.nees_median).sum::<f64>() / told.len() as f64;
    let [low, high] = first.band;
    let mark = if (low..=high).contains(&mean) { "" } else { " OUTSIDE" };
    let (states, truth) = (first.states.join(", "), first.true_median);
    Some(format!(
        "; of {states} alone, of which sensors tell, {mean:.2}, of a true one {truth:.2}, 95 % of its moments {low:.2} to {high:.2}{mark}"
    ))
}

fn told(name: &str, share: f64) -> String {
    let mark = if share < HOLDS { " LOW" } else { "" };
    format!("{name} {:.1} %{mark}", 1e2 * share)
}

/// What no sensor told of, where that is more than the nozzle's temperature, which few printers show.
pub(super) fn blind(text: &mut String, group: &Group) {
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
    if run.states_not_observed.contains(&"slip") && group.control != "off" {
        let worse = if matches!(run.advance_in_force, "planned" | "predicted") {
            ", and a planned advance makes it worse: `--advance material` or `--control off` does less harm"
        } else {
            ""
        };
        _ = writeln!(text, "{:<9} WARNING: what slips stays so{worse}, see nodes/README.md", group.control);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::consistency::Told;
    use crate::sim::report::Run;
    use crate::sim::text::table;

    fn one(run: Run) -> String {
        table(&[Group::of("off".to_owned(), vec![Run { filter: "square_root", ..run }])])
    }

    /// The mean is marked, not a single run's.
    #[test]
    fn a_channel_that_is_not_consistent_is_marked() {
        let run = |encoder: f64, width: f64| Run {
            nis_mean: [("encoder", Some(encoder)), ("thermistor", None), ("width", Some(width))].into(),
            ..Run::default()
        };
        let of = |runs| nis(&Group::of("mpc".to_owned(), runs));
        assert_eq!(of(vec![run(1.6, 0.3), run(1.2, 0.3)]), "encoder 1.40, width 0.30");
        assert_eq!(of(vec![run(1.6, 0.1), run(1.8, 0.3)]), "encoder 1.70 OUTSIDE, width 0.20 OUTSIDE");
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
        assert!(told.contains("slip 37.5 % LOW, gain 100.0 %;"), "{told}");
        assert!(!table(&[Group::of("mpc".to_owned(), vec![Run::default()])]).contains("interval"));
    }

    #[test]
    fn the_nees_of_what_is_told_of_stands_beside_its_band() {
        let run = |nees_median: f64, states: &[&'static str]| Run {
            coverage: Some([1.0; 6]),
            coverage_states: STATE_NAMES,
            nees_told: Some(Told {
                states: states.to_vec(),
                nees_median,
                true_median: 2.366,
                band: [0.216, 9.35],
            }),
            ..Run::default()
        };
        let three = &STATE_NAMES[..3];
        let told = |nees: f64| table(&[Group::of("mpc".to_owned(), vec![run(nees, three), run(1.0, three)])]);
        let of = "; of block, nozzle, thermistor alone, of which sensors tell, 2.00, of a true one 2.37, 95 % of its";
        assert!(told(3.0).contains(&format!("{of} moments 0.22 to 9.35\n")), "{}", told(3.0));
        let outside = "tell, 14.00, of a true one 2.37, 95 % of its moments 0.22 to 9.35 OUTSIDE";
        assert!(told(27.0).contains(outside), "{}", told(27.0));
        let mixed = table(&[Group::of("mpc".to_owned(), vec![run(3.0, three), run(1.0, &STATE_NAMES[..2])])]);
        assert!(!mixed.contains("sensors tell,"), "one band does not fit both: {mixed}");
        assert!(!one(run(3.0, &STATE_NAMES)).contains("sensors tell,"), "all of them: the NEES of the table");
    }

    /// A share of 90 % holds.
    #[test]
    fn an_interval_that_held_for_less_than_nine_tenths_is_marked() {
        assert_eq!([0.9, 0.899].map(|share| told("flow", share)), ["flow 90.0 %", "flow 89.9 % LOW"]);
    }

    #[test]
    fn sensors_that_are_not_fitted_are_told_and_what_nothing_shows() {
        let without = vec!["encoder".to_owned()];
        let blind = one(Run {
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
        assert!(!blind.contains("WARNING"), "nothing is planned: {blind}");
        let nothing = Run { states_not_observed: vec!["nozzle", "slip"], ..Run::default() };
        let closed = table(&[Group::of("mpc".to_owned(), vec![nothing])]);
        assert!(closed.contains("WARNING: what slips stays so"), "{closed}");
        let tip = one(Run { with: vec!["nozzle".to_owned()], ..Run::default() });
        assert!(tip.contains(", with nozzle, 1 seed(s)"), "{tip}");
        let whole = one(Run { states_not_observed: vec!["nozzle"], ..Run::default() });
        assert!(!whole.contains("no sensor") && !whole.contains("without"), "{whole}");
    }
}
