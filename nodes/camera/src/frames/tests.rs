use std::collections::BTreeMap;

use proptest::prelude::*;

use super::*;
use crate::params::Params;
use crate::picture::tests::jpeg;

#[derive(serde::Deserialize)]
struct File {
    #[serde(rename = "ros__parameters")]
    parameters: Params,
}

fn params() -> CameraParams {
    let text = include_str!("../../../../config/camera.param.yaml");
    let file: BTreeMap<String, File> = serde_saphyr::from_str(text).unwrap();
    let camera = file.into_values().next().unwrap().parameters.camera;
    CameraParams { width_px: 640, height_px: 480, rate_hz: 2.0, rate_max_hz: 10.0, ..camera }
}

fn frames() -> Frames {
    Frames::new(params())
}

/// A frame whose noise is this number, exposed 0.1 s before it comes.
fn take(frames: &mut Frames, exposed_s: f64, noise: u8) -> Result<Accepted, Refusal> {
    frames.on_frame(Seconds(exposed_s + 0.1), Seconds(exposed_s), &jpeg(640, 480, noise))
}

#[test]
fn frames_pass_and_missing_ones_are_counted_by_the_rate() {
    let mut frames = frames();
    let arrivals = [(10.0, 0), (10.5, 0), (11.1, 0), (12.5, 2), (13.0, 0)];
    for (noise, (exposed_s, dropped)) in (0_u8..).zip(arrivals) {
        assert_eq!(take(&mut frames, exposed_s, noise).unwrap().dropped, dropped, "{exposed_s}");
    }
    assert_eq!((frames.dropped(), frames.refusals().total()), (2, 0));
    assert!((frames.interval().unwrap().0 - 0.5).abs() < 1e-12);
}

#[test]
fn each_kind_of_bad_frame_is_refused_and_counted() {
    let sound = jpeg(640, 480, 1);
    let (corrupt, cut_off) = (vec![0xff, 0xd8, 0xff, 0xd9], sound[..sound.len() - 2].to_vec());
    let mut long = sound.clone();
    long.resize(BYTES_MAX + 1, 0);
    let mut frames = frames();
    take(&mut frames, 10.0, 0).unwrap();
    for (exposed_s, bytes, refusal) in [
        (f64::NAN, &sound, Refusal::NotFinite),
        (10.0, &sound, Refusal::Order),
        (9.9, &sound, Refusal::Order),
        (11.0, &sound, Refusal::Future),
        (7.0, &sound, Refusal::Stale),
        (10.5, &long, Refusal::TooLarge),
        (10.5, &jpeg(10_000, 10_000, 1), Refusal::TooLarge),
        (10.5, &corrupt, Refusal::Corrupt),
        (10.5, &cut_off, Refusal::Corrupt),
        (10.5, &jpeg(320, 240, 1), Refusal::Size),
    ] {
        assert_eq!(frames.on_frame(Seconds(10.6), Seconds(exposed_s), bytes), Err(refusal));
    }
    assert_eq!(frames.refusals().total(), 10);
    assert!(frames.complaint().unwrap().contains("320x240 px where 640x480 are configured"));
    assert!(take(&mut frames, 10.5, 1).is_ok());
    assert_eq!(frames.complaint(), None);
    // Between 10.0 and 10.5 s nothing is missing, and what was refused is not missing either.
    assert_eq!(frames.dropped(), 0);
}

/// S8: a frozen camera is known from the second frame on, and ends with the next new picture.
#[test]
fn a_picture_that_repeats_is_marked_until_it_changes() {
    let mut frames = frames();
    assert!(!take(&mut frames, 10.0, 5).unwrap().frozen);
    for index in 1..=3 {
        assert!(take(&mut frames, 10.0 + 0.5 * f64::from(index), 5).unwrap().frozen);
    }
    assert!(frames.complaint().unwrap().contains("stands still"));
    assert!(!take(&mut frames, 12.0, 6).unwrap().frozen);
    assert_eq!((frames.complaint(), frames.frozen(), frames.dropped()), (None, 3, 0));
}

/// L2: a flood is thinned to the highest rate, jitter of a stream at that rate is not.
#[test]
fn a_flood_is_thinned_and_jitter_is_not() {
    let mut frames = frames();
    let passed = (0..1000_u32).filter(|index| {
        let exposed_s = 10.0 + 1e-3 * f64::from(*index);
        take(&mut frames, exposed_s, u8::try_from(index % 251).unwrap()).is_ok()
    });
    // 1 s at 10 Hz, and the two that may come at once; the last ones need not be complete.
    assert!((10..=12).contains(&passed.count()));
    let mut frames = self::frames();
    for (index, exposed_s) in [0.0, 0.14, 0.2, 0.3, 0.44, 0.5, 0.6].into_iter().enumerate() {
        assert!(take(&mut frames, 20.0 + exposed_s, u8::try_from(index).unwrap()).is_ok(), "{exposed_s}");
    }
}

#[test]
fn a_clock_that_was_set_back_is_followed() {
    let mut frames = frames();
    take(&mut frames, 1000.0, 1).unwrap();
    assert_eq!(take(&mut frames, 10.0, 2).unwrap().dropped, 0);
    assert_eq!(take(&mut frames, 10.5, 3).unwrap().dropped, 0);
}

proptest! {
    #[test]
    fn any_frame_is_passed_or_refused_and_counted(
        arrivals in proptest::collection::vec(
            (any::<u64>(), 0u8..4, proptest::collection::vec(any::<u8>(), 0..80), 0.0..1.0f64), 1..40)
    ) {
        let (mut frames, mut now_s, mut refused) = (frames(), 10.0, 0);
        for (bits, kind, bytes, step_s) in arrivals {
            now_s += step_s;
            let stamp_s = if kind == 0 { f64::from_bits(bits) } else { now_s };
            let bytes = if kind == 1 { bytes } else { jpeg(640, 480, (bits % 7) as u8) };
            if frames.on_frame(Seconds(now_s), Seconds(stamp_s), &bytes).is_err() {
                refused += 1;
            }
        }
        prop_assert_eq!(frames.refusals().total(), refused);
    }
}
