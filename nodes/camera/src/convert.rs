//! Between messages and the brain's types.

use fdm_loop_msgs::{CameraInfo, CompressedImage, Header};
use models::units::Seconds;
use runtime::Reason;
use runtime::wire::{WireError, frame_from_wire};

use crate::frames::Refusals;
use crate::params::CameraParams;
use crate::picture;

/// A frame as it is: its picture is for the brain to judge.
pub(crate) fn frame(wire: &CompressedImage) -> Result<(Seconds, (Seconds, Vec<u8>)), WireError> {
    let frame = frame_from_wire(wire)?;
    Ok((frame.exposed, (frame.exposed, frame.jpeg)))
}

/// A checked frame, untouched; the stamp stays that of the exposure.
pub(crate) fn image(
    params: &CameraParams,
    exposed: Seconds,
    header: picture::Header,
    jpeg: Vec<u8>,
) -> CompressedImage {
    let format =
        if header.components == 1 { "mono8; jpeg compressed mono8" } else { "bgr8; jpeg compressed bgr8" };
    CompressedImage { header: stamped(params, exposed), format: format.to_owned(), data: jpeg }
}

/// The calibration that belongs to a frame: a lens without distortion that looks straight down.
pub(crate) fn info(params: &CameraParams, exposed: Seconds) -> CameraInfo {
    let k = params.intrinsics();
    let p = [k[0], k[1], k[2], 0.0, k[3], k[4], k[5], 0.0, k[6], k[7], k[8], 0.0];
    CameraInfo {
        header: stamped(params, exposed),
        height: params.height_px,
        width: params.width_px,
        distortion_model: "plumb_bob".to_owned(),
        d: vec![0.0; 5],
        k,
        r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p,
        ..CameraInfo::default()
    }
}

fn stamped(params: &CameraParams, exposed: Seconds) -> Header {
    Header { frame_id: params.frame.clone(), ..Header::at(exposed.0) }
}

/// The brain's counters by the reasons of the diagnostics.
pub(crate) fn reasons(refusals: &Refusals) -> [(Reason, u64); 5] {
    [
        (Reason::NotFinite, refusals.not_finite),
        (Reason::OutOfRange, refusals.too_large + refusals.size + refusals.future),
        (Reason::Stale, refusals.stale),
        (Reason::Order, refusals.order + refusals.too_fast),
        (Reason::Malformed, refusals.corrupt),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Image and calibration go together by their stamp; K is `f = Z/s` and the middle pixel.
    #[test]
    fn a_frame_and_its_calibration_have_one_stamp() {
        let params: CameraParams = serde_saphyr::from_str(
            "{frame: camera_optical, width_px: 640, height_px: 480, scale_m: 5.0e-5, working_distance_m: 0.05, \
             rate_hz: 2.0, rate_max_hz: 30.0, jpeg_quality: 90, stamp_future_max_s: 0.2, stamp_age_max_s: 2.0, \
             lost_after_s: 1.5}",
        )
        .unwrap();
        let header = picture::Header { width_px: 640, height_px: 480, components: 3 };
        let (image, info) = (image(&params, Seconds(2.5), header, vec![7]), info(&params, Seconds(2.5)));
        assert_eq!(image.header, info.header);
        assert_eq!(
            (image.header.frame_id.as_str(), image.format.as_str()),
            ("camera_optical", "bgr8; jpeg compressed bgr8")
        );
        // 0.05 m / 50 um = 1000 px
        let expected = [1000.0, 0.0, 319.5, 0.0, 1000.0, 239.5, 0.0, 0.0, 1.0];
        assert!(info.k.iter().zip(expected).all(|(value, wanted)| (value - wanted).abs() < 1e-9));
        assert!(
            (info.p[5] - 1000.0).abs() < 1e-9 && (info.p[6] - 239.5).abs() < 1e-9 && info.d == vec![0.0; 5]
        );
    }
}
