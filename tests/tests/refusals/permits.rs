//! The simulated printer lives by its own clock: its permits are stamped by that.

use crate::fleet;
use crate::shown::Shown;
use crate::table::Kind;
use fdm_loop_msgs::{ControlCommand, Header, PrinterState, SafetyState};
use models::units::Seconds;
use runtime::{Args, Node, Reason, topics};
use std::time::Duration;

/// Longest wait for all counters.
const PATIENCE: Duration = Duration::from_secs(20);

/// Flow that the supervisor permits, and the one that bad permits, or somebody under its name, ask for.
const PERMITTED: f64 = 1.02;
const FORGED: f64 = 1.1;

/// A permit to act that is refused for one thing alone.
fn permit(kind: Kind, now_s: f64, sequence: u64) -> ControlCommand {
    let sound = ControlCommand {
        header: Header::at(now_s),
        session_id: 1,
        sequence,
        mode: ControlCommand::MODE_ACT,
        validity_s: 0.25,
        flow_factor: PERMITTED,
        speed_factor: 1.0,
        ..ControlCommand::default()
    };
    let bad = ControlCommand { flow_factor: FORGED, ..sound.clone() };
    match kind {
        Kind::Sound | Kind::Malformed => sound,
        Kind::NotFinite => ControlCommand { speed_factor: f64::NAN, ..bad },
        Kind::OutOfRange => ControlCommand { speed_factor: 11.0, ..bad },
        // Twice its validity.
        Kind::Stale => ControlCommand { header: Header::at(now_s - 0.5), ..bad },
    }
}

/// Notes when the flow in force is the permitted one; panics on the way to another one.
fn note_flow(state: &PrinterState, taken: &mut bool) {
    let flow = state.flow_factor;
    *taken |= (flow - PERMITTED).abs() < 1e-9;
    assert!(flow < f64::midpoint(PERMITTED, FORGED), "a bad permit is in force: flow {flow}");
}

/// Sends each kind of permit in turn until the simulator has counted three of each bad one and obeyed the sound ones
/// alone.
pub(crate) async fn the_simulator_refuses_bad_permits() {
    let _printer = fleet::Fleet::of(vec![("printer_sim", fleet::start_printer())]);
    let mut node = Node::start_with("peer", Args::default()).unwrap();
    let mut clock = node.subscribe(&topics::CLOCK).unwrap();
    let mut reports = node.subscribe(&topics::DIAGNOSTICS).unwrap();
    let mut states = node.subscribe(&topics::PRINTER_STATE).unwrap();
    let permits = node.publish_on(&topics::SAFETY_COMMAND).unwrap();
    let mut ticks = node.timer(Seconds(0.02));
    let (mut shown, mut now_s, mut sequence, mut taken) = (Shown::default(), None, 0_u64, false);
    let topic = topics::SAFETY_COMMAND.name();
    let counted = |shown: &Shown| {
        Kind::NUMBERS.iter().all(|kind| shown.refused("printer_sim", topic, kind.reason()) >= 3)
    };
    let limit = tokio::time::sleep(PATIENCE);
    tokio::pin!(limit);
    while !taken || !counted(&shown) {
        tokio::select! {
            reading = clock.recv() => now_s = reading.message.clock.seconds(),
            report = reports.recv() => shown.take(&report.message),
            state = states.recv() => note_flow(&state.message, &mut taken),
            _ = ticks.next() => if let Some(now_s) = now_s {
                let kinds = [Kind::Sound, Kind::NotFinite, Kind::OutOfRange, Kind::Stale];
                permits.send(permit(kinds[usize::try_from(sequence % 4).unwrap()], now_s, sequence));
                sequence += 1;
            },
            () = &mut limit => panic!("taken: {taken}; {:?}", shown.nodes()),
        }
    }
    let (refused, sent) = (shown.refused_in_all("printer_sim", topic), sequence);
    // One in four is sound and taken.
    assert!(refused < sent * 9 / 10, "{refused} of {sent} refused");
}

/// C8, X2: whoever copies session and sequence of the permits is a second publisher all the same.
pub(crate) async fn the_simulator_believes_no_copied_session() {
    let _printer = fleet::Fleet::of(vec![("printer_sim", fleet::start_printer())]);
    let mut node = Node::start_with("peer", Args::default()).unwrap();
    let mut other = Node::start_with("forger", Args::default()).unwrap();
    let forger = other.publish_on(&topics::SAFETY_COMMAND).unwrap();
    let mut clock = node.subscribe(&topics::CLOCK).unwrap();
    let mut reports = node.subscribe(&topics::DIAGNOSTICS).unwrap();
    let mut states = node.subscribe(&topics::PRINTER_STATE).unwrap();
    let permits = node.publish_on(&topics::SAFETY_COMMAND).unwrap();
    let mut ticks = node.timer(Seconds(0.02));
    let (mut shown, mut now_s, mut sequence, mut taken) = (Shown::default(), None, 1_u64, false);
    let topic = topics::SAFETY_COMMAND.name();
    let limit = tokio::time::sleep(PATIENCE);
    tokio::pin!(limit);
    while !taken || shown.refused("printer_sim", topic, Reason::Gate.name()) < 50 {
        tokio::select! {
            reading = clock.recv() => now_s = reading.message.clock.seconds(),
            report = reports.recv() => shown.take(&report.message),
            state = states.recv() => note_flow(&state.message, &mut taken),
            _ = ticks.next() => if let Some(now_s) = now_s {
                let act = permit(Kind::Sound, now_s, sequence);
                permits.send(act.clone());
                if taken {
                    forger.send(ControlCommand { flow_factor: FORGED, sequence: sequence + 1, ..act });
                }
                sequence += 1;
            },
            () = &mut limit => panic!("taken: {taken}; {:?}", shown.nodes()),
        }
    }
}

/// C8: permits that somebody else sends take the corrections back, of a supervisor for which all else is well; and they come
/// back once nobody sends any more.
pub(crate) async fn the_supervisor_degrades_beside_another_one() {
    let simulated = ["-p", "use_sim_time:=true"];
    let started = ["thermistor", "safety_supervisor"].map(|node| (node, fleet::start_with(node, &simulated)));
    let _nodes =
        fleet::Fleet::of([("printer_sim", fleet::start_printer())].into_iter().chain(started).collect());
    let mut node = Node::start_with("rival", Args::default()).unwrap();
    let mut clock = node.subscribe(&topics::CLOCK).unwrap();
    let mut safety = node.subscribe(&topics::SAFETY_STATE).unwrap();
    let permits = node.publish_on(&topics::SAFETY_COMMAND).unwrap();
    let mut ticks = node.timer(Seconds(0.02));
    let (mut now_s, mut sequence, mut said) = (None, 1_u64, Vec::new());
    let limit = tokio::time::sleep(PATIENCE);
    tokio::pin!(limit);
    // Well, beside the other one, well again.
    while said.len() < 3 {
        tokio::select! {
            reading = clock.recv() => now_s = reading.message.clock.seconds(),
            state = safety.recv() => said.extend(step_of(&state.message, said.len())),
            _ = ticks.next() => if let Some(now_s) = now_s.filter(|_| said.len() == 1) {
                permits.send(permit(Kind::Sound, now_s, sequence));
                sequence += 1;
            },
            () = &mut limit => panic!("after {sequence} permits of another one: {said:?}"),
        }
    }
}

/// The mode and its cause, where they are those that are waited for.
fn step_of(state: &SafetyState, step: usize) -> Option<(u8, String)> {
    let rival =
        state.mode == SafetyState::MODE_DEGRADED && state.cause == "C8: a second publisher of permits";
    let well = state.mode == SafetyState::MODE_OBSERVE && state.cause.is_empty();
    (if step == 1 { rival } else { well }).then(|| (state.mode, state.cause.clone()))
}
