use super::*;
use crate::ukf::{Gaussian, Health, Measurement, Spread, Ukf, Update};
use models::hotend::RawHotend;
use models::material::RawMaterial;
use nalgebra::{Matrix1, SMatrix, Vector1};

pub(crate) fn nominal_hotend() -> Hotend {
    Hotend::try_from(RawHotend {
        block_capacity_j_k: 14.5,
        nozzle_capacity_j_k: 2.2,
        coupling_w_k: 0.45,
        block_loss_w_k: 0.058,
        nozzle_loss_w_k: 0.01,
        block_loss_fan_w_k: 0.009,
        nozzle_loss_fan_w_k: 0.02,
        heater_power_w: 40.0,
        sensor_lag_s: 1.0 / 0.22,
    })
    .unwrap()
}

pub(crate) fn pla() -> Material {
    Material::try_from(RawMaterial {
        name: "PLA".into(),
        density_kg_m3: 1240.0,
        heat_capacity_j_kg_k: 1800.0,
        flow_index: 0.4,
        consistency_pa_sn: 9000.0,
        reference_temp_k: 483.15,
        activation_energy_j_mol: 60_000.0,
        nozzle_temp_k: 483.15,
        bed_temp_k: 333.15,
        min_temp_k: 460.0,
        max_temp_k: 503.15,
        glass_temp_k: 333.15,
        adhesion_time_s: 0.8,
        fan: 1.0,
        lag_s: 0.63,
    })
    .unwrap()
}

fn pla_on_a_nominal_printer() -> PrinterModel {
    let filament_area_m2 = 2.405_281_875_404_685_7e-6;
    let setting = Setting { ambient: Kelvin(298.15), filament_area_m2, substep: Seconds(0.025) };
    PrinterModel::new(&nominal_hotend(), &pla(), setting)
}

fn near(got: f64, expected: f64) {
    assert!((got - expected).abs() <= 2e-4 * expected.abs(), "{got} for {expected}");
}

/// Golden vector `ukf_cycle-1`.
#[test]
fn a_cycle_of_the_filter_agrees_with_the_reference() {
    let model = pla_on_a_nominal_printer();
    let mut filter = Ukf::new(
        Gaussian {
            mean: [491.0, 483.15, 490.5, 0.001_817_165_951_104_801_6, 0.02, 1.01].into(),
            covariance: SMatrix::from_diagonal(
                &[1.0, 4.0, 1.0, 2.971_882_884_469_156_2e-9, 4e-4, 4e-4].into(),
            ),
        },
        Spread { alpha: 0.3, beta: 2.0, kappa: 0.0 },
    );
    let noise = SMatrix::from_diagonal(&[0.01, 0.04, 4e-4, 5.283_347_350_167_39e-11, 9e-6, 6.4e-7].into());
    let drive = Drive {
        heater_power_w: 17.0,
        motor_speed_m_s: 0.001_853_509_270_126_897_8,
        back_m_s: 0.0,
        filament_speed_m_s: None,
        fan: 1.0,
    };
    assert_eq!(filter.predict(&noise, |x| model.step(x, &drive, 0.05)), Health::Sound);
    let predicted = [491.001_849_956, 483.062_967_357, 490.505_490_058, 0.001_817_110_493, 0.02, 1.01];
    let spread = [1.006_456_737, 3.951_814_211, 0.978_701_063, 2.596_522_501e-9, 4.09e-4, 4.006_4e-4];
    for index in 0..state::COUNT {
        near(filter.belief().mean[index], predicted[index]);
        near(filter.belief().covariance[(index, index)], spread[index]);
    }
    let road = Road { path_speed_m_s: 0.05, height_m: 2e-4 };
    let updates = [
        (490.2, 0.0225, 0.093_212_222),
        (0.001_760_833_806_620_552_7, 6.724e-9, 0.380_354_537),
        (0.000_475, 1.44e-10, 0.225_701_972),
    ];
    for (channel, (value, variance, nis)) in updates.into_iter().enumerate() {
        let measurement =
            Measurement { value: Vector1::new(value), noise: Matrix1::new(variance), gate: 10.0 };
        let outcome = filter.update(&measurement, |x| {
            Vector1::new(match channel {
                0 => x[state::SENSOR],
                1 => model.filament_speed(x, drive.motor_speed_m_s),
                _ => model.width(x[state::FLOW], x[state::GAIN], road),
            })
        });
        let Update::Applied(innovation) = outcome else { panic!("{outcome:?}") };
        near(innovation.nis, nis);
    }
    let posterior =
        [490.998_510_477, 483.063_476_363, 490.206_865_281, 0.001_800_898_026, 0.025_464_872, 1.005_697_94];
    let spread =
        [1.006_337_08, 3.951_812_863, 0.021_994_357, 1.531_361_431e-9, 3.379_585_44e-4, 3.186_393_06e-4];
    for index in 0..state::COUNT {
        near(filter.belief().mean[index], posterior[index]);
        near(filter.belief().covariance[(index, index)], spread[index]);
    }
}

/// What flows is heated from the room's temperature on: 2.4 mm3/s of PLA take `rho A c_p u (T - T_a)` from the nozzle.
#[test]
fn the_filament_enters_at_the_temperature_of_the_room() {
    let model = pla_on_a_nominal_printer();
    let drive = Drive {
        heater_power_w: 0.0,
        motor_speed_m_s: 0.0,
        back_m_s: 0.0,
        filament_speed_m_s: None,
        fan: 0.0,
    };
    let nozzle_k = |flow_m_s: f64| {
        let x = State::from([490.0, 480.0, 490.0, flow_m_s, 0.0, 1.0]);
        model.step(&x, &drive, 1e-3)[state::NOZZLE]
    };
    let taken_k = nozzle_k(0.0) - nozzle_k(1e-3);
    let by_hand_k = 1240.0 * 2.405_281_875e-6 * 1800.0 * 1e-3 * (480.0 - 298.15) / 2.2 * 1e-3;
    assert!((taken_k / by_hand_k - 1.0).abs() < 1e-6, "{taken_k} {by_hand_k}");
}

#[test]
fn the_lag_does_not_depend_on_the_step() {
    // through a retraction and back
    for (start, speed) in [(0.002, -0.035), (-0.001, 0.003), (0.002, 0.0), (-0.002, -0.01), (0.001, 0.003)] {
        let whole = lagged(start, speed, 0.06, 0.63);
        let parts = (0..60).fold(start, |flow, _| lagged(flow, speed, 0.001, 0.63));
        assert!((whole - parts).abs() < 1e-12, "{whole} {parts}");
    }
}

#[test]
fn a_retraction_is_taken_back_by_the_same_stroke() {
    // 1 mm at 50 mm/s back, 0.2 s travel, 1 mm forth: while dry nothing is lost
    let dry = lagged(0.0, -0.05, 0.02, 0.63);
    assert!((dry + 0.001 / 0.63).abs() < 1e-12);
    let back = lagged(lagged(dry, 0.0, 0.2, 0.63), 0.05, 0.02, 0.63);
    assert!(back.abs() < 1e-12);
}
