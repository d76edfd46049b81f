//! Which coming moves get a law.

use super::*;
use models::motion::{MoveKind, Role, Segment, Trapezoid};

/// A line of 80 mm at 30 mm/s.
fn line() -> Segment {
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
            let trim = controller.on_coming(Seconds(1.1), 1, &line());
            assert_eq!(trim.is_some(), has_law, "{level:?} {nozzle_k} K: {trim:?}");
        }
    }
}
