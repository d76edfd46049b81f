use super::*;

const SETTINGS: Settings = Settings {
    loop_gain_1_s: 1.5,
    shortfall_kept_m: 2e-4,
    shortfall_fades_s: 0.7,
    loop_period_s: 0.01,
    advance_smooth_s: 0.02,
};
const DEPOSIT: Feed = Feed { deposited_m_s: 2e-3, other_m_s: 0.0 };

/// Runs one second at 1 ms with a gear that loses `slip`; returns (wanted, motor, delivered) in metres.
fn one_second(drive: &mut Drive, trims: &Trims, slip: f64) -> (f64, f64, f64) {
    let mut delivered_m = 0.0;
    for _ in 0..1000 {
        delivered_m +=
            (1.0 - slip) * drive.step(DEPOSIT, trims, Goal::Now(0.0, 0.0), (Some(delivered_m), 1e-3)) * 1e-3;
    }
    (drive.wanted_m(), drive.motor_m(), delivered_m)
}

#[test]
fn an_open_loop_passes_the_slicers_feed_on() {
    let mut drive = Drive::new(SETTINGS, HostProfile::Native);
    let (wanted_m, motor_m, delivered_m) = one_second(&mut drive, &Trims::NEUTRAL, 0.09);
    assert!((wanted_m - 2e-3).abs() < 1e-12 && (motor_m - 2e-3).abs() < 1e-12);
    assert!((delivered_m - 0.91 * 2e-3).abs() < 1e-12);
}

#[test]
fn a_known_slip_is_made_up_for_at_once() {
    let trims = Trims { slip: Some(0.09), ..Trims::NEUTRAL };
    for host in [HostProfile::Native, HostProfile::Serial] {
        let (wanted_m, _, delivered_m) = one_second(&mut Drive::new(SETTINGS, host), &trims, 0.09);
        assert!((delivered_m / wanted_m - 1.0).abs() < 1e-9, "{host:?}");
    }
}

#[test]
fn the_native_loop_catches_up_an_unknown_slip_and_the_serial_host_cannot() {
    let trims = Trims { slip: Some(0.0), ..Trims::NEUTRAL };
    let shortfall_after = |host| {
        let mut drive = Drive::new(SETTINGS, host);
        let (mut delivered_m, mut last) = (0.0, 0.0);
        for _ in 0..10_000 {
            delivered_m +=
                0.91 * drive.step(DEPOSIT, &trims, Goal::Now(0.0, 0.0), (Some(delivered_m), 1e-3)) * 1e-3;
            last = drive.wanted_m() - delivered_m;
        }
        last
    };
    // Steady state of the loop: 0.91 (v + k e) = v, e = v (1/0.91 - 1) / k = 0.132 mm.
    assert!((shortfall_after(HostProfile::Native) - 2e-3 * (1.0 / 0.91 - 1.0) / 1.5).abs() < 2e-6);
    assert!((shortfall_after(HostProfile::Serial) - 0.09 * 2e-2).abs() < 1e-9);
}

/// `dE/dt = v - 0.7 (v + k E) - (E - kept)/tau`: at rest `E = 0.357 mm`, and what fades is lost to the roads.
#[test]
fn what_was_laid_thin_long_ago_is_not_pushed_into_later_roads() {
    let trims = Trims { slip: Some(0.0), ..Trims::NEUTRAL };
    let mut drive = Drive::new(SETTINGS, HostProfile::Native);
    let (mut delivered_m, mut before_m) = (0.0, 0.0);
    for step in 0..10_000 {
        before_m = if step == 9_000 { delivered_m } else { before_m };
        delivered_m +=
            0.7 * drive.step(DEPOSIT, &trims, Goal::Now(0.0, 0.0), (Some(delivered_m), 1e-3)) * 1e-3;
    }
    let shortfall_m = (0.3 * 2e-3 + 2e-4 / 0.7) / (0.7 * 1.5 + 1.0 / 0.7);
    let expected_m = 2e-3 - (shortfall_m - 2e-4) / 0.7;
    assert!((delivered_m - before_m - expected_m).abs() < 4e-6, "{}", delivered_m - before_m);
}

#[test]
fn advance_displaces_by_k_times_the_feed_and_is_withdrawn_at_the_end() {
    let mut drive = Drive::new(SETTINGS, HostProfile::Native);
    for _ in 0..500 {
        drive.step(DEPOSIT, &Trims::NEUTRAL, Goal::Now(0.5, 0.0), (Some(0.0), 1e-3));
    }
    assert!((drive.wanted_m() - (1e-3 + 0.5 * 2e-3)).abs() < 1e-9);
    for _ in 0..500 {
        drive.step(Feed::default(), &Trims::NEUTRAL, Goal::Now(0.5, 0.0), (Some(0.0), 1e-3));
    }
    assert!((drive.wanted_m() - 1e-3).abs() < 1e-9);
}

/// Without an encoder a slip is made up for as it is told, and nothing is caught up.
#[test]
fn without_an_encoder_there_is_no_loop() {
    let mut drive = Drive::new(SETTINGS, HostProfile::Native);
    let trims = Trims { slip: Some(0.09), ..Trims::NEUTRAL };
    let speeds = (0..1000).map(|_| drive.step(DEPOSIT, &trims, Goal::Now(0.0, 0.0), (None, 1e-3)));
    assert!(speeds.into_iter().all(|speed| (speed * 0.91 / DEPOSIT.deposited_m_s - 1.0).abs() < 1e-12));
}

#[test]
fn a_retraction_is_neither_trimmed_nor_compensated() {
    let mut drive = Drive::new(SETTINGS, HostProfile::Native);
    let trims = Trims { flow: 1.2, slip: Some(0.3), ..Trims::NEUTRAL };
    let speed = drive.step(
        Feed { deposited_m_s: 0.0, other_m_s: -0.035 },
        &trims,
        Goal::Now(0.5, 0.0),
        (Some(-1.0), 1e-3),
    );
    assert!((speed + 0.035).abs() < 1e-12);
}
/// 20 mm at 5 mm/s, of which the gear loses half: the loop would push twice as hard, and grind.
#[test]
fn a_purge_is_passed_on_as_it_is_behind_the_length_of_a_prime() {
    let mut drive = Drive::new(SETTINGS, HostProfile::Native);
    let trims = Trims { slip: Some(0.3), ..Trims::NEUTRAL };
    let purge = Feed { deposited_m_s: 0.0, other_m_s: 5e-3 };
    let mut push = |feed, ms: u32| {
        let speeds = (0..ms)
            .map(|_| drive.step(feed, &trims, Goal::Now(0.0, 0.0), (Some(0.5 * drive.motor_m()), 1e-3)));
        speeds.last().unwrap_or_default()
    };
    assert!(push(purge, 1_000) > 6e-3, "a prime is compensated");
    assert!((push(purge, 3_000) - 5e-3).abs() < 1e-12, "a purge is not");
    assert!(push(DEPOSIT, 10) > 2.8e-3, "a road is again");
}
