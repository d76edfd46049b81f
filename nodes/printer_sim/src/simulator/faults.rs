//! How faults come into the simulation.

use super::Simulator;
use crate::faults::{Component, Fault, InForce, Kind};
use crate::scenario::Entry;
use models::units::Seconds;

impl Simulator {
    /// Adds a fault to those of the scenario; its onset counts from the start of the simulation.
    pub fn inject(&mut self, entry: Entry) {
        self.entries.push(entry);
    }

    pub(super) fn set_in_faults(&mut self) {
        if !self.entries.is_empty() {
            let share = if self.filament_m > 0.0 { self.executor.fed_m() / self.filament_m } else { 0.0 };
            let now = self.now;
            let mut set_in = Vec::new();
            self.entries.retain(|entry| match entry.due(now, share) {
                Some(fault) => {
                    set_in.push(fault);
                    false
                }
                None => true,
            });
            set_in.iter().for_each(|fault| self.happen(fault));
            self.faults.append(&mut set_in);
        }
        if !self.faults.is_empty() {
            self.faults_in_force = InForce::at(self.now, &self.faults);
        }
    }

    /// What a fault does in the moment in which it sets in.
    fn happen(&mut self, fault: &Fault) {
        match fault.kind {
            Kind::LayerShiftX => self.skip(0, fault.size),
            Kind::LayerShiftY => self.skip(1, fault.size),
            Kind::Knock => {
                if let Some(imu) = &mut self.imu {
                    imu.knock(fault.onset, fault.size);
                }
            }
            Kind::Noise | Kind::Spikes | Kind::Loose => match fault.component {
                Component::HotendThermistor => self.hotend_sensor.draw_from(fault.kind, fault.seed),
                Component::BedThermistor => self.bed_sensor.draw_from(fault.kind, fault.seed),
                _ => {}
            },
            _ => {}
        }
    }

    fn skip(&mut self, axis: usize, lost_m: f64) {
        let mut lost = [0.0; 2];
        lost[axis] = lost_m;
        self.toolhead.lose_steps(lost);
        if let Some(imu) = &mut self.imu {
            imu.skip(self.now, axis);
        }
    }

    /// What the faults do to the plant now.
    #[must_use]
    pub fn faults_in_force(&self) -> &InForce {
        &self.faults_in_force
    }

    /// Onset of the first fault, once one has set in.
    #[must_use]
    pub fn first_onset(&self) -> Option<Seconds> {
        self.faults.iter().map(|fault| fault.onset).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Onset of the newest fault that has set in.
    #[must_use]
    pub fn newest_onset(&self) -> Option<Seconds> {
        self.faults.iter().map(|fault| fault.onset).max_by(|a, b| a.0.total_cmp(&b.0))
    }
}
