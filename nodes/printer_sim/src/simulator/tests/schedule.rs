//! Trims of coming moves as a supervisor sends them.

use super::*;

mod anew;

use crate::output::Output;
use models::command::{AdvanceLaw, MotionTrim, Scheduled};
use models::status::{HostProfile, PrinterStatus};

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
    let trim = MotionTrim { sequence: number, flow: 1.0, speed: 1.0, advance, carried_m: 0.0 };
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

/// While a schedule takes the advance over, what is told is what the motor does: a half of it after half of the time.
#[test]
fn an_advance_that_is_handed_over_is_told_as_it_is() {
    let mut simulator = warm(straight_job(26), &Scenario::default());
    let (mut permits, mut sequence) = (0, 0);
    while simulator.truth().integrals.deposit_s < 14.0 {
        permits += 1;
        simulator.on_permit(permit(permits, Mode::Act)).unwrap();
        simulator.step(Seconds(1e-3));
        while let Some(output) = simulator.poll() {
            let Output::Coming { sequence: number, .. } = output else { continue };
            // later than at the begin of a road, where it is there at once
            if simulator.truth().integrals.deposit_s > 3.0 {
                sequence += 1;
                _ = simulator.on_scheduled(&scheduled(sequence, number));
            }
        }
    }
    let told_s = simulator.status().advance_s;
    assert!((told_s / ADVANCE_S - 0.5).abs() < 0.1, "{told_s}");
}

/// What is held already without an advance that pushed it is taken off along a road, in a pause, and behind the last road, where
/// it is drawn back. Without permits it fades with the share of the schedule.
#[test]
fn what_is_carried_is_taken_off_and_drawn_back_at_rest() {
    const CARRIED_M: f64 = 1.5e-3;
    let motor_m = |carried_m: f64, until_s: f64, rest: bool| {
        let mut simulator = warm(straight_job(26), &Scenario::default());
        lay(&mut simulator, Mode::Act, SETTLED_S, |simulator, mut sent| {
            sent.trim.carried_m = carried_m;
            _ = simulator.on_scheduled(&sent);
        });
        if rest {
            for sequence in 100_000_u64..101_000 {
                simulator
                    .on_permit(Permit { request: Request::Pause, ..permit(sequence, Mode::Act) })
                    .unwrap();
                simulator.step(Seconds(1e-3));
            }
        } else {
            run_for(&mut simulator, until_s);
        }
        simulator.status().motor_position_m
    };
    let less_m = |until_s, rest| motor_m(0.0, until_s, rest) - motor_m(CARRIED_M, until_s, rest);
    assert!((less_m(0.0, false) / CARRIED_M - 1.0).abs() < 1e-6, "{} m along a road", less_m(0.0, false));
    assert!((less_m(0.0, true) / CARRIED_M - 1.0).abs() < 1e-6, "{} m at rest", less_m(0.0, true));
    // The permit counts 0.25 s; then the file has it back within 2 s.
    assert!(less_m(2.4, false).abs() < 1e-6, "{} m without permits", less_m(2.4, false));
}

/// Behind the last road nothing is held: what is carried is drawn back with the rest.
#[test]
fn what_is_carried_is_drawn_back_behind_the_last_road() {
    let motor_m = |carried_m: f64| {
        let mut simulator = warm(straight_job(26), &Scenario::default());
        lay(&mut simulator, Mode::Act, 25.9, |simulator, mut sent| {
            sent.trim.carried_m = carried_m;
            _ = simulator.on_scheduled(&sent);
        });
        for sequence in 100_000_u64..100_500 {
            _ = simulator.on_permit(permit(sequence, Mode::Act));
            simulator.step(Seconds(1e-3));
        }
        simulator.status().motor_position_m
    };
    let less_m = motor_m(0.0) - motor_m(1.5e-3);
    assert!((less_m / 1.5e-3 - 1.0).abs() < 1e-6, "{less_m} m");
}

/// A coming move is told with its start on the plan: the end of the one before.
#[test]
fn a_coming_move_is_told_with_its_start() {
    let mut simulator = warm(straight_job(6), &Scenario::default());
    let mut ends_s = None;
    while simulator.truth().integrals.deposit_s < 3.0 {
        simulator.step(Seconds(1e-3));
        while let Some(output) = simulator.poll() {
            if let Output::Coming { start_s, segment, .. } = output {
                assert!(start_s >= simulator.truth().path_time_s - 1e-3, "{start_s} s has passed");
                let late_s = start_s - ends_s.unwrap_or(start_s);
                assert!(late_s.abs() < 1e-9, "{start_s} s, the move before ends {late_s} s earlier");
                ends_s = Some(start_s + segment.profile.duration().0);
            }
        }
    }
    assert!(ends_s.is_some_and(|ends_s| ends_s > 3.0));
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

/// Under permits of this mode until a road of `road_s` is laid; `attach` gets a trim for each move that becomes known.
fn lay(
    simulator: &mut Simulator,
    mode: Mode,
    road_s: f64,
    mut attach: impl FnMut(&mut Simulator, Scheduled),
) {
    let mut sequence = 0;
    for step in 1_u64.. {
        simulator.on_permit(permit(step, mode)).unwrap();
        simulator.step(Seconds(1e-3));
        while let Some(output) = simulator.poll() {
            if let Output::Coming { sequence: number, .. } = output {
                sequence += 1;
                attach(simulator, scheduled(sequence, number));
            }
        }
        if simulator.truth().integrals.deposit_s >= road_s {
            break;
        }
    }
}

/// How far along the plan a printer is after 10 s of road, whose moves are planned at a speed each; the file's speed there, and
/// what it says then.
fn planned_at(mode: Mode, speed: f64, host: HostProfile) -> (f64, f64, PrinterStatus) {
    let mut params = params();
    params.simulator.executor.host = host;
    let mut simulator = warm_of(params, straight_job(26), &Scenario::default());
    lay(&mut simulator, mode, 10.0, |simulator, mut sent| {
        sent.trim.speed = speed;
        _ = simulator.on_scheduled(&sent);
    });
    let status = simulator.status();
    (status.path_time_s, simulator.sliced_speed_m_s(), status)
}

/// The first line of 1 s begins before it can have a trim, the 9 s after it take 0.8 of a second each of the plan. What is
/// planned faster than the file is not, what would stand still goes at the printer's own least (.65), and where corrections do
/// not act the file's own speed holds.
#[test]
fn a_move_is_laid_at_the_speed_that_it_is_planned_at() {
    for host in [HostProfile::Native, HostProfile::Serial] {
        for (mode, speed, path_s, pace) in [
            (Mode::Act, 0.8, 8.2, 0.8),
            (Mode::Act, 1.1, 10.0, 1.0),
            (Mode::Act, 1e-9, 6.85, 0.65),
            (Mode::Degraded, 0.8, 10.0, 1.0),
        ] {
            let (along_s, sliced_m_s, status) = planned_at(mode, speed, host);
            assert!((along_s - path_s).abs() < 0.02, "{host:?} {mode:?} {speed}: {along_s} s along the plan");
            assert!((status.planned_speed_m_s / SPEED_M_S - pace).abs() < 1e-9, "{status:?}");
            assert!((status.path_speed_m_s / SPEED_M_S - pace).abs() < 1e-6, "{status:?}");
            assert!((sliced_m_s / SPEED_M_S - 1.0).abs() < 1e-9, "the file's: {sliced_m_s}");
            assert!(
                (status.trims.speed - 1.0).abs() < 1e-15,
                "the trim in force is the permit's: {status:?}"
            );
        }
    }
}

/// Warm, a dwell of this many seconds, then two lines.
fn after_dwell(dwell_s: f64) -> JobSource {
    let job = straight_job(2);
    let mut steps: Vec<Step> = job.steps.collect();
    let lines = steps.iter().position(|step| matches!(step, Step::Move(_))).unwrap();
    steps.insert(lines, Step::Action(Action::Dwell(Seconds(dwell_s)), 4));
    JobSource { steps: Box::new(steps.into_iter()), ..straight_job(2) }
}

/// What follows a dwell is told a second ahead as anywhere, however long the dwell lasts: told before it, the trim of the first
/// road would lapse meanwhile. Halfway along that road the motor is ahead by all that the road holds compressed.
#[test]
fn the_first_road_after_a_dwell_has_its_trim() {
    let moved_m = |dwell_s: f64, mode: Mode| {
        let mut simulator = warm(after_dwell(dwell_s), &Scenario::default());
        lay(&mut simulator, mode, 0.5, |simulator, sent| {
            assert_eq!(simulator.on_scheduled(&sent), Ok(()), "{dwell_s} s");
        });
        simulator.status().motor_position_m
    };
    let held_m = ADVANCE_S * straight_job(1).filament_m;
    for dwell_s in [3.0, 8.0] {
        let ahead_m = moved_m(dwell_s, Mode::Act) - moved_m(dwell_s, Mode::Observe);
        assert!((ahead_m / held_m - 1.0).abs() < 0.02, "{dwell_s} s: {ahead_m} of {held_m} m");
    }
}
