//! The camera on the tool head, where one is fitted.

use super::Simulator;
use crate::camera::{Camera, CameraParams, Moment, Rig};
use crate::output::Output;
use crate::plant::Road;
use std::f64::consts::FRAC_PI_4;

/// The camera that the parameters fit, in the simulation's own thread.
pub(super) fn of(params: &CameraParams, seed: u64) -> Option<Box<dyn Camera>> {
    params.enabled.then(|| Box::new(Rig::new(params, seed)) as Box<dyn Camera>)
}

impl Simulator {
    /// Shows the camera what was laid in this step; `outlet_before_m` is the truth's `outlet_m` before it.
    pub(super) fn photograph(&mut self, road: Option<Road>, outlet_before_m: f64) {
        let tool_m = self.tool_m();
        let Some(camera) = &mut self.camera else { return };
        let truth = &self.truth;
        let nominal_m2 = FRAC_PI_4 * self.params.plant.extruder.filament_diameter_m.powi(2);
        let left_m3 = (truth.outlet_m - outlet_before_m) * truth.gain * nominal_m2;
        let [x_m_s, y_m_s, _] = self.motion.velocity_m_s;
        camera.observe(&Moment {
            now: self.now,
            tool_m,
            velocity_m_s: [x_m_s, y_m_s],
            road_m: road.map(|road| (truth.width_m, road.height_m)),
            loose_m3: if truth.detached { left_m3.max(0.0) } else { 0.0 },
        });
        while let Some(shot) = camera.ready(self.now) {
            let (exposed, sequence) = (shot.exposed, shot.sequence);
            if let Some(jpeg) = self.lines.camera.pass(self.faults_in_force.camera, shot.jpeg) {
                self.outputs.push_back(Output::Frame { exposed, sequence, jpeg });
            }
        }
    }

    /// Puts another camera in the place of its own, before the first step.
    pub fn fit(&mut self, camera: Box<dyn Camera>) {
        self.camera = Some(camera);
    }
}
