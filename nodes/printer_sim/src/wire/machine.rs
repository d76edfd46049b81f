//! The wire machine: what a printer is around the process. It executes permits, reports its state, and knows the truth.
//!
//! Of a printer it has job, phase, trims and dead-man. It has no hot end, bed, fan or filament encoder: their set-points
//! and duties are 0, no temperature is reported. A demand to switch the heaters off ends the laser and the job.

use super::figures::Figures;
use super::params::{MachineSettings, Params};
use super::plant::{HeightSample, Speeds, WirePlant};
use crate::pace::Pace;
use models::command::{DeadMan, DeadManParams, InForce, Limits, Permit, Refusal, Request};
use models::status::{HostProfile, JobPhase, PrinterStatus};
use models::units::{Celsius, Seconds};
use models::wire::Process;
use std::collections::VecDeque;

/// Everything that a [`Machine`] needs to know.
#[derive(Debug, Clone)]
pub struct MachineParams {
    /// The simulated process.
    pub plant: Params,
    /// Planned layer and speeds, and what drives and laser can do.
    pub process: Process,
    /// Paces.
    pub settings: MachineSettings,
    /// What follows the supervisor's silence.
    pub dead_man: DeadManParams,
    /// The machine's own limits on trims.
    pub limits: Limits,
    /// Layers of the wall, 1 or more.
    pub layers: u32,
}

/// One thing that the machine or its sensor shows.
#[derive(Debug, Clone, PartialEq)]
pub enum MachineOutput {
    /// A measured height.
    Height {
        /// The sample.
        sample: HeightSample,
        /// Its stated standard deviation `[m]`, above 0.
        sigma_m: f64,
    },
    /// State of machine and job.
    Status(Box<PrinterStatus>),
    /// Something that a person at the machine would note.
    Note {
        /// When.
        stamp: Seconds,
        /// What, in one line.
        text: String,
    },
}

/// What is really so. For reports and tests alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WireTruth {
    /// Time of the simulation.
    pub stamp: Seconds,
    /// Layer that is laid, from 0.
    pub layer: u32,
    /// Drops are laid.
    pub depositing: bool,
    /// Place of the head along the wall `[m]`.
    pub along_m: f64,
    /// Speeds asked of the drives.
    pub speeds: Speeds,
    /// Mean height of the wall `[m]`.
    pub height_m: f64,
    /// Height errors of complete layers.
    pub figures: Figures,
}

/// A wire machine that lays one wall.
#[derive(Debug, Clone)]
pub struct Machine {
    params: MachineParams,
    plant: WirePlant,
    dead_man: DeadMan,
    in_force: InForce,
    status_pace: Pace,
    figures: Figures,
    wire_m: f64,
    path_time_s: f64,
    mains_on: bool,
    given_up: bool,
    done: bool,
    outputs: VecDeque<MachineOutput>,
}

impl Machine {
    /// A machine before the first drop; the seed makes all scatter, noise, dips and bumps.
    #[must_use]
    pub fn new(params: MachineParams, seed: u64) -> Self {
        let mut dead_man = DeadMan::new(params.dead_man, params.limits);
        let in_force = dead_man.in_force(Seconds(0.0));
        Self {
            plant: WirePlant::new(params.plant, seed),
            in_force,
            dead_man,
            status_pace: Pace::new(params.settings.status_period_s),
            figures: Figures::default(),
            wire_m: 0.0,
            path_time_s: 0.0,
            mains_on: true,
            given_up: false,
            done: false,
            outputs: VecDeque::new(),
            params,
        }
    }

    /// Takes a permit received now, or refuses it.
    ///
    /// # Errors
    /// The [`Refusal`]; the dead-man counts it too.
    pub fn on_permit(&mut self, permit: Permit) -> Result<(), Refusal> {
        self.dead_man.on_permit(self.plant.now(), permit)
    }

    /// Advances by `dt`, a few hundredths of a second.
    pub fn step(&mut self, dt: Seconds) {
        self.in_force = self.dead_man.in_force(self.plant.now() + dt);
        self.obey();
        if self.phase() == JobPhase::Printing {
            self.lay(dt);
        } else {
            self.plant.wait(dt);
        }
        while let Some(sample) = self.plant.sample() {
            // No sensor is better than its resolution, and none states a scatter of nothing.
            let sigma_m = self.params.plant.sensor.sigma_m.max(self.params.settings.sigma_floor_m);
            self.outputs.push_back(MachineOutput::Height { sample, sigma_m });
        }
        if self.status_pace.due(self.plant.now()) {
            let status = self.status();
            self.outputs.push_back(MachineOutput::Status(Box::new(status)));
        }
    }

    fn lay(&mut self, dt: Seconds) {
        let (speeds, layer) = (self.speeds(), self.plant.layer());
        if self.plant.laying_at_m().is_some() {
            self.wire_m += speeds.wire_m_s * dt.0;
            self.path_time_s += dt.0 * speeds.head_m_s / self.params.process.law.head_m_s;
        }
        if self.plant.step(dt, speeds) {
            let planned_m = f64::from(layer) * self.params.process.law.height_m;
            self.figures.add(self.plant.surface().heights_m(), planned_m);
            if layer >= self.params.layers {
                self.done = true;
                self.note("the wall is done");
            }
        }
    }

    /// What a demand of the supervisor does to laser, mains and job.
    fn obey(&mut self) {
        if self.in_force.request >= Request::HeatersOff && !self.given_up {
            self.given_up = true;
            self.note("laser off and job given up, as the supervisor or a person past it demands");
        }
        if self.in_force.request == Request::EmergencyStop && self.mains_on {
            self.mains_on = false;
            self.note("mains relay opened");
        }
    }

    /// Planned speeds times the trims in force, inside what drives and laser can do.
    #[must_use]
    pub fn speeds(&self) -> Speeds {
        let (law, limits) = (&self.params.process.law, &self.params.process.limits);
        let trims = &self.in_force.trims;
        Speeds {
            wire_m_s: (law.wire_m_s * trims.flow * trims.speed)
                .clamp(limits.wire_low_m_s, limits.wire_high_m_s),
            head_m_s: (law.head_m_s * trims.speed).clamp(limits.head_low_m_s, limits.head_high_m_s),
        }
    }

    /// Where the job stands.
    #[must_use]
    pub fn phase(&self) -> JobPhase {
        match self.in_force.request {
            _ if self.given_up => JobPhase::Failed,
            _ if self.done => JobPhase::Done,
            Request::Run => JobPhase::Printing,
            _ => JobPhase::Paused,
        }
    }

    /// Time of the simulation.
    #[must_use]
    pub fn now(&self) -> Seconds {
        self.plant.now()
    }

    /// The dead-man, for its counters.
    #[must_use]
    pub fn dead_man(&self) -> &DeadMan {
        &self.dead_man
    }

    /// The next thing that the machine shows, oldest first.
    pub fn poll(&mut self) -> Option<MachineOutput> {
        self.outputs.pop_front()
    }

    /// The truth now.
    #[must_use]
    pub fn truth(&self) -> WireTruth {
        let heights_m = self.plant.surface().heights_m();
        #[allow(clippy::cast_precision_loss, reason = "far below 2^52 cells")]
        let cells = heights_m.len() as f64;
        let laying = self.laying_at_m();
        WireTruth {
            stamp: self.plant.now(),
            layer: self.plant.layer() - 1,
            depositing: laying.is_some(),
            along_m: laying.unwrap_or(0.0),
            speeds: if laying.is_some() { self.speeds() } else { Speeds { wire_m_s: 0.0, head_m_s: 0.0 } },
            height_m: heights_m.iter().sum::<f64>() / cells,
            figures: self.figures,
        }
    }

    fn laying_at_m(&self) -> Option<f64> {
        self.plant.laying_at_m().filter(|_| self.phase() == JobPhase::Printing)
    }

    /// State of machine and job now.
    #[must_use]
    pub fn status(&self) -> PrinterStatus {
        let law = &self.params.process.law;
        let laying = self.laying_at_m();
        let layer = self.plant.layer();
        let speeds = self.speeds();
        let of_layer =
            self.plant.laying_at_m().map_or(0.0, |along_m| along_m / self.params.plant.wall_length_m);
        let layers = f64::from(layer - 1) + of_layer;
        let progress = if self.done { 1.0 } else { layers / f64::from(self.params.layers) };
        PrinterStatus {
            stamp: self.plant.now(),
            phase: self.phase(),
            host: HostProfile::Native,
            progress: progress.clamp(0.0, 1.0),
            layer: Some(layer - 1),
            line: 0,
            position_m: [laying.unwrap_or(0.0), 0.0, f64::from(layer) * law.height_m],
            path_speed_m_s: if laying.is_some() { speeds.head_m_s } else { 0.0 },
            planned_speed_m_s: if laying.is_some() { law.head_m_s } else { 0.0 },
            planned_feed_m_s: if laying.is_some() { law.wire_m_s } else { 0.0 },
            motor_position_m: self.wire_m,
            wanted_position_m: self.wire_m,
            path_time_s: self.path_time_s,
            depositing: laying.is_some(),
            target_width_m: None,
            layer_height_m: laying.map(|_| law.height_m),
            hotend_target: Celsius(0.0),
            hotend_sliced_target: Celsius(0.0),
            bed_target: Celsius(0.0),
            hotend_duty: 0.0,
            bed_duty: 0.0,
            fan: 0.0,
            trims: self.in_force.trims,
            advance_s: 0.0,
            homed: true,
            mains_on: self.mains_on,
            filament_present: None,
            part_fan_speed_1_s: None,
            stop_input: None,
        }
    }

    fn note(&mut self, text: &str) {
        self.outputs.push_back(MachineOutput::Note { stamp: self.plant.now(), text: text.to_owned() });
    }
}

#[cfg(test)]
mod tests;
