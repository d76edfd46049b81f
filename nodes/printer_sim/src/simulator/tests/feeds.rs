//! Sensors whose line is cut, or that say the same again.

use super::*;
use crate::camera::{Camera, Moment, Shot};

/// A camera whose frames all differ: two a second, at once.
struct Counting(u64);

impl Camera for Counting {
    fn observe(&mut self, _: &Moment) {}

    fn ready(&mut self, now: Seconds) -> Option<Shot> {
        let due = now.0 + 1e-6 >= 0.5 * (self.0 + 1) as f64;
        let shot = Shot { exposed: now, sequence: self.0, jpeg: self.0.to_le_bytes().to_vec() };
        self.0 += u64::from(due);
        due.then_some(shot)
    }
}

/// What of a printer at work came before 10.005 s, in the four seconds of a fault from there, and after them: between two samples.
struct Told {
    encoder: [Vec<(f64, i64)>; 3],
    imu: [Vec<crate::imu::Batch>; 3],
    frames: [Vec<(f64, Vec<u8>)>; 3],
}

fn under(component: &str, kind: &str) -> Told {
    let fault = fault_at(10.0045, &format!("component: {component}, kind: {kind}, duration_s: 4"));
    let mut simulator = warm(straight_job(30), &fault);
    simulator.fit(Box::new(Counting(0)));
    let mut told = Told { encoder: Default::default(), imu: Default::default(), frames: Default::default() };
    for (span, until_s) in [10.0035, 14.0035, 18.0].into_iter().enumerate() {
        while simulator.now().0 < until_s {
            simulator.step(Seconds(1e-3));
            while let Some(output) = simulator.poll() {
                match output {
                    Output::Encoder { stamp, counts } => told.encoder[span].push((stamp.0, counts)),
                    Output::Imu(batch) => told.imu[span].push(*batch),
                    Output::Frame { exposed, jpeg, .. } => told.frames[span].push((exposed.0, jpeg)),
                    _ => {}
                }
            }
        }
    }
    told
}

/// Messages of each span.
fn counts(told: &Told) -> [[usize; 3]; 3] {
    [
        told.encoder.each_ref().map(Vec::len),
        told.imu.each_ref().map(Vec::len),
        told.frames.each_ref().map(Vec::len),
    ]
}

#[test]
fn what_is_off_says_nothing_until_it_is_plugged_in_again_and_the_others_go_on() {
    let sound = counts(&under("fan", "gain, size: 1.0"));
    assert!(sound.iter().all(|spans| spans[1] >= 7), "{sound:?}");
    for (off, component) in ["encoder", "imu", "camera"].into_iter().enumerate() {
        let mut expected = sound;
        expected[off][1] = 0;
        let told = under(component, "off");
        assert_eq!(counts(&told), expected, "{component}");
        // What has been pushed meanwhile was counted.
        let (before, after) = (told.encoder[0].last().unwrap().1, told.encoder[2][0].1);
        assert!(after - before > 100, "{before} {after}");
    }
}

/// The stamps go on: of their age nothing shows, of their content all.
#[test]
fn what_is_stuck_says_the_last_again_with_new_stamps() {
    let sound = counts(&under("fan", "gain, size: 1.0"));
    let encoder = under("encoder", "stuck");
    assert_eq!(counts(&encoder), sound);
    let held = encoder.encoder[0].last().unwrap().1;
    assert!(encoder.encoder[1].iter().all(|(_, counts)| *counts == held));
    assert!(encoder.encoder[1].windows(2).all(|pair| pair[1].0 > pair[0].0 + 5e-3));
    let imu = under("imu", "stuck");
    assert_eq!(counts(&imu), sound);
    let held = &imu.imu[0].last().unwrap().samples;
    assert!(imu.imu[1].iter().all(|batch| batch.samples == *held) && imu.imu[2][0].samples != *held);
    assert!(imu.imu[1].windows(2).all(|pair| {
        pair[1].first > pair[0].first && pair[1].first_sequence == pair[0].first_sequence + 50
    }));
    let camera = under("camera", "stuck");
    assert_eq!(counts(&camera), sound);
    let held = &camera.frames[0].last().unwrap().1;
    assert!(camera.frames[1].iter().all(|(_, jpeg)| jpeg == held) && camera.frames[2][0].1 != *held);
    assert!(camera.frames[1].windows(2).all(|pair| pair[1].0 > pair[0].0));
}

/// A unit that hangs from the start shows its first batch for ever.
#[test]
fn what_is_stuck_before_anything_came_repeats_the_first() {
    let mut simulator = warm(straight_job(5), &fault_at(0.0, "component: imu, kind: stuck"));
    run_for(&mut simulator, 1.0);
    let batches: Vec<_> = std::iter::from_fn(|| simulator.poll())
        .filter_map(|output| if let Output::Imu(batch) = output { Some(batch.samples) } else { None })
        .collect();
    assert!(batches.len() == 20 && batches.iter().all(|samples| *samples == batches[0]));
}

/// The firmware's own loop reads the same sensor: what it misses there it pushes, as far as the loop reaches.
#[test]
fn the_firmwares_loop_is_misled_by_an_encoder_that_stands() {
    let pushed_m = |kind: &str| {
        let fault = fault_at(2.0, &format!("component: {kind}"));
        let mut simulator = warm(straight_job(30), &fault);
        let mut sequence = 0;
        while simulator.now().0 < 6.0 {
            sequence += 1;
            let trims = Trims { slip: Some(0.0), ..Trims::NEUTRAL };
            let (mode, request, validity) = (Mode::Act, Request::Run, Seconds(0.25));
            simulator.on_permit(Permit { session: 1, sequence, validity, mode, request, trims }).unwrap();
            run_for(&mut simulator, 0.1);
        }
        simulator.status().motor_position_m
    };
    let sound_m = pushed_m("fan, kind: gain, size: 1.0");
    for kind in ["encoder, kind: stuck", "encoder, kind: off"] {
        assert!(pushed_m(kind) > 1.2 * sound_m, "{kind}: {} m of {sound_m} m", pushed_m(kind));
    }
}
