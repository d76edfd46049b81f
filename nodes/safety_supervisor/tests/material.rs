//! Filament and impulses: encoder against motor, accelerations against what moves command.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use models::units::Seconds;
use safety_supervisor::checks::filament::FilamentCheck;
use safety_supervisor::checks::impulse::ImpulseCheck;
use safety_supervisor::params::{FilamentParams, ImpulseParams};

fn slip_of(motor: impl Fn(f64) -> f64, encoder: impl Fn(f64) -> f64) -> FilamentCheck {
    let mut check = FilamentCheck::new(FilamentParams {
        window_m: 5e-3,
        play_m: 1e-4,
        slip_max: 0.42,
        surplus_max: 0.25,
    });
    for step in 0..=2000 {
        let way_m = f64::from(step) * 1e-5;
        check.on_encoder(Seconds(way_m), encoder(way_m));
        check.on_motor(Seconds(way_m), motor(way_m));
    }
    check
}

#[test]
fn p6_slip_is_the_share_of_the_motors_way_that_the_encoder_has_not_seen() {
    for slip in [0.0, 0.2, 0.4, 0.5, 1.0] {
        let check = slip_of(|way_m| 3.0 + way_m, |way_m| -7.0 + way_m * (1.0 - slip));
        let seen = check.slip().unwrap();
        assert!((seen - slip).abs() < 1e-9, "{slip}: {seen}");
        assert_eq!(check.tripped(), slip > 0.42);
    }
}

/// Retractions and their way back are strokes forward of both; what is within the play is none.
#[test]
fn p6_retractions_and_play_are_no_slip() {
    let strokes = |way_m: f64| way_m + if (way_m * 1e3).fract() < 0.5 { 0.0 } else { -8e-4 };
    let check = slip_of(strokes, strokes);
    assert!((-0.2..1e-9).contains(&check.slip().unwrap()), "the motor's play is allowed to be larger");
    // A motor that trembles by less than the play has gone nowhere.
    let still = slip_of(|way_m| if (way_m * 5e4).fract() < 0.25 { 0.0 } else { 9e-5 }, |_| 0.0);
    assert_eq!(still.slip(), None);
}

/// Moves of pressure advance: 0.35 mm forward, 0.15 mm back, over and over. What is drawn back does not slip.
#[test]
fn p6_short_strokes_slip_no_more_than_long_ones() {
    for (slip, trips) in [(0.0, false), (0.3, false), (0.38, false), (0.46, true), (0.5, true)] {
        let mut check = FilamentCheck::new(FilamentParams {
            window_m: 5e-3,
            play_m: 1e-4,
            slip_max: 0.42,
            surplus_max: 0.25,
        });
        let (mut motor_m, mut encoder_m) = (0.0, 0.0);
        let mut found = false;
        for step in 0..5000 {
            let moved_m = if step % 50 < 35 { 1e-5 } else { -1e-5 };
            motor_m += moved_m;
            encoder_m += if moved_m > 0.0 { moved_m * (1.0 - slip) } else { moved_m };
            check.on_encoder(Seconds(0.02 * f64::from(step)), encoder_m);
            check.on_motor(Seconds(0.02 * f64::from(step)), motor_m);
            found |= check.tripped();
        }
        assert_eq!(found, trips, "{slip}: {:?}", check.slip());
    }
}

/// Messages up to 0.2 s late overtake each other: what is behind says nothing new, and no slip is hidden by it.
#[test]
fn p6_overtaken_messages_of_the_encoder_count_once() {
    for (slip, trips) in [(0.0, false), (0.3, false), (0.5, true)] {
        let mut check = FilamentCheck::new(FilamentParams {
            window_m: 5e-3,
            play_m: 1e-4,
            slip_max: 0.42,
            surplus_max: 0.25,
        });
        // 3 mm/s; each message of 50 Hz is 0, 0.08, 0.16 or 0.04 s old when it comes.
        for step in 0..2000_u32 {
            let time_s = 0.02 * f64::from(step);
            let stamp_s = time_s - [0.0, 0.08, 0.16, 0.04][(step % 4) as usize];
            check.on_encoder(Seconds(stamp_s), 3e-3 * stamp_s * (1.0 - slip));
            check.on_motor(Seconds(time_s), 3e-3 * time_s);
        }
        let seen = check.slip().unwrap();
        assert!((seen - slip).abs() < 0.05, "{slip}: {seen}");
        assert_eq!(check.tripped(), trips, "{slip}: {seen}");
    }
}

/// A clock of the encoder's that is set back by an hour begins anew and is followed.
#[test]
fn p6_an_encoder_whose_clock_is_set_back_is_followed() {
    let check = |stamp_s: fn(f64) -> f64| {
        let params = FilamentParams { window_m: 5e-3, play_m: 1e-4, slip_max: 0.42, surplus_max: 0.25 };
        let mut check = FilamentCheck::new(params);
        for step in 0..2000_u32 {
            let time_s = 0.02 * f64::from(step);
            check.on_encoder(Seconds(stamp_s(time_s)), 3e-3 * time_s);
            check.on_motor(Seconds(time_s), 3e-3 * time_s);
        }
        check.slip().unwrap()
    };
    assert!(check(|time_s| if time_s < 20.0 { 5e3 + time_s } else { 1e3 + time_s }).abs() < 0.02);
    assert!((check(|_| 7.0) - 1.0).abs() < 1e-9, "a clock that stands is no encoder");
}

/// Another unit, jitter at a filament that stands: such an encoder hides every slip, and is told.
#[test]
fn p6_an_encoder_that_reads_more_than_the_motor_went_is_no_witness() {
    let jitter = |size_m: f64| move |way_m: f64| if (way_m * 5e4).fract() < 0.5 { 0.0 } else { size_m };
    assert!(slip_of(|way_m| 4.0 * way_m, |way_m| 4e3 * way_m).reads_too_much(), "millimetres");
    assert!(slip_of(|way_m| 4.0 * way_m, |way_m| 5.2 * way_m).reads_too_much());
    assert!(slip_of(|way_m| 4.0 * way_m, jitter(3e-4)).reads_too_much(), "10 times a millimetre");
    assert!(!slip_of(|way_m| 4.0 * way_m, |way_m| 4.8 * way_m).reads_too_much());
    // States that come late and all at once: the encoder leads by 4 mm now and then.
    let late = |way_m: f64| (way_m * 250.0).floor() / 250.0;
    assert!(!slip_of(|way_m| 4.0 * late(way_m), |way_m| 4.0 * way_m).reads_too_much());
    let strokes = |way_m: f64| 4.0 * way_m + if (way_m * 1e3).fract() < 0.5 { 0.0 } else { -8e-4 };
    assert!(!slip_of(strokes, strokes).reads_too_much());
}

/// A host that tells its state at 4 Hz hides the strokes between two states: 0.35 mm forward and 0.15 mm back, five times or so.
#[test]
fn p6_strokes_that_no_state_shows_are_no_surplus() {
    let params = FilamentParams { window_m: 5e-3, play_m: 1e-4, slip_max: 0.42, surplus_max: 0.25 };
    let mut check = FilamentCheck::new(params);
    let mut way_m = 0.0;
    for step in 0..60_000 {
        way_m += if step % 50 < 35 { 1e-5 } else { -1e-5 };
        check.on_encoder(Seconds(0.02 * f64::from(step)), way_m);
        if step % 263 == 0 {
            check.on_motor(Seconds(0.02 * f64::from(step)), way_m);
        }
        assert!(!check.reads_too_much(), "after {step}: {:?}", check.surplus());
    }
    assert!(check.surplus().is_some_and(|surplus| surplus.abs() < 0.1), "{:?}", check.surplus());
}

#[test]
fn p6_slip_is_known_once_the_window_is_gone_through_and_forgotten_on_demand() {
    let mut check =
        FilamentCheck::new(FilamentParams { window_m: 6e-3, play_m: 0.0, slip_max: 0.45, surplus_max: 0.25 });
    check.on_motor(Seconds(-1.0), 0.0);
    check.on_encoder(Seconds(0.0), 0.0);
    let known = (0..1000).find(|step| {
        check.on_encoder(Seconds(0.02 * f64::from(*step)), 0.0);
        check.on_motor(Seconds(0.02 * f64::from(*step)), f64::from(*step) * 1e-5);
        check.slip().is_some()
    });
    // 15 marks of 0.4 mm make 6 mm; each mark may come a step of 10 um late.
    assert!(known.is_some_and(|step| (600..=615).contains(&step)), "{known:?}");
    check.reset();
    assert!(check.slip().is_none() && !check.tripped());
}

fn impulses(bursts: &[(f64, usize, f64)]) -> ImpulseCheck {
    let mut check = ImpulseCheck::new(ImpulseParams {
        commanded_max_m_s2: 10.0,
        residual_m_s2: 12.0,
        samples: 4,
        span_s: 0.02,
        apart_s: 0.2,
        still_s: 1.0,
    });
    check.on_samples(Seconds(0.0), Seconds(1e-3), &vec![[0.0, 0.0, 9.81]; 1000]);
    for (start_s, count, size_m_s2) in bursts {
        check.on_samples(Seconds(*start_s), Seconds(1e-3), &vec![[0.0, *size_m_s2, 9.81]; *count]);
    }
    check
}

#[test]
fn p8_impulses_are_counted_by_size_number_and_distance() {
    assert_eq!(impulses(&[(1.1, 4, 22.1)]).total(), 1);
    assert_eq!(impulses(&[(1.1, 4, 21.9)]).total(), 0, "what moves command");
    assert_eq!(impulses(&[(1.1, 3, 40.0)]).total(), 0, "too few");
    assert_eq!(impulses(&[(1.1, 2, 40.0), (1.115, 2, 40.0)]).total(), 1, "within 20 ms");
    assert_eq!(impulses(&[(1.1, 2, 40.0), (1.13, 2, 40.0)]).total(), 0, "farther apart");
    assert_eq!(impulses(&[(1.1, 4, 40.0), (1.25, 4, 40.0)]).total(), 1, "one and the same");
    assert_eq!(impulses(&[(1.1, 4, 40.0), (1.35, 4, 40.0)]).total(), 2);
    assert!(impulses(&[(1.1, 4, 40.0)]).recent(Seconds(31.1), Seconds(30.0)));
    assert!(!impulses(&[(1.1, 4, 40.0)]).recent(Seconds(31.2), Seconds(30.0)));
}

/// A mounting that tilts by 5 m/s2 is still after some time constants of 1 s: e^-6 of it is left.
#[test]
fn p8_what_is_still_follows_the_mounting() {
    let mut check = impulses(&[]);
    let tilted = [5.0, 0.0, 8.4];
    check.on_samples(Seconds(1.0), Seconds(1e-3), &vec![tilted; 6000]);
    check.on_samples(Seconds(7.1), Seconds(1e-3), &[[5.0 + 21.5, 0.0, 8.4]; 4]);
    assert_eq!(check.total(), 0);
    check.on_samples(Seconds(7.5), Seconds(1e-3), &[[5.0 + 22.2, 0.0, 8.4]; 4]);
    assert_eq!(check.total(), 1);
}
