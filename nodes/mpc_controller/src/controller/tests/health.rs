//! K1, K2, K3, K5: what the controller tells of its own work, and what it does meanwhile.

use super::*;
use models::command::ControlHealth;

/// A controller made of the shipped file with some lines changed.
fn rig(changes: &[(&str, &str)]) -> Rig {
    let text = changes.iter().fold(SHIPPED.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    Rig::of(made_of(&text, Level::Mpc))
}

/// Runs until this is told, and returns after how many steps of 50 ms.
fn told_after(rig: &mut Rig, health: ControlHealth, shape: impl Fn(Estimate) -> Estimate) -> Option<u32> {
    (1..=700).find(|_| {
        rig.run(1, &shape);
        rig.controller.health() == health
    })
}

fn is_back(trims: &Trims) -> bool {
    (trims.flow - 1.0).abs() < 1e-9
        && (trims.speed - 1.0).abs() < 1e-9
        && trims.setpoint_offset_k.abs() < 1e-9
}

/// A drive without any force allows no feed: the ceiling gives way, or, told not to, there is no plan.
#[test]
fn k1_without_softening_an_impossible_ceiling_holds_a_cycle_and_goes_back() {
    let weak = ("force_margin: 0.8 ", "force_margin: 0.01 ");
    let mut rig = self::rig(&[weak]);
    assert_eq!(told_after(&mut rig, ControlHealth::Infeasible, |estimate| estimate), None);
    assert!(rig.controller.report().softened > 0);
    let mut rig = self::rig(&[weak, ("soften: true ", "soften: false ")]);
    // the second tick: one cycle after the first
    assert_eq!(told_after(&mut rig, ControlHealth::Infeasible, |estimate| estimate), Some(10));
}

/// One iteration is never enough: three cycles, then back to the slicer's values.
#[test]
fn k2_a_solver_that_is_cut_short_is_told_in_three_cycles() {
    let mut rig = self::rig(&[("guesses: 12 ", "guesses: 0 "), ("iterations: 60 ", "iterations: 1 ")]);
    assert_eq!(told_after(&mut rig, ControlHealth::Late, |estimate| estimate), Some(15));
    let sent = rig.run(100, |estimate| Estimate { gain: 1.1, ..estimate });
    assert!(is_back(sent.last().unwrap()), "{:?}", sent.last());
}

/// An estimate whose numbers are finite, and whose plan is not.
#[test]
fn k3_a_plan_that_is_not_finite_is_told_by_the_next_command_and_heals() {
    let mut rig = Rig::new(Level::Mpc);
    rig.run(99, |estimate| Estimate { gain: 1.1, ..estimate });
    assert!(rig.controller.held[FEED] < -0.01);
    assert_eq!(rig.controller.health(), ControlHealth::Sound);
    let told =
        told_after(&mut rig, ControlHealth::NotFinite, |estimate| Estimate { gain: f64::MAX, ..estimate });
    // the next tick
    assert!(told.is_some_and(|steps| steps <= 5), "{told:?}");
    let sent = rig.run(60, |estimate| Estimate { gain: f64::MAX, ..estimate });
    assert!(sent.iter().all(Trims::is_finite) && is_back(sent.last().unwrap()));
    rig.run(5, |estimate| estimate);
    assert_eq!(rig.controller.health(), ControlHealth::Sound);
}

/// A heater that gives all it can: told in 30 s, and the set-point does not wind up meanwhile.
#[test]
fn k5_a_saturated_heater_is_told_and_nothing_winds_up() {
    let cold = |estimate: Estimate| Estimate { nozzle: Kelvin(NOZZLE_K - 15.0), ..estimate };
    let mut rig = Rig::new(Level::Mpc);
    rig.duty = 1.0;
    let told = told_after(&mut rig, ControlHealth::Saturated, cold);
    assert!(told.is_some_and(|steps| (520..=600).contains(&steps)), "{told:?}: 26 to 30 s");
    assert!(rig.controller.held[SETPOINT].abs() < 1e-9, "{:?}", rig.controller.held);
    rig.duty = 0.5;
    rig.run(60, cold);
    assert!(rig.controller.held[SETPOINT] > 1.0, "with room the set-point is raised");
    assert_eq!(rig.controller.health(), ControlHealth::Sound);
}

/// A move at its end for long is told, and leaves it within a cycle once there is no more reason.
#[test]
fn k5_a_move_at_its_end_is_told_and_comes_back_at_once() {
    let wide = |estimate: Estimate| Estimate { gain: 1.8, ..estimate };
    let mut rig = Rig::new(Level::Mpc);
    let told = told_after(&mut rig, ControlHealth::Saturated, wide);
    assert!(told.is_some_and(|steps| steps <= 640), "{told:?}: 28 s and the way there");
    let at_end = rig.controller.held;
    rig.run(10, |estimate| estimate);
    assert!(rig.controller.held[SPEED] < at_end[SPEED] - 0.02, "{at_end:?} {:?}", rig.controller.held);
}
