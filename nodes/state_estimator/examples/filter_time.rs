//! Time of a filter cycle: one prediction and three scalar updates, as in golden vector `ukf_cycle-1`.
//!
//! `cargo run --release -p state_estimator --no-default-features --example filter_time`

use models::hotend::{Hotend, RawHotend};
use models::material::{Material, RawMaterial};
use models::units::{Kelvin, Seconds};
use nalgebra::{Matrix1, SMatrix, Vector1};
use state_estimator::printer_model::{Drive, PrinterModel, Road, Setting, state};
use state_estimator::ukf::{Gaussian, Measurement, Spread, Ukf};
use std::io::Write;
use std::time::Instant;

const CYCLES: u32 = 100_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = model()?;
    let mut filter = Ukf::new(
        Gaussian {
            mean: [491.0, 483.15, 490.5, 1.817e-3, 0.02, 1.01].into(),
            covariance: SMatrix::from_diagonal(&[1.0, 4.0, 1.0, 2.97e-9, 4e-4, 4e-4].into()),
        },
        Spread { alpha: 0.3, beta: 2.0, kappa: 0.0 },
    );
    let noise = SMatrix::from_diagonal(&[0.01, 0.04, 4e-4, 5.28e-11, 9e-6, 6.4e-7].into());
    let drive =
        Drive { heater_power_w: 17.0, motor_speed_m_s: 1.8535e-3, filament_speed_m_s: None, fan: 1.0 };
    let road = Road { path_speed_m_s: 0.05, height_m: 2e-4 };
    let measurement = |value: f64, variance: f64| Measurement {
        value: Vector1::new(value),
        noise: Matrix1::new(variance),
        gate: f64::INFINITY,
    };
    let start = Instant::now();
    for _ in 0..CYCLES {
        filter.predict(&noise, |x| model.step(x, &drive, 0.05));
        filter.update(&measurement(490.2, 0.0225), |x| Vector1::new(x[state::SENSOR]));
        filter.update(&measurement(1.7608e-3, 6.7e-9), |x| {
            Vector1::new(model.filament_speed(x, drive.motor_speed_m_s))
        });
        filter.update(&measurement(4.75e-4, 1.44e-10), |x| {
            Vector1::new(model.width(x[state::FLOW], x[state::GAIN], road))
        });
    }
    let micros = start.elapsed().as_secs_f64() / f64::from(CYCLES) * 1e6;
    writeln!(std::io::stdout(), "cycle {micros:.2} us, flow {:.6e} m/s", filter.belief().mean[state::FLOW])?;
    Ok(())
}

fn model() -> Result<PrinterModel, models::params::ParamError> {
    let hotend = Hotend::try_from(RawHotend {
        block_capacity_j_k: 14.5,
        nozzle_capacity_j_k: 2.2,
        coupling_w_k: 0.45,
        block_loss_w_k: 0.058,
        nozzle_loss_w_k: 0.01,
        block_loss_fan_w_k: 0.009,
        nozzle_loss_fan_w_k: 0.02,
        heater_power_w: 40.0,
        sensor_lag_s: 1.0 / 0.22,
    })?;
    let material = Material::try_from(RawMaterial {
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
    })?;
    let setting =
        Setting { ambient: Kelvin(298.15), filament_area_m2: 2.405_281_875e-6, substep: Seconds(0.025) };
    Ok(PrinterModel::new(&hotend, &material, setting))
}
