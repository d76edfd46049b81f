//! What came of a print, in a line: whether it was printed, and why not.

use super::View;
use super::summary::host;
use super::words::{clock, counted, percent};
use crate::report::decode::short;
use crate::report::record::ending::{HeldUp, works};
use crate::up::words::mode_name;
use fdm_loop_msgs::{PrinterState, SafetyState};

/// Width error from which on a print is no good one, root mean square: twice what the loop leaves where nothing is wrong `[-]`.
const MISSED_REL: f64 = 0.05;

/// Class, verdict and its reason.
pub(super) fn verdict(view: &View) -> (&'static str, &'static str, String) {
    let print = &view.record.print;
    let Some(state) = &print.last else {
        let (wall, unread) = (view.record.wall.layers(), view.record.tally.unreadable("/printer/state"));
        return match wall {
            Some(layers) => {
                ("info", "A wall of metal wire,", format!("{} of it in the bag.", counted(layers, "layer")))
            }
            None if unread => {
                ("warn", "Unknown.", "None of the printer's states could be decoded.".to_owned())
            }
            None => ("warn", "Unknown.", "The bag does not say what the printer did.".to_owned()),
        };
    };
    if let Some(done_s) = print.ending.done() {
        return printed(view, done_s);
    }
    let because = because(view);
    let far = percent(state.progress, 0);
    // What a printer does not heed has stopped nothing; a supervisor at its stop tells of it in any case.
    let latched = print.safety.as_ref().is_some_and(|safety| safety.mode >= SafetyState::MODE_SAFE_OFF);
    match (state.phase, print.ending.stop().filter(|_| latched || !works(state.phase))) {
        (_, Some(stop)) => ("error", stop.headline(), format!("at {far}.{because}")),
        (PrinterState::PHASE_FAILED, _) => ("error", "Failed", format!("at {far}.{because}")),
        (PrinterState::PHASE_PAUSED, _) => {
            ("error", "Paused", format!("at {far}, and not gone on.{because}"))
        }
        _ => ("info", "Not ended", format!("where the bag ends: {far} of the filament.{because}")),
    }
}

/// Verdict of a print whose file has come to its end; what was stopped behind that is told last.
fn printed(view: &View, done_s: f64) -> (&'static str, &'static str, String) {
    const PRINTED: &str = "Printed to its end";
    let (events, told) = (&view.record.events, view.record.print.ending.told());
    let (counts, behind, wished) = match told.first() {
        None => (events.counts, String::new(), true),
        Some(first) => {
            let how = if first.at < done_s { "It went on past" } else { "Afterwards" };
            let wished = told.iter().all(|held_up| held_up.is_wished() && held_up.at >= done_s);
            (events.before_the_end, format!(" {how} {}.", listed(&told)), wished)
        }
    };
    let [_, warnings, errors] = counts;
    let seen = |count| format!("with {count}: see the events.{behind}");
    let missed = missed(view.record.truth.width_rms_rel());
    let missed = missed.map(|missed| format!("{missed}{}", loop_of(view)));
    match (warnings, errors) {
        (_, 1..) => ("error", PRINTED, seen(counted(errors, "error"))),
        _ if !wished => ("error", PRINTED, format!("without an error.{behind}")),
        (1.., _) => {
            let missed = missed.map_or(String::new(), |missed| format!(" It is simulated: {missed}."));
            ("warn", PRINTED, seen(counted(warnings, "warning")) + &missed)
        }
        _ => match missed {
            Some(missed) => ("warn", PRINTED, format!("without a warning, but simulated: {missed}.{behind}")),
            None => ("ok", PRINTED, format!("without a warning.{behind}")),
        },
    }
}

/// By how much the roads of a simulated print miss their width, where it is much: nobody warned of that.
fn missed(width_rms_rel: Option<f64>) -> Option<String> {
    let rms = width_rms_rel.filter(|rms| *rms > MISSED_REL)?;
    Some(format!("its roads miss their width by {} (RMS)", percent(rms, 1)))
}

/// What corrected, and behind which host.
fn loop_of(view: &View) -> String {
    let control = view.record.print.configured.get("control").map(|control| format!("control {control}"));
    let parts = control.into_iter().chain([host(view)]).filter(|part| !part.is_empty());
    parts.map(|part| format!(", {part}")).collect()
}

/// Why the print does not go on: what held it up, what ended it, and what came behind that.
fn because(view: &View) -> String {
    let print = &view.record.print;
    let told = print.ending.told();
    let last = print.safety.as_ref().map(|safety| short(&safety.cause, 200)).unwrap_or_default();
    match told.first() {
        Some(_) => format!(" {}", listed(&told)),
        None if last.is_empty() => String::new(),
        None => format!(" {last}"),
    }
}

/// Pauses and stops in words.
fn listed(told: &[&HeldUp]) -> String {
    let word = |held_up: &&HeldUp| {
        format!("{} ({} at {})", held_up.cause, mode_name(held_up.mode), clock(held_up.at))
    };
    told.iter().map(word).collect::<Vec<_>>().join(", then ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simulated_print_that_nobody_complained_of_is_not_called_good_by_that() {
        assert_eq!(missed(None), None, "beside a real printer nobody knows");
        assert_eq!(missed(Some(MISSED_REL)), None);
        assert!(missed(Some(MISSED_REL + 1e-6)).is_some());
        let told = missed(Some(0.1052)).unwrap();
        assert!(told.starts_with("its roads miss their width by 10.5 %"), "{told}");
    }
}
