//! What the printer's firmware and sensors read.

use super::Simulator;
use crate::faults::{Feed, Line, SensorFaults};
use crate::output::Output;
use crate::plant::Road;
use models::command::Request;
use models::status::JobPhase;
use models::units::{Celsius, Seconds};

/// From the sensors beside the thermistors, which the firmware reads itself.
#[derive(Debug, Default)]
pub(super) struct Lines {
    encoder: Line<i64>,
    imu: Line<Vec<[f64; 3]>>,
    pub(super) camera: Line<Vec<u8>>,
}

impl Simulator {
    /// Firmware: reads its thermistors, sets the duties with the period of its loop and tells with that of its reports.
    fn regulate(&mut self) {
        let (sets, tells) = (self.paces.heaters.due(self.now), self.paces.temperature.due(self.now));
        if !(sets || tells) {
            return;
        }
        let faults = &self.faults_in_force;
        let hotend = self.hotend_sensor.read(self.plant.sensor(), &faults.hotend_sensor);
        let bed = self.bed_sensor.read(self.plant.bed_sensor(), &faults.bed_sensor);
        if tells {
            let at_tip = self.plant.nozzle();
            let nozzle = self.nozzle_sensor.as_mut().map(|sensor| sensor.read(at_tip, &SensorFaults::NONE));
            self.outputs.push_back(Output::Temperatures { stamp: self.now, hotend, bed, nozzle });
        }
        if sets {
            self.set_duties(hotend, bed);
        }
    }

    fn set_duties(&mut self, hotend: Celsius, bed: Celsius) {
        let sliced = *self.executor.sliced();
        let offset_k = self.motion.trims.unwrap_or(self.in_force.trims).setpoint_offset_k;
        self.heaters.hotend_target = match self.in_force.request {
            _ if self.given_up => Celsius(0.0),
            Request::Standby => Celsius(sliced.hotend.0.min(self.params.simulator.firmware.standby.0)),
            _ if sliced.hotend.0 > 0.0 => Celsius(sliced.hotend.0 + offset_k),
            _ => sliced.hotend,
        };
        self.heaters.bed_target = if self.given_up { Celsius(0.0) } else { sliced.bed };
        self.heaters.update(&self.params.plant, hotend, bed);
    }

    /// Set-point of the part fan `[-]`: the file's, and full where a supervisor has the heaters off and the hot end is not
    /// known to be cool. With the mains relay open nothing turns.
    pub(super) fn fan(&self) -> f64 {
        let cool = self.heaters.hotend_reading < self.params.simulator.firmware.cool_above;
        match (self.mains_on, self.in_force.request >= Request::HeatersOff) {
            (false, _) => 0.0,
            (true, true) if !cool => 1.0,
            (true, _) => self.executor.sliced().fan,
        }
    }

    pub(super) fn sense(&mut self, road: Option<Road>) {
        self.regulate();
        let fitted = self.params.simulator.sensors.encoder_period_s > 0.0;
        if fitted && self.paces.encoder.due(self.now) {
            let measured = self.counts();
            if let Some(counts) = self.lines.encoder.pass(self.faults_in_force.encoder, measured) {
                self.outputs.push_back(Output::Encoder { stamp: self.now, counts });
            }
        }
        let stand_in = self.params.simulator.sensors.width_period_s > 0.0;
        if stand_in && self.paces.width.due(self.now) && road.is_some() {
            self.width_gauge.expose(self.now, self.truth.width_m);
        }
        while let Some((exposed, width_m)) = self.width_gauge.ready(self.now) {
            let sigma_m = self.width_gauge.sigma_m();
            self.outputs.push_back(Output::Width { exposed, width_m, sigma_m });
        }
        self.duty = (self.duty.0 + self.heaters.hotend_duty, self.duty.1 + 1.0);
        if self.paces.status.due(self.now) {
            let mut status = self.status();
            let (sum, count) = std::mem::take(&mut self.duty);
            // what is seen a few times a second is told as a mean: the firmware switches more often
            if self.link.is_some() {
                status.hotend_duty = sum / count;
            }
            self.outputs.push_back(Output::Status(Box::new(status)));
        }
        if !self.done_noted && self.phase() == JobPhase::Done {
            self.done_noted = true;
            self.note("the file has ended");
        }
    }

    /// Accelerations over a step of `dt`; a batch that is stuck is of now, its samples are not.
    pub(super) fn feel(&mut self, dt: Seconds) {
        let Some(imu) = &mut self.imu else { return };
        let Some(mut batch) = imu.step(self.now, self.motion.velocity_m_s, dt) else { return };
        let measured = std::mem::take(&mut batch.samples);
        if let Some(samples) = self.lines.imu.pass(self.faults_in_force.imu, measured) {
            batch.samples = samples;
            self.outputs.push_back(Output::Imu(Box::new(batch)));
        }
    }

    /// What the firmware hears of the encoder: under a fault of that, the last count that came.
    pub(super) fn heard_counts(&self) -> i64 {
        let held = self.lines.encoder.last().filter(|_| self.faults_in_force.encoder != Feed::Live);
        held.copied().unwrap_or_else(|| self.counts())
    }

    fn counts(&self) -> i64 {
        // A count is a whole quantum that has passed; kilometres of filament stay far below 2^63 of them.
        #[allow(clippy::cast_possible_truncation, reason = "bounded above")]
        let counts =
            (self.plant.delivered_m() / self.params.simulator.sensors.encoder_quantum_m).floor() as i64;
        counts
    }

    /// The next thing that the printer shows, oldest first.
    pub fn poll(&mut self) -> Option<Output> {
        self.outputs.pop_front()
    }
}
