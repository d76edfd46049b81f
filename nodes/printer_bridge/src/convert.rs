//! Between the brain's types and messages.

use crate::event::{Refusals, Report};
use crate::note::{Note, Sensor, Severity};
use fdm_loop_msgs::{Header, PrintEvent, TemperatureReport};
use models::status::JobPhase;
use models::units::Seconds;
use runtime::Reason;

/// A report as it is. A sensor that the firmware does not name is not a number: the thermistor node counts it.
pub(crate) fn temperatures(report: &Report) -> TemperatureReport {
    TemperatureReport {
        header: Header::at(report.stamp.0),
        hotend_degc: report.hotend.map_or(f64::NAN, |temp| temp.0),
        bed_degc: report.bed.map_or(f64::NAN, |temp| temp.0),
        // no firmware names a sensor in the nozzle itself
        nozzle_degc: f64::NAN,
    }
}

/// A line of the print's log.
pub(crate) fn event(now: Seconds, who: &str, note: &Note) -> PrintEvent {
    let (before, after) = match note {
        Note::Job { before, after } => (job_name(*before).to_owned(), job_name(*after).to_owned()),
        _ => Default::default(),
    };
    PrintEvent {
        header: Header::at(now.0),
        severity: match note.severity() {
            Severity::Info => PrintEvent::SEVERITY_INFO,
            Severity::Warn => PrintEvent::SEVERITY_WARN,
            Severity::Error => PrintEvent::SEVERITY_ERROR,
        },
        who: who.to_owned(),
        what: what(note).to_owned(),
        why: why(note),
        before,
        after,
    }
}

fn what(note: &Note) -> &'static str {
    match note {
        Note::Connected => "link_connected",
        Note::Lost { .. } => "link_lost",
        Note::Stale { .. } => "link_silent",
        Note::Fresh => "link_alive",
        Note::Found(_) => "firmware_found",
        Note::SensorMissing(_) => "sensor_missing",
        Note::Started => "firmware_started",
        Note::Halted { .. } => "firmware_halted",
        Note::FirmwareError { .. } => "firmware_error",
        Note::Resend => "resend_demanded",
        Note::Job { .. } => "job_changed",
        Note::OutOfFilament => "out_of_filament",
    }
}

fn why(note: &Note) -> String {
    match note {
        Note::Connected => "the serial line is open".into(),
        Note::Lost { reason } => printable(reason),
        Note::Stale { age_s } => format!("no line for {age_s:.1} s: printer/state is not sent any more"),
        Note::Fresh => "lines arrive".into(),
        Note::Found(firmware) => {
            let abilities: Vec<&str> = firmware.abilities().collect();
            let protection = if firmware.protection_is_off() {
                "; THERMAL PROTECTION IS OFF: switch it on in the firmware"
            } else {
                ""
            };
            let reports =
                if firmware.reports_temperatures() { "" } else { "; temperatures have to be asked for" };
            let stop = if firmware.has_emergency_parser() { "" } else { "; M112 waits while it is busy" };
            let name = firmware.name().unwrap_or("without a name");
            printable(&format!("{name}; can {}{protection}{reports}{stop}", abilities.join(" ")))
        }
        Note::SensorMissing(Sensor::Hotend) => "no T: in the temperature report".into(),
        Note::SensorMissing(Sensor::Bed) => "no B: in the temperature report".into(),
        Note::Started => "the firmware said start: what it was told before is forgotten".into(),
        Note::Halted { text } | Note::FirmwareError { text } => printable(text),
        Note::Resend => {
            "a line arrived damaged; the bridge asks again by itself and sends no line twice".into()
        }
        Note::Job { .. } => "as the firmware tells".into(),
        Note::OutOfFilament => "the firmware reports that the filament has run out".into(),
    }
}

/// Words of a device, without what a terminal would obey.
fn printable(text: &str) -> String {
    text.chars().map(|letter| if letter.is_control() { '?' } else { letter }).collect()
}

/// Name of a phase.
pub(crate) fn job_name(phase: Option<JobPhase>) -> &'static str {
    match phase {
        None => "unknown",
        Some(JobPhase::Idle) => "idle",
        Some(JobPhase::Preparing) => "preparing",
        Some(JobPhase::Printing) => "printing",
        Some(JobPhase::Paused) => "paused",
        Some(JobPhase::Done) => "done",
        Some(JobPhase::Failed) => "failed",
    }
}

/// The brain's counters by the reasons of the diagnostics.
pub(crate) fn reasons(refusals: &Refusals) -> [(Reason, u64); 3] {
    [
        (Reason::NotFinite, refusals.not_finite),
        (Reason::OutOfRange, refusals.out_of_range),
        (Reason::Malformed, refusals.malformed + refusals.overlong),
    ]
}
