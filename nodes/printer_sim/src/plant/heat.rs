//! Heat of hot end and bed: what the firmware switches, what faults take, what the beads feel.

use super::{Inputs, Plant};
use crate::faults::InForce;
use crate::sensors::bead_surroundings;
use models::hotend::Inputs as HeatInputs;
use models::units::{Kelvin, Seconds};

/// More loss of the block for each kelvin of a cold draught `[1/K]`: 30 % at -10 K (model book 1.12).
const DRAUGHT_LOSS_1_K: f64 = 0.03;

impl Plant {
    /// Heat over one step of `dt`.
    pub fn heat(&mut self, inputs: &Inputs, faults: &InForce, dt: Seconds) {
        let power_w = self.params.hotend.heater_power_w;
        self.heater_w = power_w * faults.hotend_heater.power_share(inputs.hotend_duty, inputs.mains_on);
        self.fan = inputs.fan * faults.fan_gain;
        let air = self.air(faults);
        let heat = HeatInputs {
            heater_w: self.heater_w - self.draught_w(faults),
            fan: self.fan,
            ambient_k: air.0,
            filament_k: air.0,
            melt_w_k: self.material.heat_flow_w_k(self.melted_m3 / dt.0),
        };
        self.melted_m3 = 0.0;
        let before = self.thermal;
        self.thermal = self.params.hotend.step(before, &heat, dt);
        // A bead that fell out of the block follows what is around it with the same lag.
        let beside = bead_surroundings(Kelvin(self.thermal.block_k), air, faults.hotend_sensor.circuit);
        let kept = (-dt.0 / self.params.hotend.sensor_lag_s).exp();
        if (beside.0 - self.thermal.block_k).abs() > 0.0 {
            self.thermal.sensor_k = beside.0 + (before.sensor_k - beside.0) * kept;
        }
        let bed_share = faults.bed_heater.power_share(inputs.bed_duty, inputs.mains_on);
        self.bed = self.params.bed.step(self.bed, bed_share * self.params.bed.heater_power_w, air, dt);
        // A bed follows its heater so slowly that a bead in its place shows no lag; beside it, it is a bead like any.
        let beside = bead_surroundings(self.bed, air, faults.bed_sensor.circuit);
        let apart_k = if beside == self.bed { 0.0 } else { self.bed_sensor.0 - beside.0 };
        self.bed_sensor = Kelvin(beside.0 + apart_k * kept);
    }

    /// Loss that a draught adds to the block `[W]`.
    fn draught_w(&self, faults: &InForce) -> f64 {
        let more = (-faults.ambient_offset_k * DRAUGHT_LOSS_1_K).max(0.0);
        more * self.params.hotend.block_loss_w_k * (self.thermal.block_k - self.air(faults).0)
    }

    /// Air around the printer.
    #[must_use]
    pub fn air(&self, faults: &InForce) -> Kelvin {
        Kelvin(self.params.ambient_temp_k + faults.ambient_offset_k)
    }
}
