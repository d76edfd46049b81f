//! Frames that tell of no force, or of no other one.

use super::*;

/// A drive that slips through for a while: the roads lack what did not pass the encoder, and nothing more is held. Taken for held it
/// would be a force of two to three times.
#[test]
fn what_did_not_pass_the_encoder_is_not_held() {
    for (lasts_s, first_s) in [(0.6, 0.25), (1.0, 0.05), (1.0, 0.3), (1.5, 0.4)] {
        let (mut melt, mut clog) = (Melt::steady(), Clog::new(EAGER));
        melt.run(&mut clog, (2.0, 0.5), 1.0, 1.0);
        melt.run(&mut clog, (lasts_s, first_s), 1.0, 0.0);
        melt.run(&mut clog, (10.0, 0.25), 1.0, 1.0);
        assert!((clog.factor() - 1.0).abs() < 0.05, "{lasts_s} {first_s}: {}", clog.factor());
    }
}

/// A drive that slips while a nozzle narrows: what it lost is no force.
#[test]
fn what_slips_while_a_nozzle_narrows_is_not_held() {
    let (mut melt, mut clog) = (Melt::steady(), Clog::new(EAGER));
    melt.run(&mut clog, (2.0, 0.5), 1.0, 1.0);
    melt.run(&mut clog, (1.0, 0.25), 2.0, 0.5);
    melt.run(&mut clog, (10.0, 0.25), 2.0, 1.0);
    assert!((clog.factor() / 2.0 - 1.0).abs() < 0.1, "{}", clog.factor());
}

/// Frames in turn, each half second, as what lacks in them.
fn shown(lacking: impl IntoIterator<Item = f64>) -> Clog {
    let (mut clog, mut melt) = (Clog::new(EAGER), Melt::steady());
    for lacking in lacking {
        melt.now_s += 0.5;
        clog.on_look(melt.look(lacking), melt.ahead());
    }
    clog
}

/// A leak lacks as much all the time, a road that is not seen all of it; a bubble is a single frame, and so is the noise of a
/// width at the thin end of a road; and one that is thin already when it is first seen began nobody knows when.
#[test]
fn what_tells_of_no_force_changes_nothing() {
    let after_sound = |lacking: f64, frames: usize| {
        [0.0; 5].into_iter().chain(std::iter::repeat_n(lacking, frames)).chain([0.0; 5])
    };
    let (mut thin, mut melt) = (Clog::new(EAGER), Melt::steady());
    melt.run(&mut thin, (12.0, 0.25), 2.5, 1.0);
    let bubbles = (0..10).flat_map(|_| after_sound(0.3, 1));
    let cases = [
        ("leak", shown(after_sound(0.25, 60))),
        ("large leak", shown(after_sound(0.85, 60))),
        ("no road seen", shown(after_sound(1.1, 60))),
        ("not seen twice", shown(after_sound(0.95, 2))),
        ("bubbles", shown(bubbles)),
        ("noise", shown([0.0, 0.0, 0.19, 0.014, 0.0])),
        ("thin", thin),
    ];
    for (name, clog) in cases {
        assert!(!clog.is_beyond() && clog.factor() <= 1.0 && clog.carried_m() <= 0.0, "{name}: {clog:?}");
    }
}

/// What was told early stands where another road cuts the dip off: its frames still lacked.
#[test]
fn a_road_that_cuts_off_what_has_told_takes_nothing_back() {
    let mut clog = shown([0.0, 0.0, 0.95, 0.85, 0.65]);
    let told = clog.factor();
    clog.on_unsettled(2.0 * FEED_M_S, 0.0, Melt::steady().ahead());
    assert!(told > 2.0 && (clog.factor() - told).abs() < 1e-15, "{told}: {}", clog.factor());
}

/// Two frames are enough for that, and a road that is a fifth faster is the same.
#[test]
fn two_frames_stand_and_a_little_faster_cuts_off_nothing() {
    for (frames, faster) in [(2, 2.0), (1, 1.2)] {
        let mut clog = shown([0.0, 0.0, 0.95, 0.85].into_iter().take(2 + frames));
        let told = clog.factor();
        clog.on_unsettled(faster * FEED_M_S, 0.0, Melt::steady().ahead());
        assert!(told > 2.0 && (clog.factor() - told).abs() < 1e-15, "{frames}: {told} {}", clog.factor());
    }
}

/// A leak behind a nozzle that has narrowed: it is as narrow as it was.
#[test]
fn what_lasts_takes_back_no_other_word() {
    let (mut melt, mut clog) = narrowed(2.0, 0.25);
    let told = (clog.factor(), clog.carried_m());
    for _ in 0..60 {
        melt.now_s += 0.5;
        clog.on_look(melt.look(0.185), melt.ahead());
    }
    assert_eq!((clog.factor(), clog.carried_m()), told);
}

/// Nobody knows what a dip came to that another road cuts off after a halt.
#[test]
fn a_dip_of_long_ago_tells_nothing() {
    let after = |halt_s: f64| {
        let (mut melt, mut clog) = (Melt::steady(), Clog::new(SETTINGS));
        melt.run(&mut clog, (2.0, 0.5), 1.0, 1.0);
        melt.run(&mut clog, (1.2, 0.25), 2.0, 1.0);
        let (now_s, ahead) = (melt.now_s + halt_s, melt.ahead());
        clog.on_unsettled(2.0 * FEED_M_S, 0.0, Ahead { now_s, acts_s: now_s, ..ahead });
        clog.factor()
    };
    assert!(after(1.0) > 1.5 && (after(3600.0) - 1.0).abs() < 1e-15);
}

/// Roads that never settle tell no force; where two in a row lack much it is open.
#[test]
fn thin_roads_that_never_settle_open_the_force() {
    for (frames, doubt) in [
        (&[(0.5, 0.6), (1.0, 0.6)][..], 1.0),
        (&[(0.5, 0.6)], 0.0),
        (&[(0.5, 0.3), (1.0, 0.3)], 0.0),
        (&[(0.5, 0.6), (1.0, 0.0), (1.5, 0.6)], 0.0),
        (&[(0.5, 0.6), (9.0, 0.6)], 0.0),
        (&[(0.5, -0.6), (1.0, -0.6)], 0.0),
    ] {
        let mut clog = Clog::new(EAGER);
        for (now_s, lacking) in frames {
            let ahead = Ahead { now_s: *now_s, acts_s: *now_s, ..Melt::steady().ahead() };
            assert!(!clog.on_unsettled(FEED_M_S, *lacking, ahead), "no word");
        }
        assert_eq!((clog.doubt(), clog.factor()), (doubt, 1.0), "{frames:?}");
    }
}

/// But what a single frame told is taken back: it may have been a bubble, and stand for the rest of the print.
#[test]
fn a_road_that_cuts_off_a_single_frame_takes_its_word_back() {
    for (lacking, faster) in [(0.3, true), (0.95, true), (0.3, false)] {
        let mut clog = shown([0.0, 0.0, lacking]);
        assert!(clog.factor() > 1.1, "{lacking}: {clog:?}");
        let (melt, later_s) = (Melt::steady(), 60.0);
        if faster {
            clog.on_unsettled(2.0 * FEED_M_S, 0.0, melt.ahead());
        } else {
            clog.on_look(Look { exposed_s: later_s, ..melt.look(0.0) }, melt.ahead());
        }
        assert!(!clog.is_beyond() && clog.factor() <= 1.0 && clog.carried_m() <= 0.0, "{lacking}: {clog:?}");
    }
}
