//! What is told of a graph.

use super::*;

#[test]
fn who_looks_for_another_printer_is_told_of_those_that_are_there() {
    let args = StatusArgs { namespace: "/left".to_owned(), listen_s: 2.0, json: None };
    let told =
        |topics: &[&str]| nothing_heard(&args, &topics.iter().map(|topic| (*topic).to_owned()).collect());
    let nobody = "no node of /left was heard in 2 s: is `fdm up` running, with the same ROS_DOMAIN_ID?";
    assert_eq!(told(&["/left/heartbeat", "/clock", "/rosout"]), nobody);
    let others = told(&["/heartbeat", "/left/heartbeat", "/right/heartbeat", "/right/events"]);
    assert_eq!(
        others,
        "no node of /left was heard in 2 s: others are there: --namespace /, --namespace /right"
    );
}

fn printer() -> PrinterState {
    PrinterState {
        phase: PrinterState::PHASE_PAUSED,
        progress: 0.25,
        layer: 2,
        layer_known: true,
        hotend_target_degc: 215.0,
        bed_target_degc: 60.0,
        mains_on: true,
        ..PrinterState::default()
    }
}

/// Who hangs, and who was deactivated, stands among those that work, and does not look like them.
#[test]
fn a_silent_node_and_one_that_is_not_active_are_told() {
    let seen = |state: &str| Seen { beats: 20, work_counter: 7, state: Some(state.to_owned()) };
    let nodes = [("/printer/imu", seen("active")), ("/printer/camera", seen("inactive"))];
    let nodes = nodes.map(|(name, seen)| (name.to_owned(), seen)).into();
    let told = text(&status((nodes, vec!["/printer/mpc_controller".to_owned()]), None, None, (None, None)));
    let lines: Vec<&str> = told.lines().collect();
    assert!(
        lines[0].starts_with("/printer/camera ") && lines[0].ends_with(", NOT ACTIVE: inactive"),
        "{told}"
    );
    assert!(lines[1].starts_with("/printer/imu ") && lines[1].ends_with("20 heartbeats, work 7"), "{told}");
    assert!(lines[2].starts_with("/printer/mpc_controller ") && lines[2].contains(" silent: "), "{told}");
}

#[test]
fn temperatures_stand_beside_their_set_points() {
    let mut seen = status(<_>::default(), None, Some(printer()), (Some(211.44), None));
    let told = text(&seen);
    assert!(told.contains("supervisor: not heard\nprinter: paused, 25.0 %, layer 3\n"), "{told}");
    let line = "temperatures: hot end 211.4 degC, set to 215 degC; bed not heard, set to 60 degC";
    assert!(told.ends_with(line), "{told}");
    seen.hotend_target_degc = None;
    assert!(text(&seen).contains("hot end 211.4 degC; bed"));
}

#[test]
fn the_phase_of_the_job_and_a_latch_are_told() {
    let told = |latched: bool, phase: u8| {
        let safety = SafetyState {
            mode: SafetyState::MODE_SAFE_OFF,
            set_mode: SafetyState::MODE_ACT,
            cause: "S1".to_owned(),
            latched,
            ..SafetyState::default()
        };
        let state = PrinterState { phase, ..printer() };
        let seen = status(<_>::default(), Some(safety), Some(state), (None, None));
        (text(&seen), serde_json::to_value(seen).unwrap())
    };
    let (lines, json) = told(true, PrinterState::PHASE_FAILED);
    assert!(
        lines.contains("supervisor: safe_off (S1), latched until `fdm acknowledge`, set to act\n"),
        "{lines}"
    );
    assert!(lines.contains("printer: failed, 25.0 %"), "{lines}");
    assert_eq!((&json["latched"], &json["phase"]), (&true.into(), &"failed".into()));
    let (lines, json) = told(false, PrinterState::PHASE_DONE);
    assert!(lines.contains("supervisor: safe_off (S1), set to act\n"), "{lines}");
    assert_eq!((&json["latched"], &json["phase"]), (&false.into(), &"done".into()));
    let off = PrinterState { mains_on: false, ..printer() };
    let told = text(&status(<_>::default(), None, Some(off), (None, None)));
    assert!(told.contains("printer: paused, 25.0 %, layer 3, off the mains\n"), "{told}");
    let nobody = serde_json::to_value(status(<_>::default(), None, None, (None, None))).unwrap();
    assert!(nobody["latched"].is_null() && nobody["phase"].is_null());
}
