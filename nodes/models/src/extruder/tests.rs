//! Also the extruder of other modules' tests.

use super::*;
use crate::material::tests::pla;
use crate::melt::Melt;
use crate::units::{Kelvin, Seconds};
use proptest::prelude::*;

pub(crate) fn bowden() -> Extruder {
    Extruder::try_from(RawExtruder {
        compliance_m_n: 6.2e-5,
        linear_lag_s: 0.436,
        force_max_n: 80.0,
        melting_flow_m3_s: 2.5e-8,
        nozzle_radius_m: 2e-4,
        nozzle_length_m: 4.5e-3,
        filament_diameter_m: 1.75e-3,
        rabinowitsch: false,
    })
    .unwrap()
}

fn law(temp_k: f64, clog: f64) -> StaticLaw {
    StaticLaw::new(&Melt::new(&pla(), &bowden()), &bowden(), Kelvin(temp_k), clog)
}

/// Model book 1.3: at u = 2 mm/s the lag n c F/u + K_lin is about 0.61 s.
#[test]
fn the_local_lag_is_the_model_books() {
    assert!((law(483.15, 1.0).lag_s(2e-3) - 0.61).abs() < 0.005);
}

#[test]
fn a_scaled_law_holds_so_much_more_at_every_speed_by_the_same_force() {
    let (law, more) = (law(483.15, 1.0), law(483.15, 1.0).scaled(1.25));
    for outlet_m_s in [1e-4, 7e-4, 2e-3] {
        assert!((more.compression_m(outlet_m_s) / law.compression_m(outlet_m_s) - 1.25).abs() < 1e-12);
        assert!((more.lag_s(outlet_m_s) / law.lag_s(outlet_m_s) - 1.25).abs() < 1e-12);
        assert!((more.force_n(outlet_m_s) - law.force_n(outlet_m_s)).abs() < 1e-12);
    }
}

#[test]
fn a_clog_raises_the_force_and_leaves_the_steady_flow() {
    let (free, clogged) = (law(483.15, 1.0), law(483.15, 0.4));
    let mut pressure = Pressure::steady(&free, 2e-3);
    let before_n = pressure.outlet().force_n;
    for _ in 0..30_000 {
        pressure.step(&clogged, 2e-3, Seconds(1e-3));
    }
    // 30 s are more than 30 lags.
    assert!((pressure.outlet().speed_m_s / 2e-3 - 1.0).abs() < 1e-9);
    assert!((pressure.outlet().force_n / before_n - 1.0 / 0.4).abs() < 1e-9);
}

#[test]
fn a_retracted_filament_does_not_flow_until_the_length_is_back() {
    let law = law(483.15, 1.0);
    let mut pressure = Pressure::steady(&law, 2e-3);
    let stroke_m = pressure.compression_m() + 1e-3;
    let laid_m: f64 = (0..100).map(|_| pressure.step(&law, -stroke_m / 0.1, Seconds(1e-3))).sum();
    assert!(pressure.compression_m() < 0.0);
    assert!(pressure.outlet().speed_m_s.abs() < f64::EPSILON);
    // What is missing of the 1 mm is what oozed during the stroke.
    assert!((pressure.compression_m() + 1e-3 + laid_m).abs() < 1e-12);
    let laid_m = pressure.step(&law, 0.5e-3 / 1e-3, Seconds(1e-3));
    assert!(laid_m.abs() < f64::EPSILON);
}

/// A step of the melt temperature changes the law under the same compression: more flow, at once.
#[test]
fn a_hotter_melt_flows_faster_at_the_same_compression() {
    let mut cold = Pressure::steady(&law(473.15, 1.0), 2e-3);
    let mut hot = cold;
    let laid_cold = cold.step(&law(473.15, 1.0), 2e-3, Seconds(1e-3));
    let laid_hot = hot.step(&law(493.15, 1.0), 2e-3, Seconds(1e-3));
    assert!(laid_hot > 1.05 * laid_cold);
}

/// Second order in the step: 1 ms against 0.1 ms over a 60 ms ramp and its tail agrees to 1e-4 of the speed.
#[test]
fn a_step_of_one_millisecond_is_fine_enough() {
    let law = law(483.15, 1.0);
    let run = |steps_per_ms: u32| {
        let mut pressure = Pressure::steady(&law, 6e-4);
        let dt_s = 1e-3 / f64::from(steps_per_ms);
        for k in 0..(200 * steps_per_ms) {
            let t_s = (f64::from(k) + 0.5) * dt_s;
            let feed_m_s = 6e-4 + 1.8e-3 * (t_s / 0.06).min(1.0);
            pressure.step(&law, feed_m_s, Seconds(dt_s));
        }
        pressure.outlet().speed_m_s
    };
    assert!((run(1) / run(10) - 1.0).abs() < 1e-4);
}

#[test]
fn slip_is_the_sum_of_its_parts_up_to_the_cap() {
    let slip = SlipParams::try_from(RawSlip {
        base: 0.01,
        creep: 0.02,
        creep_force_n: 40.0,
        overload: 0.5,
        overload_force_n: 10.0,
        cap: 0.95,
    })
    .unwrap();
    assert!((slip.slip(20.0, 80.0, 0.09) - (0.01 + 0.09 + 0.005)).abs() < 1e-12);
    assert!((slip.slip(82.0, 80.0, 0.0) - (0.01 + 0.02 * 4.2025 + 0.1)).abs() < 1e-12);
    assert!((slip.slip(200.0, 80.0, 0.0) - 0.95).abs() < 1e-12);
}

/// Stationary: the variance that decays is the variance that is added.
#[test]
fn the_filaments_diameter_keeps_its_spread() {
    let filament = Filament::try_from(RawFilament {
        diameter_m: 1.75e-3,
        diameter_sigma_m: 2e-5,
        correlation_length_m: 2.0,
    })
    .unwrap();
    let kept = filament.deviation_after_m(1.0, 0.3, 0.0);
    let added = filament.deviation_after_m(0.0, 0.3, 1.0);
    assert!(((kept * 2e-5).powi(2) + added.powi(2) - 4e-10).abs() < 1e-18);
    assert!((kept - (-0.15_f64).exp()).abs() < 1e-12);
}

proptest! {
    #[test]
    fn the_outlet_is_the_inverse_of_the_law_from_any_start(
        speed_mm_s in 1e-6..50.0_f64, warm_mm_s in 1e-6..50.0_f64, temp_k in 440.0..520.0_f64, clog in 0.05..1.0_f64,
    ) {
        let law = law(temp_k, clog);
        let warm = law.outlet(law.compression_m(warm_mm_s * 1e-3), Outlet::STILL);
        let found = law.outlet(law.compression_m(speed_mm_s * 1e-3), warm);
        prop_assert!((found.speed_m_s / (speed_mm_s * 1e-3) - 1.0).abs() < 1e-9);
        prop_assert!((found.force_n / law.force_n(speed_mm_s * 1e-3) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_outlet_never_falls_with_compression(x_mm in 0.0..10.0_f64, more_mm in 0.0..1.0_f64) {
        let law = law(483.15, 1.0);
        let less = law.outlet(x_mm * 1e-3, Outlet::STILL).speed_m_s;
        prop_assert!(law.outlet((x_mm + more_mm) * 1e-3, Outlet::STILL).speed_m_s >= less * (1.0 - 1e-12));
    }

    #[test]
    fn filament_in_is_filament_out_plus_what_is_compressed(
        feeds_mm_s in prop::collection::vec(-40.0..60.0_f64, 1..200), dt_ms in 0.1..50.0_f64,
    ) {
        let law = law(483.15, 1.0);
        let mut pressure = Pressure::steady(&law, 2e-3);
        let start_m = pressure.compression_m();
        let (mut fed_m, mut laid_m) = (0.0, 0.0);
        for feed in feeds_mm_s {
            fed_m += feed * 1e-3 * dt_ms * 1e-3;
            let laid = pressure.step(&law, feed * 1e-3, Seconds(dt_ms * 1e-3));
            prop_assert!(laid >= 0.0 && pressure.outlet().speed_m_s.is_finite());
            laid_m += laid;
        }
        prop_assert!((start_m + fed_m - laid_m - pressure.compression_m()).abs() < 1e-12);
    }

    #[test]
    fn the_linear_lag_does_not_depend_on_the_step(
        outlet in 0.0..5e-3_f64, feed in 0.0..5e-3_f64, dt_s in 1e-3..2.0_f64,
    ) {
        let lag = LinearLag { lag_s: 0.63 };
        let halved = lag.step(lag.step(outlet, feed, Seconds(dt_s / 2.0)), feed, Seconds(dt_s / 2.0));
        prop_assert!((lag.step(outlet, feed, Seconds(dt_s)) - halved).abs() < 1e-15);
        // K (u+ - u) = (v - mean) dt: what is stored is what did not leave.
        let stored = 0.63 * (lag.step(outlet, feed, Seconds(dt_s)) - outlet);
        prop_assert!((stored - (feed - lag.mean(outlet, feed, Seconds(dt_s))) * dt_s).abs() < 1e-15);
        let middle = 0.5 * (outlet + feed);
        let first = lag.step_ramp(outlet, (outlet, middle), Seconds(dt_s / 2.0));
        let ramp = lag.step_ramp(first, (middle, feed), Seconds(dt_s / 2.0));
        prop_assert!((lag.step_ramp(outlet, (outlet, feed), Seconds(dt_s)) - ramp).abs() < 1e-15);
    }
}
