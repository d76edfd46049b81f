//! Which frames are learnt from, and how much of one, after a step of the feed: the lever is known in closed form.

use super::super::tests::{LEARNING, status};
use super::tests::{FORETOLD_S, HEIGHT_M, TARGET_M, foretold};
use super::*;
use models::command::Trims;

/// Feed before and after the step `[m/s]`.
const STEP_M_S: [f64; 2] = [0.5e-3, 3e-3];
/// Between two statuses `[s]`; the step is a ramp over one.
const TICK_S: f64 = 0.02;
/// When it begins `[s]`: the road is settled then.
const BEGUN_S: f64 = 1.2;
/// Share of the foretold advance that statuses tell `[-]`.
const SHARE: f64 = 0.5 / FORETOLD_S;

/// A road with that step, told from status to status up to `until_s` after the step began.
fn stepped(settings: RawLearning, until_s: f64) -> Learning {
    stepped_with(settings, until_s, |status| status)
}

/// The same, told by a host of its own.
fn stepped_with(
    settings: RawLearning,
    until_s: f64,
    host: impl Fn(PrinterStatus) -> PrinterStatus,
) -> Learning {
    let mut learning = Learning::new(settings);
    let told = |step: u32| TICK_S * f64::from(step);
    for at_s in (0..).map(told).take_while(|at_s| *at_s <= BEGUN_S + until_s + 1e-9) {
        let [before, after] = STEP_M_S;
        let feed_m_s = if at_s < BEGUN_S + 0.5 * TICK_S { before } else { after };
        learning.on_status(&host(status(at_s, feed_m_s)), &foretold(), Nozzle::SOUND);
    }
    learning
}

/// `r_w (1 - u/v)`: behind a ramp of length d what u lacks is `(v - v_0) K/d (1 - e^(-d/K))`, and falls with K from then on;
/// of `v_0` it still lacks what the first road, that nothing was held for, left.
fn lever(since_s: f64) -> f64 {
    let [before, after] = STEP_M_S;
    let width = 1.0 - HEIGHT_M * ROUND_SIDES / TARGET_M;
    let lacking = FORETOLD_S / TICK_S * (1.0 - (-TICK_S / FORETOLD_S).exp());
    let step = (1.0 - before / after) * lacking * (-(since_s - TICK_S) / FORETOLD_S).exp();
    width * (step + before / after * (-(BEGUN_S + since_s) / FORETOLD_S).exp())
}

/// The lever is 0.75 at once and falls to 0.6 within 0.15 s, to 0.3 within 0.57 s: frames before are left out.
#[test]
fn frames_with_a_large_lever_are_left_out() {
    for lever_max in [0.3, 0.6] {
        let (mut out, mut taught) = (0, 0);
        for step in 5..50_u32 {
            let since_s = TICK_S * f64::from(step);
            let mut learning = stepped(RawLearning { lever_max, ..LEARNING }, since_s);
            learning.on_width(BEGUN_S + since_s, TARGET_M);
            let is_taught = learning.frames() > 0.0;
            assert_eq!(
                is_taught,
                lever(since_s) <= lever_max,
                "{lever_max}: {since_s} s, {}",
                lever(since_s)
            );
            out += u32::from(!is_taught);
            taught += u32::from(is_taught);
        }
        assert!(out > 0 && taught > 0, "{lever_max}: {out} {taught}");
    }
}

/// `d - e`, e within `+- error_max`: whatever is said beyond teaches no more.
#[test]
fn large_errors_of_a_width_count_as_the_largest_believed() {
    for (error_max, error, believed) in [
        (0.5, 0.49, 0.49),
        (0.5, 0.9, 0.5),
        (0.5, -0.49, -0.49),
        (0.5, -0.9, -0.5),
        (0.2, 0.49, 0.2),
        (0.2, -0.9, -0.2),
        (2.0, 1.9, 1.9),
    ] {
        let mut learning = stepped(RawLearning { error_max, ..LEARNING }, 0.4);
        learning.on_width(BEGUN_S + 0.4, (1.0 + error) * TARGET_M);
        let answer = SHARE * lever(0.4) - believed;
        // Rounding of 80 sums of numbers about 1.
        let (told, product) = learning.fit.told();
        assert!((told - answer).abs() < 1e-12, "{error_max} {error}: {told}");
        assert!((product - lever(0.4) * answer).abs() < 1e-12, "{error_max} {error}");
    }
}

/// The drive's smoothing shows behind a ramp, which ends with the status after the step's, whether one K is executed or the laws of
/// moves.
#[test]
fn frames_close_behind_a_ramp_are_left_out() {
    for is_ahead in [false, true] {
        for calm_s in [0.06, 0.2] {
            for step in 2..30_u32 {
                let since_s = TICK_S * f64::from(step);
                let settings = RawLearning { calm_s, settle_s: 0.1, lever_max: 2.0, ..LEARNING };
                let mut learning = stepped_with(settings, since_s, |status| {
                    let advance_s = is_ahead.then_some(status.advance_s);
                    PrinterStatus { trims: Trims { advance_s, ..Trims::NEUTRAL }, ..status }
                });
                learning.on_width(BEGUN_S + since_s, TARGET_M);
                let behind_s = since_s - TICK_S;
                // at the limit itself rounding decides
                if (behind_s - calm_s).abs() > 1e-9 {
                    assert_eq!(learning.frames() > 0.0, behind_s > calm_s, "{is_ahead} {calm_s} {behind_s}");
                }
            }
        }
    }
}

/// The next status is the frame's where it comes within `pairing_s`; a frame behind the newest has none.
#[test]
fn a_frame_far_before_its_status_is_no_pair() {
    for (pairing_s, before_s, is_pair) in [
        (0.015, 0.0149, true),
        (0.015, 0.0151, false),
        (0.03, 0.0151, true),
        (0.03, 0.0299, true),
        (0.03, 0.0301, false),
        (0.09, 0.0301, true),
        (0.09, 0.0899, true),
        (0.09, 0.0901, false),
        (0.09, -0.001, false),
    ] {
        let mut learning = stepped(RawLearning { pairing_s, ..LEARNING }, 0.4);
        // One status late by four: 0.1 s behind the one before.
        let next_s = BEGUN_S + 0.5;
        learning.on_status(&status(next_s, STEP_M_S[1]), &foretold(), Nozzle::SOUND);
        learning.on_width(next_s - before_s, TARGET_M);
        assert_eq!(learning.frames() > 0.0, is_pair, "{pairing_s} s, {before_s} s before");
    }
}

impl Learning {
    pub(in crate::advance) fn frames(&self) -> f64 {
        self.fit.weight()
    }
}

/// Lever of a road 0.1 s after its start, behind a travel of half a second whose first and last status tell these feeds.
fn restarted([first_m_s, last_m_s]: [f64; 2]) -> f64 {
    const FEED_M_S: f64 = 2e-3;
    let mut learning = Learning::new(LEARNING);
    for step in 0..231_u32 {
        let (travels, at_s) = ((200..225).contains(&step), TICK_S * f64::from(step));
        let feed_m_s = match step {
            200 => first_m_s,
            224 => last_m_s,
            _ if travels => 0.0,
            _ => FEED_M_S,
        };
        let told = PrinterStatus { depositing: !travels, ..status(at_s, feed_m_s) };
        learning.on_status(&told, &foretold(), Nozzle::SOUND);
    }
    let moment = learning.moments.back().unwrap();
    // of one K the drive's part is as held back, or has run out, as the printer's
    assert!((moment.driven - SHARE * moment.levers[0]).abs() < 1e-12, "{moment:?}");
    moment.levers[0]
}

/// Behind a hole in the statuses nobody knows what is held: it begins anew, the drive's part too.
#[test]
fn a_hole_begins_anew() {
    let mut learning = stepped(LEARNING, 0.1);
    assert!(learning.moments.back().unwrap().driven > 0.1);
    for at_s in [20.0, 20.02] {
        learning.on_status(&status(at_s, STEP_M_S[1]), &foretold(), Nozzle::SOUND);
    }
    let moment = learning.moments.back().unwrap();
    assert!(moment.driven.abs() < 1e-12 && moment.levers[0].abs() < 1e-12, "{moment:?}");
}

/// A filament that is drawn back leaves the outlet dry: what the printer holds is there again when that is taken back, and the
/// road tells nothing of the lag. Without that the melt runs out meanwhile. What takes a retraction back is laid in no case.
#[test]
fn what_is_drawn_back_is_held() {
    const DRAW_M_S: f64 = 0.04;
    let held = restarted([-DRAW_M_S, DRAW_M_S]);
    assert!(held.abs() < 0.05, "{held}");
    let travels_s = 25.0 * TICK_S;
    let width = 1.0 - HEIGHT_M * ROUND_SIDES / TARGET_M;
    let ran_out = width * (1.0 - (-travels_s / FORETOLD_S).exp()) * (-0.1 / FORETOLD_S).exp();
    for last_m_s in [0.0, DRAW_M_S] {
        let lever = restarted([0.0, last_m_s]);
        assert!((lever / ran_out - 1.0).abs() < 0.1, "{lever}, expected {ran_out}");
    }
}
