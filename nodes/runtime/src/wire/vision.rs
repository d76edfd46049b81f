//! Frames and what was found in them.

use super::{WireError, optional, stamp_from_wire, within};
use fdm_loop_msgs::{CompressedImage, DefectReport, Header};
use models::units::Seconds;

/// Largest compressed frame that is passed on `[byte]`: faults.md, S9.
pub const FRAME_BYTES_MAX: usize = 4 << 20;
/// What the simulated printer and the camera node write into `format`.
const FORMAT: &str = "mono8; jpeg compressed mono8";

/// A compressed frame.
#[derive(Debug, Clone, PartialEq)]
pub struct JpegFrame {
    /// Time of exposure.
    pub exposed: Seconds,
    /// The JPEG file, not looked into.
    pub jpeg: Vec<u8>,
}

/// What controller and supervisor read of a defect report.
#[derive(Debug, Clone, PartialEq)]
pub struct DefectReading {
    /// Time of exposure.
    pub exposed: Seconds,
    /// The frame could be judged; nothing else counts where not.
    pub usable: bool,
    /// Fused confidence c_k `[0, 1]`.
    pub confidence: f64,
    /// Class that carries it.
    pub cause: String,
    /// Enough frames agree on the cause.
    pub confirmed: bool,
    /// The frame itself could tell of the cause.
    pub told: bool,
    /// Offset of the layers below in x and y `[m]`, where they were found.
    pub offset_m: Option<[f64; 2]>,
}

/// A frame: JPEG by its magic number, no larger than [`FRAME_BYTES_MAX`].
///
/// # Errors
/// [`WireError`] for a frame of another kind, an empty or a too large one.
pub fn frame_from_wire(wire: &CompressedImage) -> Result<JpegFrame, WireError> {
    #[allow(clippy::cast_precision_loss, reason = "a size for people")]
    let bytes = |count: usize| count as f64;
    within("data.length", bytes(wire.data.len()), (4.0, bytes(FRAME_BYTES_MAX)))?;
    if !wire.data.starts_with(&[0xff, 0xd8, 0xff]) {
        return Err(WireError::Missing { field: "JPEG magic number" });
    }
    Ok(JpegFrame { exposed: stamp_from_wire(&wire.header)?, jpeg: wire.data.clone() })
}

/// A frame as sent.
#[must_use]
pub fn frame_to_wire(frame: JpegFrame, frame_id: &str) -> CompressedImage {
    CompressedImage {
        header: Header { frame_id: frame_id.to_owned(), ..Header::at(frame.exposed.0) },
        format: FORMAT.to_owned(),
        data: frame.jpeg,
    }
}

/// A defect report.
///
/// # Errors
/// [`WireError`] for a value that is not finite or out of range, probabilities that do not belong to the classes.
pub fn defects_from_wire(wire: &DefectReport) -> Result<DefectReading, WireError> {
    const SHARE: (f64, f64) = (0.0, 1.0);
    if wire.usable && (wire.classes.is_empty() || wire.probabilities.len() != wire.classes.len()) {
        return Err(WireError::Missing { field: "probabilities" });
    }
    for share in &wire.probabilities {
        within("probabilities", *share, SHARE)?;
    }
    within("detection", wire.detection, SHARE)?;
    within("residual", wire.residual, (0.0, f64::MAX))?;
    optional(wire.offset_known, "offset_sigma_m", wire.offset_sigma_m, (0.0, 1.0))?;
    let x_m = optional(wire.offset_known, "offset_m", wire.offset_m[0], (-1.0, 1.0))?;
    let y_m = optional(wire.offset_known, "offset_m", wire.offset_m[1], (-1.0, 1.0))?;
    Ok(DefectReading {
        exposed: stamp_from_wire(&wire.header)?,
        usable: wire.usable,
        confidence: within("confidence", wire.confidence, SHARE)?,
        cause: wire.cause.clone(),
        confirmed: wire.confirmed,
        told: wire.cause_told,
        offset_m: x_m.zip(y_m).map(|(x_m, y_m)| [x_m, y_m]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_jpeg_of_a_bounded_size_is_a_frame() {
        let frame = JpegFrame { exposed: Seconds(2.0), jpeg: vec![0xff, 0xd8, 0xff, 0xd9] };
        let sound = frame_to_wire(frame.clone(), "camera_optical");
        assert_eq!(frame_from_wire(&sound).unwrap(), frame);
        let png = CompressedImage { data: vec![0x89, 0x50, 0x4e, 0x47], ..sound.clone() };
        assert!(frame_from_wire(&png).unwrap_err().to_string().contains("JPEG"));
        let mut long = sound.clone();
        long.data.resize(FRAME_BYTES_MAX + 1, 0);
        assert!(frame_from_wire(&long).unwrap_err().to_string().starts_with("data.length = 4194305"));
        assert!(frame_from_wire(&CompressedImage { data: vec![], ..sound }).is_err());
    }

    #[test]
    fn a_report_with_a_value_that_cannot_be_is_refused() {
        type Poison = fn(&mut DefectReport);
        let poisons: [(&str, Poison); 4] = [
            ("confidence = 1.5", |wire| wire.confidence = 1.5),
            ("probabilities is not finite", |wire| wire.probabilities[0] = f64::NAN),
            ("probabilities is missing", |wire| wire.classes.clear()),
            ("offset_m is not finite", |wire| wire.offset_m[1] = f64::INFINITY),
        ];
        let sound = DefectReport {
            usable: true,
            classes: vec!["ok".into(), "shift".into()],
            probabilities: vec![0.9, 0.1],
            confidence: 0.2,
            offset_known: true,
            ..DefectReport::default()
        };
        assert_eq!(defects_from_wire(&sound).unwrap().offset_m, Some([0.0, 0.0]));
        for (text, poison) in poisons {
            let mut wire = sound.clone();
            poison(&mut wire);
            let said = defects_from_wire(&wire).unwrap_err().to_string();
            assert!(said.starts_with(text), "{said} is not {text}");
        }
    }
}
