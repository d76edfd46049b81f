//! A hot end that is unlike the nominal one, heated and fed by a script, and what a bag of it holds.

use crate::config::{Choice, ConfigDir, Setup};
use crate::identify::params::IdentifyParams;
use crate::identify::record::Recorded;
use models::command::Trims;
use models::extruder::{Pressure, StaticLaw};
use models::hotend::{Hotend, Inputs, RawHotend, Thermal};
use models::melt::Melt;
use models::status::{HostProfile, JobPhase, PrinterStatus};
use models::units::{Celsius, Kelvin, Seconds};
use mpc_controller::params::Level;
use printer_sim::sensors::Noise;
use std::path::Path;

/// Room of the test `[K]`.
pub(super) const ROOM_K: f64 = 295.15;
/// Time between two readings, and two states `[s]`.
const PERIOD_S: f64 = 0.2;

/// A stretch of the script: how long, duty, fan, filament fed `[m/s]`.
pub(super) type Stretch = (f64, f64, f64, f64);

/// Cold, heat-up, hold, low, heat again, fan, flow.
pub(super) const SCRIPT: [Stretch; 10] = [
    (10.0, 0.0, 0.0, 0.0),
    (95.0, 1.0, 0.0, 0.0),
    (60.0, 0.33, 0.0, 0.0),
    (40.0, 0.0, 0.0, 0.0),
    (25.0, 1.0, 0.0, 0.0),
    (30.0, 0.36, 0.0, 0.0),
    (60.0, 0.36, 1.0, 0.0),
    (50.0, 0.42, 0.0, 0.0),
    (60.0, 0.42, 0.0, 2.5e-3),
    (60.0, 0.42, 1.0, 2.5e-3),
];

/// The same with a flow that changes every 2 s, as in the file to print.
pub(super) fn pulsed() -> Vec<Stretch> {
    let pulses = |fan| [(2.0, 0.42, fan, 4.0e-3), (2.0, 0.42, fan, 1.0e-3)].repeat(15);
    [SCRIPT[..8].to_vec(), pulses(0.0), pulses(1.0)].concat()
}

pub(super) fn setup() -> (ConfigDir, Setup, IdentifyParams) {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config"));
    let config = ConfigDir::find(Some(folder)).unwrap();
    let setup = config.load(&Choice::of("PLA".into(), Level::Off)).unwrap();
    let params = IdentifyParams::load(&config).unwrap();
    (config, setup, params)
}

pub(super) fn unlike(nominal: &Hotend) -> RawHotend {
    RawHotend {
        block_capacity_j_k: 1.15 * nominal.block_capacity_j_k,
        nozzle_capacity_j_k: 0.85 * nominal.nozzle_capacity_j_k,
        coupling_w_k: 0.9 * nominal.coupling_w_k,
        block_loss_w_k: 1.1 * nominal.block_loss_w_k,
        nozzle_loss_w_k: 1.2 * nominal.nozzle_loss_w_k,
        block_loss_fan_w_k: 1.2 * nominal.block_loss_fan_w_k,
        nozzle_loss_fan_w_k: 0.85 * nominal.nozzle_loss_fan_w_k,
        sensor_lag_s: 0.9 * nominal.sensor_lag_s,
        ..**nominal
    }
}

fn state(at_s: f64, (duty, fan, fed_m): (f64, f64, f64)) -> PrinterStatus {
    PrinterStatus {
        stamp: Seconds(at_s),
        phase: JobPhase::Printing,
        host: HostProfile::Moonraker,
        progress: 0.0,
        layer: None,
        line: 0,
        position_m: [0.0; 3],
        path_speed_m_s: 0.0,
        planned_speed_m_s: 0.0,
        planned_feed_m_s: 0.0,
        motor_position_m: fed_m,
        wanted_position_m: fed_m,
        path_time_s: 0.0,
        depositing: false,
        target_width_m: None,
        layer_height_m: None,
        hotend_target: Celsius(210.0),
        hotend_sliced_target: Celsius(210.0),
        bed_target: Celsius(0.0),
        hotend_duty: duty,
        bed_duty: 0.0,
        fan,
        trims: Trims::NEUTRAL,
        advance_s: 0.0,
        homed: true,
        mains_on: true,
        filament_present: None,
        part_fan_speed_1_s: None,
        stop_input: None,
    }
}

/// What a bag of the script holds.
pub(super) fn recorded(setup: &Setup, script: &[Stretch], seed: u64) -> Recorded {
    let hotend = Hotend::try_from(unlike(&setup.printer.hotend)).unwrap();
    let area_m2 = setup.printer.extruder.filament_area_m2();
    let mut noise = Noise::new(seed, 1);
    let mut recorded = Recorded::default();
    let melt = Melt::new(&setup.material, &setup.printer.extruder);
    let (mut thermal, mut fed_m, mut step) = (Thermal::uniform(ROOM_K), 0.0, 0_u32);
    // This host tells a duty as the mean of the time up to its stamp.
    let (mut pressure, mut told) = (Pressure::RELAXED, 0.0);
    for &(lasts_s, duty, fan, feed_m_s) in script {
        let end_s = f64::from(step) * PERIOD_S + lasts_s;
        while f64::from(step) * PERIOD_S < end_s - 1e-9 {
            let at_s = f64::from(step) * PERIOD_S;
            recorded.states.push(state(at_s, (told, fan, fed_m)));
            told = duty;
            recorded.hotend_k.push((at_s, thermal.sensor_k + 0.15 * noise.draw()));
            // What leaves the nozzle takes its heat along, and lags behind what is fed.
            let law = StaticLaw::new(&melt, &setup.printer.extruder, Kelvin(thermal.nozzle_k), 1.0);
            let left_m: f64 = (0..20).map(|_| pressure.step(&law, feed_m_s, Seconds(PERIOD_S / 20.0))).sum();
            let inputs = Inputs {
                heater_w: hotend.heater_power_w * duty,
                fan,
                ambient_k: ROOM_K,
                filament_k: ROOM_K,
                melt_w_k: setup.material.heat_flow_w_k(area_m2 * left_m / PERIOD_S),
            };
            thermal = hotend.step(thermal, &inputs, Seconds(PERIOD_S));
            fed_m += feed_m_s * PERIOD_S;
            step += 1;
        }
    }
    recorded
}
