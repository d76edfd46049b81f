use super::*;
use crate::wire::{RawMachine, RawParams, RawSensor};
use models::command::{Mode, OnLoss, RawDeadManParams, RawLimits, Trims};
use models::wire::{Feed, Law, Limits as Drives, RawFeed, RawLaw, RawLimits as RawDrives};

fn process() -> Process {
    Process {
        material: "aluminium".into(),
        feed: Feed::try_from(RawFeed {
            diameter_m: 3e-3,
            drop_length_m: 3e-3,
            absorbed_w: 64.885,
            spacing: 2.0 / 3.0,
        })
        .unwrap(),
        law: Law::try_from(RawLaw {
            height_m: 2.16e-3,
            wire_m_s: 3.5e-3,
            head_m_s: 1.68e-3,
            gain: 0.635,
            split: 2.0 / 3.0,
            ratio_low: 0.2,
            ratio_high: 1.8,
        })
        .unwrap(),
        limits: Drives::try_from(RawDrives {
            wire_low_m_s: 5e-4,
            wire_high_m_s: 5.4e-3,
            head_low_m_s: 5e-4,
            head_high_m_s: 0.01,
        })
        .unwrap(),
    }
}

fn limits() -> Limits {
    Limits::try_from(RawLimits {
        flow_min: 0.15,
        flow_max: 1.9,
        flow_slew_1_s: 10.0,
        speed_min: 0.4,
        speed_max: 1.8,
        speed_slew_1_s: 10.0,
        setpoint_offset_min_k: 0.0,
        setpoint_offset_max_k: 0.0,
        setpoint_offset_slew_k_s: 1.0,
        advance_max_s: 0.0,
        advance_slew_s_s: 1.0,
        slip_min: 0.0,
        slip_max: 0.0,
        slip_slew_1_s: 1.0,
        validity_max_s: 1.0,
    })
    .unwrap()
}

fn machine(layers: u32) -> Machine {
    let plant = RawParams {
        diameter_m: 3e-3,
        drop_length_m: 3e-3,
        feed_ratio: 1.0,
        bead_width_m: 6.818e-3,
        spread_m: 1.2e-3,
        drive_lag_s: 0.3,
        wall_length_m: 0.02,
        cell_m: 2.5e-4,
        return_s: 1.0,
        drop_volume_sigma: 0.0,
        drop_place_sigma_m: 0.0,
        features_per_layer: 0,
        feature_height_m: 0.0,
        feature_length_m: 4.5e-3,
        sensor: RawSensor { period_s: 0.5, sigma_m: 0.0, delay_s: 0.5, trail_m: 6e-3 },
    };
    let params = MachineParams {
        plant: Params::try_from(plant).unwrap(),
        process: process(),
        settings: MachineSettings::try_from(RawMachine { status_period_s: 0.02, sigma_floor_m: 1e-5 })
            .unwrap(),
        dead_man: RawDeadManParams {
            on_supervisor_loss: OnLoss::Baseline,
            pause_delay_s: 5.0,
            heaters_off_delay_s: 60.0,
        }
        .try_into()
        .unwrap(),
        limits: limits(),
        layers,
    };
    Machine::new(params, 1)
}

fn permit(sequence: u64, request: Request, trims: Trims) -> Permit {
    Permit { session: 1, sequence, validity: Seconds(0.25), mode: Mode::Act, request, trims }
}

fn steps(machine: &mut Machine, count: u32) {
    (0..count).for_each(|_| machine.step(Seconds(0.01)));
}

fn trims(flow: f64, speed: f64) -> Trims {
    Trims { flow, speed, ..Trims::NEUTRAL }
}

#[test]
fn a_permit_moves_both_speeds_and_its_end_brings_the_planned_ones_back() {
    let mut machine = machine(2);
    machine.on_permit(permit(1, Request::Run, trims(1.2, 0.9))).unwrap();
    // 10 a second at most
    steps(&mut machine, 3);
    // flow is wire per path: 3.5 * 1.2 * 0.9 and 1.68 * 0.9
    let speeds = machine.speeds();
    assert!((speeds.wire_m_s - 3.78e-3).abs() < 1e-12 && (speeds.head_m_s - 1.512e-3).abs() < 1e-12);
    steps(&mut machine, 25);
    assert_eq!(machine.speeds(), Speeds { wire_m_s: 3.5e-3, head_m_s: 1.68e-3 });
    assert_eq!(machine.status().trims, Trims::NEUTRAL);
}

/// The machine's own limits hold whatever a permit says, and so do those of drives and laser: 3.5 mm/s * 1.9 * 1.8 is
/// more than the laser melts.
#[test]
fn a_permit_outside_is_clamped_and_counted() {
    let mut machine = machine(2);
    machine.on_permit(permit(1, Request::Run, trims(9.0, 9.0))).unwrap();
    steps(&mut machine, 10);
    assert_eq!(machine.dead_man().clamped(), 1);
    assert_eq!(machine.status().trims, trims(1.9, 1.8));
    assert!((machine.speeds().wire_m_s - 5.4e-3).abs() < 1e-15);
}

#[test]
fn a_pause_lays_nothing_and_a_trip_ends_the_job() {
    let mut machine = machine(2);
    steps(&mut machine, 200);
    machine.on_permit(permit(1, Request::Pause, Trims::NEUTRAL)).unwrap();
    steps(&mut machine, 1);
    let before = (machine.truth().height_m, machine.status().motor_position_m);
    steps(&mut machine, 500);
    assert_eq!((machine.phase(), machine.truth().depositing), (JobPhase::Paused, false));
    assert_eq!((machine.truth().height_m, machine.status().motor_position_m), before);
    machine.on_permit(permit(2, Request::Run, Trims::NEUTRAL)).unwrap();
    steps(&mut machine, 100);
    assert!(machine.truth().height_m > before.0);
    machine.on_permit(permit(3, Request::EmergencyStop, Trims::NEUTRAL)).unwrap();
    steps(&mut machine, 1);
    assert_eq!((machine.phase(), machine.status().mains_on), (JobPhase::Failed, false));
}

/// 20 mm at 1.68 mm/s, 6 mm to the end of the sensor's view, 1 s back: 16.5 s a layer; samples every 0.5 s of 11.9 s.
#[test]
fn a_wall_comes_to_its_end_and_was_measured_on_its_way() {
    let mut machine = machine(2);
    let (mut heights, mut states) = (0, 0);
    while machine.phase() != JobPhase::Done {
        steps(&mut machine, 1);
        while let Some(output) = machine.poll() {
            match output {
                MachineOutput::Height { sigma_m, .. } => {
                    assert!((sigma_m - 1e-5).abs() < 1e-15);
                    heights += 1;
                }
                MachineOutput::Status(_) => states += 1,
                MachineOutput::Note { text, .. } => assert_eq!(text, "the wall is done"),
            }
        }
        assert!(machine.now().0 < 40.0);
    }
    let status = machine.status();
    assert!((status.progress - 1.0).abs() < 1e-12 && !status.depositing && status.hotend_duty == 0.0);
    assert!((44..=50).contains(&heights), "{heights}");
    assert!(states > 1500, "{states}");
    // As planned but for the lag of the drives at the start: a hundredth of a layer.
    let figures = machine.truth().figures;
    assert!(figures.layers() == 2 && figures.rms_m() < 0.1e-3, "{figures:?}");
}
