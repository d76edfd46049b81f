//! Laws of the whole predictor. The networks are the committed ones.

use super::*;
use crate::compensation::tests::{params, shipped, text};
use models::motion::{Role, Trapezoid};

fn predictor() -> AdvancePredictor {
    let params = params();
    let network = TurnNetwork::parse(&text("models/turn.json")).unwrap();
    AdvancePredictor::new(params.clone(), shipped(params.drive), network)
}

/// A set-point, all at one time.
fn target(celsius: f64) -> Event {
    Event::Target(Seconds(1.0), Celsius(celsius))
}

fn road(start_mm: [f64; 2], end_mm: [f64; 2], width_mm: f64) -> Event {
    let length_m = 1e-3 * (end_mm[0] - start_mm[0]).hypot(end_mm[1] - start_mm[1]);
    Event::Move(Segment {
        line: 1,
        layer: Some(0),
        start_m: [1e-3 * start_mm[0], 1e-3 * start_mm[1], 2e-4],
        end_m: [1e-3 * end_mm[0], 1e-3 * end_mm[1], 2e-4],
        length_m,
        filament_m: 0.03 * length_m,
        kind: MoveKind::Deposit,
        role: Role::ExternalPerimeter,
        arc: false,
        target_width_m: Some(1e-3 * width_mm),
        stated_width_m: None,
        layer_height_m: Some(2e-4),
        profile: Trapezoid::new(length_m, (0.05, 0.05), 0.05, 0.5),
    })
}

/// 0.45 mm wide and 0.2 mm high the stadium is as large as a rectangle of 0.45 - 0.2 (1 - pi/4) = 0.4071 mm.
#[test]
fn the_answer_is_for_the_roads_cross_section() {
    let mut predictor = predictor();
    assert!(predictor.on_event(target(215.0)).is_none());
    let output = predictor.on_event(road([0.0, 0.0], [10.0, 0.0], 0.45)).unwrap();
    let advance = output.advance.unwrap();
    assert!((advance.at.width_m - 4.070_796e-4).abs() < 1e-9, "{advance:?}");
    // Model book 2.4: 0.635 s at 0.4 mm, less for wider roads.
    assert!((0.60..0.64).contains(&advance.prediction.advance.0), "{advance:?}");
    assert!(output.turn.is_some());
}

/// A road at one speed from rest, 25 mm/s: the lag is the chord of the static law from 0 to there, which is longer than the test
/// line's secant from 20 to 80 mm/s. K and its interval grow alike; roads as slow as 2 mm/s stop at the bound.
#[test]
fn the_answer_follows_the_speeds_that_are_printed() {
    let advance = |speed_m_s: f64| {
        let mut predictor = predictor();
        _ = predictor.on_event(target(215.0));
        let Event::Move(road) = road([0.0, 0.0], [10.0, 0.0], 0.45) else { panic!("a road is a move") };
        let profile = Trapezoid::new(road.length_m, (speed_m_s, speed_m_s), speed_m_s, 0.5);
        let said = predictor.on_event(Event::Move(Segment { profile, ..road })).unwrap().advance.unwrap();
        let (law, per_way) = predictor.compensation.static_law("PLA", &said.at).unwrap();
        let outlet_m_s = per_way * speed_m_s;
        let line_s = predictor.compensation.secant_s("PLA", &said.at).unwrap();
        (said, law.compression_m(outlet_m_s) / outlet_m_s / line_s)
    };
    for speed_m_s in [0.025, 0.05, 0.08] {
        let (said, chord) = advance(speed_m_s);
        assert!(chord > 1.05 && (said.speeds - chord).abs() < 1e-9, "{chord} {said:?}");
        assert!((said.advance().0 / said.prediction.advance.0 - chord).abs() < 1e-9, "{said:?}");
        assert!((said.half_width().0 / said.prediction.half_width.0 - chord).abs() < 1e-9, "{said:?}");
    }
    let (slow, chord) = advance(0.002);
    assert!(chord > 1.6 && (slow.speeds - 1.6).abs() < 1e-12, "{chord} {slow:?}");
}

/// A set-point that changes is told at once; one that stays, or a heater that is off, is not answered for.
#[test]
fn a_changed_set_point_is_told_and_an_equal_one_is_not() {
    let mut predictor = predictor();
    _ = predictor.on_event(target(215.0));
    let warm = predictor.on_event(road([0.0, 0.0], [10.0, 0.0], 0.45)).unwrap();
    assert!(predictor.on_event(target(215.2)).is_none());
    let hot = predictor.on_event(target(225.0)).unwrap();
    assert!(hot.advance.unwrap().prediction.advance < warm.advance.unwrap().prediction.advance);
    let off = predictor.on_event(target(0.0)).unwrap();
    assert!(off.advance.is_none());
    assert_eq!(predictor.counts().unanswered, 0);
}

/// A road 4 mm wide lies out of bounds: no answer, counted, with the reason.
#[test]
fn conditions_out_of_bounds_are_counted() {
    let mut predictor = predictor();
    _ = predictor.on_event(target(215.0));
    let output = predictor.on_event(road([0.0, 0.0], [10.0, 0.0], 4.0)).unwrap();
    assert!(output.advance.is_none());
    assert_eq!(predictor.counts().unanswered, 1);
    assert!(matches!(predictor.refused(), Some(Unanswered::Bounds { field: "line width", .. })));
}

/// The second layer of a square in pieces of half a millimetre: behind each piece the memory knows the corners.
#[test]
fn a_repeated_square_is_foreseen_without_any_buffer() {
    let mut predictor = predictor();
    _ = predictor.on_event(target(215.0));
    let corners = [[0.0, 0.0], [20.0, 0.0], [20.0, 20.0], [0.0, 20.0], [0.0, 0.0]];
    let (mut right, mut all) = (0, 0);
    for layer in 0..4 {
        for pair in corners.windows(2) {
            let at = |step: i32| {
                [0, 1].map(|axis| pair[0][axis] + (pair[1][axis] - pair[0][axis]) * f64::from(step) / 40.0)
            };
            for step in 0..40 {
                let output = predictor.on_event(road(at(step), at(step + 1), 0.45)).unwrap();
                // The horizon is 100 ms at 50 mm/s, 5 mm: 10 pieces; the two at its edge may fall either way.
                let left = 40 - step;
                if layer == 3 && !(9..=12).contains(&left) {
                    all += 1;
                    right += i32::from(output.expected == (left <= 10));
                }
            }
        }
    }
    assert!(all == 144 && right >= 137, "{right} of {all}");
}

/// A road of 180 mm takes seconds in which no move begins: its word is said again each second, the turn nearer by as much.
#[test]
fn a_word_is_said_again_while_a_road_lasts() {
    let mut predictor = predictor();
    let at = |time_s| Event::Target(Seconds(time_s), Celsius(215.0));
    assert!(predictor.on_event(at(10.0)).is_none(), "nothing is known yet");
    let said = predictor.on_event(road([0.0, 0.0], [180.0, 0.0], 0.45)).unwrap();
    assert!(predictor.on_event(at(10.02)).is_none());
    assert!(predictor.on_event(at(10.98)).is_none());
    let again = predictor.on_event(at(11.02)).unwrap();
    assert_eq!(again.advance, said.advance);
    let [first, second] = [said, again].map(|output| output.turn.unwrap().lead.0);
    assert!((first - second - 1.0).abs() < 1e-9, "{first} {second}");
    assert!(predictor.on_event(at(11.04)).is_none());
    // Time that jumps back is no reason to be silent.
    assert!(predictor.on_event(at(3.0)).is_some());
}

/// A move over a way without a speed never arrives: it is no part of the path. The sound one takes 0.2 s.
#[test]
fn a_move_without_speed_foretells_nothing() {
    let mut predictor = predictor();
    _ = predictor.on_event(target(215.0));
    let Event::Move(still) = road([0.0, 0.0], [10.0, 0.0], 0.45) else { panic!("a road is a move") };
    let profile = Trapezoid { entry_m_s: 0.0, cruise_m_s: 0.0, exit_m_s: 0.0, ..still.profile };
    for segment in [Segment { profile, ..still }, still, Segment { profile, ..still }] {
        _ = predictor.on_event(Event::Move(segment));
        for time_s in [5.0, 7.0, 9.0] {
            let said = predictor.on_event(Event::Target(Seconds(time_s), Celsius(215.0))).unwrap();
            assert!(
                said.turn.is_none_or(|turn| turn.lead.0.is_finite() && turn.way_m.is_finite()),
                "{said:?}"
            );
        }
    }
}
