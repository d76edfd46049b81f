//! Messages of the slower topics of the print that never was.

use super::picture;
use super::print::{Print, WIDTH_M};
use super::writer::BagFile;
use fdm_loop_msgs::*;
use runtime::topics;
use std::f64::consts::TAU;

impl Print {
    pub(super) fn commands(&self, bag: &mut BagFile, at: f64) {
        let wish = ControlCommand {
            header: Header::at(at),
            validity_s: 1.0,
            mode: ControlCommand::MODE_ACT,
            flow_factor: 1.0 + 0.02 * (TAU * at / 40.0).sin() + self.number,
            speed_factor: 1.0,
            set_advance: true,
            advance_s: 0.05,
            close_extruder_loop: true,
            slip_compensation: if self.slips(at) { 0.09 } else { 0.01 },
            ..ControlCommand::default()
        };
        bag.put(&topics::CONTROL_COMMAND, at, &wish);
        bag.put(&topics::SAFETY_COMMAND, at, &ControlCommand { flow_factor: 1.0, ..wish });
    }

    pub(super) fn slow(&self, bag: &mut BagFile, at: f64) {
        let paused = self.share(at) >= Self::PAUSE;
        let safety = SafetyState {
            header: Header::at(at),
            mode: if paused { SafetyState::MODE_PAUSED } else { SafetyState::MODE_ACT },
            set_mode: SafetyState::MODE_ACT,
            cause: if paused { self.text("P9: spaghetti") } else { String::new() },
            what_to_do: if paused { self.text("clear the bed") } else { String::new() },
            ..SafetyState::default()
        };
        bag.put(&topics::SAFETY_STATE, at, &safety);
        let quality = LayerQuality {
            header: Header::at(at),
            layer: self.layer(at),
            quality: 0.4 + 0.2 * f64::from(self.layer(at) % 3) + self.number,
            width_term: 0.2,
            temperature_term: 0.1 + 0.2 * f64::from(self.layer(at) % 3),
            adhesion_term: 0.1,
            ..LayerQuality::default()
        };
        bag.put(&topics::LAYER_QUALITY, at, &quality);
        let width = BeadWidth {
            header: Header::at(at),
            width_m: WIDTH_M * (1.0 + 0.02 * (TAU * at / 7.0).sin()) + self.number,
            sigma_m: 1e-5,
            source: self.text("camera"),
        };
        bag.put(&topics::BEAD_WIDTH, at, &width);
        let value = KeyValue { key: self.text("frames"), value: self.text("1") };
        let status = DiagnosticStatus {
            name: self.text("/printer/camera"),
            message: self.text("ok"),
            values: vec![value],
            ..DiagnosticStatus::default()
        };
        let array = DiagnosticArray { header: Header::at(at), status: vec![status] };
        bag.put(&topics::DIAGNOSTICS, at, &array);
    }

    pub(super) fn frame(&self, bag: &mut BagFile, at: f64) {
        let seen = self.share(at) >= Self::DEFECT;
        let report = DefectReport {
            header: Header::at(at),
            usable: true,
            classes: vec!["ok".into(), "spaghetti".into()],
            probabilities: vec![0.2, 0.8],
            detection: if seen { 0.8 } else { 0.05 },
            residual: 0.5 + self.number,
            residual_limit: 2.0,
            confidence: if seen { 0.7 } else { 0.1 } + self.number,
            cause: if seen { self.text("spaghetti") } else { "ok".into() },
            confirmed: seen,
            in_favour: 6,
            window: 10,
            cause_told: true,
            offset_known: true,
            ..DefectReport::default()
        };
        let data = picture::png(160, 120, seen, self.frame_bytes);
        let image = CompressedImage { header: Header::at(at), format: self.text("png"), data };
        bag.put(&topics::ANNOTATED, at, &image);
        bag.put(&topics::DEFECTS, at, &report);
    }
}
