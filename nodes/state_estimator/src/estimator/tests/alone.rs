//! What holds where widths alone tell: each number of `widths_alone` acts.

use super::*;

/// Without an encoder, half of the feed from 30 s on, and half a second later.
fn off_balance(changes: &[(&str, &str)]) -> Estimate {
    let mut rig = Rig::with(changes);
    rig.encoder = false;
    rig.run(3000);
    rig.feed_m_s = 0.5 * FEED_M_S;
    rig.run(55)
}

/// A width of a flow off balance is known worse where the lag is, or where widths themselves are.
#[test]
fn a_flow_off_balance_is_judged_as_they_say() {
    let nis = |changes: &[(&str, &str)]| off_balance(changes).nis[Channel::Width as usize].unwrap();
    let shipped = nis(&[]);
    for change in [("lag_rel: 0.05 ", "lag_rel: 2.0 "), ("imbalance: 0.005 ", "imbalance: 5.0 ")] {
        let changed = nis(&[change]);
        assert!(changed < 0.2 * shipped, "{}: {changed} of {shipped}", change.1);
    }
}

/// The frame that tells of a step lacks what the flow has followed: where that is half of the slip, twice as much slips.
#[test]
fn a_step_is_told_the_larger_the_less_the_flow_has_followed() {
    let told = |followed: &str| {
        let mut rig = Rig::with(&[("followed: 0.6 ", &format!("followed: {followed} "))]);
        rig.encoder = false;
        let before = rig.run(3000).steps;
        rig.slip = 0.10;
        (0..120).map(|_| rig.run(5)).find(|estimate| estimate.steps > before).unwrap().x[state::SLIP]
    };
    let [whole, most, half] = ["1.0", "0.85", "0.5"].map(told);
    assert!(most > whole + 0.005 && half > 1.3 * whole, "{whole} {most} {half}");
}

/// 1.2 mm back and forth each 0.2 s: four times as much goes forth as is laid, and slips. Where a step were told by what is laid
/// alone, the frame that tells of it would be put down to the flow, and 0.18 of the 0.30 told.
#[test]
fn with_strokes_a_step_takes_of_all_that_goes_forth() {
    let mut rig = Rig::new();
    (rig.encoder, rig.stroke_m) = (false, 1.2e-3);
    let before = rig.run(3000).steps;
    rig.slip = 0.30;
    let told = (0..400).map(|_| rig.run(5)).find(|estimate| estimate.steps > before).unwrap().x[state::SLIP];
    assert!((0.23..0.35).contains(&told), "{told}");
}

/// The gear grips less than expected: a usual step, here of a hundredth, does not explain the road, and one of any size does.
#[test]
fn a_large_slip_is_told_where_a_usual_step_explains_nothing() {
    let mut rig = Rig::with(&[("step_std: 0.1 ", "step_std: 0.01 ")]);
    rig.encoder = false;
    let before = rig.run(3000);
    rig.slip = 0.30;
    let told = rig.run(1000);
    assert_eq!(told.resets, before.resets);
    assert!((told.x[state::SLIP] - 0.30).abs() < 0.05, "{}", told.x[state::SLIP]);
}

/// A path that changes its speed each second is steady for 0.05 s before most exposures, and before none for 2 s.
#[test]
fn a_width_is_looked_at_where_the_path_was_steady_for_so_long() {
    let measured = |changes: &[(&str, &str)]| {
        let mut rig = Rig::with(changes);
        rig.encoder = false;
        rig.host = Box::new(|status| {
            status.path_speed_m_s = if status.stamp.0 % 1.0 < 0.3 { 0.5 * SPEED_M_S } else { SPEED_M_S };
        });
        rig.run(1000).measured[Channel::Width as usize]
    };
    let none = ("unsteady_spread: 0.75 ", "unsteady_spread: 0.0 ");
    assert!(measured(&[none]) > 8);
    assert_eq!(measured(&[none, ("steady_s: 0.05 ", "steady_s: 2.0 ")]), 0);
    assert!(
        measured(&[("steady_s: 0.05 ", "steady_s: 2.0 ")]) > 8,
        "even so, where half is no larger spread"
    );
    let less = ("unsteady_spread: 0.75 ", "unsteady_spread: 0.45 ");
    assert_eq!(measured(&[less, ("steady_s: 0.05 ", "steady_s: 2.0 ")]), 0, "and not where it is");
}

/// A path that slows down and speeds up all the time, and three times a usual step of the slip: told, and each width speaks the
/// less loudly the larger their noise is.
#[test]
fn widths_of_a_path_that_is_never_steady_tell_of_the_slip() {
    let told = |noise: &str| {
        let mut rig = Rig::with(&[("unsteady_noise: 0.2 ", &format!("unsteady_noise: {noise} "))]);
        (rig.encoder, rig.swing) = (false, 0.2);
        rig.run(3000);
        rig.slip = 0.30;
        let first = rig.run(100).nis[Channel::Width as usize].unwrap();
        (rig.run(1400).x[state::SLIP], first)
    };
    let (slip, first) = told("0.2");
    assert!((slip - 0.30).abs() < 0.02, "{slip}");
    assert!(told("0.8").1 < 0.5 * first, "{} {first}", told("0.8").1);
}

/// Nor do such widths teach the noise of the sensor; beside an encoder, which tells of the slip, they are left out.
#[test]
fn widths_of_a_path_that_is_never_steady_teach_no_noise() {
    let told = |encoder: bool| {
        let mut rig = Rig::new();
        (rig.encoder, rig.swing) = (encoder, 0.2);
        let estimate = rig.run(3000);
        (estimate.measured[Channel::Width as usize], estimate.noise_scale[Channel::Width as usize])
    };
    let (alone, scale) = told(false);
    assert!(alone > 50 && (scale - 1.0).abs() < 1e-12, "{alone} {scale}");
    assert_eq!(told(true).0, 0);
}

/// Widths after 30 s without an encoder, each off by such a gain: what is believed of the road then, over what was.
fn believed(outlier: &str, gains: &[f64]) -> f64 {
    let mut rig = Rig::with(&[("outlier: 1.75 ", &format!("outlier: {outlier} "))]);
    rig.encoder = false;
    let laid = |estimate: &Estimate| estimate.x[state::FLOW] * estimate.x[state::GAIN] / FEED_M_S;
    let before = laid(&rig.run(3000));
    gains.iter().fold(0.0, |_, gain| {
        rig.gain = *gain;
        laid(&rig.run(50)) - before
    })
}

/// A width of 6 % too much is off by more than three deviations: its own mistake, which counts the less the farther it is off, and
/// all of which is told. With two and more to the same side roads are wider.
#[test]
fn a_single_width_that_is_far_off_is_doubted() {
    let [near, far, farther] = [1.01, 1.045, 1.06].map(|gain| believed("1.75", &[gain]));
    let all = believed("100.0", &[1.06]);
    assert!((believed("100.0", &[1.01]) - near).abs() < 1e-12, "one that is not off is none");
    assert!(0.0 < farther && farther < far && far < 0.6 * all, "{farther} {far} of {all}");
    let again = believed("1.75", &[1.06, 1.06]);
    assert!(again > 2.0 * all, "{again} of {all}");
    let mut rig = Rig::new();
    rig.encoder = false;
    rig.run(3000);
    rig.gain = 1.06;
    assert!(rig.run(50).nis[Channel::Width as usize].unwrap() > 3.0_f64.powi(2));
}

/// One that is off to the other side agrees with nothing.
#[test]
fn widths_to_either_side_do_not_agree() {
    let moved = |outlier: &str| believed(outlier, &[0.96, 1.05]) - believed(outlier, &[0.96]);
    assert!(moved("1.75") < 0.5 * moved("100.0"), "{} of {}", moved("1.75"), moved("100.0"));
}

/// Beside an encoder a width counts for what it is.
#[test]
fn beside_an_encoder_no_width_is_doubted() {
    let told = |outlier: &str| {
        let mut rig = Rig::with(&[("outlier: 1.75 ", &format!("outlier: {outlier} "))]);
        rig.run(3000);
        rig.gain = 1.05;
        rig.run(50).x
    };
    assert_eq!(told("1.75"), told("100.0"));
}

/// What slip and gain are taken for one another by: the walk of a gain, 0.0007 a tick, 0.014 after 20 s, no more than said.
#[test]
fn slip_and_gain_are_stated_to_be_parted_as_far_as_they_say() {
    let stated = |std: &str| {
        let mut rig = Rig::with(&[("parted_std: 0.035 ", &format!("parted_std: {std} "))]);
        rig.encoder = false;
        rig.run(2000).p
    };
    let none = stated("0.0");
    for (std, wanted) in [("0.035", 0.0007 * 400.0_f64.sqrt()), ("0.005", 0.005)] {
        let added = stated(std) - none;
        let told = added[(state::SLIP, state::SLIP)].sqrt();
        assert!((told / wanted - 1.0).abs() < 0.01, "{told} for {wanted}");
        assert!(added[(state::SLIP, state::GAIN)] > 0.0 && added[(state::SLIP, state::FLOW)] < 0.0);
    }
}

/// No larger slip is believed than they say, whatever roads look like.
#[test]
fn no_larger_slip_is_believed_than_they_say() {
    let told = |most: &str| {
        let mut rig = Rig::with(&[("slip_most: 0.35 ", &format!("slip_most: {most} "))]);
        rig.encoder = false;
        rig.run(3000);
        rig.slip = 0.45;
        (0..200).map(|_| rig.run(10).x[state::SLIP]).fold(0.0, f64::max)
    };
    assert!((told("0.35") - 0.35).abs() < 1e-6 && (told("0.1") - 0.1).abs() < 1e-6);
    assert!(told("1.0") > 0.4, "{}", told("1.0"));
}

/// Twice as much: more than a step explains. A filter that would reject that for good is lost, and starts anew.
#[test]
fn what_no_step_explains_starts_the_filter_anew() {
    let after = |gain: f64| {
        let mut rig = Rig::new();
        rig.encoder = false;
        let before = rig.run(3000);
        rig.gain = gain;
        let estimate = rig.run(2000);
        (estimate.resets - before.resets, estimate.x[state::GAIN] * (1.0 - estimate.x[state::SLIP]))
    };
    assert!(after(2.0).0 > 0);
    let (resets, told) = after(1.5);
    assert!(resets == 0 && told > 1.4, "steps explain it: {resets} {told}");
    assert_eq!(after(1.3).0, 0, "a step explains it");
}
