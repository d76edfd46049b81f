//! Dips so deep that each of their frames tells.

use super::*;

/// One so deep tells by its first frame: what the nozzle holds by then is carried, what it will hold more is pushed, and no more than
/// the drive can. With `deep` at 1 it has to pass first.
#[test]
fn a_deep_dip_is_told_of_by_its_first_frame() {
    let melt_m = SOUND.shear * FEED_M_S.powf(SOUND.index);
    let seen = |settings: RawClog, (force, first_s): (f64, f64)| {
        let (mut melt, mut clog) = (Melt::steady(), Clog::new(settings));
        melt.run(&mut clog, (2.0, 0.5), 1.0, 1.0);
        melt.run(&mut clog, (first_s + 1e-4, first_s), force, 1.0);
        (clog, melt.held_m - SOUND.held_m(FEED_M_S), melt.now_s)
    };
    for case in [(1.0 / 0.7, 0.1), (1.0 / 0.7, 0.3), (2.0, 0.2), (3.5, 0.05), (5.0, 0.25), (5.0, 0.45)] {
        let (clog, held_m, now_s) = seen(RawClog { force_max: 10.0, ..EAGER }, case);
        assert!((clog.factor() / case.0 - 1.0).abs() < 0.25, "{case:?}: {}", clog.factor());
        let (whole_m, carried_m) = ((case.0 - 1.0) * melt_m, clog.carried_m());
        assert!((carried_m - held_m).abs() < 0.25 * whole_m, "{case:?}: {carried_m} of {held_m} m");
        assert!(carried_m < 0.6 * whole_m, "{case:?}: {carried_m} m, all of it");
        let (waits, ..) = seen(RawClog { deep: 1.0, ..EAGER }, case);
        assert!((waits.factor() - 1.0).abs() < 1e-15, "{case:?}: {}", waits.factor());
        for clog in [clog, waits] {
            assert!(clog.rest(now_s) > 0.2, "{case:?}: {}", clog.rest(now_s));
        }
    }
    let (clog, ..) = seen(EAGER, (7.0, 0.05));
    assert!(clog.is_beyond() && (clog.factor() - SETTINGS.force_max).abs() < 1e-12, "{}", clog.factor());
}

/// What a law pushes since the first frame has told is no other force to the second one, and is not pushed again: a nozzle that the
/// drive fills gives the road its flow.
#[test]
fn what_was_pushed_is_known_when_the_dip_tells_again() {
    for (force, first_s) in [(1.0 / 0.7, 0.1), (1.0 / 0.7, 0.4), (2.0, 0.2), (2.5, 0.3)] {
        let (mut melt, mut clog) = (Melt::steady(), Clog::new(EAGER));
        melt.run(&mut clog, (2.0, 0.5), 1.0, 1.0);
        melt.run(&mut clog, (first_s + 1e-4, first_s), force, 1.0);
        for frame in 2..=3 {
            let told = clog.factor();
            melt.push(&clog);
            melt.run(&mut clog, (0.2501, 0.25), force, 1.0);
            let lacks = 1.0 - melt.outlet_m_s(force) / FEED_M_S;
            assert!((clog.factor() / force - 1.0).abs() < 0.15, "{force} {first_s}: {}", clog.factor());
            assert!(frame == 2 || (clog.factor() / told - 1.0).abs() < 0.1, "{told} {}", clog.factor());
            assert!(frame == 2 || lacks.abs() < 0.04, "{force} {first_s}: {lacks} lacks");
        }
    }
}

/// Until a law acts the road fills by itself: that is not pushed.
#[test]
fn a_law_that_acts_later_pushes_less() {
    let pushed_m = |acts_in_s: f64| {
        let (mut melt, mut clog) = (Melt::steady(), Clog::new(EAGER));
        melt.run(&mut clog, (2.0, 0.5), 1.0, 1.0);
        melt.run(&mut Clog::new(EAGER), (0.1, 9.0), 2.0, 1.0);
        let lacking = 1.0 - melt.outlet_m_s(2.0) / FEED_M_S;
        clog.on_look(melt.look(lacking), Ahead { acts_s: melt.now_s + acts_in_s, ..melt.ahead() });
        melt.run(&mut Clog::new(EAGER), (acts_in_s, 9.0), 2.0, 1.0);
        melt.push(&clog);
        (melt.driven.beyond_m(melt.melt_m()), 1.0 - melt.outlet_m_s(2.0) / FEED_M_S)
    };
    let ((at_once_m, lacks), (later_m, lacks_later)) = (pushed_m(0.01), pushed_m(0.8));
    assert!(later_m < 0.6 * at_once_m, "{later_m} {at_once_m}");
    assert!(lacks.abs() < 0.1 && lacks_later.abs() < 0.1, "{lacks} {lacks_later}");
}

/// What the drive has pushed between a frame and its arrival is held by then.
#[test]
fn what_passed_since_the_frame_is_held() {
    let carried_m = |more_m: f64| {
        let (mut melt, mut clog) = (Melt::steady(), Clog::new(EAGER));
        melt.run(&mut clog, (2.0, 0.5), 1.0, 1.0);
        melt.run(&mut Clog::new(EAGER), (0.1, 9.0), 2.0, 1.0);
        let look = melt.look(1.0 - melt.outlet_m_s(2.0) / FEED_M_S);
        let now_s = melt.now_s + 0.2;
        clog.on_look(look, Ahead { now_s, acts_s: now_s, excess_m: look.excess_m + more_m, ..melt.ahead() });
        clog.carried_m()
    };
    let more_m = 0.3 * Melt::steady().melt_m();
    let held_m = carried_m(more_m) - carried_m(0.0);
    assert!((0.5..1.1).contains(&(held_m / more_m)), "{held_m} of {more_m} m");
}

/// A dip that fits a force for longer than any passes is none that a law should follow.
#[test]
fn a_told_dip_that_lasts_is_taken_back() {
    let (mut melt, mut clog) =
        (Melt::steady(), Clog::new(RawClog { lasts_s: 4.0, force_max: 10.0, ..EAGER }));
    melt.run(&mut clog, (2.0, 0.5), 1.0, 1.0);
    melt.run(&mut clog, (4.0, 0.25), 9.0, 1.0);
    assert!(clog.factor() > 5.0, "{}", clog.factor());
    melt.run(&mut clog, (1.0, 0.25), 9.0, 1.0);
    assert!((clog.factor() - 1.0).abs() < 1e-15, "{}", clog.factor());
}

/// A narrow nozzle narrows again: what the drive holds for the first time is not pushed twice.
#[test]
fn a_second_dip_tells_beside_the_first() {
    let (mut melt, mut clog) = (Melt::steady(), Clog::new(EAGER));
    melt.run(&mut clog, (2.0, 0.5), 1.0, 1.0);
    for (before, force) in [(1.0, 1.6), (1.6, 2.6)] {
        melt.run(&mut clog, (0.2001, 0.2), force, 1.0);
        for _ in 0..2 {
            melt.push(&clog);
            melt.run(&mut clog, (0.2501, 0.25), force, 1.0);
        }
        let lacks = 1.0 - melt.outlet_m_s(force) / FEED_M_S;
        assert!((clog.factor() / force - 1.0).abs() < 0.15, "{before}: {}", clog.factor());
        assert!(lacks.abs() < 0.05, "{before}: {lacks} lacks");
        melt.push(&clog);
        melt.run(&mut clog, (12.0, 0.25), force, 1.0);
    }
}
