use super::*;
use crate::classifier::tests::{nominal, printer_status};
use crate::path::tests::road;
use models::motion::Trapezoid;
use models::status::JobPhase;

/// Shares every 20 ms of a print with these feeds `(m/s, s)` under an advance; the first status tells the start.
fn shares(feeds: &[(f64, f64)], advance_s: f64, change: impl Fn(&mut PrinterStatus)) -> Vec<f64> {
    let mut nozzle = NominalFlow::new(params(), nominal(), Kelvin(298.15));
    let (mut step, mut fed_m) = (0, 0.0);
    for &(feed_m_s, duration_s) in feeds {
        let end_s = 0.02 * f64::from(step) + duration_s;
        while 0.02 * f64::from(step) < end_s - 1e-9 {
            step += 1;
            fed_m += 0.02 * feed_m_s;
            let mut status = PrinterStatus {
                planned_feed_m_s: feed_m_s,
                wanted_position_m: fed_m + advance_s * feed_m_s,
                ..printer_status(0.02 * f64::from(step), JobPhase::Printing, 0)
            };
            change(&mut status);
            nozzle.on_status(&status);
        }
    }
    (1..=step).map(|step| nozzle.share(Seconds(0.02 * f64::from(step)), None)).collect()
}

/// Model book 2.2: after a step of the feed a part of `e^(-t/K)` of it is missing, near enough.
#[test]
fn roads_are_thin_until_the_pressure_is_there() {
    let steps = [(1e-3, 10.0), (2e-3, 5.0)];
    let without = shares(&steps, 0.0, |_| ());
    assert!((without[498] - 1.0).abs() < 1e-3, "at rest {}", without[498]);
    assert!((0.6..0.7).contains(&without[502]) && without[540] < 0.93, "{:?}", &without[500..550]);
    assert!(without[510..].is_sorted() && without[748] > 0.99, "{:?}", &without[500..]);
    let with = shares(&steps, nominal().material.lag_s, |_| ());
    assert!(with[502] > 0.9, "an advance brings it: {:?}", &with[500..510]);
    let slower = shares(&[(2e-3, 10.0), (1e-3, 5.0)], 0.0, |_| ());
    assert!(slower[505] > 1.2, "what is compressed flows on: {:?}", &slower[500..510]);
}

/// The law takes a fifth off: between a tenth and three tenths it may be, and nothing is wrong with the road.
#[test]
fn what_the_law_may_err_by_is_no_error_of_the_width() {
    let nozzle = NominalFlow::new(params(), nominal(), Kelvin(298.15));
    for (ratio, share, beside) in [
        (0.8, 0.8, 1.0),
        (0.71, 0.8, 1.0),
        (0.89, 0.8, 1.0),
        (0.56, 0.8, 0.8),
        (0.99, 0.8, 1.1),
        (1.0, 1.2, 1.0 / 1.1),
        (0.8, 1.0, 0.8),
        (1.2, 1.0, 1.2),
    ] {
        let told = nozzle.beside_sound(ratio, share);
        assert!((told - beside).abs() < 1e-9, "{ratio} at {share}: {told}");
    }
    assert!(nozzle.beside_sound(f64::NAN, 0.8).is_nan());
}

/// A flow that the loop corrects is no pressure that is missing; what the encoder loop adds is not in the wanted filament.
#[test]
fn a_trim_is_wanted() {
    let trimmed = shares(&[(2e-3, 10.0)], 0.0, |status| {
        status.trims.flow = 1.2;
        status.wanted_position_m *= 1.2;
    });
    assert!((trimmed[498] - 1.0).abs() < 1e-3, "{}", trimmed[498]);
}

fn raw() -> RawPressure {
    RawPressure {
        kept_s: 60.0,
        gap_max_s: 0.3,
        jump_max_m: 0.05,
        slow_rel: 0.25,
        share: [0.6, 1.4],
        unsure: 0.5,
    }
}

fn params() -> PressureParams {
    raw().try_into().unwrap()
}

#[test]
fn what_is_not_known_takes_nothing_off() {
    let rare = shares(&[(1e-3, 3.0), (2e-3, 0.2)], 0.0, |status| status.stamp.0 *= 20.0);
    assert!(rare.iter().all(|share| (share - 1.0).abs() < 1e-12), "slow hosts without their moves");
    for spoil in [f64::NAN, 1e3] {
        let spoiled = shares(&[(1e-3, 3.0), (2e-3, 0.1)], 0.0, |status| {
            if (status.stamp.0 - 3.0).abs() < 0.01 {
                status.wanted_position_m += spoil;
            }
        });
        assert!(spoiled[..149].iter().all(|share| (share - 1.0).abs() < 1e-12), "{spoiled:?}");
        assert!(spoiled[150..].iter().all(|share| (0.6..=1.0).contains(share)), "{spoiled:?}");
    }
}

/// A move of a feed `[m/s]` at 50 mm/s for a time.
fn laid_at(feed_m_s: f64, duration_s: f64) -> Segment {
    let length_m = 0.05 * duration_s;
    Segment {
        length_m,
        filament_m: feed_m_s * duration_s,
        profile: Trapezoid {
            entry_m_s: 0.05,
            cruise_m_s: 0.05,
            exit_m_s: 0.05,
            acceleration_m_s2: 1.0,
            accel_s: 0.0,
            cruise_s: duration_s,
            decel_s: 0.0,
        },
        ..road(0, [0.1, 0.1], [0.1 + length_m, 0.1])
    }
}

/// Shares every 20 ms where one status alone was heard: what the moves tell is what statuses would have told.
fn shares_of_moves(feeds: &[(f64, f64)], advance_s: f64) -> Vec<f64> {
    let mut nozzle = NominalFlow::new(params(), nominal(), Kelvin(298.15));
    nozzle.on_status(&PrinterStatus { advance_s, ..printer_status(0.0, JobPhase::Printing, 0) });
    let mut begin_s = 100.0;
    for &(feed_m_s, duration_s) in feeds {
        nozzle.on_move(begin_s, &laid_at(feed_m_s, duration_s));
        begin_s += duration_s;
    }
    let mut told = Vec::new();
    while 100.0 + 0.02 * told.len() as f64 + 0.02 < begin_s {
        let path_s = 100.0 + 0.02 * (told.len() + 1) as f64;
        told.push(nozzle.share(Seconds(5.0), Some(path_s)));
    }
    told
}

#[test]
fn of_a_slow_host_the_moves_tell_what_statuses_would() {
    let steps = [(1e-3, 10.0), (2e-3, 5.0), (1e-3, 5.0)];
    for advance_s in [0.0, nominal().material.lag_s] {
        let (moves, statuses) = (shares_of_moves(&steps, advance_s), shares(&steps, advance_s, |_| ()));
        for (at, (moved, told)) in moves.iter().zip(&statuses).enumerate().skip(400) {
            // The first status tells only where it starts; at the very step one of them stands on its far side.
            let step = [499, 500, 749, 750].contains(&at);
            assert!(step || (moved - told).abs() < 0.02, "{at}: {moved} {told}");
        }
    }
    let thin = shares_of_moves(&steps, 0.0);
    assert!(thin[505] < 0.8 && thin[755] > 1.2, "{:?}", &thin[495..515]);
}

/// A plan that goes back, and a rest: what was compressed has flown on.
#[test]
fn moves_that_do_not_follow_begin_anew() {
    let mut nozzle = NominalFlow::new(params(), nominal(), Kelvin(298.15));
    nozzle.on_status(&printer_status(0.0, JobPhase::Printing, 0));
    let mut begun = |begin_s: f64| {
        nozzle.on_move(begin_s, &laid_at(1e-3, 5.0));
        [0.1, 4.9].map(|after_s| nozzle.share(Seconds(9.0), Some(begin_s + after_s)))
    };
    let first = begun(100.0);
    assert!(first[0] < 0.7 && first[1] > 0.97, "{first:?}");
    let (on, rested, back) = (begun(105.0), begun(114.0), begun(50.0));
    assert!(on[0] > 0.97, "{on:?}");
    assert!(rested[0] < 0.9 && rested[1] > 0.97, "{rested:?}");
    assert!((back[0] - first[0]).abs() < 0.02, "{back:?}");
}

#[test]
fn a_share_that_cannot_be_is_refused_with_its_name() {
    let raw = RawPressure { share: [1.1, 1.4], ..raw() };
    assert!(PressureParams::try_from(raw).unwrap_err().to_string().contains("pressure.share[0]"));
}
