//! Widths: in order, once each, and no faster than the time between them allows.

use super::*;

/// 4.5 % too wide: beyond the dead band, and no transient.
const WIDE_M: f64 = 1.045 * 4.8e-4;

fn steady() -> Controller {
    let mut rig = Rig::new(Level::Mpc);
    rig.run(59, |estimate| estimate);
    rig.controller
}

fn see(controller: &mut Controller, exposed_s: f64) {
    controller.on_event(Event::Width { exposed: Seconds(exposed_s), width_m: WIDE_M });
}

#[test]
fn a_width_that_is_repeated_or_older_is_refused_and_counted() {
    let mut controller = steady();
    see(&mut controller, 2.9);
    let after_one = controller.held;
    assert!(after_one[FEED] < -1e-4, "{after_one:?}");
    for exposed_s in [2.9, 2.8, 1.0] {
        see(&mut controller, exposed_s);
    }
    assert_eq!((controller.held, controller.report().refusals.width.late), (after_one, 3));
    see(&mut controller, 3.4);
    assert!(controller.held[FEED] < after_one[FEED], "{:?}", controller.held);
    assert_eq!(controller.report().refusals.width.late, 3);
}

/// A hundred frames within a period of the plan may move the feed by what the period allows, not by a hundred gains.
#[test]
fn a_burst_of_frames_moves_no_further_than_its_time_allows() {
    let mut controller = steady();
    let (period_s, rate) = (controller.params.period_s, controller.params.limits.rate());
    see(&mut controller, 2.9);
    let before = controller.held;
    for frame in 1..=100 {
        see(&mut controller, 2.9 + 0.01 * period_s * f64::from(frame));
    }
    assert_eq!(controller.report().refusals.width.late, 0);
    for index in [FEED, SPEED] {
        let moved = (controller.held[index] - before[index]).abs();
        assert!(moved <= rate[index] + 1e-9, "{index}: {moved} of {}", rate[index]);
    }
    assert!((controller.held[FEED] - before[FEED]).abs() > 0.5 * rate[FEED], "{:?}", controller.held);
}

/// A quarter of the section lacks while the encoder sees all of the feed: the path runs slower by as much at the same feed
/// over time, at once up to its rate, and is back at its speed once that has passed.
#[test]
fn a_dip_of_the_flow_is_made_up_for_by_a_slower_path() {
    let mut rig = Rig::new(Level::Mpc);
    rig.run(59, |estimate| estimate);
    let before = rig.in_force;
    rig.controller.on_event(Event::Width { exposed: Seconds(2.9), width_m: 0.75 * 4.8e-4 });
    let sent = rig.run(20, |estimate| estimate);
    let slowest = sent.iter().map(|trims| trims.speed).fold(1.0, f64::min);
    assert!((0.85..0.92).contains(&slowest), "{slowest}");
    for trims in &sent {
        let feed = trims.flow * trims.speed / (before.flow * before.speed);
        assert!((feed - 1.0).abs() < 5e-3, "the feed over time stays: {trims:?}");
    }
    let later = rig.run(200, |estimate| estimate);
    assert!((later[199].speed - before.speed).abs() < 5e-3, "{:?}", later[199]);
}

/// A spool that is 3 % thin by the estimate: a frame 5.5 % too narrow in the first seconds is the spool's and the noise's, and
/// goes on being learnt from. Once the spool is known and fed for, it is a dip.
#[test]
fn what_a_spool_that_is_not_known_explains_is_no_dip() {
    for (steps, is_dip) in [(30, false), (399, true)] {
        let mut rig = Rig::new(Level::Mpc);
        let thin = |estimate| Estimate { gain: 0.97, ..estimate };
        rig.run(steps, thin);
        let exposed = Seconds(rig.now_s() - 0.1);
        rig.controller.on_event(Event::Width { exposed, width_m: 0.945 * 4.8e-4 });
        assert_eq!(rig.controller.passes(rig.now_s()), is_dip, "after {steps} steps");
        let before = rig.controller.report().base;
        rig.run(10, thin);
        let learnt = (rig.controller.report().base - before).abs();
        assert_eq!(learnt < 1e-9, is_dip, "{learnt} after {steps} steps");
    }
}

/// A tenth of a second behind a corner of one status in six: the road has settled, and is not steady for long. A quarter that
/// lacks there is a dip, an eighth may be the corner's and moves nothing; and none of it is one behind a nozzle that has
/// narrowed too far.
#[test]
fn shortly_behind_a_short_corner_a_large_lack_alone_is_a_dip() {
    let slowest = |width_m: f64, beyond: bool| {
        let mut rig = Rig::new(Level::Mpc);
        rig.run(59, |estimate| estimate);
        rig.controller.roads = crate::roads::tests::behind_a_corner(2.9 - 0.1, 2.9);
        rig.controller.steady_since_s = 2.8;
        rig.controller.clog.set_beyond(beyond);
        rig.controller.on_event(Event::Width { exposed: Seconds(2.9), width_m });
        rig.run(20, |estimate| estimate).iter().map(|trims| trims.speed).fold(1.0, f64::min)
    };
    let (deep, shallow) = (slowest(0.75 * 4.8e-4, false), slowest(0.87 * 4.8e-4, false));
    assert!((0.85..0.92).contains(&deep), "{deep}");
    assert!(shallow > 1.0 - 1e-9, "{shallow}");
    let beyond = slowest(0.75 * 4.8e-4, true);
    assert!(beyond > 0.98, "{beyond}");
}

/// Nobody vouches for the feed: it may be slip that makes the road thin, and more feed that it needs.
#[test]
fn without_an_encoder_a_thin_road_slows_nothing_beyond_the_gains() {
    let mut rig = Rig::new(Level::Mpc);
    let alone = |estimate| Estimate { encoder_alive: false, ..estimate };
    rig.run(59, alone);
    rig.controller.on_event(Event::Width { exposed: Seconds(2.9), width_m: 0.75 * 4.8e-4 });
    let sent = rig.run(3, alone);
    assert!(sent.iter().all(|trims| trims.speed > 0.97 && trims.flow > 1.0), "{sent:?}");
}

/// The encoder falls silent in the midst of a dip: the path goes back to its speed by its rate, and not at once.
#[test]
fn a_slowed_path_without_an_encoder_goes_back_by_its_rate() {
    let mut rig = Rig::new(Level::Mpc);
    rig.run(59, |estimate| estimate);
    rig.controller.on_event(Event::Width { exposed: Seconds(2.9), width_m: 0.6 * 4.8e-4 });
    let slowed = rig.run(15, |estimate| estimate);
    let mut before = slowed[14].speed;
    assert!(before < 0.9, "{before}");
    let (period_s, rate) = (rig.controller.params.period_s, rig.controller.params.limits.speed_rate);
    for trims in rig.run(40, |estimate| Estimate { encoder_alive: false, ..estimate }) {
        assert!(trims.speed - before <= rate * 0.05 / period_s + 1e-9, "{before} -> {trims:?}");
        before = trims.speed;
    }
    assert!(before > 0.99, "{before}");
}

/// Where corners are not planned, their roads are as thin as those of a dip.
#[test]
fn a_path_is_slowed_only_where_corners_are_planned() {
    use HostProfile::{Moonraker, Native, Octoprint, Serial};
    let planned = [(Native, "planned"), (Native, "predicted"), (Serial, "planned")];
    let chased = [
        (Moonraker, "planned"),
        (Octoprint, "planned"),
        (Native, "file"),
        (Native, "none"),
        (Serial, "material"),
    ];
    for (index, (host, source)) in planned.into_iter().chain(chased).enumerate() {
        let text = SHIPPED.replace("source: planned ", &format!("source: {source} "));
        let mut rig = Rig::of(made_of(&text, Level::Mpc));
        rig.run(59, |estimate| estimate);
        let reported = PrinterStatus { host, ..status(2.96, rig.wanted_m, rig.in_force) };
        rig.controller.on_event(Event::Printer(reported));
        rig.controller.on_event(Event::Width { exposed: Seconds(2.9), width_m: 0.75 * 4.8e-4 });
        let sent = rig.run(1, |estimate| estimate);
        assert_eq!(sent[0].speed < 0.995, index < planned.len(), "{host:?}, {source:?}: {sent:?}");
    }
}
