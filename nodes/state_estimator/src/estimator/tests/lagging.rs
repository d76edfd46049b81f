//! A melt that lags otherwise than its file says, and strokes that reports hide.

use super::*;

/// The feed is halved and doubled in turn each 1.3 s, and frames meet all phases of it.
fn changing(rig: &mut Rig, seconds: u32) -> Estimate {
    let mut last = None;
    for change in 0..seconds * 10 / 13 {
        rig.feed_m_s = if change % 2 == 0 { FEED_M_S } else { 0.5 * FEED_M_S };
        last = Some(rig.run(130));
    }
    last.unwrap()
}

#[test]
fn a_lag_that_the_material_does_not_tell_is_learnt_from_widths() {
    for (encoder, factor) in [(false, 1.3), (true, 1.3), (false, 1.0), (true, 0.8)] {
        let mut rig = Rig::new();
        (rig.encoder, rig.law) = (encoder, rig.law.scaled(factor));
        let learnt = changing(&mut rig, 200).melt_lag;
        assert!((learnt - factor).abs() < 0.08, "{learnt} for {factor}, encoder {encoder}");
    }
}

/// A slip of 9 % takes as much from all widths, whatever the lag does.
#[test]
fn a_slip_is_no_lag() {
    let mut rig = Rig::new();
    rig.encoder = false;
    changing(&mut rig, 100);
    rig.slip = 0.10;
    let learnt = changing(&mut rig, 40).melt_lag;
    assert!((learnt - 1.0).abs() < 0.1, "{learnt}");
}

#[test]
fn a_reach_of_zero_learns_nothing() {
    let mut rig = Rig::with(&[("reach: 0.4 ", "reach: 0.0 ")]);
    rig.law = rig.law.scaled(1.3);
    assert!((changing(&mut rig, 100).melt_lag - 1.0).abs() < 1e-12);
}

/// 0.3 mm back and forth each 0.2 s, and a status as often: the motor's reports show none of it. Of 0.66 mm forth 0.066 slip, of
/// the 0.36 mm that they show 0.036: widths would have a slip of 0.18 told. What the motor makes up for tells of the rest.
#[test]
fn strokes_that_reports_hide_are_told_by_what_is_made_up_for() {
    let mut rig = Rig::new();
    (rig.encoder, rig.status_steps, rig.slip, rig.made_up) = (false, 20, 0.10, 0.10);
    let before = rig.run(6000).x[state::SLIP];
    rig.stroke_m = 0.3e-3;
    let hidden = rig.run(4000).x[state::SLIP];
    assert!((hidden - before).abs() < 0.02, "{hidden} after {before}");
}

/// A gear passes no more than it pushes: a road that is 4 % too wide is a gain, at once.
#[test]
fn what_seems_to_slip_backwards_is_a_gain() {
    let mut rig = Rig::new();
    rig.encoder = false;
    rig.run(1000);
    rig.gain = 1.04;
    for _ in 0..400 {
        let slip = rig.run(5).x[state::SLIP];
        assert!(slip >= -1e-12, "{slip}");
    }
    let told = rig.run(5);
    let product = (1.0 - told.x[state::SLIP]) * told.x[state::GAIN];
    assert!((product - 1.04 * 0.99).abs() < 0.01, "{product}");
}
