//! A nozzle that narrows: what becomes of the laws of coming moves.

use super::preview::line;
use super::*;
use crate::params::RawClog;
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

/// A sound road, settled before its first frame, then the dip of a nozzle that narrows, which has to pass before it tells; the law
/// that a move gets before and behind it.
fn after_a_dip(shape: impl Fn(Estimate) -> Estimate + Copy) -> (Rig, MotionTrim, MotionTrim) {
    let mut rig = Rig::new(Level::Mpc);
    rig.controller.clog = Clog::new(RawClog { deep: 1.0, ..rig.controller.params.clog });
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
    rig.controller.on_coming(now, &preview::coming(line())).unwrap()
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
    let trim = rig.controller.on_coming(now, &preview::coming(Segment { profile, ..line() })).unwrap();
    assert!(trim.speed < 0.95, "{trim:?}");
}

/// A rig whose host knows three moves, one that begins at once, one 0.1 s later and one far ahead, and has seen the first frame of a
/// dip; their trims.
fn beside_coming_moves() -> (Rig, [MotionTrim; 3]) {
    let mut rig = Rig::new(Level::Mpc);
    rig.executes = true;
    rig.run(100, |estimate| estimate);
    (0..6).for_each(|_| see(&mut rig, 0.0, |estimate| estimate));
    let begins_s = rig.now_s();
    let sent = [(1, 0.51), (2, 0.61), (3, 5.0)].map(|(sequence, in_s)| {
        let start = Seconds(begins_s + in_s);
        rig.controller.on_coming(Seconds(rig.now_s()), &Coming { sequence, start, segment: line() }).unwrap()
    });
    assert!(rig.controller.take_anew(Seconds(rig.now_s())).is_empty(), "nothing is other than it was");
    see(&mut rig, dip(sent[0].advance, FORCE)[0], |estimate| estimate);
    (rig, sent)
}

/// What the first frame of a dip tells goes out with moves that were sent already, but not with one that begins at once.
#[test]
fn moves_that_are_known_are_sent_anew_when_a_dip_tells() {
    let (mut rig, sent) = beside_coming_moves();
    let now = Seconds(rig.now_s());
    let anew = rig.controller.take_anew(now);
    assert_eq!(
        anew.iter().map(|trim| trim.sequence).collect::<Vec<_>>(),
        [2, 3],
        "the first begins in 10 ms"
    );
    assert!(anew[0].advance.shear > 1.3 * sent[1].advance.shear, "{anew:?} {sent:?}");
    let held_m = |trim: &MotionTrim| trim.advance.held_m(FEED_M_S) - trim.carried_m;
    assert!(held_m(&anew[0]) > 1.05 * held_m(&sent[1]), "what the nozzle lacks is pushed: {anew:?}");
    assert!(rig.controller.take_anew(now).is_empty(), "once");
}

/// What was sent for a clog is not left with moves behind a pause.
#[test]
fn a_pause_sends_known_moves_as_through_a_sound_nozzle() {
    let (mut rig, sent) = beside_coming_moves();
    rig.controller.take_anew(Seconds(rig.now_s()));
    let laid = status(rig.now_s() + 0.001, rig.wanted_m, rig.in_force);
    rig.controller.on_event(Event::Printer(PrinterStatus {
        phase: JobPhase::Paused,
        depositing: false,
        ..laid
    }));
    let anew = rig.controller.take_anew(Seconds(rig.now_s()));
    assert_eq!(anew.iter().map(|trim| trim.sequence).collect::<Vec<_>>(), [2, 3]);
    for (sound, anew) in sent[1..].iter().zip(&anew) {
        let grown = anew.advance.shear / sound.advance.shear - 1.0;
        assert!(grown.abs() < 0.1 && anew.carried_m.abs() < 1e-15, "{sound:?} {anew:?}");
    }
}

/// What is sent anew is of the slicer's own feed, however often; and nothing goes out that is as it was.
#[test]
fn what_is_sent_anew_does_not_compound() {
    let (mut rig, _) = beside_coming_moves();
    rig.controller.held[FEED] = 0.1;
    let now = Seconds(rig.now_s());
    assert_eq!(rig.controller.take_anew(now).len(), 2);
    rig.controller.anew = true;
    assert!(rig.controller.take_anew(now).is_empty());
}

/// Where no law is known for a moment, moves get it later.
#[test]
fn what_cannot_be_sent_anew_is_sent_once_it_can() {
    let (mut rig, _) = beside_coming_moves();
    let now_s = rig.now_s();
    assert!(rig.controller.take_anew(Seconds(now_s + 1.0)).is_empty(), "the estimate is too old");
    assert_eq!(rig.controller.take_anew(Seconds(now_s)).len(), 2);
}

/// A faster road takes back what a single frame told: so it is with moves that have the word already.
#[test]
fn what_is_taken_back_is_sent_anew() {
    let (mut rig, sent) = beside_coming_moves();
    rig.controller.take_anew(Seconds(rig.now_s()));
    let (from_s, wanted_m, in_force) = (rig.now_s(), rig.wanted_m, rig.in_force);
    for step in 1..=3 {
        let status = status(from_s + 0.02 * f64::from(step), wanted_m, in_force);
        rig.controller.on_event(Event::Printer(PrinterStatus {
            planned_speed_m_s: 2.0 * status.planned_speed_m_s,
            planned_feed_m_s: 2.0 * status.planned_feed_m_s,
            path_time_s: from_s,
            ..status
        }));
    }
    rig.controller.on_event(Event::Width { exposed: Seconds(from_s + 0.02), width_m: TARGET_M });
    let anew = rig.controller.take_anew(Seconds(from_s));
    assert_eq!(anew.iter().map(|trim| trim.sequence).collect::<Vec<_>>(), [2, 3]);
    assert!((anew[0].advance.shear / sent[1].advance.shear - 1.0).abs() < 0.1, "{anew:?} {sent:?}");
}

/// Who has sent a move on has no use for another trim of it.
#[test]
fn a_serial_host_gets_no_trim_twice() {
    let (mut rig, _) = beside_coming_moves();
    let now_s = rig.now_s();
    let serial =
        PrinterStatus { host: HostProfile::Serial, ..status(now_s + 0.001, rig.wanted_m, rig.in_force) };
    rig.controller.on_event(Event::Printer(serial));
    assert!(rig.controller.take_anew(Seconds(now_s)).is_empty());
}

/// The path is slowed down until a move that pushes begins.
#[test]
fn a_move_that_pushes_ends_the_slowing() {
    let speed_after = |anew: bool| {
        let (mut rig, _) = beside_coming_moves();
        if anew {
            rig.controller.take_anew(Seconds(rig.now_s()));
        }
        rig.run(1, |estimate| estimate);
        let slowed = rig.in_force.speed;
        let advance_s = rig.in_force.advance_s.unwrap();
        let laid = status(rig.now_s() + 0.001, rig.wanted_m, rig.in_force);
        let path_time_s = laid.path_time_s + 0.1;
        rig.controller.on_event(Event::Printer(PrinterStatus { advance_s, path_time_s, ..laid }));
        let commands = [0.01, 0.06, 0.11].map(|after_s| {
            let seen = estimate(rig.now_s() + after_s);
            rig.controller.on_event(Event::Estimate(seen)).unwrap().trims.speed
        });
        (slowed, commands[2])
    };
    let ((slowed, pushed), (slowed_too, not_sent)) = (speed_after(true), speed_after(false));
    assert!(slowed < 0.999 && (slowed - slowed_too).abs() < 1e-12, "{slowed} {slowed_too}");
    assert!(pushed > not_sent + 0.005, "{pushed} {not_sent}");
}

/// A nozzle that a push has filled looks sound, and is none: what was pushed is known.
#[test]
fn a_push_that_fills_the_nozzle_takes_nothing_back() {
    for (executes, stands) in [(true, true), (false, false)] {
        let (mut rig, _) = beside_coming_moves();
        assert!(!rig.controller.take_anew(Seconds(rig.now_s())).is_empty());
        rig.executes = executes;
        see(&mut rig, 0.0, |estimate| estimate);
        let factor = rig.controller.clog.factor();
        assert_eq!(factor > 1.2, stands, "executed {executes}: {factor}");
    }
}
