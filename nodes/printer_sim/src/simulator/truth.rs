//! What is really so, and the score of it.

use super::Simulator;
use crate::output::Truth;
use crate::plant::Road;
use crate::score::Moment;
use models::quality::Observed;
use models::units::Kelvin;

impl Simulator {
    /// Notes the truth of this step; `road` is what has landed.
    pub(super) fn note_truth(&mut self, road: Option<Road>) {
        let before = self.truth;
        let mut truth = self.plant.truth(road, self.params.simulator.firmware.below_bed_k);
        truth.stamp_s = self.now.0;
        truth.path_time_s = self.executor.path_time_s();
        truth.wanted_m = self.drive.wanted_m();
        truth.path_speed_m_s = self.motion.path_speed_m_s;
        truth.layer_shift_m = self.toolhead.shift_m();
        truth.detached = self.faults_in_force.detached;
        truth.layer = self.executor.layer().map_or(0, |layer| layer + 1);
        truth.reference_k = Kelvin::from(self.executor.sliced().hotend).0 - self.params.nozzle_drop_k;
        let retracts_or_primes = self.motion.feed.other_m_s.abs() > 0.0;
        if !retracts_or_primes {
            self.score.add_feed(truth.wanted_m - before.wanted_m, truth.delivered_m - before.delivered_m);
        }
        if road.is_some() {
            self.score.add_road(&Moment {
                bead: Observed {
                    feature_errors: &[],
                    width_m: truth.width_m,
                    width_wanted_m: truth.target_width_m,
                    temperature_error_k: truth.nozzle_k - truth.reference_k,
                    adhesion: truth.adhesion,
                    porosity: truth.porosity,
                },
                dt_s: truth.stamp_s - before.stamp_s,
            });
        }
        truth.integrals = self.score.integrals();
        self.truth = truth;
    }

    /// The truth now.
    #[must_use]
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// Where the tool really is in the bed frame `[m]`: commanded position plus lost steps.
    #[must_use]
    pub fn tool_m(&self) -> [f64; 3] {
        self.toolhead.position_m(self.executor.position_m())
    }
}
