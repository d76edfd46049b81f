//! What faults together do.

use super::*;

fn slip(ramp_s: f64, duration_s: Option<f64>) -> Fault {
    Fault {
        component: Component::Extruder,
        kind: Kind::Slip,
        size: 0.1,
        ramp: Seconds(ramp_s),
        duration: duration_s.map(Seconds),
        seed: None,
        onset: Seconds(10.0),
    }
}

#[test]
fn a_step_is_whole_from_its_onset_and_gone_after_its_duration() {
    let at = |now_s: f64| InForce::at(Seconds(now_s), &[slip(0.0, Some(5.0))]).slip;
    assert_eq!(
        [at(9.999), at(10.0), at(14.999), at(15.0)].map(|slip| slip > 0.0),
        [false, true, true, false]
    );
}

#[test]
fn a_ramp_grows_linearly_and_stays() {
    let at = |now_s: f64| InForce::at(Seconds(now_s), &[slip(4.0, None)]).slip;
    assert!((at(11.0) - 0.025).abs() < 1e-12);
    assert!((at(99.0) - 0.1).abs() < 1e-12);
}

#[test]
fn two_slips_add_up() {
    let both = InForce::at(Seconds(20.0), &[slip(0.0, None), slip(0.0, None)]);
    assert!((both.slip - 0.2).abs() < 1e-12);
}

#[test]
fn leaks_and_clogs_together_leave_a_nozzle() {
    let fault = |kind, size| Fault { kind, size, ..slip(0.0, None) };
    let many = |kind, size| InForce::at(Seconds(20.0), &[fault(kind, size); 300]);
    assert!((many(Kind::Leak, 0.9).leak - 0.99).abs() < 1e-12);
    assert!((many(Kind::Clog, 0.05).clog - 0.01).abs() < 1e-12);
}

#[test]
fn a_shorted_switch_heats_until_the_mains_relay_opens() {
    let shorted = HeaterFaults { gain: 1.0, stuck_on: true };
    assert!(shorted.power_share(0.0, true) > 0.999 && shorted.power_share(0.0, false).abs() < 1e-12);
    let weak = HeaterFaults { gain: 0.2, stuck_on: false };
    assert!((weak.power_share(0.5, true) - 0.1).abs() < 1e-12);
}

#[test]
fn each_thermistor_has_faults_of_its_own() {
    let fault = |component, kind, size| Fault { component, kind, size, ..slip(0.0, None) };
    let bed = InForce::at(Seconds(20.0), &[fault(Component::BedThermistor, Kind::Noise, 10.0)]);
    assert!((bed.bed_sensor.noise - 10.0).abs() < 1e-12 && bed.hotend_sensor == SensorFaults::NONE);
    let both = InForce::at(
        Seconds(20.0),
        &[
            fault(Component::HotendThermistor, Kind::Spikes, 0.3),
            fault(Component::HotendThermistor, Kind::Loose, 0.4),
            fault(Component::HotendThermistor, Kind::Bias, 30.0),
        ],
    );
    assert!((both.hotend_sensor.spikes - 0.3).abs() < 1e-12);
    assert!((both.hotend_sensor.loose - 0.4).abs() < 1e-12);
    assert!((both.hotend_sensor.bias_k - 30.0).abs() < 1e-12);
}

/// Of what is unplugged nothing is repeated, whichever came first.
#[test]
fn off_outdoes_stuck() {
    let fault = |component, kind| Fault { component, kind, ..slip(0.0, None) };
    let (off, stuck) = (fault(Component::Imu, Kind::Off), fault(Component::Imu, Kind::Stuck));
    for both in [[off, stuck], [stuck, off]] {
        let all = InForce::at(Seconds(20.0), &both);
        assert_eq!((all.imu, all.encoder, all.camera), (Feed::Off, Feed::Live, Feed::Live));
    }
}
