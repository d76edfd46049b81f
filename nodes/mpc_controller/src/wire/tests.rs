use super::*;
use models::wire::{RawLaw, RawLimits};
use proptest::prelude::*;

pub(super) const PARAMS: RawParams =
    RawParams { mode: Mode::Both, cell_m: 1.5e-3, valid_s: 200.0, error_max_m: 5e-3 };

pub(super) fn law(gain: f64) -> Law {
    Law::try_from(RawLaw {
        height_m: 2.16e-3,
        wire_m_s: 3.5e-3,
        head_m_s: 1.68e-3,
        gain,
        split: 2.0 / 3.0,
        ratio_low: 0.2,
        ratio_high: 1.8,
    })
    .unwrap()
}

pub(super) fn limits() -> Limits {
    let raw =
        RawLimits { wire_low_m_s: 5e-4, wire_high_m_s: 5.4e-3, head_low_m_s: 5e-4, head_high_m_s: 0.01 };
    Limits::try_from(raw).unwrap()
}

fn controller() -> HeightController {
    HeightController::new(Params::try_from(PARAMS).unwrap(), law(0.635), limits()).unwrap()
}

fn measured(layer: u32, height_m: f64) -> Measured {
    Measured { stamp: Seconds(10.0), layer, position_m: 0.02, height_m }
}

/// A quarter of a millimetre too low: r = 1 + 0.635 * 0.25 / 2.16 = 1.0735, wire 3.650 and head 1.632 mm/s.
#[test]
fn a_dip_in_layer_k_is_filled_by_layer_k_plus_1_alone() {
    let mut controller = controller();
    controller.on_height(measured(3, 3.0 * 2.16e-3 - 0.25e-3)).unwrap();
    let Answer::Correct(trims) = controller.answer(Seconds(60.0), 4, 0.0201) else { panic!() };
    assert!((trims.wire * 3.5 - 3.650).abs() < 1e-3 && (trims.head * 1.68 - 1.632).abs() < 1e-3, "{trims:?}");
    assert!((trims.trims().flow - 1.0735).abs() < 1e-4);
    for (layer, position_m) in [(3, 0.02), (5, 0.02), (4, 0.05)] {
        assert_eq!(controller.answer(Seconds(60.0), layer, position_m), Answer::Unmeasured);
    }
}

#[test]
fn an_old_measurement_is_neutral() {
    let mut controller = controller();
    controller.on_height(measured(1, 2e-3)).unwrap();
    let answer = controller.answer(Seconds(211.0), 2, 0.02);
    assert_eq!(answer, Answer::Stale);
    assert_eq!(answer.trims(), WireTrims::NEUTRAL);
}

#[test]
fn samples_of_a_cell_are_averaged() {
    let mut controller = controller();
    for noise_m in [-2e-4, 2e-4] {
        controller.on_height(measured(1, 2.16e-3 + noise_m)).unwrap();
    }
    let trims = controller.answer(Seconds(11.0), 2, 0.02).trims();
    assert!((trims.wire - 1.0).abs() < 1e-12 && (trims.head - 1.0).abs() < 1e-12);
}

#[test]
fn what_is_no_measurement_is_refused_and_counted() {
    let mut controller = controller();
    assert_eq!(controller.on_height(measured(1, f64::NAN)), Err(Refused::NotFinite));
    assert_eq!(controller.on_height(measured(1, 0.1)), Err(Refused::OutOfRange));
    assert_eq!(controller.on_height(measured(0, 0.0)), Err(Refused::OldLayer));
    controller.on_height(measured(2, 4.3e-3)).unwrap();
    assert_eq!(controller.on_height(measured(1, 2.1e-3)), Err(Refused::OldLayer));
    assert_eq!(controller.refusals(), Refusals { not_finite: 1, out_of_range: 1, old_layer: 2 });
}

#[test]
fn a_gain_that_makes_the_error_grow_is_refused() {
    let params = Params::try_from(PARAMS).unwrap();
    for gain in [0.0, 2.0, 2.5] {
        let error = HeightController::new(params, law(gain), limits()).unwrap_err();
        assert!(error.to_string().starts_with(&format!("gain = {gain} (no unit): must be")), "{error}");
    }
}

proptest! {
    #[test]
    fn trims_stay_within_the_limits(error_m in -5e-3..5e-3_f64) {
        let mut controller = controller();
        controller.on_height(measured(1, 2.16e-3 + error_m)).unwrap();
        let trims = controller.answer(Seconds(11.0), 2, 0.02).trims();
        prop_assert!((5e-4..=5.4e-3 + 1e-15).contains(&(trims.wire * 3.5e-3)), "{trims:?}");
        prop_assert!((5e-4 - 1e-15..=0.01 + 1e-15).contains(&(trims.head * 1.68e-3)), "{trims:?}");
    }
}
