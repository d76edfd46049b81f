//! Also the hot end of other modules' tests.

use super::*;
use proptest::prelude::*;

pub(crate) fn ender3() -> Hotend {
    Hotend::try_from(RawHotend {
        block_capacity_j_k: 14.5,
        nozzle_capacity_j_k: 2.2,
        coupling_w_k: 0.45,
        block_loss_w_k: 0.058,
        nozzle_loss_w_k: 0.010,
        block_loss_fan_w_k: 0.009,
        nozzle_loss_fan_w_k: 0.020,
        heater_power_w: 40.0,
        sensor_lag_s: 1.0 / 0.22,
    })
    .unwrap()
}

fn inputs(heater_w: f64, fan: f64, melt_w_k: f64) -> Inputs {
    Inputs { heater_w, fan, ambient_k: 298.15, filament_k: 298.15, melt_w_k }
}

/// Model book 1.3: 12.8 W idle, 15.1 W at 4.8 mm3/s, 21.0 W with the fan as well, at 210 degC.
#[test]
fn steady_power_is_the_model_books() {
    let printing_w_k = 1240.0 * 4.8e-9 * 1800.0;
    for (fan, melt_w_k, power_w) in [(0.0, 0.0, 12.8), (0.0, printing_w_k, 15.1), (1.0, printing_w_k, 21.0)] {
        let steady = ender3().steady(483.15, &inputs(0.0, fan, melt_w_k));
        assert!((steady.heater_w - power_w).abs() < 0.05, "{} W", steady.heater_w);
    }
}

/// Against a classic Runge-Kutta of 1 ms, whose error here is (1 ms * 0.25 1/s)^4 * 100 K, far below 1e-9 K.
#[test]
fn a_step_is_the_exact_solution() {
    let hotend = ender3();
    let acting = inputs(31.0, 0.7, 0.012);
    let start = Thermal { block_k: 480.0, nozzle_k: 430.0, sensor_k: 410.0 };
    let mut fine = start;
    let add = |a: Thermal, b: Thermal, s: f64| Thermal {
        block_k: a.block_k + s * b.block_k,
        nozzle_k: a.nozzle_k + s * b.nozzle_k,
        sensor_k: a.sensor_k + s * b.sensor_k,
    };
    for _ in 0..20_000 {
        let k1 = hotend.rhs(fine, &acting);
        let k2 = hotend.rhs(add(fine, k1, 5e-4), &acting);
        let k3 = hotend.rhs(add(fine, k2, 5e-4), &acting);
        let k4 = hotend.rhs(add(fine, k3, 1e-3), &acting);
        fine = add(add(add(add(fine, k1, 1e-3 / 6.0), k2, 1e-3 / 3.0), k3, 1e-3 / 3.0), k4, 1e-3 / 6.0);
    }
    let exact = hotend.step(start, &acting, Seconds(20.0));
    assert!((exact.block_k - fine.block_k).abs() < 1e-8);
    assert!((exact.nozzle_k - fine.nozzle_k).abs() < 1e-8);
    assert!((exact.sensor_k - fine.sensor_k).abs() < 1e-8);
}

#[test]
fn the_followed_mode_is_smooth_through_resonance() {
    // At rate = 1/lag the answer is (t/lag) e^(-t/lag).
    let resonant = followed(0.22, 1.0 / 0.22, 3.0);
    assert!((resonant - 0.66 * (-0.66_f64).exp()).abs() < 1e-12);
    assert!((followed(0.22 * (1.0 + 1e-7), 1.0 / 0.22, 3.0) - resonant).abs() < 1e-6);
}

proptest! {
    #[test]
    fn the_energy_balance_closes_at_the_steady_state(
        nozzle_k in 420.0..540.0_f64, fan in 0.0..1.0_f64, melt_w_k in 0.0..0.05_f64,
    ) {
        let hotend = ender3();
        let mut acting = inputs(0.0, fan, melt_w_k);
        let steady = hotend.steady(nozzle_k, &acting);
        acting.heater_w = steady.heater_w;
        let at = Thermal { block_k: steady.block_k, nozzle_k, sensor_k: steady.block_k };
        // Power in is power out: block to air, nozzle to air, melt.
        let out_w = (0.058 + 0.009 * fan) * (steady.block_k - 298.15)
            + (0.010 + 0.020 * fan + melt_w_k) * (nozzle_k - 298.15);
        prop_assert!((steady.heater_w - out_w).abs() < 1e-9);
        let rates = hotend.rhs(at, &acting);
        prop_assert!(rates.block_k.abs() < 1e-9 && rates.nozzle_k.abs() < 1e-9);
        let settled = hotend.equilibrium(&acting);
        prop_assert!((settled.nozzle_k - nozzle_k).abs() < 1e-8);
        prop_assert!((settled.block_k - steady.block_k).abs() < 1e-8);
    }

    #[test]
    fn more_flow_cools_the_nozzle(
        melt_w_k in 0.0..0.05_f64, more in 1e-4..0.05_f64, heater_w in 5.0..40.0_f64, fan in 0.0..1.0_f64,
    ) {
        let hotend = ender3();
        let less_k = hotend.equilibrium(&inputs(heater_w, fan, melt_w_k)).nozzle_k;
        let more_k = hotend.equilibrium(&inputs(heater_w, fan, melt_w_k + more)).nozzle_k;
        prop_assert!(more_k < less_k);
    }

    #[test]
    fn the_step_size_does_not_matter(
        heater_w in 0.0..40.0_f64, block_k in 300.0..550.0_f64, nozzle_k in 300.0..550.0_f64, melt_w_k in 0.0..0.05_f64,
    ) {
        let hotend = ender3();
        let acting = inputs(heater_w, 0.5, melt_w_k);
        let start = Thermal { block_k, nozzle_k, sensor_k: block_k };
        let once = hotend.step(start, &acting, Seconds(5.0));
        let often = (0..100).fold(start, |at, _| hotend.step(at, &acting, Seconds(0.05)));
        prop_assert!((once.block_k - often.block_k).abs() < 1e-8);
        prop_assert!((once.nozzle_k - often.nozzle_k).abs() < 1e-8);
        prop_assert!((once.sensor_k - often.sensor_k).abs() < 1e-8);
    }
}
