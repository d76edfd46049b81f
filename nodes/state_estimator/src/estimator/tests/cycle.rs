//! What a cycle takes from the host, and when the filter starts anew.

use super::*;

/// A time constant of 10 s: after as long the mean is 1 - 1/e of the way to the new feed.
#[test]
fn the_reference_feed_follows_the_slicers() {
    let mut rig = Rig::new();
    rig.host = Box::new(|status| status.planned_feed_m_s = 2.0 * FEED_M_S);
    // the filter starts with the first temperature, after 0.1 s
    let reference_m_s = rig.run(1010).reference_feed_m_s;
    let wanted_m_s = FEED_M_S * (2.0 - (-1.0_f64).exp());
    assert!((reference_m_s / wanted_m_s - 1.0).abs() < 1e-3, "{reference_m_s} for {wanted_m_s}");
    rig.host = Box::new(|status| (status.planned_feed_m_s, status.depositing) = (9.0 * FEED_M_S, false));
    assert!((rig.run(1000).reference_feed_m_s / reference_m_s - 1.0).abs() < 1e-12, "travel is no feed");
}

/// `telemetry.restart_s` is 3 s.
#[test]
fn only_a_long_gap_of_the_status_starts_the_filter_anew() {
    for (gap_steps, resets) in [(250, 0), (350, 1)] {
        let mut rig = Rig::new();
        rig.run(1000);
        rig.step += gap_steps;
        assert_eq!(rig.run(100).resets, resets, "{gap_steps}");
    }
}

/// A printer beyond one bound after the other, and within all shipped ones.
#[test]
fn a_state_beyond_its_bound_resets_the_filter() {
    let disturbed = |changes: &[(&str, &str)], slip: f64, gain: f64| {
        let mut rig = Rig::with(changes);
        (rig.slip, rig.gain) = (slip, gain);
        _ = rig.try_run(4000);
        rig.estimator.filter.resets()
    };
    for (from, to, slip, gain) in [
        ("temperature_high_k: 700.0 ", "temperature_high_k: 450.0 ", 0.01, 1.0),
        ("flow_max_m_s: 0.1 ", "flow_max_m_s: 0.001 ", 0.01, 1.0),
        ("slip_low: -0.5 ", "slip_low: -0.1 ", -0.2, 1.0),
        ("gain_low: 0.3 ", "gain_low: 0.9 ", 0.01, 0.8),
        ("gain_high: 3.0 ", "gain_high: 1.1 ", 0.01, 1.2),
    ] {
        assert!(disturbed(&[(from, to)], slip, gain) > 0, "{to}");
        assert_eq!(disturbed(&[], slip, gain), 0, "{from}");
    }
}

/// Half of the heater's power behind an open relay is none.
#[test]
fn a_heater_without_mains_heats_nothing() {
    let told = |host: fn(&mut PrinterStatus)| {
        let mut rig = Rig::new();
        rig.host = Box::new(host);
        rig.run(500).x
    };
    let cold = told(|status| status.mains_on = false);
    assert_eq!(cold, told(|status| status.hotend_duty = 0.0));
    assert_ne!(cold, told(|_| ()));
}
