use super::*;

fn check() -> DriftCheck {
    DriftCheck::new(DriftParams {
        capacity_j_k: 16.7,
        lag_s: 6.0,
        learn_s: 20.0,
        usual_time_s: 180.0,
        usual_max_w: 4.0,
        steady_w: 2.5,
        allowance_w: 1.6,
        doubt_j: 15.0,
        air_share: 0.36,
        bed_above_air_k: 15.0,
        degraded_k: 5.0,
        safe_off_k: 15.0,
    })
}

/// Feeds a constant balance at 10 Hz until a span is over or the check trips; returns the time it took.
fn feed(check: &mut DriftCheck, from_s: f64, span_s: f64, (hotend_w, bed_w): (f64, Option<f64>)) -> f64 {
    let mut now_s = from_s;
    while now_s < from_s + span_s && !check.tripped() {
        now_s += 0.1;
        let balance = Balance { disturbance_w: hotend_w, warming_w: 0.0, unseen_w2_s: 0.0 };
        check.on_balance(Seconds(now_s), balance, bed_w);
    }
    now_s - from_s
}

/// 0.2 K/s take 16.7 * 0.2 = 3.34 W; 5 K are there after 25 s, 15 K after 75 s.
#[test]
fn a_drift_is_as_far_as_its_energy_says() {
    for sign in [-1.0, 1.0] {
        let mut check = check();
        feed(&mut check, 0.0, 400.0, (2.0, Some(4.0)));
        feed(&mut check, 400.0, 30.0, (2.0 + sign * 3.34, Some(4.0)));
        assert!(check.is_doubtful() && !check.tripped(), "{}", check.residual_k());
        assert!((check.limit_k() - sign * 5.0).abs() < 1e-12 && check.residual_k() * sign > 5.0);
        let time_s = 30.0 + feed(&mut check, 430.0, 60.0, (2.0 + sign * 3.34, Some(4.0)));
        // This balance comes without the lag of 6 s that is made up for; the doubt takes 15 J / 1.7 W = 9 s, in
        // which the usual power learns 9/180 of the change: (250 J - 19 J) / 3.2 W = 73 s.
        assert!((69.0..77.0).contains(&time_s), "{time_s} s");
    }
}

#[test]
fn an_overtaken_balance_counts_no_time_twice() {
    let [mut in_order, mut overtaken] = [check(), check()];
    for sums in [&mut in_order, &mut overtaken] {
        feed(sums, 0.0, 400.0, (2.0, Some(4.0)));
    }
    for tick in 1..=300 {
        let now_s = 400.0 + 0.1 * f64::from(tick);
        let balance = Balance { disturbance_w: 5.34, warming_w: 0.0, unseen_w2_s: 0.0 };
        in_order.on_balance(Seconds(now_s), balance, Some(4.0));
        overtaken.on_balance(Seconds(now_s), balance, Some(4.0));
        overtaken.on_balance(Seconds(now_s - 0.15), balance, Some(4.0));
    }
    assert!(in_order.is_doubtful());
    assert!((in_order.residual_k() - overtaken.residual_k()).abs() < 1e-9);
}

#[test]
fn what_the_bed_feels_too_is_air() {
    let mut check = check();
    feed(&mut check, 0.0, 100.0, (2.0, Some(4.0)));
    feed(&mut check, 100.0, 200.0, (2.0 - 4.5, Some(4.0 - 12.5)));
    assert!(!check.is_doubtful(), "{}", check.residual_k());
}

#[test]
fn without_a_bed_to_tell_it_never_switches_off() {
    let mut check = check();
    feed(&mut check, 0.0, 100.0, (2.0, None));
    feed(&mut check, 100.0, 200.0, (2.0 - 4.5, None));
    assert!(check.is_doubtful() && !check.tripped());
}

#[test]
fn a_change_below_the_allowance_becomes_usual() {
    let mut check = check();
    feed(&mut check, 0.0, 100.0, (2.0, Some(4.0)));
    feed(&mut check, 100.0, 600.0, (3.5, Some(4.0)));
    assert!(check.residual_k().abs() < 1e-9);
    assert!((check.usual_w - 3.5).abs() < 0.1);
}

/// From its first balance on, -0.2 K/s: 3.34 W, and 0.1 W/K of what it has come to. Nothing else would be found.
#[test]
fn a_drift_that_was_learnt_is_found_by_what_it_grows_to() {
    let found_s = |usual_max_w: f64| {
        let mut check = DriftCheck::new(DriftParams { usual_max_w, ..check().params });
        let tick = (0..3000).find(|tick| {
            let now_s = 0.1 * f64::from(*tick);
            let balance = Balance { disturbance_w: -4.34 - 0.02 * now_s, warming_w: 0.0, unseen_w2_s: 0.0 };
            check.on_balance(Seconds(now_s), balance, Some(4.0));
            check.tripped()
        });
        tick.map(|tick| 0.1 * f64::from(tick))
    };
    // Beyond 3.2 W and the allowance of 1.6 W from 23 s on; 250 J of what is beyond 3.2 W: 1.6 W and more.
    assert!(found_s(3.2).is_some_and(|at_s| (80.0..140.0).contains(&at_s)), "{:?}", found_s(3.2));
    assert!(found_s(100.0).is_none_or(|at_s| at_s > 200.0), "{:?}", found_s(100.0));
}

/// An onset just after the usual power is known: what is learnt of it takes the usual time.
#[test]
fn a_young_check_learns_no_faster_than_an_old_one() {
    let mut check = check();
    feed(&mut check, 0.0, 22.0, (-1.0, Some(4.0)));
    let time_s = feed(&mut check, 22.0, 120.0, (-1.0 + 3.34, Some(4.0)));
    assert!(check.tripped() && time_s < 90.0, "{time_s} s, {} K", check.residual_k());
}

/// 3 W beyond an allowance of 1 W for 0.5 s: 1 J beyond, 1.5 J in all, and 3 W for each second of lag.
#[test]
fn a_sum_counts_energy() {
    let mut sum = Sum::default();
    sum.add(3.0, 1.0, 0.0, 0.5);
    assert!((sum.beyond_j - 1.0).abs() < 1e-12 && (sum.until_now_j(2.0) - 7.5).abs() < 1e-12, "{sum:?}");
    sum.add(-1.0, 1.0, 0.0, 1.0);
    assert_eq!(sum, Sum::default(), "what is back below it is forgotten");
}

#[test]
fn a_moving_set_point_is_not_judged() {
    let mut check = check();
    feed(&mut check, 0.0, 100.0, (2.0, Some(4.0)));
    for tick in 0..600 {
        let balance = Balance { disturbance_w: -6.0, warming_w: 20.0, unseen_w2_s: 0.0 };
        check.on_balance(Seconds(100.0 + 0.1 * f64::from(tick)), balance, Some(4.0));
    }
    assert!(check.residual_k().abs() < 1e-9);
}

/// An order that is known to 100 W^2 s: the usual power to 1.8 W after 30 s, the energy to 100 J and 6 K after 100 s.
#[test]
fn what_is_not_known_of_the_order_is_allowed_for() {
    let found_s = |unseen_w2_s: f64, drift_w: f64| {
        let mut check = check();
        let tick = (0..6000).find(|tick| {
            let now_s = 0.1 * f64::from(*tick);
            let disturbance_w = if now_s < 60.0 { 2.0 } else { 2.0 + drift_w };
            let balance = Balance { disturbance_w, warming_w: 0.0, unseen_w2_s };
            check.on_balance(Seconds(now_s), balance, Some(4.0));
            check.tripped()
        });
        tick.map(|tick| 0.1 * f64::from(tick) - 60.0)
    };
    // 15 K of 3.34 W are there after 75 s; 15 K and 2 * 10 J/s^0.5 * t^0.5 of it after 115 s; 5 W less the
    // allowance of 1.6 + 1.8 W take longer for what is learnt meanwhile.
    assert!(found_s(0.0, 3.34).is_some_and(|at_s| (65.0..80.0).contains(&at_s)), "{:?}", found_s(0.0, 3.34));
    assert!(found_s(100.0, 3.34).is_none_or(|at_s| at_s > 115.0), "{:?}", found_s(100.0, 3.34));
    assert!(
        found_s(100.0, 5.0).is_some_and(|at_s| (100.0..150.0).contains(&at_s)),
        "{:?}",
        found_s(100.0, 5.0)
    );
    assert!(found_s(0.0, 2.5).is_some() && found_s(100.0, 2.5).is_none());
}
