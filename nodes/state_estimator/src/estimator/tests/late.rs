//! Measurements that come late, or at times that are not known well.

use super::*;
use crate::measurement;

/// The feed changes each second, frames tell the width of half a second ago: they are judged by the flow of then.
#[test]
fn a_late_width_is_of_the_flow_of_its_exposure() {
    let mut rig = Rig::new();
    rig.width_noise_m = f64::NAN;
    let mut flows_m_s = Vec::new();
    for step in 0..4000_u32 {
        rig.feed_m_s = if step / 100 % 2 == 0 { FEED_M_S } else { 0.6 * FEED_M_S };
        _ = rig.try_run(1);
        flows_m_s.push(rig.flow_m_s);
        if step % 50 == 49 && step > 100 {
            let flow_m3_s = flows_m_s[flows_m_s.len() - 51] * 2.405_281_875e-6;
            let width_m = models::bead::stadium::width_m(flow_m3_s, SPEED_M_S, HEIGHT_M);
            let exposed = Seconds(f64::from(rig.step) * 0.01 - 0.5);
            rig.estimator.on_event(Event::Width { exposed, width_m, sigma_m: 1e-5 });
        }
    }
    let estimate = rig.run(5);
    let width = Channel::Width as usize;
    let nis = estimate.nis_mean[width].unwrap();
    assert!(nis < 1.0 && estimate.gated[width] == 0, "{nis} {:?}", estimate.gated);
    assert!((estimate.x[state::GAIN] - 1.0).abs() < 0.01, "{}", estimate.x[state::GAIN]);
}

/// A width that was exposed before the feed changed, and comes after that, is of a flow in balance; one exposed since is not.
#[test]
fn a_late_width_is_as_noisy_as_the_flow_of_its_exposure_was_off_balance() {
    let nis = |imbalance: &str, exposed_after_s: f64| {
        let imbalance = format!("imbalance: {imbalance} ");
        let mut rig = Rig::with(&[("imbalance: 0.002 ", &imbalance)]);
        // A tenth of a second after a frame, and no other comes.
        rig.run(3010);
        (rig.width_noise_m, rig.feed_m_s) = (f64::NAN, 0.5 * FEED_M_S);
        let changed_s = f64::from(rig.step) * 0.01;
        rig.run(20);
        let refused = rig.estimator.refusals().width;
        let width_m = 1.05 * models::bead::stadium::width_m(FEED_M_S * 2.405_281_875e-6, SPEED_M_S, HEIGHT_M);
        let exposed = Seconds(changed_s + exposed_after_s);
        rig.estimator.on_event(Event::Width { exposed, width_m, sigma_m: 1e-5 });
        let nis = rig.run(5).nis[Channel::Width as usize].unwrap();
        assert_eq!(rig.estimator.refusals().width, refused);
        nis
    };
    let ratio = |exposed_after_s: f64| nis("5.0", exposed_after_s) / nis("0.002", exposed_after_s);
    assert!((0.8..1.2).contains(&ratio(-0.02)), "{}", ratio(-0.02));
    assert!(ratio(0.1) < 0.2, "{}", ratio(0.1));
}

/// The motor goes from 1 to 5 mm/s within the interval: stamps that are off by 2 ms shift 8 um from one side to the other.
#[test]
fn an_encoders_speed_is_known_as_well_as_its_times() {
    let params = serde_saphyr::from_str::<File>(SHIPPED).unwrap().node.parameters;
    let mut inbox = Rig::new().estimator.inbox;
    for step in 0..=5_u32 {
        let stamp_s = f64::from(step) * 0.02;
        let motor_m = 1e-3 * stamp_s + 4e-3 * (stamp_s - 0.04).max(0.0);
        let sample = Sample {
            stamp_s,
            motor_m,
            wanted_m: 0.0,
            slip: 0.0,
            path_speed_m_s: SPEED_M_S,
            tool_m: [0.0; 2],
            height_m: Some(HEIGHT_M),
            depositing: true,
        };
        inbox.samples.push(sample);
        inbox.positions.push((stamp_s, motor_m));
    }
    inbox.position_used = Some((0.0, 0.0));
    let observed = measurement::encoder(&params, FEED_M_S, &mut inbox).unwrap();
    let speed_m_s = (1e-3 * 0.1 + 4e-3 * 0.06) / 0.1;
    let parts = [1e-5 / 6.0_f64.sqrt() / 0.1, 0.002 * 4e-3 / 0.1, 0.004 * speed_m_s];
    let variance = parts.iter().map(|part| part * part).sum::<f64>();
    let told = observed.observation(&params.encoder).measurement(1.0);
    assert!((told.value.x / speed_m_s - 1.0).abs() < 1e-9, "{}", told.value.x);
    assert!((told.noise.x / variance - 1.0).abs() < 1e-9, "{} for {variance}", told.noise.x);
}
