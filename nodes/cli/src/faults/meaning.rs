//! What the named figures of a trial are, for people.

use super::figures::Figures;
use std::collections::BTreeSet;

/// Name and meaning of each; the names of the catalogue's bounds among them.
const MEANINGS: [(&str, &str); 26] = [
    ("acknowledged_s", "until `fdm acknowledge` had ended the latched mode and permits came again"),
    ("acted_s", "from the fault until the supervisor left its mode, for degraded or worse"),
    ("answer", "time until a service call was answered"),
    ("answered_hz", "service calls answered a second"),
    ("back_s", "from the fault until the process was started again, or continued"),
    (
        "bare timer late",
        "the same of a thread in `fdm` that does nothing but wake every 20 ms: the machine's share",
    ),
    ("beats_s", "from the fault until the first heartbeat of its next run, or of the one that goes on"),
    ("died", "1 where the process ended for lack of memory, 0 where it went on"),
    ("ended", "processes that ended on the way until every node worked"),
    (
        "excused_runs",
        "runs that missed a bound and told so, on a machine that was busy elsewhere or wakes nobody in time",
    ),
    ("foreign_cores", "processors that were busy with something else"),
    ("grown_mib", "address space that a node took beyond its limit of memory"),
    ("growth_mib", "memory that the largest of the nodes took more"),
    ("neutral_s", "from the fault until the printer was at the slicer's values"),
    ("not_answered", "service calls without an answer"),
    ("paused_s", "from the fault until the supervisor had paused the print"),
    (
        "permit late",
        "how much longer than usual the supervisor took from tick to tick, in whole ms, rounded up",
    ),
    ("permit that stops", "time from the call until the permit that demands the stop"),
    ("printer_state_gap_s", "longest silence of printer/state"),
    ("rss_all_mib", "memory of all nodes together"),
    ("rss_slope_mib_h", "growth of the node that grows fastest"),
    ("safe_off_s", "from the fault until the supervisor had switched the heaters off for good"),
    ("sent_hz", "messages of the flood that were sent a second"),
    ("told_s", "from the fault until `fdm` told that the process ended or hangs"),
    ("whole", "time from the start until every node works"),
    ("whole_s", "from the end of the fault until every node works again"),
];

/// One line for each named figure that occurs.
#[must_use]
pub fn of(figures: &Figures) -> Vec<String> {
    let trials = figures.faults.iter().flat_map(|fault| &fault.trials);
    let names: BTreeSet<&str> = trials
        .flat_map(|trial| {
            let measures = trial.measures.iter().map(|measure| measure.name.as_str());
            trial.figures.keys().map(String::as_str).chain(measures)
        })
        .collect();
    let meaning = |name: &str| MEANINGS.iter().find(|(known, _)| *known == name).map(|(_, meaning)| meaning);
    names.into_iter().filter_map(|name| Some(format!("{name}: {}", meaning(name)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// Every name that a process trial inserts has a meaning.
    #[test]
    fn no_named_figure_is_left_unexplained() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/faults/process");
        let mut found = 0;
        for entry in std::fs::read_dir(folder).unwrap() {
            let text = std::fs::read_to_string(entry.unwrap().path()).unwrap();
            // Inserted by its name, or a pair of a list: the unit tells a figure from other pairs.
            for mark in ["figures.insert(\"", "measures.insert(\"", "(\""] {
                for name in text.split(mark).skip(1).filter_map(|rest| rest.split('"').next()) {
                    let units = ["_s", "_hz", "_mib", "_mib_h", "_cores"];
                    if mark == "(\"" && !units.iter().any(|unit| name.ends_with(unit)) {
                        continue;
                    }
                    assert!(MEANINGS.iter().any(|(known, _)| *known == name), "{name}");
                    found += 1;
                }
            }
        }
        assert!(found >= MEANINGS.len(), "{found} names found in the sources");
    }
}
