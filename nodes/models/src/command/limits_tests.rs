use proptest::prelude::*;

use super::*;

/// Limits used by the tests of this module and its neighbours.
pub(in crate::command) fn raw() -> RawLimits {
    RawLimits {
        flow_min: 0.75,
        flow_max: 1.25,
        flow_slew_1_s: 0.6,
        speed_min: 0.7,
        speed_max: 1.15,
        speed_slew_1_s: 0.5,
        setpoint_offset_min_k: -10.0,
        setpoint_offset_max_k: 10.0,
        setpoint_offset_slew_k_s: 10.0,
        advance_max_s: 2.0,
        advance_slew_s_s: 2.0,
        slip_min: -0.05,
        slip_max: 0.5,
        slip_slew_1_s: 3.0,
        validity_max_s: 1.5,
    }
}

pub(in crate::command) fn limits() -> Limits {
    Limits::try_from(raw()).unwrap()
}

fn any_trims() -> impl Strategy<Value = Trims> {
    (-3.0..4.0, -3.0..4.0, -50.0..50.0, proptest::option::of(-1.0..5.0), proptest::option::of(-1.0..2.0))
        .prop_map(|(flow, speed, setpoint_offset_k, advance_s, slip)| Trims {
            flow,
            speed,
            setpoint_offset_k,
            advance_s,
            slip,
        })
}

fn inside(trims: &Trims) -> bool {
    limits().clamp(trims).is_ok_and(|clamped| !clamped.changed.any())
}

#[test]
fn limits_that_exclude_the_slicers_own_values_are_refused() {
    assert!(Limits::try_from(RawLimits { flow_min: 1.01, ..raw() }).is_err());
    assert!(Limits::try_from(RawLimits { setpoint_offset_max_k: -1.0, ..raw() }).is_err());
    assert!(Limits::try_from(RawLimits { speed_slew_1_s: f64::NAN, ..raw() }).is_err());
    assert!(inside(&Trims::NEUTRAL));
}

#[test]
fn a_value_that_is_not_finite_is_refused_not_clamped() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for trims in [
            Trims { flow: bad, ..Trims::NEUTRAL },
            Trims { speed: bad, ..Trims::NEUTRAL },
            Trims { setpoint_offset_k: bad, ..Trims::NEUTRAL },
            Trims { advance_s: Some(bad), ..Trims::NEUTRAL },
            Trims { slip: Some(bad), ..Trims::NEUTRAL },
        ] {
            assert_eq!(limits().clamp(&trims), Err(NotFinite));
        }
    }
}

#[test]
fn slip_starts_from_zero_and_is_set_free_at_zero() {
    let open = Trims::NEUTRAL;
    let held = Trims { slip: Some(0.09), ..open };
    // 3 per s over 10 ms: 0.03
    let first = limits().slew(&open, &held, Seconds(0.01)).trims.slip.unwrap();
    assert!((first - 0.03).abs() < 1e-12, "{first}");
    assert_eq!(limits().slew(&held, &open, Seconds(0.02)).trims.slip.map(|s| s > 0.0), Some(true));
    assert_eq!(limits().slew(&held, &open, Seconds(0.03)).trims.slip, None);
}

proptest! {
    #[test]
    fn clamped_trims_are_inside_and_clamping_again_moves_nothing(trims in any_trims()) {
        let once = limits().clamp(&trims).unwrap();
        prop_assert!(inside(&once.trims));
        prop_assert_eq!(once.changed.any(), once.trims != trims);
    }

    #[test]
    fn slewing_never_leaves_the_span_nor_exceeds_the_rate(a in any_trims(), b in any_trims(), dt in -1.0..5.0f64) {
        let (a, b) = (limits().clamp(&a).unwrap().trims, limits().clamp(&b).unwrap().trims);
        let moved = limits().slew(&a, &b, Seconds(dt)).trims;
        prop_assert!(inside(&moved));
        // one part in 1e12 for rounding
        prop_assert!((moved.flow - a.flow).abs() <= raw().flow_slew_1_s * dt.max(0.0) + 1e-12);
        prop_assert!((moved.speed - a.speed).abs() <= raw().speed_slew_1_s * dt.max(0.0) + 1e-12);
        prop_assert!((moved.flow - b.flow).abs() <= (a.flow - b.flow).abs());
    }

    #[test]
    fn slewing_arrives(a in any_trims(), b in any_trims()) {
        let (a, b) = (limits().clamp(&a).unwrap().trims, limits().clamp(&b).unwrap().trims);
        // the longest way: 20 K at 10 K/s
        let arrived = limits().slew(&a, &b, Seconds(2.0));
        prop_assert_eq!(arrived.trims, b);
        prop_assert!(!arrived.changed.any());
    }

    #[test]
    fn the_ramp_starts_at_the_trims_shrinks_and_ends_neutral(trims in any_trims(), t in 0.0..2.0f64) {
        let trims = limits().clamp(&trims).unwrap().trims;
        let within = Seconds(2.0);
        let start = trims.ramp_to_neutral(Seconds(0.0), within);
        prop_assert!((start.flow - trims.flow).abs() < 1e-15 * 4.0);
        let (now, next) = (trims.ramp_to_neutral(Seconds(t), within), trims.ramp_to_neutral(Seconds(t + 0.02), within));
        prop_assert!(inside(&now));
        prop_assert!((next.flow - 1.0).abs() <= (now.flow - 1.0).abs());
        prop_assert!(next.setpoint_offset_k.abs() <= now.setpoint_offset_k.abs());
        prop_assert_eq!(trims.ramp_to_neutral(within, within), Trims::NEUTRAL);
        prop_assert_eq!(trims.ramp_to_neutral(Seconds(f64::NAN), within), Trims::NEUTRAL);
    }
}
