//! Trims of coming moves as a supervisor sends them.

use super::*;
use crate::output::Output;
use models::command::{AdvanceLaw, MotionTrim, Scheduled};

/// `K_A` that no permit and no file has `[s]`.
const ADVANCE_S: f64 = 0.4;

fn permit(sequence: u64, mode: Mode) -> Permit {
    Permit {
        session: 1,
        sequence,
        validity: Seconds(0.25),
        mode,
        request: Request::Run,
        trims: Trims::NEUTRAL,
    }
}

fn scheduled(sequence: u64, number: u64) -> Scheduled {
    let advance = AdvanceLaw { linear_s: ADVANCE_S, shear: 0.0, index: 1.0 };
    let trim = MotionTrim { sequence: number, flow: 1.0, speed: 1.0, advance };
    Scheduled { session: 1, sequence, validity: Seconds(5.0), trim }
}

/// The schedule begins with the second line, and has the advance for itself 20 s later: as shipped, `advance_handover_s`.
const SETTLED_S: f64 = 22.5;

/// Keeps the printer under permits and attaches a trim to each move as it becomes known, from the supervisor `session`
/// and with a validity; returns how far the motor is once the schedule has taken over.
fn motor_m(mode: Mode, session: u64, validity_s: f64) -> f64 {
    let mut simulator = warm(straight_job(26), &Scenario::default());
    let (mut permits, mut sequence) = (0, 0);
    while simulator.truth().integrals.deposit_s < SETTLED_S {
        permits += 1;
        simulator.on_permit(permit(permits, mode)).unwrap();
        simulator.step(Seconds(1e-3));
        while let Some(output) = simulator.poll() {
            if let Output::Coming { sequence: number, .. } = output {
                sequence += 1;
                let validity = Seconds(validity_s);
                let sent = Scheduled { session, validity, ..scheduled(sequence, number) };
                // The first line begins as soon as it is known.
                assert_eq!(simulator.on_scheduled(&sent).is_ok(), session == 1 && number > 0);
            }
        }
    }
    simulator.status().motor_position_m
}

/// How far it is ahead of a printer that is only watched.
fn ahead_m(mode: Mode, session: u64, validity_s: f64) -> f64 {
    motor_m(mode, session, validity_s) - motor_m(Mode::Observe, 1, 5.0)
}

/// The motor runs ahead by `K_A u` where a permit to act of the same supervisor is in force, else by nothing: the file
/// has no advance.
#[test]
fn a_scheduled_advance_is_executed_beside_permits_to_act_of_the_same_supervisor() {
    // a line of it lasts 1 s
    let filament_m_s = straight_job(1).filament_m;
    let held_m = ahead_m(Mode::Act, 1, 5.0);
    assert!((held_m / (ADVANCE_S * filament_m_s) - 1.0).abs() < 0.01, "{held_m} of {filament_m_s} m/s");
    for (mode, session) in [(Mode::Degraded, 1), (Mode::Act, 2)] {
        let held_m = ahead_m(mode, session, 5.0);
        assert!(held_m.abs() < 1e-9, "{mode:?} {session}: {held_m}");
    }
}

/// A line lasts 1 s and is known a second before it begins: a trim of 0.5 s is void by then.
#[test]
fn a_trim_whose_move_did_not_begin_in_time_is_void() {
    let held_m = ahead_m(Mode::Act, 1, 0.5);
    assert!(held_m.abs() < 1e-9, "{held_m}");
}

#[test]
fn what_does_not_count_is_refused() {
    let mut simulator = warm(straight_job(6), &Scenario::default());
    assert_eq!(simulator.on_scheduled(&scheduled(1, 3)), Err(Unscheduled::Refused(Refusal::OtherSession)));
    simulator.on_permit(permit(1, Mode::Act)).unwrap();
    assert_eq!(simulator.on_scheduled(&scheduled(1, 3)), Ok(()));
    assert_eq!(simulator.on_scheduled(&scheduled(1, 4)), Err(Unscheduled::Refused(Refusal::Sequence)));
    assert_eq!(simulator.on_scheduled(&scheduled(2, 3)), Err(Unscheduled::Late), "the move has its trim");
    let long = Scheduled { validity: Seconds(5.1), ..scheduled(3, 5) };
    assert_eq!(simulator.on_scheduled(&long), Err(Unscheduled::Refused(Refusal::Validity)));
    run_for(&mut simulator, 1.2);
    simulator.on_permit(permit(2, Mode::Act)).unwrap();
    assert_eq!(simulator.on_scheduled(&scheduled(4, 0)), Err(Unscheduled::Late), "the move has begun");
}

/// A cold start: the wait for the hot end has left the queue long before it is over. What was said of a move meanwhile would be
/// of a nozzle that cannot lay it.
#[test]
fn no_move_is_told_before_the_hot_end_is_warm() {
    let mut simulator = Simulator::new(params(), straight_job(3), &Scenario::default(), 1).unwrap();
    let told = |simulator: &mut Simulator| {
        std::iter::from_fn(|| simulator.poll()).any(|output| matches!(output, Output::Coming { .. }))
    };
    while !told(&mut simulator) {
        assert!(simulator.now().0 < 600.0, "the printer never became warm");
        simulator.step(Seconds(1e-3));
    }
    let hotend_c = simulator.hotend_sensor.last().0;
    assert!(hotend_c >= 226.0 - params().simulator.executor.reached_band_k, "{hotend_c} degC");
    run_to_end(&mut simulator);
    assert!(simulator.truth().integrals.deposit_s > 2.9, "all is laid: {:?}", simulator.truth().integrals);
}
