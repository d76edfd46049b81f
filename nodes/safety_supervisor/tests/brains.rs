//! What estimator and controller say of themselves, and the swing of commands that nobody needs to tell.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::print::Print;
use models::command::{Command, ControlHealth, EstimateHealth, Mode, Trims};
use models::units::Seconds;
use safety_supervisor::{Cause, Event, Operator, What};

/// K1, K2, K3, K5: at once, and the set mode is back 2 s after the controller is sound again.
#[test]
fn a_controller_in_doubt_degrades_and_heals() {
    for (health, cause) in [
        (ControlHealth::Infeasible, Cause::PlanInfeasible),
        (ControlHealth::Late, Cause::PlanLate),
        (ControlHealth::NotFinite, Cause::PlanNotFinite),
        (ControlHealth::Saturated, Cause::Saturated),
    ] {
        let mut print = Print::acting();
        print.event(Event::ControlHealth(health));
        // the next tick
        assert!(print.until(Mode::Degraded) <= 0.021, "{health:?}");
        assert_eq!(print.output.state.cause, Some(cause));
        let told = print.output.events.iter().find(|decision| decision.what == What::ModeChanged).unwrap();
        assert_eq!(told.why, cause.text());
        print.run(2.0);
        assert_eq!(print.output.permit.trims, Trims::NEUTRAL);
        print.event(Event::ControlHealth(ControlHealth::Sound));
        assert!(print.until(Mode::Act) <= 2.1);
    }
}

/// C8, X2: what a second controller says of its health is not the controller's, neither good nor bad.
#[test]
fn the_health_of_a_stranger_is_not_believed() {
    let told_for = |print: &mut Print, validity, session, health| {
        let sequence = 1_000_000;
        print.event(Event::Command(Command { session, sequence, validity, trims: Trims::NEUTRAL }));
        print.event(Event::ControlHealth(health));
        print.run(0.1);
    };
    let told = |print: &mut Print, session, health| told_for(print, Seconds(0.2), session, health);
    let mut print = Print::acting();
    // Before the first one speaks again, which makes the stranger a second publisher: a cause of its own.
    print.controller = false;
    told(&mut print, 66, ControlHealth::NotFinite);
    assert_eq!((print.mode(), print.output.state.cause), (Mode::Act, None));
    // Nor is one that asks to count for too long, while the other is in force and after it.
    for silent_s in [0.0, 2.0] {
        let mut print = Print::acting();
        print.controller = false;
        print.run(silent_s);
        let before = print.output.state.cause;
        told_for(&mut print, Seconds(60.0), 66, ControlHealth::NotFinite);
        assert_eq!(print.output.state.cause, before, "{silent_s} s");
    }
    let mut print = Print::acting();
    print.event(Event::ControlHealth(ControlHealth::NotFinite));
    told(&mut print, 66, ControlHealth::Sound);
    print.run(20.0);
    assert_eq!(print.output.state.cause, Some(Cause::PlanNotFinite), "a stranger does not heal it");
}

/// C6: a command of its own that comes twice is refused, and makes no stranger of the controller.
#[test]
fn the_health_of_a_controller_whose_command_was_refused_is_believed() {
    let mut print = Print::acting();
    let command = print.command();
    print.event(command.clone());
    print.event(command);
    print.event(Event::ControlHealth(ControlHealth::NotFinite));
    assert!(print.until(Mode::Degraded) <= 0.021);
    assert_eq!(print.output.state.cause, Some(Cause::PlanNotFinite));
}

/// C8, X2: a permit of somebody else takes the corrections back, whoever the printer believes, until nobody writes any.
#[test]
fn a_second_publisher_of_permits_degrades_and_heals() {
    let mut print = Print::acting();
    print.event(Event::RivalPermit);
    assert!(print.until(Mode::Degraded) <= 0.021);
    let told = print.output.events.iter().find_map(|decision| decision.cause);
    assert_eq!(told.map(|(cause, _)| cause), Some(Cause::SecondSupervisor));
    for _ in 0..50 {
        print.run(0.1);
        print.event(Event::RivalPermit);
    }
    assert_eq!((print.mode(), print.output.permit.trims), (Mode::Degraded, Trims::NEUTRAL));
    // 2 s of memory, and 1 s until what is gone counts as gone
    let back_s = print.until(Mode::Act);
    assert!((2.9..3.2).contains(&back_s), "{back_s} s");
}

/// C8: so does a second publisher of what everything rests on.
#[test]
fn a_second_publisher_of_a_stream_degrades_and_heals() {
    let mut print = Print::acting();
    print.event(Event::RivalSample);
    assert!(print.until(Mode::Degraded) <= 0.021);
    assert_eq!(print.output.state.cause, Some(Cause::SecondSource));
    let back_s = print.until(Mode::Act);
    assert!((2.9..3.2).contains(&back_s), "{back_s} s");
}

/// K4, first divergence: degraded, the mode stays set.
#[test]
fn an_estimate_started_anew_degrades_and_heals() {
    let mut print = Print::acting();
    print.event(Event::EstimateHealth(EstimateHealth::Reset));
    assert!(print.until(Mode::Degraded) <= 0.021);
    assert_eq!(print.output.state.cause, Some(Cause::EstimateReset));
    print.event(Event::EstimateHealth(EstimateHealth::Sound));
    assert!(print.until(Mode::Act) <= 2.1);
}

/// K4, second divergence, and K8: the set mode itself falls, and comes back only when a person sets it with the
/// reason gone.
#[test]
fn a_distrusted_estimate_takes_the_mode_to_observe_until_a_person_sets_it() {
    for (health, cause) in [
        (EstimateHealth::Diverging, Cause::EstimateDiverging),
        (EstimateHealth::Mismatch, Cause::ModelMismatch),
    ] {
        let mut print = Print::acting();
        print.event(Event::EstimateHealth(health));
        assert!(print.until(Mode::Observe) <= 0.021, "{health:?}");
        let state = &print.output.state;
        assert_eq!((state.set_mode, state.cause), (Mode::Observe, Some(cause)));
        assert!(!state.what_to_do.is_empty());
        let told = print.output.events.iter().find(|decision| decision.what == What::ModeChanged).unwrap();
        assert_eq!((told.why, told.before, told.after), (cause.text(), Mode::Act, Mode::Observe));
        print.run(2.0);
        assert_eq!(print.output.permit.trims, Trims::NEUTRAL);
        for mode in [Mode::Act, Mode::Advise] {
            print.ask(Operator::SetMode(mode));
            let denied = What::Denied(Operator::SetMode(mode));
            let told = print.output.events.iter().find(|decision| decision.what == denied).unwrap();
            assert_eq!(told.cause.map(|(cause, _)| cause), Some(cause), "not for a moment alone");
            print.run(0.1);
            assert_eq!((print.mode(), print.output.state.cause), (Mode::Observe, Some(cause)));
        }
        print.event(Event::EstimateHealth(EstimateHealth::Sound));
        print.run(30.0);
        assert_eq!(print.mode(), Mode::Observe, "it does not come back by itself");
        print.ask(Operator::SetMode(Mode::Act));
        print.run(0.1);
        assert_eq!((print.mode(), print.output.state.cause), (Mode::Act, None));
    }
}

/// Runs `span_s` of a swing of flow around 0.95 and returns when it degraded.
fn swing(amplitude: f64, period_s: f64, span_s: f64) -> Option<f64> {
    swing_of(&mut Print::acting(), amplitude, period_s, span_s)
}

fn swing_of(print: &mut Print, amplitude: f64, period_s: f64, span_s: f64) -> Option<f64> {
    let start_s = print.now();
    while print.now() - start_s < span_s {
        let phase = std::f64::consts::TAU * (print.now() - start_s) / period_s;
        print.wish = Trims { flow: 0.95 + amplitude * phase.sin(), ..Trims::NEUTRAL };
        print.step();
        if print.mode() == Mode::Degraded {
            assert_eq!(print.output.state.cause, Some(Cause::Oscillation));
            return Some(print.now() - start_s);
        }
    }
    None
}

/// K7: wishes that are not carried out close no loop: what they swing is theirs.
#[test]
fn k7_what_is_not_carried_out_is_no_limit_cycle() {
    let mut print = Print::acting();
    print.event(Event::Operator(Operator::SetMode(Mode::Observe)));
    assert_eq!(swing_of(&mut print, 0.16, 2.0, 30.0), None);
    assert_eq!(print.mode(), Mode::Observe);
}

/// K7: five turns within 20 s, wherever the middle; neither a small swing nor a slow one nor a step is one.
#[test]
fn k7_a_limit_cycle_degrades_within_twenty_seconds() {
    // five turns after a first way are 2.75 periods, a deadband of 10 % of 2 x 16 % later, and a command of 0.24 s
    for period_s in [2.0, 4.0, 6.0] {
        let detected_s = swing(0.16, period_s, 30.0).unwrap();
        assert!(detected_s <= 3.0 * period_s + 0.3 && detected_s <= 20.0, "{period_s}: {detected_s}");
    }
    // peak to peak below the deadband; two turns in ten seconds
    assert_eq!(swing(0.045, 4.0, 60.0), None);
    assert_eq!(swing(0.16, 12.0, 60.0), None);
    let mut print = Print::acting();
    for step in 0..20 {
        print.wish.flow = 1.05 - 0.005 * f64::from(step);
        print.run(1.0);
        assert_eq!(print.mode(), Mode::Act, "one way is no swing");
    }
}
