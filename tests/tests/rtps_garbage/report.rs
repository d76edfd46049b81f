//! Limits of X1 and the table of what was measured.

use crate::storm::Storm;
use fdm_loop_msgs::SafetyState;
use std::fmt::Write;

/// The dead-man's time: no correction outlives its permit by more `[s]`.
const NEUTRAL_S: f64 = 0.25;
/// A look of the printer and two periods of `printer/state` `[s]`.
const OBSERVED_S: f64 = 0.05;
/// Permits that the printer heard and neither observer nor recorder did, in a middleware that drowns `[s]`.
const UNHEARD_S: f64 = 0.15;
/// All is whole again after the last datagram `[s]`: what the catalogue asks for, and what the long form of the tests holds.
const WHOLE_S: f64 = 5.0;
/// The same in the gate, where a machine of unknown load decides how long discovery takes: it is whole again by itself.
/// What it took is printed.
const WHOLE_AT_LAST_S: f64 = 60.0;
/// What a process may hold `[KiB]`: 256 MiB of data (`runtime::bounds`), its code and what it maps of files.
const RESIDENT_KIB: u64 = 320 * 1024;

/// `FDM_WHOLE_LIMIT_S` says which limit is held.
pub(crate) fn whole_limit_s() -> f64 {
    std::env::var("FDM_WHOLE_LIMIT_S").ok().and_then(|text| text.parse().ok()).unwrap_or(WHOLE_AT_LAST_S)
}

/// One row a kind.
pub(crate) fn table(storms: &[Storm]) -> String {
    let late = storms.iter().filter(|storm| storm.whole_s.is_none_or(|whole_s| whole_s > WHOLE_S)).count();
    let mut text = format!(
        "{:<14} {:>8} {:>7} {:>7} {:>6} {:>10} {:>9} {:>5} {:>9} {:>8}  deaths\n",
        "kind", "sent", "took s", "deaths", "whole", "oldest s", "gap s", "gaps", "RSS MiB", "tripped"
    );
    for storm in storms {
        let deaths: Vec<String> =
            storm.deaths.iter().map(|(node, count)| format!("{node} {count}")).collect();
        let (heaviest, peak) =
            storm.peaks.iter().max_by_key(|(_, kib)| **kib).map_or(("-", 0), |(name, kib)| (name, *kib));
        _ = writeln!(
            text,
            "{:<14} {:>8} {:>7.1} {:>7} {:>6} {:>10.3} {:>9.2} {:>5} {:>9} {:>8}  {} (largest: {heaviest})",
            storm.kind.name,
            storm.sent,
            storm.took_s,
            storm.deaths.values().sum::<u32>(),
            storm.whole_s.map_or("-".to_owned(), |whole_s| format!("{whole_s:.2}")),
            storm.judged.oldest_s,
            storm.judged.longest_gap_s,
            storm.judged.gaps,
            peak / 1024,
            storm.tripped.as_ref().map_or("-".to_owned(), |(mode, _)| mode.to_string()),
            deaths.join(", "),
        );
    }
    _ = writeln!(text, "{late} of {} whole later than the {WHOLE_S} s of X1", storms.len());
    text
}

/// What lies outside of the limits.
pub(crate) fn failures(storms: &[Storm]) -> Vec<String> {
    let mut failures = Vec::new();
    let limit_s = whole_limit_s();
    for storm in storms {
        let mut fails = |what: String| failures.push(format!("{}: {what}", storm.kind.name));
        if storm.whole_s.is_none_or(|whole_s| whole_s > limit_s) {
            fails(format!("whole after {:?} s, limit {limit_s} s: {}", storm.whole_s, storm.lacking));
        }
        if storm.judged.oldest_s > NEUTRAL_S + OBSERVED_S + UNHEARD_S {
            fails(format!("a correction {:.3} s after its permit", storm.judged.oldest_s));
        }
        if storm.judged.states < 20 || storm.judged.corrected == 0 {
            fails(format!("little was seen of the printer: {:?}", storm.judged));
        }
        if storm.sent < u64::from(storm.kind.count) {
            fails(format!("{} of {} datagrams sent", storm.sent, storm.kind.count));
        }
        if storm.ports < crate::storm::NODES.len() {
            fails(format!("sent to {} ports alone", storm.ports));
        }
        if let Some((mode, cause)) = switched_off(storm) {
            fails(format!("mode {mode} ({cause}): nothing may be switched off"));
        }
        let died = !storm.deaths.is_empty() || storm.tripped.is_some();
        if died && !storm.kind.deadly {
            fails(format!("ended {:?}, mode {:?}: this kind may do neither", storm.deaths, storm.tripped));
        }
        for (node, kib) in storm.peaks.iter().filter(|(_, kib)| **kib > RESIDENT_KIB) {
            fails(format!("{node} took {} MiB", kib / 1024));
        }
    }
    failures.extend(spared(storms));
    failures
}

/// The mode and its cause where heaters or mains were switched off. In the gate a machine that takes longer than X1 allows until
/// all is whole may also be without a temperature for the 3 s of S7.
fn switched_off(storm: &Storm) -> Option<&(u8, String)> {
    let (mode, cause) = storm.tripped.as_ref()?;
    let slow = whole_limit_s() > WHOLE_S && storm.whole_s.is_none_or(|whole_s| whole_s > WHOLE_S);
    let excused = slow && *mode == SafetyState::MODE_SAFE_OFF && cause.starts_with("S7");
    storm.tripped.as_ref().filter(|(mode, _)| *mode >= SafetyState::MODE_SAFE_OFF && !excused)
}

/// What ends a supervisor leaves the printer without permits: without a single gap nothing is shown of its dead-man. One
/// kind that is looked at alone may leave none.
fn spared(storms: &[Storm]) -> Option<String> {
    let mut deadly = storms.iter().filter(|storm| storm.kind.deadly);
    let spared = deadly.all(|storm| storm.judged.gaps == 0) && std::env::var_os(crate::ONLY).is_none();
    spared
        .then(|| "the deadly kinds left no gap between permits: the dead-man was never asked for".to_owned())
}
