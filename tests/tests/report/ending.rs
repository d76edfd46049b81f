//! What the page says of how a print ended, and of a bag that is not what it seems.

use super::print::{Print, USUAL};
use super::writer::{BagFile, folder};
use super::{bag, section};
use cli::report::page;
use fdm_loop_msgs::{CompressedImage, DefectReport, Header, ImuBatch, PrintEvent, PrinterState, SafetyState};
use runtime::topics;
use std::path::Path;

const SHIFT: &str = "what was laid lies elsewhere than it was laid";

/// A print that was paused for P8 and stopped by a person, with the frame that led to it.
fn stopped(bag: &mut BagFile) {
    let state =
        |phase, at| PrinterState { header: Header::at(at), phase, progress: 0.53, ..Default::default() };
    let safety = |mode, cause: &str, what_to_do: &str, at| SafetyState {
        header: Header::at(at),
        mode,
        cause: cause.to_owned(),
        what_to_do: what_to_do.to_owned(),
        ..Default::default()
    };
    let event = |why: &str, (before, after): (&str, &str), at| PrintEvent {
        header: Header::at(at),
        severity: PrintEvent::SEVERITY_WARN,
        who: "/printer/safety_supervisor".to_owned(),
        what: "mode_changed".to_owned(),
        why: why.to_owned(),
        before: before.to_owned(),
        after: after.to_owned(),
    };
    bag.put(&topics::PRINTER_STATE, 0.0, &state(PrinterState::PHASE_PRINTING, 0.0));
    // A pause that was resumed from is not what ended the print.
    bag.put(&topics::SAFETY_STATE, 5.0, &safety(SafetyState::MODE_PAUSED, "P7: no filament", "load it", 5.0));
    bag.put(&topics::SAFETY_STATE, 8.0, &safety(SafetyState::MODE_ACT, "", "", 8.0));
    bag.put(&topics::DEFECTS, 10.0, &shifted(10.0));
    let data = [0xff, 0xd8, 0xff, 0xe0];
    let image = CompressedImage { header: Header::at(10.0), data: data.to_vec(), ..Default::default() };
    bag.put(&topics::ANNOTATED, 10.0, &image);
    bag.put(&topics::EVENTS, 10.0, &event(SHIFT, ("act", "paused"), 10.0));
    let cause = format!("P8: {SHIFT}");
    bag.put(
        &topics::SAFETY_STATE,
        10.0,
        &safety(SafetyState::MODE_PAUSED, &cause, "stop and print anew", 10.0),
    );
    bag.put(&topics::PRINTER_STATE, 10.5, &state(PrinterState::PHASE_PAUSED, 10.5));
    bag.put(&topics::EVENTS, 20.0, &event("stopped by a person", ("paused", "safe_off"), 20.0));
    let last = safety(SafetyState::MODE_SAFE_OFF, "P13: stopped by a person", "acknowledge", 20.0);
    bag.put(&topics::SAFETY_STATE, 20.0, &last);
    bag.put(&topics::PRINTER_STATE, 20.5, &state(PrinterState::PHASE_FAILED, 20.5));
}

/// A frame that looks well and lies 0.71 mm beside the layer below.
fn shifted(at: f64) -> DefectReport {
    DefectReport {
        header: Header::at(at),
        usable: true,
        cause: "ok".to_owned(),
        confidence: 0.32,
        residual_limit: 1.0,
        offset_known: true,
        offset_m: [-0.71e-3, 0.0],
        ..Default::default()
    }
}

/// The cause that held the print up stays at the top after a person has stopped it; events carry their codes.
#[test]
fn a_stop_by_a_person_does_not_hide_why_the_print_was_held_up() {
    let folder = folder("stopped");
    let mut file = BagFile::create(&folder.join("stopped_0.mcap"), true);
    stopped(&mut file);
    file.finish();
    let page = page(&folder, None).unwrap();
    let head = format!(
        "<b>Stopped by a person</b> at 53 %. P8: {SHIFT} (paused at 10.0 s), then P13: stopped by a person"
    );
    assert!(page.contains(&head), "{}", section(&page, "summary"));
    assert!(page.contains("P8: stop and print anew (`fdm stop`); then acknowledge (`fdm acknowledge`)"));
    let events = section(&page, "events");
    assert!(
        events.contains(&format!("P8: {SHIFT}")) && events.contains("P13: stopped by a person"),
        "{events}"
    );
    assert!(!page.contains("P7: no filament (paused"), "that pause was resumed from");
    let pictures = section(&page, "pictures");
    let caption = format!("P8: {SHIFT}; the camera&#39;s judge calls this frame ok, confidence c_k 0.32");
    let said = pictures.contains(&caption) || pictures.contains(&caption.replace("&#39;", "'"));
    assert!(said && pictures.contains("layers lie -0.71 mm, +0.00 mm beside"), "{pictures}");
}

/// What switched the heaters off, not the pause before it, though somebody has acknowledged both.
#[test]
fn the_worst_cause_of_a_failed_print_stands_at_the_top() {
    let folder = folder("worst");
    let mut file = BagFile::create(&folder.join("worst_0.mcap"), true);
    let state = |phase, at| PrinterState { header: Header::at(at), phase, ..Default::default() };
    file.put(&topics::PRINTER_STATE, 0.0, &state(PrinterState::PHASE_PRINTING, 0.0));
    let (paused, failed) = (PrinterState::PHASE_PAUSED, PrinterState::PHASE_FAILED);
    for (at, mode, cause, phase) in [
        (5.0, SafetyState::MODE_PAUSED, "P6: the filament does not follow", paused),
        (9.0, SafetyState::MODE_SAFE_OFF, "S1: out of range", failed),
        (20.0, SafetyState::MODE_ACT, "", failed),
    ] {
        let safety =
            SafetyState { header: Header::at(at), mode, cause: cause.to_owned(), ..Default::default() };
        file.put(&topics::SAFETY_STATE, at, &safety);
        file.put(&topics::PRINTER_STATE, at + 0.5, &state(phase, at + 0.5));
    }
    file.finish();
    let page = page(&folder, None).unwrap();
    let (head, _) = page.split_once("<h2 ").unwrap();
    assert!(head.contains("Stopped by the supervisor") && head.contains("S1: out of range ("), "{head}");
    assert!(!head.contains("P6:"), "{head}");
}

/// One reading of 12 degC more, the checksum as it was: the page says that the data were changed.
#[test]
fn a_changed_reading_does_not_fit_the_checksum() {
    let folder = folder("sums");
    let path = folder.join("sums_0.mcap");
    let mut file = BagFile::create(&path, false);
    let reading = fdm_loop_msgs::Temperature { temperature: 211.0, ..Default::default() };
    file.put(&topics::HOTEND_TEMPERATURE, 0.0, &reading);
    file.finish();
    let sound = page(&folder, None).unwrap();
    assert!(!sound.contains("This bag is not whole"));
    assert!(section(&sound, "recorder").contains("The data of 1 of 1 files fit the checksum"));
    let mut bytes = std::fs::read(&path).unwrap();
    let (before, after) = (211.0_f64.to_le_bytes(), 223.0_f64.to_le_bytes());
    let at = bytes.windows(8).position(|window| window == before).unwrap();
    bytes[at..at + 8].copy_from_slice(&after);
    std::fs::write(&path, bytes).unwrap();
    let changed = page(&folder, None).unwrap();
    assert!(changed.contains("sums_0.mcap does not fit the checksum of its data"));
}

#[test]
fn a_namespace_that_is_not_there_is_refused_with_those_there_are() {
    let folder = bag("namespace", &Print { duration_s: 5.0, ..USUAL });
    let said = format!("{:#}", page(&folder, Some("/nosuch")).unwrap_err());
    let wanted = format!("{}: --namespace /nosuch", folder.display());
    assert!(said.starts_with(&wanted) && said.ends_with("there are /printer"), "{said}");
    assert!(page(&folder, Some("/printer/")).unwrap().contains("square.gcode"));
}

/// Half of the messages are of another version: that stands at the top, not in the recorder's section alone.
#[test]
fn what_could_not_be_decoded_is_said_at_the_top() {
    let folder = folder("version");
    let mut file = BagFile::create(&folder.join("version_0.mcap"), true);
    let reading = fdm_loop_msgs::Temperature { temperature: 20.0, ..Default::default() };
    file.put(&topics::HOTEND_TEMPERATURE, 0.0, &reading);
    file.bytes("/printer/printer/state", "fdm_loop_msgs/msg/PrinterState", 0.0, &[1; 6]);
    file.finish();
    let page = page(&folder, None).unwrap();
    let (head, _) = page.split_once("<h2 ").unwrap();
    assert!(head.contains("1 of 2 messages (50.0 %) could not be decoded"), "{head:.3000}");
    assert!(
        head.contains("None of the printer&#39;s states") || head.contains("None of the printer's states")
    );
}

/// A knock of one sample in an hour of quiet: its 9 m/s2 are on the axis and in the line.
#[test]
fn a_knock_is_seen_in_the_plot_of_an_hour() {
    let vibration = |knock: f64, name: &str| {
        let folder = folder(name);
        let mut file = BagFile::create(&folder.join(format!("{name}_0.mcap")), true);
        for second in 0..3600 {
            let at = f64::from(second);
            let x = if second == 1800 { vec![0.1, knock, -0.1] } else { vec![0.1, 0.0, -0.1] };
            let batch = ImuBatch {
                header: Header::at(at),
                period_s: 0.005,
                y_m_s2: vec![0.0; 3],
                z_m_s2: vec![0.0; 3],
                x_m_s2: x,
                ..Default::default()
            };
            file.put(&topics::IMU_BATCH, at, &batch);
        }
        file.finish();
        section(&page(&folder, None).unwrap(), "vibration").to_owned()
    };
    let (quiet, knocked) = (vibration(0.0, "quiet"), vibration(13.5, "knocked"));
    // The mean of the knocked batch is a third of it: 9 m/s2 remain. The axis of the quiet one ends at 1 m/s2.
    let labelled = |plot: &str| plot.split(['<', '>']).any(|text| text.trim() == "8");
    assert!(labelled(&knocked) && !labelled(&quiet), "{knocked:.3000}");
    assert!(highest(&knocked) < 0.25, "{}", highest(&knocked));
}

/// How far below the top of the first plot its line reaches, as a share of the height.
fn highest(plot: &str) -> f64 {
    let line = plot.split("<polyline").find(|line| line.contains("stroke-width=\"2\"")).unwrap();
    let points = line.split("points=\"").nth(1).unwrap().split('"').next().unwrap();
    let heights = points.split_whitespace().filter_map(|point| point.split_once(',')?.1.parse::<f64>().ok());
    heights.fold(f64::INFINITY, f64::min) / 250.0
}

/// The page replaces neither the bag nor anything in its folder.
#[test]
fn a_page_never_replaces_what_it_is_made_of() {
    let folder = bag("outputs", &Print { duration_s: 5.0, ..USUAL });
    let file = folder.join("outputs_0.mcap");
    std::fs::write(folder.join("counts.json"), "{}").unwrap();
    let before = std::fs::read(&file).unwrap();
    let refused = |bag: &Path, out: &Path| {
        let args = cli::report::ReportArgs {
            bag: bag.to_owned(),
            out: Some(out.to_owned()),
            namespace: None,
            against: None,
        };
        cli::report::run(&args).is_err()
    };
    for out in [&file, &folder.join("counts.json"), &folder.join("new.html")] {
        assert!(refused(&folder, out), "{}", out.display());
    }
    assert!(refused(&file, &file) && refused(&file, &folder.join("counts.json")));
    assert_eq!(std::fs::read(&file).unwrap(), before);
    assert_eq!(std::fs::read_to_string(folder.join("counts.json")).unwrap(), "{}");
    assert!(!folder.join("new.html").exists());
    let beside = folder.with_extension("html");
    assert!(!refused(&folder, &beside) && beside.is_file());
}
