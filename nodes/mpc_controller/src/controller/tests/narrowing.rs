//! A nozzle that narrows: what becomes of the laws of coming moves.

use super::preview::line;
use super::*;
use models::bead::stadium;
use models::command::{AdvanceLaw, MotionTrim};
use models::extruder::{Pressure, StaticLaw};

const TARGET_M: f64 = 4.8e-4;
const HEIGHT_M: f64 = 2e-4;

/// Ten steps, and a frame at their end of a road in which this share of the flow lacks.
fn see(rig: &mut Rig, lacking: f64, shape: impl Fn(Estimate) -> Estimate) {
    rig.run(10, shape);
    let factor = rig.in_force.speed / (1.0 + rig.controller.held[SPEED]);
    let section = (1.0 - lacking) / factor - 1.0;
    let area_m2 = (1.0 + section) * stadium::area_m2(TARGET_M, HEIGHT_M);
    let width_m = stadium::width_of_area_m(area_m2, HEIGHT_M);
    rig.controller.on_event(Event::Width { exposed: Seconds(rig.now_s()), width_m });
}

/// Force over that before `[-]`.
const FORCE: f64 = 1.5;

/// Shares that lack in frames each half second, the first after a quarter, behind a nozzle that has come to need `force` times
/// the melt's part of a law.
fn dip(law: AdvanceLaw, force: f64) -> [f64; 5] {
    let of = |force: f64| StaticLaw::of_compression(law.index, force * law.shear, law.linear_s);
    let mut pressure = Pressure::steady(&of(1.0), FEED_M_S);
    std::array::from_fn(|frame| {
        for _ in 0..if frame == 0 { 250 } else { 500 } {
            pressure.step(&of(force), FEED_M_S, Seconds(1e-3));
        }
        1.0 - pressure.outlet().speed_m_s / FEED_M_S
    })
}

/// A sound road, settled before its first frame, then the dip of a nozzle that narrows; the law that a move gets before and behind it.
fn after_a_dip(shape: impl Fn(Estimate) -> Estimate + Copy) -> (Rig, MotionTrim, MotionTrim) {
    let mut rig = Rig::new(Level::Mpc);
    rig.run(100, shape);
    for _ in 0..6 {
        see(&mut rig, 0.0, shape);
    }
    let before = coming(&mut rig);
    dip(before.advance, FORCE).into_iter().for_each(|lacking| see(&mut rig, lacking, shape));
    let after = coming(&mut rig);
    (rig, before, after)
}

fn coming(rig: &mut Rig) -> MotionTrim {
    let now = Seconds(rig.now_s());
    rig.controller.on_coming(now, 1, &line()).unwrap()
}

/// What lacked is held: it is what the law has grown by at that feed, and is not pushed.
#[test]
fn laws_grow_by_what_a_dip_took_from_the_roads_and_push_none_of_it() {
    let (_, before, after) = after_a_dip(|estimate| estimate);
    assert!(before.carried_m.abs() < 1e-15, "{before:?}");
    let more_m = (FORCE - 1.0) * before.advance.shear * FEED_M_S.powf(before.advance.index);
    assert!((after.carried_m / more_m - 1.0).abs() < 0.2, "{} of {more_m} m", after.carried_m);
    assert!(after.advance.shear > 1.3 * before.advance.shear, "{before:?} {after:?}");
    // what the loop's own trims of the dip teach of the whole law is some per cent: the rig's flow follows its feed at once
    assert!((after.advance.linear_s / before.advance.linear_s - 1.0).abs() < 0.1, "{before:?} {after:?}");
    let pushed_m = after.advance.held_m(FEED_M_S) - after.carried_m - before.advance.held_m(FEED_M_S);
    assert!(pushed_m.abs() < 0.1 * after.carried_m, "{pushed_m} of {} m", after.carried_m);
}

/// Beyond what the laws follow each change of speed leaves the widths off for longer: frames are waited for.
#[test]
fn behind_a_nozzle_that_cannot_be_followed_a_frame_has_to_wait_longer() {
    let mut rig = Rig::new(Level::Mpc);
    // whether a frame of a wide road, so long after a change of path speed, moves a trim
    let counts = |rig: &mut Rig, since_s: f64| {
        rig.run(10, |estimate| estimate);
        let before = rig.controller.held[FEED];
        rig.controller.steady_since_s = rig.now_s() - since_s;
        rig.controller.on_event(Event::Width { exposed: Seconds(rig.now_s()), width_m: 1.04 * TARGET_M });
        (rig.controller.held[FEED] - before).abs() > 0.0
    };
    rig.run(100, |estimate| estimate);
    (0..4).for_each(|_| see(&mut rig, 0.0, |estimate| estimate));
    assert!(!counts(&mut rig, 0.1) && counts(&mut rig, 0.3));
    (0..4).for_each(|_| see(&mut rig, 0.0, |estimate| estimate));
    let law = coming(&mut rig).advance;
    dip(law, 2.0 * rig.controller.params.clog.force_max).into_iter().for_each(|lacking| {
        see(&mut rig, lacking, |estimate| estimate);
    });
    assert!(rig.controller.clog.is_beyond());
    rig.run(600, |estimate| estimate);
    assert!(!counts(&mut rig, 0.3) && counts(&mut rig, 0.6));
}

/// Nobody vouches for the feed: what lacks may not have been fed.
#[test]
fn without_an_encoder_a_dip_tells_of_no_force() {
    let (_, _, after) = after_a_dip(|estimate| Estimate { encoder_alive: false, ..estimate });
    assert!(after.carried_m.abs() < 1e-15, "{after:?}");
}

/// What lacks in a dip is no error of the law: its frames teach nothing of it, those before and behind it do.
#[test]
fn a_dip_teaches_nothing_of_the_law() {
    let mut rig = Rig::new(Level::Mpc);
    let frames = |rig: &mut Rig, lacking: &[f64]| {
        let before = rig.controller.advance.frames_learnt();
        lacking.iter().for_each(|lacking| see(rig, *lacking, |estimate| estimate));
        rig.controller.advance.frames_learnt() - before
    };
    assert!(frames(&mut rig, &[0.0; 6]) > 4.0);
    // the frame that begins it is the first that may be known
    assert!(frames(&mut rig, &[0.3, 0.28, 0.26, 0.24]) < 1.1);
    frames(&mut rig, &[0.1, 0.03]);
    see(&mut rig, 0.0, |estimate| estimate);
    rig.run(100, |estimate| estimate);
    assert!(frames(&mut rig, &[0.0; 4]) > 3.0);
}

/// Whoever paused may have cleaned the nozzle.
#[test]
fn a_pause_forgets_the_clog() {
    let (mut rig, before, _) = after_a_dip(|estimate| estimate);
    let paused = PrinterStatus {
        phase: JobPhase::Paused,
        depositing: false,
        ..status(rig.now_s() + 0.02, rig.wanted_m, rig.in_force)
    };
    rig.controller.on_event(Event::Printer(paused));
    let after = coming(&mut rig);
    assert!(after.carried_m.abs() < 1e-15, "{after:?}");
    assert!((after.advance.shear / before.advance.shear - 1.0).abs() < 0.2, "{before:?} {after:?}");
}

/// A nozzle that needs more force reaches the drive's sooner: what the drive can push is planned at a lower speed.
#[test]
fn a_clogged_nozzle_is_asked_for_less() {
    use models::motion::{Segment, Trapezoid};
    let (mut rig, _, _) = after_a_dip(|estimate| estimate);
    let most_m_s = rig.controller.feed_max_m_s(&estimate(rig.now_s()));
    let profile = Trapezoid::new(0.08, (0.0, 0.0), 0.99 * most_m_s / (2.6e-3 / 0.08), 1e3);
    let now = Seconds(rig.now_s());
    let trim = rig.controller.on_coming(now, 1, &Segment { profile, ..line() }).unwrap();
    assert!(trim.speed < 0.95, "{trim:?}");
}
