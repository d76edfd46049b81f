//! A print that never was: every topic, with a slip, a defect and a pause in it.

use super::writer::BagFile;
use fdm_loop_msgs::*;
use runtime::topics;
use std::f64::consts::TAU;

/// What the print is like.
#[derive(Clone)]
pub(crate) struct Print {
    pub(crate) duration_s: f64,
    pub(crate) layers: u32,
    /// Period of the state `[s]`.
    pub(crate) period_s: f64,
    /// Every text that a bag can hold.
    pub(crate) text: &'static str,
    /// What a float is where the print has nothing special to say.
    pub(crate) number: f64,
    /// Frames every so many seconds, of so many bytes.
    pub(crate) frame_s: f64,
    pub(crate) frame_bytes: usize,
}

pub(crate) const USUAL: Print = Print {
    duration_s: 120.0,
    layers: 4,
    period_s: 0.05,
    text: "",
    number: 0.0,
    frame_s: 1.0,
    frame_bytes: 0,
};

/// Width that is asked for, height, filament section `[m], [m], [m2]`.
pub(super) const WIDTH_M: f64 = 0.45e-3;
const HEIGHT_M: f64 = 0.2e-3;
const FILAMENT_M2: f64 = 2.405e-6;
/// Edge of the square that is printed `[m]`.
const EDGE_M: f64 = 0.02;
const SPEED_M_S: f64 = 0.04;

impl Print {
    /// Share of the print at which the head is knocked, the gear begins to slip, a defect is seen, and the print pauses.
    pub(crate) const KNOCK: f64 = 0.3;
    pub(crate) const SLIP: f64 = 0.4;
    pub(crate) const DEFECT: f64 = 0.7;
    pub(crate) const PAUSE: f64 = 0.9;

    /// Writes the whole print.
    pub(crate) fn write(&self, bag: &mut BagFile) {
        self.info(bag);
        let mut events = self.events();
        let (mut road_s, mut roads) = (0.0, 0);
        let steps = (self.duration_s / self.period_s) as u64;
        let every = |period_s: f64, step: u64| {
            step.is_multiple_of((period_s / self.period_s).round().max(1.0) as u64)
        };
        for step in 0..steps {
            let at = step as f64 * self.period_s;
            while road_s <= at {
                road_s = self.road(bag, road_s, roads);
                roads += 1;
            }
            while events.first().is_some_and(|(due, _)| *due <= at) {
                bag.put(&topics::EVENTS, at, &events.remove(0).1);
            }
            self.state(bag, at);
            self.estimate(bag, at);
            if every(0.1, step) {
                self.sensors(bag, at);
            }
            if every(0.25, step) {
                self.commands(bag, at);
            }
            if every(1.0, step) {
                self.slow(bag, at);
            }
            if every(self.frame_s, step) {
                self.frame(bag, at);
            }
        }
    }

    pub(super) fn share(&self, at: f64) -> f64 {
        at / self.duration_s
    }

    pub(super) fn layer(&self, at: f64) -> u32 {
        ((self.share(at) * f64::from(self.layers)) as u32).min(self.layers - 1)
    }

    pub(super) fn slips(&self, at: f64) -> bool {
        self.share(at) >= Self::SLIP
    }

    pub(super) fn text(&self, usual: &str) -> String {
        if self.text.is_empty() { usual.to_owned() } else { self.text.to_owned() }
    }

    fn info(&self, bag: &mut BagFile) {
        let config =
            "# state_estimator 00\nmaterial.name: \"PLA\"\n\n# mpc_controller 00\ncontrol: \"mpc\"\n";
        let info = PrintInfo {
            header: Header::at(0.0),
            print_id: self.text("square-1"),
            gcode_file: self.text("square.gcode"),
            config: format!("{config}x: {}\n", self.text("1")),
            build: self.text("0.1.0"),
            scenario: self.text("slip09"),
            ..PrintInfo::default()
        };
        bag.put(&topics::PRINT_INFO, 0.0, &info);
    }

    /// One edge of the squares that fill a layer from outside in.
    fn road(&self, bag: &mut BagFile, at: f64, sequence: u64) -> f64 {
        const CORNERS: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let turn = (sequence / 4 % 20) as f64;
        let edge_m = EDGE_M - 2.0 * turn * WIDTH_M;
        let place = |corner: u64| {
            let [x, y] = CORNERS[(corner % 4) as usize];
            let inset_m = 0.1 + turn * WIDTH_M;
            [inset_m + x * edge_m, inset_m + y * edge_m, HEIGHT_M]
        };
        let segment = MotionSegment {
            header: Header::at(at),
            sequence,
            start_time_s: at + self.number,
            layer_known: true,
            layer: self.layer(at),
            kind: MotionSegment::KIND_DEPOSIT,
            role: MotionSegment::ROLE_SOLID,
            start_m: place(sequence),
            end_m: place(sequence + 1),
            length_m: edge_m,
            cruise_speed_m_s: SPEED_M_S,
            cruise_s: edge_m / SPEED_M_S,
            target_width_known: true,
            target_width_m: WIDTH_M,
            ..MotionSegment::default()
        };
        bag.put(&topics::PRINTER_MOTION, at, &segment);
        at + edge_m / SPEED_M_S
    }

    fn state(&self, bag: &mut BagFile, at: f64) {
        let paused = self.share(at) >= Self::PAUSE;
        let state = PrinterState {
            header: Header::at(at),
            phase: if paused { PrinterState::PHASE_PAUSED } else { PrinterState::PHASE_PRINTING },
            progress: self.share(at),
            layer_known: true,
            layer: self.layer(at),
            path_speed_m_s: SPEED_M_S,
            path_time_s: at + self.number,
            depositing: !paused,
            target_width_known: true,
            target_width_m: WIDTH_M + self.number,
            layer_height_known: true,
            layer_height_m: HEIGHT_M,
            hotend_target_degc: 210.0 + self.number,
            bed_target_degc: 60.0,
            ..PrinterState::default()
        };
        bag.put(&topics::PRINTER_STATE, at, &state);
        let truth = SimTruth {
            header: Header::at(at),
            nozzle_degc: 203.0 + self.number,
            slip: if self.slips(at) { 0.09 } else { 0.01 },
            depositing: true,
            width_m: WIDTH_M,
            target_width_m: WIDTH_M,
            deposit_s: at,
            ..SimTruth::default()
        };
        bag.put(&topics::SIM_TRUTH, at, &truth);
    }

    fn estimate(&self, bag: &mut BagFile, at: f64) {
        let lag = (self.share(at) - Self::SLIP) * self.duration_s;
        let slip = if lag > 0.0 { 0.01 + 0.08 * (1.0 - (-lag / 2.0).exp()) } else { 0.01 };
        let area_m2 = models::bead::stadium::area_m2(WIDTH_M, HEIGHT_M);
        let flow_m_s = area_m2 * SPEED_M_S / FILAMENT_M2 * (1.0 + 0.05 * (TAU * at / 3.0).sin());
        let names = runtime::wire::STATES.map(str::to_owned).to_vec();
        let x = vec![483.0, 476.0, 483.0, flow_m_s, slip, 1.0 + self.number];
        let mut covariance = vec![0.0; 36];
        for (index, sigma) in [1.0, 1.5, 0.2, 1e-4, 0.01, 0.02].into_iter().enumerate() {
            covariance[index * 7] = sigma * sigma;
        }
        let windowed = 20.0 * (1.0 + 0.5 * (TAU * at / 20.0).sin());
        let estimate = StateEstimate {
            header: Header::at(at),
            names,
            x,
            covariance,
            observed: vec![true; 6],
            held: vec![false; 6],
            reference_feed_m_s: 1e-3,
            channels: runtime::wire::CHANNELS.map(str::to_owned).to_vec(),
            alive: vec![true; 4],
            measured: vec![true; 4],
            nis: vec![1.0; 4],
            nis_mean: vec![1.0; 4],
            gated: vec![0; 4],
            chi_square: vec![windowed; 4],
            chi_square_window: 20,
            ..StateEstimate::default()
        };
        bag.put(&topics::ESTIMATE, at, &estimate);
    }

    fn sensors(&self, bag: &mut BagFile, at: f64) {
        let reading = |temperature| Temperature { header: Header::at(at), temperature, variance: 0.02 };
        let hotend = 210.0 + (TAU * at / 30.0).sin() + self.number;
        bag.put(&topics::HOTEND_TEMPERATURE, at, &reading(hotend));
        bag.put(&topics::BED_TEMPERATURE, at, &reading(60.0));
        let axis = |size: f64| {
            (0..20).map(|n| size * (f64::from(n) * 0.9).sin() + self.number).collect::<Vec<f64>>()
        };
        let batch = ImuBatch {
            header: Header::at(at),
            period_s: 0.005,
            range_m_s2: 160.0,
            x_m_s2: axis(0.5),
            y_m_s2: axis(0.3),
            z_m_s2: axis(0.1),
            ..ImuBatch::default()
        };
        bag.put(&topics::IMU_BATCH, at, &batch);
    }

    fn events(&self) -> Vec<(f64, PrintEvent)> {
        let event = |share: f64, severity, why: &str, (before, after): (&str, &str)| {
            let what = if before == after { "impulse" } else { "mode_changed" };
            let at = self.duration_s * share;
            let event = PrintEvent {
                header: Header::at(at),
                severity,
                who: self.text("/printer/safety_supervisor"),
                what: what.to_owned(),
                why: self.text(why),
                before: self.text(before),
                after: self.text(after),
            };
            (at, event)
        };
        let (warn, error) = (PrintEvent::SEVERITY_WARN, PrintEvent::SEVERITY_ERROR);
        vec![
            event(Self::KNOCK, warn, "P8: a knock or lost steps", ("act", "act")),
            event(Self::DEFECT, warn, "P9: spaghetti in 6 of 10 frames", ("act", "degraded")),
            event(Self::PAUSE, error, "P9: spaghetti, no way back", ("degraded", "paused")),
        ]
    }
}
