//! Which end of a print its report is headed with, where several causes come one after the other.

use super::section;
use super::writer::{BagFile, folder};
use cli::report::page;
use fdm_loop_msgs::{Header, PrintEvent, PrinterState, SafetyState, SimTruth};
use runtime::topics;

const PRINTING: u8 = PrinterState::PHASE_PRINTING;
const PAUSED: u8 = PrinterState::PHASE_PAUSED;
const DONE: u8 = PrinterState::PHASE_DONE;
const FAILED: u8 = PrinterState::PHASE_FAILED;
const SAFE_OFF: u8 = SafetyState::MODE_SAFE_OFF;
const ESTOP: u8 = SafetyState::MODE_ESTOP;
const STOPPED: &str = "P13: stopped by a person";
const RESUME: &str = "`fdm resume` to go on";

/// What a bag holds.
enum Told {
    Phase(u8, f64),
    /// Mode, cause, what to do.
    Safety(u8, &'static str, &'static str),
    /// By `fdm`, past the supervisor: what the printer shows then.
    Past(&'static str),
    /// A mode that the supervisor has taken, at this severity.
    Changed(u8),
    /// Width error of a simulated print, root mean square.
    Width(f64),
}
use Told::{Changed, Past, Phase, Safety, Width};

/// The page of a bag that is told so, and the verdict at its top.
fn verdict(name: &str, story: &[(f64, Told)]) -> (String, String) {
    let folder = folder(name);
    let mut file = BagFile::create(&folder.join(format!("{name}_0.mcap")), true);
    for (at, told) in story {
        let (at, header) = (*at, Header::at(*at));
        match told {
            Phase(phase, progress) => {
                let state = PrinterState { header, phase: *phase, progress: *progress, ..Default::default() };
                file.put(&topics::PRINTER_STATE, at, &state);
            }
            Safety(mode, cause, what_to_do) => {
                let (cause, what_to_do) = ((*cause).to_owned(), (*what_to_do).to_owned());
                let state = SafetyState { header, mode: *mode, cause, what_to_do, ..Default::default() };
                file.put(&topics::SAFETY_STATE, at, &state);
            }
            Past(after) => {
                let event = PrintEvent {
                    header,
                    severity: PrintEvent::SEVERITY_ERROR,
                    who: "fdm".to_owned(),
                    what: "stopped_past_the_supervisor".to_owned(),
                    why: "P13: a person stops the print; the supervisor does not answer".to_owned(),
                    after: (*after).to_owned(),
                    ..Default::default()
                };
                file.put(&topics::EVENTS, at, &event);
            }
            Width(rms) => {
                let width_error_sq_s = rms * rms * 40.0;
                let truth = SimTruth { header, deposit_s: 40.0, width_error_sq_s, ..Default::default() };
                file.put(&topics::SIM_TRUTH, at, &truth);
            }
            Changed(severity) => {
                let what = "mode_changed".to_owned();
                let event = PrintEvent { header, severity: *severity, what, ..Default::default() };
                file.put(&topics::EVENTS, at, &event);
            }
        }
    }
    file.finish();
    let page = page(&folder, None).unwrap();
    let (head, _) = page.split_once("<h2 ").unwrap();
    let verdict = head.rsplit("<div class=\"verdict ").next().unwrap();
    (verdict.split("</div>").next().unwrap().to_owned(), section(&page, "summary").to_owned())
}

#[test]
fn what_is_stopped_behind_the_end_was_printed() {
    let error = || Changed(PrintEvent::SEVERITY_ERROR);
    let story = [(0.0, Phase(PRINTING, 0.5)), (100.0, Phase(DONE, 1.0)), (130.0, error())];
    let [printing, done, changed] = story;
    let (head, todo) = verdict(
        "behind_stop",
        &[printing, done, changed, (130.0, Safety(SAFE_OFF, STOPPED, "`fdm acknowledge`"))],
    );
    let told = "without a warning. Afterwards P13: stopped by a person (safe_off at 2:10 min).";
    assert!(head.starts_with("ok\"><div><b>Printed to its end</b> ") && head.contains(told), "{head}");
    assert!(todo.contains("`fdm acknowledge`"), "{todo}");
    let stopped = [
        (0.0, Phase(PRINTING, 0.5)),
        (100.0, Phase(DONE, 1.0)),
        (130.0, error()),
        (130.0, Safety(ESTOP, "P1: heats without being told to", "off the mains")),
        (130.5, Phase(FAILED, 1.0)),
    ];
    let (head, _) = verdict("behind_estop", &stopped);
    let told = "Afterwards P1: heats without being told to (estop at 2:10 min).";
    assert!(head.starts_with("error\"><div><b>Printed to its end</b> ") && head.contains(told), "{head}");
}

/// Nothing of the supervisor, or a pause by a person before it: the stop is told, and what to do about it.
#[test]
fn a_stop_past_the_supervisor_heads_the_page() {
    let pause = || (8.0, Safety(SafetyState::MODE_PAUSED, "P13: paused by a person", RESUME));
    for (name, after, mode) in [
        ("past_stop", "heaters off, job given up", "safe_off"),
        ("past_estop", "heaters off, mains relay open, job given up", "estop"),
    ] {
        for paused in [false, true] {
            let mut story = vec![(0.0, Phase(PRINTING, 0.2))];
            if paused {
                story.extend([pause(), (8.5, Phase(PAUSED, 0.2))]);
            }
            story.extend([(12.0, Past(after)), (12.2, Phase(FAILED, 0.2)), (12.3, Past(after))]);
            let (head, summary) = verdict(name, &story);
            let told = format!(
                "<b>Stopped by a person</b> at 20 %. P13: a person stops the print; the \
                                supervisor does not answer ({mode} at 12.0 s)"
            );
            assert!(head.contains(&told) && !head.contains("paused by a person"), "{head}");
            let (_, todo) = summary.split_once("What to do: </b>").unwrap();
            assert!(todo.contains("start the next print") && !todo.contains(RESUME), "{todo}");
            assert_eq!(todo.contains("make the printer safe"), mode == "estop", "{todo}");
        }
    }
}

/// Nobody warned, and the simulator knows better.
#[test]
fn a_simulated_print_that_misses_its_width_is_not_called_good() {
    let verdict_of = |name, rms, severity| {
        let story = [
            (0.0, Phase(PRINTING, 0.5)),
            (5.0, Changed(severity)),
            (9.0, Width(rms)),
            (9.1, Phase(DONE, 1.0)),
        ];
        verdict(name, &story).0
    };
    let (note, warning) = (PrintEvent::SEVERITY_INFO, PrintEvent::SEVERITY_WARN);
    let good = verdict_of("width_good", 0.03, note);
    assert!(good.starts_with("ok") && good.contains("without a warning."), "{good}");
    let missed = verdict_of("width_missed", 0.2, note);
    let told = "without a warning, but simulated: its roads miss their width by 20.0 % (RMS)";
    assert!(missed.starts_with("warn") && missed.contains(told), "{missed}");
    let warned = verdict_of("width_warned", 0.2, warning);
    assert!(warned.contains("with 1 warning: see the events. It is simulated: its roads miss"), "{warned}");
}

/// One that is not heeded has stopped nothing.
#[test]
fn a_print_that_goes_on_was_not_stopped() {
    let story = [
        (0.0, Phase(PRINTING, 0.2)),
        (12.0, Past("heaters off, job given up")),
        (16.0, Phase(PRINTING, 0.3)),
    ];
    let (head, _) = verdict("unheeded", &story);
    assert!(head.contains("<b>Not ended</b>") && head.contains("P13: a person stops"), "{head}");
}

#[test]
fn the_first_cause_of_the_end_comes_first() {
    for (name, cause, headline) in [
        ("first_p2", "P2: too little power", "Stopped by the supervisor"),
        ("first_s1", "S1: out of range", "Stopped by the supervisor"),
        ("first_p13", STOPPED, "Stopped by a person"),
        ("first_estop", "P13: emergency stop by a person", "Stopped by a person"),
    ] {
        let story = [
            (0.0, Phase(PRINTING, 0.4)),
            (9.0, Safety(SAFE_OFF, cause, "first")),
            (9.1, Phase(FAILED, 0.4)),
            (17.0, Safety(ESTOP, "P1: no reading shows it", "second")),
        ];
        let (head, summary) = verdict(name, &story);
        let told = format!(
            "<b>{headline}</b> at 40 %. {cause} (safe_off at 9.0 s), then P1: no reading shows it (estop at 17.0 s)"
        );
        assert!(head.contains(&told), "{head}");
        assert!(summary.contains(&format!("{}: first; then second", &cause[..cause.find(':').unwrap()])));
    }
}

/// A person who acknowledges, or stops what the printer has given up by itself, has not ended it.
#[test]
fn a_printer_that_gave_up_by_itself_has_failed() {
    let story = [
        (0.0, Phase(PRINTING, 0.4)),
        (9.0, Phase(FAILED, 0.4)),
        (9.2, Safety(SAFE_OFF, "C14: the printer gave the job up", "")),
        (30.0, Safety(ESTOP, STOPPED, "")),
    ];
    let (head, _) = verdict("by_itself", &story);
    assert!(head.contains("<b>Failed</b> at 40 %. C14: the printer gave the job up"), "{head}");
}
