//! What file, supervisor and people demand of the printer.

use super::*;
use models::command::{OnLoss, RawDeadManParams};

/// `M600`: the printer waits until the supervisor, which took the pause over, is told to resume.
#[test]
fn a_pause_of_the_file_ends_with_a_persons_resume() {
    let mut simulator = Simulator::new(params(), job_of(&[Action::Pause]), &Scenario::default(), 1).unwrap();
    simulator.warm_up(&Preheat { hotend: Some(Celsius(226.0)), bed: Some(Celsius(60.0)) });
    run_for(&mut simulator, 1.0);
    assert_eq!(simulator.phase(), JobPhase::Paused);
    let permit = |sequence, request| Permit {
        session: 1,
        sequence,
        validity: Seconds(0.25),
        mode: Mode::Act,
        request,
        trims: Trims::NEUTRAL,
    };
    for (sequence, request) in [(1, Request::Pause), (2, Request::Run)] {
        simulator.on_permit(permit(sequence, request)).unwrap();
        run_for(&mut simulator, 0.1);
    }
    run_for(&mut simulator, 0.5);
    assert_eq!(simulator.phase(), JobPhase::Printing);
}

#[test]
fn an_emergency_stop_in_the_file_gives_the_job_up() {
    let mut simulator = Simulator::new(params(), job_of(&[Action::Stop]), &Scenario::default(), 1).unwrap();
    run_for(&mut simulator, 0.5);
    assert_eq!(simulator.phase(), JobPhase::Failed);
}

#[test]
fn a_demand_to_switch_off_gives_the_job_up_for_good() {
    let mut simulator = Simulator::new(params(), straight_job(30), &Scenario::default(), 1).unwrap();
    let permit = |sequence, request| Permit {
        session: 1,
        sequence,
        validity: Seconds(0.25),
        mode: Mode::SafeOff,
        request,
        trims: Trims::NEUTRAL,
    };
    simulator.on_permit(permit(1, Request::HeatersOff)).unwrap();
    simulator.step(Seconds(1e-3));
    assert_eq!(simulator.phase(), JobPhase::Failed);
    simulator.on_permit(permit(2, Request::Run)).unwrap();
    for _ in 0..1000 {
        simulator.step(Seconds(1e-3));
    }
    assert_eq!(simulator.phase(), JobPhase::Failed);
    assert_eq!(simulator.status().hotend_target, Celsius(0.0));
    assert!(simulator.status().hotend_duty <= 0.0);
}

/// What the printer does by itself is not laid at the supervisor's door.
#[test]
fn a_policy_of_the_printer_says_that_nobody_demanded_it() {
    for (policy, told) in
        [(OnLoss::Pause, "dead_man.pause_delay_s"), (OnLoss::HeatersOff, "dead_man.heaters_off_delay_s")]
    {
        let raw =
            RawDeadManParams { on_supervisor_loss: policy, pause_delay_s: 0.5, heaters_off_delay_s: 0.5 };
        let mut params = params();
        params.dead_man = raw.try_into().unwrap();
        let mut simulator = Simulator::new(params, straight_job(30), &Scenario::default(), 1).unwrap();
        let (validity, trims) = (Seconds(0.25), Trims::NEUTRAL);
        let permit =
            Permit { session: 1, sequence: 1, validity, mode: Mode::Act, request: Request::Run, trims };
        simulator.on_permit(permit).unwrap();
        run_for(&mut simulator, 2.0);
        let mut notes = Vec::new();
        while let Some(output) = simulator.poll() {
            if let Output::Note { text, .. } = output {
                notes.push(text);
            }
        }
        assert_eq!(notes.iter().filter(|note| note.contains(told)).count(), 1, "{notes:?}");
    }
}

/// Whatever is switched off after its end: a job that is done stays done.
#[test]
fn a_job_that_has_ended_is_not_given_up() {
    let mut simulator = Simulator::new(params(), straight_job(1), &Scenario::default(), 1).unwrap();
    simulator.warm_up(&Preheat { hotend: Some(Celsius(226.0)), bed: Some(Celsius(60.0)) });
    run_to_end(&mut simulator);
    let permit = Permit {
        session: 1,
        sequence: 1,
        validity: Seconds(0.25),
        mode: Mode::SafeOff,
        request: Request::HeatersOff,
        trims: Trims::NEUTRAL,
    };
    simulator.on_permit(permit).unwrap();
    run_for(&mut simulator, 0.2);
    assert_eq!((simulator.phase(), simulator.status().hotend_target), (JobPhase::Done, Celsius(0.0)));
}

/// With the heaters off a hot end is cooled to the threshold by the part fan, and no further; with the mains relay open by
/// nothing.
#[test]
fn a_hot_end_that_was_switched_off_is_cooled() {
    for request in [Request::HeatersOff, Request::EmergencyStop] {
        let mut simulator = Simulator::new(params(), straight_job(30), &Scenario::default(), 1).unwrap();
        simulator.warm_up(&Preheat { hotend: Some(Celsius(226.0)), bed: None });
        run_for(&mut simulator, 1.0);
        assert!(simulator.status().fan <= 0.0, "as sliced");
        let (session, sequence, validity) = (1, 1, Seconds(0.25));
        let (mode, trims) = (Mode::SafeOff, Trims::NEUTRAL);
        simulator.on_permit(Permit { session, sequence, validity, mode, request, trims }).unwrap();
        run_for(&mut simulator, 1.0);
        assert_eq!(simulator.status().fan > 0.99, request == Request::HeatersOff);
        let mut hot_k = simulator.truth().block_k;
        for _ in 0..1200 {
            run_for(&mut simulator, 1.0);
            let block_k = simulator.truth().block_k;
            assert!(block_k < hot_k, "it cools: {block_k} K after {hot_k} K");
            hot_k = block_k;
            if hot_k < 273.15 + 48.0 {
                break;
            }
        }
        assert!(simulator.status().fan <= 0.0, "{hot_k} K");
    }
}

/// A paused move does not keep the corrections that were in force when it stopped: not its own, and not the set-point's.
#[test]
fn corrections_lapse_in_a_pause_too() {
    let mut simulator = Simulator::new(params(), straight_job(30), &Scenario::default(), 1).unwrap();
    simulator.warm_up(&Preheat { hotend: Some(Celsius(226.0)), bed: Some(Celsius(60.0)) });
    let trims = Trims { flow: 1.1, setpoint_offset_k: 4.0, ..Trims::NEUTRAL };
    for (sequence, request, wanted) in [(1, Request::Run, trims), (2, Request::Pause, Trims::NEUTRAL)] {
        let permit =
            Permit { session: 1, sequence, validity: Seconds(0.25), mode: Mode::Act, request, trims: wanted };
        for step in 0..2000 {
            if step % 100 == 0 {
                let sequence = sequence * 10_000 + step;
                simulator.on_permit(Permit { sequence, ..permit }).unwrap();
            }
            simulator.step(Seconds(1e-3));
        }
        let status = simulator.status();
        assert_eq!(status.trims, wanted);
        let offset_k = status.hotend_target.0 - status.hotend_sliced_target.0;
        assert!((offset_k - wanted.setpoint_offset_k).abs() < 1e-9, "{offset_k}");
    }
    assert_eq!(simulator.phase(), JobPhase::Paused);
}

/// A wait for heat is for the target in force: the file's own is never met while a correction holds the nozzle below it.
#[test]
fn a_wait_for_heat_ends_under_an_offset_that_cools() {
    let mut simulator = warm(straight_job(2), &Scenario::default());
    let trims = Trims { setpoint_offset_k: -8.0, ..Trims::NEUTRAL };
    let cooler = Permit {
        session: 1,
        sequence: 0,
        validity: Seconds(0.25),
        mode: Mode::Act,
        request: Request::Run,
        trims,
    };
    // The nozzle cools to the target in force before the file's wait is met.
    simulator.warm_up(&Preheat { hotend: Some(Celsius(218.0)), bed: Some(Celsius(60.0)) });
    for step in 0..8_000 {
        if step % 100 == 0 {
            simulator.on_permit(Permit { sequence: step + 1, ..cooler }).unwrap();
        }
        simulator.step(Seconds(1e-3));
    }
    assert!(simulator.status().hotend_target.0 < 219.0, "the offset acts");
    assert_eq!(simulator.phase(), JobPhase::Done);
}

#[test]
fn an_opened_mains_relay_ends_a_stuck_heater() {
    let stuck = scenario(
        "description: t\nfaults: [{component: hotend_heater, kind: stuck_on, onset: {time_s: 0.0}}]",
    );
    let mut simulator = Simulator::new(params(), straight_job(30), &stuck, 1).unwrap();
    for _ in 0..20_000 {
        simulator.step(Seconds(1e-3));
    }
    assert!(simulator.truth().heater_w > 39.0);
    let request = Request::EmergencyStop;
    let mode = Mode::Estop;
    let validity = Seconds(0.25);
    simulator
        .on_permit(Permit { session: 1, sequence: 1, validity, mode, request, trims: Trims::NEUTRAL })
        .unwrap();
    for _ in 0..20 {
        simulator.step(Seconds(1e-3));
    }
    assert!(simulator.truth().heater_w <= 0.0);
}
