//! Which coming moves get a law.

use super::*;
use crate::advance::Advance;
use crate::advance::learning::tests::taught;
use crate::params::{AdvanceSource, RawAdvance};
use models::motion::{MoveKind, Role, Segment, Trapezoid};

/// A line of 80 mm at 30 mm/s.
pub(super) fn line() -> Segment {
    Segment {
        line: 1,
        layer: Some(0),
        start_m: [0.0; 3],
        end_m: [0.08, 0.0, 0.0],
        length_m: 0.08,
        filament_m: 2.6e-3,
        kind: MoveKind::Deposit,
        role: Role::Unknown,
        arc: false,
        target_width_m: Some(4.5e-4),
        stated_width_m: None,
        layer_height_m: Some(2e-4),
        profile: Trapezoid::new(0.08, (0.0, 0.0), 0.03, 0.5),
    }
}

/// The same as a host tells it.
pub(super) fn coming(segment: Segment) -> Coming {
    Coming { sequence: 1, start: Seconds(0.0), segment }
}

/// PLA is laid at block temperatures of 187 degC (460 K) and more: 446.6 K in a nozzle with full fan at the flow of the
/// reference. A law of a colder melt would be held to `law_high_s`, and nothing of it would be true once the nozzle is warm.
#[test]
fn a_nozzle_too_cold_to_lay_anything_has_no_law() {
    for level in [Level::Encoder, Level::Mpc] {
        for (nozzle_k, has_law) in
            [(298.15, false), (400.0, false), (445.0, false), (450.0, true), (NOZZLE_K, true)]
        {
            let mut controller = controller(level);
            controller.on_event(Event::Estimate(Estimate { nozzle: Kelvin(nozzle_k), ..estimate(1.0) }));
            let trim = controller.on_coming(Seconds(1.1), &coming(line()));
            assert_eq!(trim.is_some(), has_law, "{level:?} {nozzle_k} K: {trim:?}");
        }
    }
}

/// What the force does not suffice for is planned slower, by as much as it lacks and no more than a speed trim may: 80 mm of
/// 2.6 mm filament want 0.975 mm/s at 30 mm/s, and as many times more at as many times the speed.
#[test]
fn a_move_beyond_the_drives_force_is_planned_slower() {
    let mut controller = controller(Level::Mpc);
    controller.on_event(Event::Estimate(estimate(1.0)));
    let most_m_s = controller.feed_max_m_s(&estimate(1.0));
    let speed_for = |times: f64| times * most_m_s / (2.6e-3 / 0.08);
    for (times, pace) in [(0.5, 1.0), (0.99, 1.0), (1.25, 0.8), (3.0, 0.7)] {
        let profile = Trapezoid::new(0.08, (0.0, 0.0), speed_for(times), 1e3);
        let trim = controller.on_coming(Seconds(1.1), &coming(Segment { profile, ..line() })).unwrap();
        assert!((trim.speed - pace).abs() < 1e-9, "{times} of what the force allows: {trim:?}");
    }
}

/// Who corrects nothing slows nothing, and a plan that is too old says nothing.
#[test]
fn only_the_plan_slows() {
    let profile = Trapezoid::new(0.08, (0.0, 0.0), 1.0, 1e4);
    let mut encoder = controller(Level::Encoder);
    encoder.on_event(Event::Estimate(estimate(1.0)));
    let trim = encoder.on_coming(Seconds(1.1), &coming(Segment { profile, ..line() })).unwrap();
    assert!((trim.speed - 1.0).abs() < 1e-15, "{trim:?}");
    let mut plan = controller(Level::Mpc);
    plan.on_event(Event::Estimate(estimate(1.0)));
    assert_eq!(plan.on_coming(Seconds(2.0), &coming(Segment { profile, ..line() })), None);
}

/// A melt that is known to run stiffer leaves the drive less force for the same feed: a move is planned as much slower.
#[test]
fn a_move_through_a_stiffer_melt_is_planned_slower() {
    let mut controller = controller(Level::Mpc);
    controller.on_event(Event::Estimate(estimate(1.0)));
    let most_m_s = controller.feed_max_m_s(&estimate(1.0));
    let profile = Trapezoid::new(0.08, (0.0, 0.0), most_m_s / (2.6e-3 / 0.08), 1e3);
    let mut pace =
        || controller.on_coming(Seconds(1.1), &coming(Segment { profile, ..line() })).unwrap().speed;
    assert!((pace() - 1.0).abs() < 1e-9, "{}", pace());
    controller.advance = taught(AdvanceSource::Planned, Level::Mpc).0;
    let speed = controller.on_coming(Seconds(1.1), &coming(Segment { profile, ..line() })).unwrap().speed;
    assert!((0.7..0.97).contains(&speed), "{speed}");
}

/// No law that is sent is higher than `law_high_s` at the feed at which the supervisor looks: its shape stays, and is scaled.
#[test]
fn a_law_that_is_too_high_is_sent_scaled() {
    let mut controller = controller(Level::Mpc);
    controller.on_event(Event::Estimate(estimate(1.0)));
    let mut sent = |high_of: &dyn Fn(f64) -> f64| {
        let settings = controller.params.advance;
        let whole = controller.on_coming(Seconds(1.1), &coming(line())).unwrap().advance;
        let high_s = high_of(whole.advance_s(settings.law_feed_m_s));
        controller.advance = Advance::new(RawAdvance { law_high_s: high_s, ..settings }, Level::Mpc);
        let law = controller.on_coming(Seconds(1.1), &coming(line())).unwrap().advance;
        (whole, law, law.advance_s(settings.law_feed_m_s) / high_s)
    };
    let (whole, law, of_most) = sent(&|advance_s| 0.5 * advance_s);
    assert!(
        (of_most - 1.0).abs() < 1e-9 && (law.linear_s / whole.linear_s - 0.5).abs() < 1e-9,
        "{law:?} {whole:?}"
    );
    let (whole, law, _) = sent(&|advance_s| 4.0 * advance_s);
    assert!((law.linear_s / whole.linear_s - 2.0).abs() < 1e-9, "as it was before it was bounded: {law:?}");
}
