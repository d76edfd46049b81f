//! The wire process over DDS: machine, controller and supervisor are processes of their own.
//!
//! The loop makes the wall flatter than the same wall in the mode observe; without its controller the machine is back at
//! its planned speeds; what lies outside of the limits is cut twice; bad heights are refused, counted and shown. Beside it the
//! error budget of a machine whose axes are wrong, as the classifier publishes it.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "helpers of tests: a failure is the test's failure"
)]

#[path = "wire_loop/fleet.rs"]
mod fleet;
#[path = "wire_loop/peer.rs"]
mod peer;

use fdm_loop_msgs::{DiagnosticArray, Header, LayerHeight, PrinterState, SafetyState};
use fleet::Fleet;
use models::units::Seconds;
use peer::{Peer, Seen, is_neutral, stamp_s};
use runtime::{Args, Node, topics};
use std::collections::BTreeMap;
use std::time::Duration;

/// Layers that are compared.
const LAYERS: u32 = 6;

/// Runs `body` in a process with a domain of its own.
fn on_own_domain(test: &str, offset: u32, body: impl AsyncFnOnce()) {
    if let Some(alone) = system_tests::run_in_own_domain(test, offset).unwrap() {
        assert!(alone.success(), "it failed in its own domain, see above");
        return;
    }
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    executor.block_on(body());
}

/// A wall of 30 mm, one dip or bump of 0.3 mm a layer, 5 % too little wire, six times as fast as real: 22 s of the
/// process, 4 s of ours a layer. A dip stands in its own layer whatever the loop does; open, the lack of 0.11 mm a layer
/// adds up.
const MACHINE: &[&str] = &[
    "run.speed:=6.0",
    "run.layers:=50",
    "run.seed:=3",
    "wire_plant.wall_length_m:=0.03",
    "wire_plant.features_per_layer:=1",
    "wire_plant.feature_height_m:=3.0e-4",
    "wire_plant.feed_ratio:=0.95",
    "wire_plant.return_s:=0.5",
];
const SIMULATED: &[&str] = &["use_sim_time:=true"];

/// Starts all three and builds some layers; the truth's height RMS of the last layer and of all `[mm]`.
async fn wall(mode: &'static str) -> (Fleet, Peer, f64, f64) {
    let mut peer = Peer::join();
    let start_mode: &'static str = if mode == "act" { "start_mode:=act" } else { "start_mode:=observe" };
    let fleet = Fleet::start(&[
        ("safety_supervisor", &[SIMULATED[0], start_mode]),
        ("mpc_controller", SIMULATED),
        ("printer_sim", MACHINE),
    ]);
    let mut corrected = 0_u32;
    let built = peer.until(|seen| {
        corrected += u32::from(seen.machine.as_ref().is_some_and(|state| !is_neutral(state)));
        seen.truth.as_ref().is_some_and(|truth| truth.layers_complete >= LAYERS)
    });
    assert!(built.await, "no {LAYERS} layers: {:?}", peer.seen);
    assert_eq!(corrected > 0, mode == "act", "{mode}: {corrected} states with corrections");
    let truth = peer.seen.truth.as_ref().unwrap();
    let (last_mm, all_mm) = (1e3 * truth.layer_rms_m, 1e3 * truth.rms_m);
    println!("{mode}: height RMS {all_mm:.3} mm, last layer {last_mm:.3} mm");
    (fleet, peer, last_mm, all_mm)
}

#[test]
fn the_closed_loop_flattens_the_wall_and_its_end_is_neutral() {
    on_own_domain("the_closed_loop_flattens_the_wall_and_its_end_is_neutral", 0, async || {
        let (mut fleet, peer, open_last_mm, open_mm) = wall("observe").await;
        fleet.end();
        drop((fleet, peer));
        let (mut fleet, mut peer, closed_last_mm, closed_mm) = wall("act").await;
        assert!(closed_mm < 0.7 * open_mm, "{closed_mm} mm against {open_mm} mm");
        assert!(closed_last_mm < 0.6 * open_last_mm, "{closed_last_mm} mm against {open_last_mm} mm");
        without_its_controller(&mut fleet, &mut peer).await;
        outside_of_the_limits(&mut fleet, &mut peer).await;
        fleet.end();
    });
}

/// Silence of 0.75 s degrades, corrections end over 0.8 s; half a second more for the ways between the processes, which
/// take six times as long on the machine's clock as on ours.
async fn without_its_controller(fleet: &mut Fleet, peer: &mut Peer) {
    let strong = |seen: &Seen| {
        seen.machine.as_ref().is_some_and(|state| state.depositing && (state.flow_factor - 1.0).abs() > 0.02)
    };
    assert!(peer.until(strong).await, "no correction: {:?}", peer.seen);
    fleet.kill("mpc_controller");
    let killed_s = stamp_s(peer.seen.machine.as_ref().unwrap());
    let neutral = |seen: &Seen| seen.machine.as_ref().is_some_and(is_neutral);
    assert!(peer.until(neutral).await, "still corrected: {:?}", peer.seen);
    let took_s = stamp_s(peer.seen.machine.as_ref().unwrap()) - killed_s;
    println!("neutral {took_s:.2} s after the controller's end");
    assert!(took_s <= 3.0, "{took_s}");
    // And so it stays, while the machine goes on.
    let mut moved = false;
    let begin_s = killed_s + took_s;
    let later = peer.until(|seen| {
        let state = seen.machine.as_ref().unwrap();
        moved |= !is_neutral(state);
        stamp_s(state) > begin_s + 5.0
    });
    assert!(later.await && !moved, "corrected without a controller");
    let state = peer.seen.machine.as_ref().unwrap();
    assert_eq!(state.phase, PrinterState::PHASE_PRINTING);
    assert_eq!(peer.seen.safety.as_ref().unwrap().mode, SafetyState::MODE_DEGRADED);
}

/// A wish of five times the wire never gets beyond the supervisor's 1.8; without a supervisor a permit of that never gets
/// beyond the machine's own 1.9.
async fn outside_of_the_limits(fleet: &mut Fleet, peer: &mut Peer) {
    peer.seen.flow_max = 0.0;
    let clamped = |seen: &Seen| seen.safety.as_ref().is_some_and(|state| state.clamped >= 3);
    assert!(peer.speak_until((false, 5.0), clamped).await, "not clamped: {:?}", peer.seen.safety);
    assert!(peer.seen.flow_max <= 1.8 + 1e-9, "{}", peer.seen.flow_max);
    fleet.kill("safety_supervisor");
    // At the machine's own slew.
    let there = |seen: &Seen| seen.machine.as_ref().is_some_and(|state| state.flow_factor >= 1.9 - 1e-12);
    assert!(peer.speak_until((true, 5.0), there).await, "the permit is not taken: {:?}", peer.seen.machine);
    let state = peer.seen.machine.as_ref().unwrap();
    assert!((state.flow_factor - 1.9).abs() < 1e-12, "{}", state.flow_factor);
}

/// Refused on `sensors/layer/height` by reason.
fn refusals(report: &DiagnosticArray) -> BTreeMap<String, u64> {
    const COUNTER: &str = "refused_sensors_layer_height_";
    let own = report.status.iter().filter(|status| status.name.ends_with("mpc_controller"));
    own.flat_map(|status| &status.values)
        .filter_map(|pair| Some((pair.key.strip_prefix(COUNTER)?.to_owned(), pair.value.parse().ok()?)))
        .collect()
}

#[test]
fn bad_heights_are_refused_counted_and_shown() {
    on_own_domain("bad_heights_are_refused_counted_and_shown", 40, async || {
        let mut fleet = Fleet::start(&[("mpc_controller", &[])]);
        let mut node = Node::start_with("peer", Args::default()).unwrap();
        let heights = node.publish_on(&topics::LAYER_HEIGHT).unwrap();
        let mut reports = node.subscribe(&topics::DIAGNOSTICS).unwrap();
        let mut ticks = node.timer(Seconds(0.05));
        let mut shown = BTreeMap::new();
        let limit = tokio::time::sleep(Duration::from_secs(30));
        tokio::pin!(limit);
        // No number, a standard deviation of nothing, half a minute old, 10 mm beside the plan, a layer of the past.
        let enough = |shown: &BTreeMap<String, u64>| {
            ["not_finite", "out_of_range", "stale", "order"]
                .iter()
                .all(|reason| shown.get(*reason).is_some_and(|count| *count >= 3))
        };
        while !enough(&shown) {
            tokio::select! {
                report = reports.recv() => shown.extend(refusals(&report.message)),
                now = ticks.next() => {
                    let sound = LayerHeight {
                        header: Header::at(now.0),
                        layer: 4,
                        along_m: 0.01,
                        height_m: 5.0 * 2.16e-3,
                        sigma_m: 1e-4,
                    };
                    heights.send(LayerHeight { height_m: f64::NAN, ..sound.clone() });
                    heights.send(LayerHeight { sigma_m: 0.0, ..sound.clone() });
                    heights.send(LayerHeight { height_m: sound.height_m + 0.01, ..sound.clone() });
                    heights.send(LayerHeight { header: Header::at(now.0 - 30.0), ..sound.clone() });
                    heights.send(LayerHeight { layer: 3, height_m: 4.0 * 2.16e-3, ..sound.clone() });
                    heights.send(sound);
                }
                () = &mut limit => panic!("not all refused: {shown:?}"),
            }
        }
        fleet.end();
    });
}

/// What the machine cannot do stands beside what it did. That the same number widens the supervisor's limit is a test of
/// its own (`the_machines_own_error_widens_the_limit`).
#[test]
fn the_error_budget_of_the_machine_stands_beside_the_quality_of_a_layer() {
    on_own_domain("the_error_budget_of_the_machine_stands_beside_the_quality_of_a_layer", 60, async || {
        let budget: &[&str] = &["machine.error_known:=true", "machine.error_m:=2.5e-4"];
        let mut fleet = Fleet::start(&[("defect_classifier", budget)]);
        let mut node = Node::start_with("peer", Args::default()).unwrap();
        let printer = node.publish_on(&topics::PRINTER_STATE).unwrap();
        let mut qualities = node.subscribe(&topics::LAYER_QUALITY).unwrap();
        let mut ticks = node.timer(Seconds(0.02));
        let limit = tokio::time::sleep(Duration::from_secs(30));
        tokio::pin!(limit);
        let seen = loop {
            tokio::select! {
                quality = qualities.recv() => break quality.message,
                now = ticks.next() => {
                    printer.send(PrinterState {
                        header: Header::at(now.0),
                        phase: PrinterState::PHASE_PRINTING,
                        layer_known: true,
                        layer: 7,
                        flow_factor: 1.0,
                        speed_factor: 1.0,
                        ..PrinterState::default()
                    });
                }
                () = &mut limit => panic!("no quality of a layer"),
            }
        };
        assert_eq!(seen.layer, 7);
        assert!(seen.machine_error_known && (seen.machine_error_m - 2.5e-4).abs() < 1e-12, "{seen:?}");
        fleet.end();
    });
}
