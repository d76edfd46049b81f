//! K4, K8 and the noise that is learnt: what the estimator tells of its own work.

use super::*;
use models::command::EstimateHealth;

/// Runs in steps of 50 ms until this is told; `None` after so many seconds without it.
fn told_after(rig: &mut Rig, health: EstimateHealth, within_s: u32) -> Option<f64> {
    let told = |rig: &mut Rig| rig.try_run(5).is_some_and(|estimate| estimate.health == health);
    (1..=within_s * 20).find(|_| told(rig)).map(|steps| f64::from(steps) * 0.05)
}

#[test]
fn a_sound_print_and_a_step_that_is_taken_as_given_are_told_sound() {
    let mut rig = Rig::new();
    rig.width_noise_m = 17e-6;
    let mut worst = EstimateHealth::Sound;
    for (slip, gain) in [(0.01, 1.0), (0.10, 1.0), (0.30, 1.0), (0.01, 1.03), (0.02, 0.97)] {
        (rig.slip, rig.gain) = (slip, gain);
        (0..600).for_each(|_| worst = rig.try_run(5).map_or(worst, |estimate| worst.max(estimate.health)));
    }
    assert_eq!((worst, rig.run(20).resets), (EstimateHealth::Sound, 0));
}

/// K4 with R a hundredth of what it is: told in 1 s; again within a minute it is more than a reset.
#[test]
fn k4_a_noise_stated_a_hundred_times_too_small_resets_and_then_distrusts() {
    let wrong = [
        ("relative: 0.004 ", "relative: 0.0004 "),
        ("quantum_m: 1.0e-5 ", "quantum_m: 1.0e-6 "),
        ("skew_s: 0.002 ", "skew_s: 0.0 "),
    ];
    let mut rig = Rig::with(&wrong);
    // a second of encoder speeds, and a quarter of one until the first
    let first_s = told_after(&mut rig, EstimateHealth::Reset, 60).unwrap();
    let second_s = told_after(&mut rig, EstimateHealth::Diverging, 60).unwrap();
    assert!(first_s <= 1.25 && second_s <= 1.25, "{first_s} {second_s}");
    assert!(rig.run(20).resets >= 2);
}

/// The noise is put right after the first reset: what spoke against the filter before it is over.
#[test]
fn a_filter_that_starts_anew_is_judged_anew() {
    let mut rig = Rig::with(&[
        ("relative: 0.004 ", "relative: 0.0 "),
        ("skew_s: 0.002 ", "skew_s: 0.0 "),
        ("quantum_m: 1.0e-5 ", "quantum_m: 1.0e-6 "),
    ]);
    told_after(&mut rig, EstimateHealth::Reset, 60).unwrap();
    rig.estimator.retune(serde_saphyr::from_str::<File>(SHIPPED).unwrap().node.parameters);
    assert_eq!(rig.run(500).resets, 1);
}

/// K8 with a heater three times as strong in the model as it is: no single reading is impossible, all are off. The bound
/// is that of a consistent channel: the shipped one bears a sensor of twice its noise, and this much of a wrong heater.
#[test]
fn k8_a_wrong_model_is_told_within_a_minute() {
    let strict = SHIPPED.replace("window_bound: 120.0 ", "window_bound: 45.3 ");
    assert_ne!(strict, SHIPPED);
    let mut rig = Rig::of(estimator(&strict, 3.0 * nominal_hotend().heater_power_w));
    let at_s = told_after(&mut rig, EstimateHealth::Mismatch, 60);
    assert!(at_s.is_some_and(|at_s| at_s > 30.0), "{at_s:?}");
}

/// K8: a road a quarter wider than the model's for good, and widths that scatter beyond every bound.
#[test]
fn k8_another_printer_is_told_within_a_minute() {
    let mut rig = Rig::new();
    rig.run(1000);
    rig.gain = 1.25;
    let at_s = told_after(&mut rig, EstimateHealth::Mismatch, 60).unwrap();
    assert!(at_s > 20.0, "{at_s}: a transient is none");
    let mut rig = Rig::new();
    rig.run(1000);
    rig.width_noise_m = 90e-6;
    let at_s = told_after(&mut rig, EstimateHealth::Mismatch, 60);
    assert!(at_s.is_some_and(|at_s| at_s > 20.0), "{at_s:?}");
}

/// The scale follows the scatter of the widths both ways, within its bounds, and the estimate is the same one.
#[test]
fn the_scale_of_the_noise_follows_the_widths() {
    let settled = |noise_m: f64| {
        let mut rig = Rig::new();
        rig.width_noise_m = noise_m;
        rig.run(20_000)
    };
    let (calm, rough) = (settled(3e-6), settled(40e-6));
    let scale = |estimate: &Estimate| estimate.noise_scale[Channel::Width as usize];
    assert!(scale(&calm) < 0.5 && scale(&calm) >= 0.2, "{}", scale(&calm));
    assert!(scale(&rough) > 1.5 && scale(&rough) <= 4.0, "{}", scale(&rough));
    assert!((calm.x[state::GAIN] - 1.0).abs() < 0.01 && (rough.x[state::GAIN] - 1.0).abs() < 0.02);
}
