use super::*;
use crate::camera::tests::camera;
use opencv::core::{Mat, Vector, VectorToVec};
use opencv::imgcodecs;
use proptest::prelude::*;

pub(crate) fn checks() -> FrameChecks {
    FrameChecks::try_from(RawChecks {
        bytes_max: 4 << 20,
        pixels_max: 8_000_000,
        black_grey: 12.0,
        saturated_grey: 250.0,
        saturated_share: 0.4,
        sharpness_blur_px: 2.0,
        sharpness_min: 1e-3,
    })
    .unwrap()
}

pub(crate) fn jpeg(grey: &Mat) -> Vec<u8> {
    let mut bytes = Vector::new();
    imgcodecs::imencode_def(".jpg", grey, &mut bytes).unwrap();
    bytes.to_vec()
}

pub(crate) fn picture(width_px: usize, height_px: usize, level: impl Fn(usize, usize) -> u8) -> Mat {
    let levels: Vec<Vec<u8>> = (0..height_px).map(|v| (0..width_px).map(|u| level(u, v)).collect()).collect();
    Mat::from_slice_2d(&levels).unwrap()
}

/// Bars eight pixels wide.
fn bars() -> Mat {
    picture(640, 480, |u, _| if (u / 8) % 2 == 0 { 60 } else { 160 })
}

fn opened(picture: &Mat) -> Result<Mat, Unusable> {
    FrameGate::new(checks(), &camera()).open(&jpeg(picture))
}

#[test]
fn a_sharp_lit_frame_is_opened() {
    assert_eq!(opened(&bars()).unwrap().cols(), 640);
}

/// Networks and edges were learned from pictures that OpenCV decoded: at most two grey levels lie between the decoders.
#[test]
fn the_levels_are_those_that_opencv_decodes() {
    let wavy = picture(640, 480, |u, v| u8::try_from(90 + (u * u / 300 + v * 7) % 120).unwrap());
    let ours = opened(&wavy).unwrap();
    let bytes = jpeg(&wavy);
    let theirs = imgcodecs::imdecode(&Mat::from_slice(&bytes).unwrap(), imgcodecs::IMREAD_GRAYSCALE).unwrap();
    let pairs = ours.data_bytes().unwrap().iter().zip(theirs.data_bytes().unwrap());
    let apart = pairs.map(|(ours, theirs)| ours.abs_diff(*theirs)).max();
    assert!(apart <= Some(2), "{apart:?}");
    assert_eq!((ours.rows(), ours.cols()), (theirs.rows(), theirs.cols()));
}

#[test]
fn black_saturated_and_blurred_frames_are_refused_with_their_figure() {
    assert!(matches!(opened(&picture(640, 480, |_, _| 3)), Err(Unusable::Black { .. })));
    assert!(matches!(
        opened(&picture(640, 480, |u, _| if u < 400 { 255 } else { 90 })),
        Err(Unusable::Saturated { .. })
    ));
    let blocks = picture(640, 480, |u, v| if (u / 100 + v / 100) % 2 == 0 { 60 } else { 160 });
    assert!(opened(&blocks).is_ok());
    let mut soft = Mat::default();
    imgproc::gaussian_blur_def(&blocks, &mut soft, Size::default(), 8.0).unwrap();
    assert!(matches!(opened(&soft), Err(Unusable::Blurred { .. })));
}

#[test]
fn the_same_bytes_twice_are_a_frozen_camera() {
    let (mut gate, bytes) = (FrameGate::new(checks(), &camera()), jpeg(&bars()));
    assert!(gate.open(&bytes).is_ok());
    assert_eq!(gate.open(&bytes).unwrap_err(), Unusable::Frozen);
}

/// S9: 100 megapixels in the header of a small file are refused before a byte is decoded.
#[test]
fn a_huge_or_wrong_size_in_the_header_is_refused_undecoded() {
    let mut bytes = jpeg(&bars());
    let at = (0..bytes.len()).find(|&at| bytes[at] == 0xff && bytes[at + 1] == 0xc0).unwrap();
    bytes[at + 5..at + 9].copy_from_slice(&[0x27, 0x10, 0x27, 0x10]);
    assert_eq!(jpeg_size(&bytes), Some(JpegSize { width_px: 10_000, height_px: 10_000 }));
    let mut gate = FrameGate::new(checks(), &camera());
    assert!(matches!(gate.open(&bytes), Err(Unusable::TooLarge { found: 100_000_000, .. })));
    assert!(matches!(
        opened(&picture(320, 240, |u, _| if u % 16 < 8 { 9 } else { 99 })),
        Err(Unusable::WrongSize { .. })
    ));
    assert!(matches!(gate.open(&vec![0; (4 << 20) + 1]), Err(Unusable::TooLarge { unit: "byte", .. })));
}

#[test]
fn a_cut_file_is_never_opened_and_a_filled_up_one_is() {
    let mut bytes = jpeg(&bars());
    for length in [0, 1, 3, 20, 160, 300, bytes.len() / 2, bytes.len() - 1] {
        assert!(FrameGate::new(checks(), &camera()).open(&bytes[..length]).is_err(), "{length}");
    }
    bytes.extend([0; 7]);
    assert!(FrameGate::new(checks(), &camera()).open(&bytes).is_ok());
}

/// A driver that closes a half transferred file: its end marker is there, half of its picture is not. Filled up
/// differently each time it is still the same picture.
#[test]
fn a_cut_file_with_an_end_marker_is_refused_and_filling_hides_no_frozen_camera() {
    let mut gate = FrameGate::new(checks(), &camera());
    let whole = jpeg(&bars());
    for share in [0.125, 0.5, 0.9, 0.98] {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a part of a length")]
        let mut cut = whole[..(whole.len() as f64 * share) as usize].to_vec();
        cut.extend([0xff, 0xd9]);
        assert_eq!(gate.open(&cut).unwrap_err(), Unusable::Corrupt, "{share}");
    }
    assert!(gate.open(&whole).is_ok());
    let filled = [&whole[..], &[0; 9]].concat();
    assert_eq!(gate.open(&filled).unwrap_err(), Unusable::Frozen);
}

proptest! {
    #[test]
    fn no_bytes_lead_the_header_reader_astray(mut bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        prop_assert!(jpeg_size(&bytes).is_none_or(|size| size.width_px > 0));
        bytes.splice(0..0, [0xff, 0xd8, 0xff]);
        if let Some(size) = jpeg_size(&bytes) {
            prop_assert!(size.width_px > 0 && size.height_px > 0);
        }
    }
}
