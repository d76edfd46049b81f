use super::*;
use opencv::core::{CV_8UC1, CV_8UC3, Scalar, Vector, VectorToVec};

const NOTHING: Measured = Measured {
    width_error_rel: None,
    width_drift_rel: None,
    offset_m: None,
    unexplained: None,
    seam_drift_sigmas: None,
};

/// A picture from levels `[0, 1]` by column and row.
fn picture((width, height): (u16, u16), level: impl Fn(f64, f64) -> f64) -> Mat {
    let rows: Vec<Vec<u8>> = (0..height)
        .map(|y| {
            let one = |x: u16| (255.0 * level(f64::from(x), f64::from(y)).clamp(0.0, 1.0)).round();
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "rounded, in [0, 255]"
            )]
            (0..width).map(|x| one(x) as u8).collect()
        })
        .collect();
    Mat::from_slice_2d(&rows).unwrap()
}

/// Roads of 14 px pitch at an angle.
fn roads(angle_rad: f64, contrast: f64) -> Mat {
    picture((640, 480), |x, y| {
        let across = x * angle_rad.cos() + y * angle_rad.sin();
        0.5 + contrast * (std::f64::consts::TAU * across / 14.0).sin()
    })
}

fn of(grey: &Mat, name: &str) -> f64 {
    let place = names().iter().position(|known| *known == name).unwrap();
    extract(grey, Hidden(0.0), &NOTHING).unwrap()[place]
}

#[test]
fn every_feature_is_named_once_and_finite_on_any_picture() {
    let names = names();
    assert_eq!(names.len(), COUNT);
    let mut unique = names.clone();
    unique.sort_unstable();
    unique.dedup();
    assert_eq!(unique.len(), COUNT);
    let flat = |level| picture((64, 64), move |_, _| level);
    let checks = picture((65, 311), |x, y| if (x + y) % 2.0 < 1.0 { 1.0 } else { 0.0 });
    for grey in [flat(0.0), flat(1.0), checks, roads(0.3, 0.4)] {
        let values = extract(&grey, Hidden(0.0), &NOTHING).unwrap();
        assert_eq!(values.len(), COUNT);
        let odd = values.iter().zip(&names).find(|(value, _)| !value.is_finite());
        assert!(odd.is_none(), "{odd:?}");
    }
}

/// A pitch of 14 px at 640 px is 7 px at 320: 1/7 cycles a pixel, to the grid of 1/320 in each axis.
#[test]
fn the_pitch_of_roads_is_found_whichever_way_they_run() {
    for angle_rad in [0.0, 0.4, 1.1, 2.2] {
        let found = of(&roads(angle_rad, 0.3), "pitch_freq");
        assert!((found - 1.0 / 7.0).abs() < 2.0 / 240.0, "{angle_rad} rad: {found}");
    }
}

#[test]
fn even_roads_agree_in_direction_and_noise_does_not() {
    // A hash of the place: no direction anywhere.
    let noise = picture((640, 480), |x, y| ((x * 12.9898 + y * 78.233).sin() * 43_758.545).rem_euclid(1.0));
    assert!(of(&roads(0.7, 0.3), "concord_2") > 0.98);
    assert!(of(&roads(0.7, 0.3), "coh_mean") > 0.9);
    assert!(of(&noise, "concord_2") < 0.5 && of(&noise, "coh_mean") < 0.4);
}

/// Half the contrast is half the spread; what is relative to the variance stays.
#[test]
fn contrast_changes_the_levels_and_not_the_texture() {
    let (strong, weak) = (roads(0.4, 0.4), roads(0.4, 0.2));
    assert!((of(&weak, "level_std") / of(&strong, "level_std") - 0.5).abs() < 0.01);
    for name in ["grad_energy", "concord_2", "sector_max", "pitch_freq", "lap_2"] {
        let (one, other) = (of(&strong, name), of(&weak, name));
        assert!((one - other).abs() < 0.05 * one.abs().max(1.0), "{name}: {one} and {other}");
    }
}

/// The same scene at 1280 x 960 and at 640 x 480, and beside a margin that is cut off.
#[test]
fn resolution_and_margins_do_not_change_what_is_seen() {
    let scene = |x: f64, y: f64| 0.5 + 0.3 * (x * 40.0 + (y * 9.0).sin() * 3.0).sin() * (y * 25.0).cos();
    let small = picture((640, 480), |x, y| scene((x + 0.5) / 640.0, (y + 0.5) / 480.0));
    let large = picture((1280, 960), |x, y| scene((x + 0.5) / 1280.0, (y + 0.5) / 960.0));
    let margin = picture((640, 640), |x, y| {
        if (80.0..560.0).contains(&y) { scene((x + 0.5) / 640.0, (y - 79.5) / 480.0) } else { 0.0 }
    });
    for name in ["level_mean", "grad_entropy", "coh_mean", "lbp_coarse_8", "ring_3"] {
        let one = of(&small, name);
        for other in [of(&large, name), of(&margin, name)] {
            assert!((one - other).abs() < 0.05 * one.abs().max(0.2), "{name}: {one} and {other}");
        }
    }
}

#[test]
fn a_picture_that_is_none_is_refused() {
    let colour = Mat::new_rows_cols_with_default(100, 100, CV_8UC3, Scalar::all(9.0)).unwrap();
    let tiny = Mat::new_rows_cols_with_default(63, 100, CV_8UC1, Scalar::all(9.0)).unwrap();
    for grey in [Mat::default(), colour, tiny] {
        assert!(matches!(extract(&grey, Hidden(0.0), &NOTHING), Err(FeatureError::Picture { .. })));
    }
    assert!(matches!(extract_encoded(b"no picture", Hidden(0.0), &NOTHING), Err(FeatureError::Encoded(10))));
    assert!(extract_encoded(&[], Hidden(0.0), &NOTHING).is_err());
}

/// OpenCV fills up what is missing: half a file would be judged as half a print.
#[test]
fn a_part_of_a_picture_is_refused_and_what_a_phone_appends_is_not() {
    let grey = roads(0.0, 0.3);
    for progressive in [0, 1] {
        let flags = Vector::from_slice(&[imgcodecs::IMWRITE_JPEG_PROGRESSIVE, progressive]);
        let mut whole = Vector::new();
        imgcodecs::imencode(".jpg", &grey, &mut whole, &flags).unwrap();
        let whole = whole.to_vec();
        assert!(decode(&whole).is_ok() && decode(&[&whole[..], b"a film \xff\xd9 of it"].concat()).is_ok());
        for length in [3, 200, whole.len() / 2, whole.len() - 2] {
            assert!(matches!(decode(&whole[..length]), Err(FeatureError::Cut(_))), "{progressive}: {length}");
        }
        // A small picture in the comments has an end marker of its own.
        let comment = [&whole[..2], &[0xff, 0xe1, 0, 6, 1, 0xff, 0xd9, 2], &whole[2..]].concat();
        assert!(decode(&comment).is_ok());
        assert!(matches!(decode(&comment[..comment.len() / 2]), Err(FeatureError::Cut(_))), "{progressive}");
    }
    let mut png = Vector::new();
    imgcodecs::imencode_def(".png", &grey, &mut png).unwrap();
    let png = png.to_vec();
    assert!(decode(&png).is_ok());
    assert!(decode(&png[..png.len() / 2]).is_err());
}

#[test]
fn what_the_head_hides_does_not_count() {
    let disc = |level: f64| {
        picture((640, 480), move |x, y| {
            let road = 0.5 + 0.3 * (std::f64::consts::TAU * x / 14.0).sin();
            if (x - 319.5).hypot(y - 239.5) < 80.0 { level } else { road }
        })
    };
    let [dark, bright] = [0.0, 1.0].map(|level| extract(&disc(level), Hidden(0.19), &NOTHING).unwrap());
    // 80 px are 0.167 of the height: inside the disc of 0.19 whatever the reduction does at its rim.
    for ((one, other), name) in dark.iter().zip(&bright).zip(names()) {
        assert!((one - other).abs() < 1e-9, "{name}: {one} and {other}");
    }
}

#[test]
fn what_is_measured_stands_after_its_flag() {
    let grey = roads(0.0, 0.3);
    let measured = Measured { width_error_rel: Some(-0.1), offset_m: Some([3e-4, 4e-4]), ..NOTHING };
    let values = extract(&grey, Hidden(0.0), &measured).unwrap();
    let last = &values[COUNT - 4..];
    assert!(last[..3] == [1.0, -0.1, 1.0] && (last[3] - 0.5).abs() < 1e-12);
    assert_eq!(extract(&grey, Hidden(0.0), &NOTHING).unwrap()[COUNT - 4..], [0.0; 4]);
    let wild = Measured { width_error_rel: Some(f64::NAN), ..NOTHING };
    assert!(matches!(extract(&grey, Hidden(0.0), &wild), Err(FeatureError::Measured("width_error_rel"))));
}
