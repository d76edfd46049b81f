//! L3: what the systemd units say of memory. A drop-in has the last word over the template, as systemd has it.

use super::{NODES, root};
use std::collections::BTreeMap;

/// The simulated printer is nobody's service.
const NO_SERVICE: &str = "printer_sim";

/// Every setting of `[Service]` for a node, the last one that is written wins.
fn settings(node: &str) -> BTreeMap<String, String> {
    let units = root().join("launch_scripts/systemd");
    let mut texts = vec![std::fs::read_to_string(units.join("fdm_loop@.service")).unwrap()];
    let mut dropins: Vec<_> = std::fs::read_dir(units.join(format!("fdm_loop@{node}.service.d")))
        .into_iter()
        .flatten()
        .map(|file| file.unwrap().path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "conf"))
        .collect();
    dropins.sort();
    texts.extend(dropins.iter().map(|path| std::fs::read_to_string(path).unwrap()));
    let mut settings = BTreeMap::new();
    for text in texts {
        let mut section = "";
        for line in text.lines().map(str::trim) {
            match line.split_once('=') {
                _ if line.starts_with('[') => section = line,
                Some((key, value)) if section == "[Service]" && !key.starts_with('#') => {
                    settings.insert(key.to_owned(), value.to_owned());
                }
                _ => {}
            }
        }
    }
    settings
}

fn services() -> impl Iterator<Item = &'static str> {
    NODES.into_iter().filter(|node| *node != NO_SERVICE)
}

/// Where the memory of the machine runs out, a higher number is killed first (`proc_pid_oom_score_adj(5)`).
fn score(node: &str) -> i32 {
    let score: i32 = settings(node)["OOMScoreAdjust"].parse().unwrap();
    assert!((-1000..=1000).contains(&score), "{node}: {score}");
    score
}

/// Every node has a bound of its own, in bytes with a unit, and no way around it over the swap.
#[test]
fn every_unit_bounds_its_memory() {
    for node in services() {
        let settings = settings(node);
        let most = &settings["MemoryMax"];
        let mib = |text: &str| match text.split_at(text.len() - 1) {
            (number, "M") => number.parse::<u64>().ok(),
            (number, "G") => number.parse::<u64>().ok().map(|gib| gib << 10),
            _ => None,
        };
        let most_mib = mib(most).unwrap_or_else(|| panic!("{node}: MemoryMax={most}"));
        // What it needs is 40 MB, and all eleven together have to leave something of a small machine.
        assert!((64..=1024).contains(&most_mib), "{node}: MemoryMax={most}");
        assert_eq!(settings["MemorySwapMax"], "0", "{node}");
        // Its own bound, at which it ends in order, comes before that of the system.
        if let Some(own) = settings["Environment"].strip_prefix("FDM_MEMORY_MIB=") {
            assert!(own.parse::<u64>().unwrap() < most_mib, "{node}: FDM_MEMORY_MIB={own}, MemoryMax={most}");
        }
    }
}

/// The order of the design: recorder, vision, controller, what else measures and reckons, and the supervisor last.
#[test]
fn the_recorder_is_killed_first_and_the_supervisor_last() {
    const ORDER: [&[&str]; 3] = [&["bag_recorder"], &["defect_classifier", "camera"], &["mpc_controller"]];
    const LAST: [&str; 2] = ["printer_bridge", "safety_supervisor"];
    let named: Vec<&str> = ORDER.concat().into_iter().chain(LAST).collect();
    let others: Vec<&str> = services().filter(|node| !named.contains(node)).collect();
    assert!(others.len() >= 5, "{others:?}");
    let groups: Vec<&[&str]> = ORDER.into_iter().chain([&others[..], &LAST[..1], &LAST[1..]]).collect();
    for pair in groups.windows(2) {
        for (first, later) in pair[0].iter().flat_map(|first| pair[1].iter().map(move |later| (first, later)))
        {
            assert!(score(first) > score(later), "{later} is killed before {first}");
        }
    }
    assert_eq!(score("safety_supervisor"), -900);
}

/// A drop-in for a node that does not exist would bound nothing.
#[test]
fn every_drop_in_is_of_a_node() {
    for entry in std::fs::read_dir(root().join("launch_scripts/systemd")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if let Some(node) = name.strip_prefix("fdm_loop@").and_then(|name| name.strip_suffix(".service.d")) {
            assert!(services().any(|known| known == node), "{name}");
        }
    }
}
