//! Trims that are sent anew, of moves that have one.

use super::*;

/// How far the motor is behind the last of 26 lines, where each gets a trim of `ADVANCE_S` and, half a second before it begins, one
/// with the advance of `anew_s`; and how many of those were taken.
fn motor_m(host: HostProfile, anew_s: Option<f64>) -> (f64, usize) {
    let mut params = params();
    params.simulator.executor.host = host;
    let mut simulator = warm_of(params, straight_job(26), &Scenario::default());
    let (mut sequence, mut taken, mut coming) = (0, 0, Vec::new());
    for step in 1_u64.. {
        simulator.on_permit(permit(step, Mode::Act)).unwrap();
        simulator.step(Seconds(1e-3));
        while let Some(output) = simulator.poll() {
            if let Output::Coming { sequence: number, start_s, .. } = output {
                sequence += 1;
                _ = simulator.on_scheduled(&scheduled(sequence, number));
                coming.push((number, start_s));
            }
        }
        let now_s = simulator.truth().path_time_s;
        let due = coming.iter().position(|(_, start_s)| start_s - now_s < 0.5);
        if let (Some(advance_s), Some(index)) = (anew_s, due) {
            let mut sent = scheduled(sequence + 1, coming.remove(index).0);
            sent.trim.advance = AdvanceLaw::constant(advance_s);
            sequence += 1;
            taken += usize::from(simulator.on_scheduled(&sent).is_ok());
        }
        if simulator.truth().integrals.deposit_s >= SETTLED_S {
            break;
        }
    }
    (simulator.status().motor_position_m, taken)
}

/// The newest trim of a move that has not begun counts; a serial host has sent it on with the one before.
#[test]
fn a_trim_that_is_sent_anew_stands_for_the_one_before() {
    let held_m = ADVANCE_S * straight_job(1).filament_m;
    for (host, times) in [(HostProfile::Native, 1.5), (HostProfile::Serial, 1.0)] {
        let (before_m, _) = motor_m(host, None);
        let (anew_m, taken) = motor_m(host, Some(1.5 * ADVANCE_S));
        assert_eq!(taken > 15, host == HostProfile::Native, "{host:?}: {taken}");
        let more_m = anew_m - before_m;
        assert!((more_m / held_m - (times - 1.0)).abs() < 0.02, "{host:?}: {more_m} of {held_m} m");
    }
}

/// What has begun goes on as it was sent.
#[test]
fn a_move_that_has_begun_takes_none_anew() {
    let mut simulator = warm(straight_job(6), &Scenario::default());
    simulator.on_permit(permit(1, Mode::Act)).unwrap();
    assert_eq!(simulator.on_scheduled(&scheduled(1, 1)), Ok(()));
    assert_eq!(simulator.on_scheduled(&scheduled(2, 1)), Ok(()), "it has not begun");
    assert_eq!(simulator.attached(), 1);
    run_for(&mut simulator, 1.2);
    simulator.on_permit(permit(2, Mode::Act)).unwrap();
    assert_eq!(simulator.on_scheduled(&scheduled(3, 1)), Err(Unscheduled::Late));
}
