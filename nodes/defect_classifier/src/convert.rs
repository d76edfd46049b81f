//! Between messages and the brain's types.

use fdm_loop_msgs::{
    BeadWidth, CompressedImage, DefectReport, Header, LayerQuality, MotionSegment, PrintEvent, PrinterState,
    StateEstimate,
};
use models::units::Seconds;
use runtime::wire::{self, JpegFrame, PlannedMove, WireError};

use crate::event::{Defects, EstimateReading, Event, Note, Weight};
use crate::layer::LayerFigure;
use crate::params::MachineParams;
use crate::width::WidthMeasurement;

/// Optical frame of the camera.
const CAMERA_FRAME: &str = "camera_optical";
/// Source that a width states.
const SOURCE: &str = "camera";

pub fn frame(wire: &CompressedImage) -> Result<(Seconds, Event), WireError> {
    let JpegFrame { exposed, jpeg } = wire::frame_from_wire(wire)?;
    Ok((exposed, Event::Frame { exposed, jpeg }))
}

pub fn motion(wire: &MotionSegment) -> Result<(Seconds, Event), WireError> {
    let planned = wire::motion_from_wire(wire)?;
    let PlannedMove { start, path_time_s: path_s, segment, .. } = planned;
    Ok((start, Event::Motion { start, path_s, segment: Box::new(segment) }))
}

pub fn printer(wire: &PrinterState) -> Result<(Seconds, Event), WireError> {
    let status = wire::status_from_wire(wire)?;
    Ok((status.stamp, Event::Printer(Box::new(status))))
}

pub fn estimate(wire: &StateEstimate) -> Result<(Seconds, Event), WireError> {
    let reading = wire::estimate_from_wire(wire)?;
    let estimate = EstimateReading {
        stamp: reading.stamp,
        nozzle: reading.nozzle,
        chi_square: wire.chi_square.clone(),
        window: wire.chi_square_window,
    };
    Ok((reading.stamp, Event::Estimate(estimate)))
}

pub fn width(width: &WidthMeasurement) -> BeadWidth {
    BeadWidth {
        header: Header::at(width.laid.0),
        width_m: width.width_m,
        sigma_m: width.sigma_m,
        source: SOURCE.to_owned(),
    }
}

pub fn picture(exposed: Seconds, jpeg: Vec<u8>) -> CompressedImage {
    CompressedImage {
        header: in_camera(exposed),
        format: "bgr8; jpeg compressed bgr8".to_owned(),
        data: jpeg,
    }
}

fn in_camera(exposed: Seconds) -> Header {
    Header { frame_id: CAMERA_FRAME.to_owned(), ..Header::at(exposed.0) }
}

pub fn defects(defects: &Defects, classes: &[String]) -> DefectReport {
    let blank = DefectReport {
        header: in_camera(defects.exposed),
        frame: defects.frame,
        classes: classes.to_vec(),
        ..DefectReport::default()
    };
    match &defects.judged {
        Err(why) => DefectReport { why: why.to_string(), ..blank },
        Ok(judged) => DefectReport {
            usable: true,
            probabilities: judged.probabilities.clone(),
            detection: judged.fused.detection,
            residual: judged.fused.residual,
            residual_limit: judged.fused.residual_limit,
            confidence: judged.fused.confidence,
            cause: judged.fused.cause.clone(),
            confirmed: judged.fused.confirmed,
            in_favour: judged.fused.in_favour,
            window: judged.fused.window,
            offset_known: judged.offset.is_some(),
            offset_m: judged.offset.map_or([0.0; 2], |offset| offset.offset_m),
            offset_sigma_m: judged.offset.map_or(0.0, |offset| offset.sigma_m),
            region_known: judged.region_px.is_some(),
            region_px: judged.region_px.unwrap_or_default(),
            cause_told: judged.fused.told,
            ..blank
        },
    }
}

pub fn quality(figure: &LayerFigure, machine: &MachineParams) -> LayerQuality {
    LayerQuality {
        header: Header::at(figure.stamp.0),
        layer: figure.layer,
        complete: figure.complete,
        quality: figure.terms.total(),
        feature_term: figure.terms.features,
        width_term: figure.terms.width,
        temperature_term: figure.terms.temperature,
        adhesion_term: figure.terms.adhesion,
        porosity_term: figure.terms.porosity,
        width_error_rel: figure.width_error_rel,
        width_rms_rel: figure.width_rms_rel,
        widths: figure.widths,
        frames: figure.frames,
        machine_error_known: machine.error_m.is_some(),
        machine_error_m: machine.error_m.unwrap_or(0.0),
    }
}

pub fn note(note: &Note, who: &str) -> PrintEvent {
    PrintEvent {
        header: Header::at(note.stamp.0),
        severity: match note.weight {
            Weight::Info => PrintEvent::SEVERITY_INFO,
            Weight::Warn => PrintEvent::SEVERITY_WARN,
        },
        who: who.to_owned(),
        what: note.what.to_owned(),
        why: note.why.clone(),
        before: note.before.clone(),
        after: note.after.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Unusable;

    /// S8: a frame that cannot be judged is never OK on the wire either.
    #[test]
    fn a_frame_that_cannot_be_judged_is_unknown_with_its_reason() {
        let unknown =
            Defects { exposed: Seconds(3.0), frame: 7, judged: Err(Unusable::Black { mean_grey: 2.0 }) };
        let wire = defects(&unknown, &["ok".to_owned()]);
        assert!(!wire.usable && wire.probabilities.is_empty() && wire.cause.is_empty());
        assert_eq!(wire.why, "black: mean grey 2.0");
        assert!(!runtime::wire::defects_from_wire(&wire).unwrap().usable);
    }
}
