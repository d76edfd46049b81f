//! What a demand in force does to mains, heaters and job, and who is behind it.

use super::Simulator;
use models::command::Request;

impl Simulator {
    /// Carries out what is demanded now, `before` of the step before.
    pub(super) fn obey(&mut self, before: Request) {
        if self.executor.stopped() && !std::mem::replace(&mut self.given_up, true) {
            self.note("heaters off and job given up, as the file demands (M112)");
        }
        // What a permit demands is held beyond its time: who is there at the first moment of it says whose demand it is.
        let alone = self.in_force.lapsed;
        if alone && self.in_force.request == Request::Pause && before < Request::Pause {
            self.note("job held: no supervisor has been heard for longer than dead_man.pause_delay_s");
        }
        if self.in_force.request >= Request::HeatersOff && !std::mem::replace(&mut self.given_up, true) {
            self.note(if alone {
                "heaters off and job given up: no supervisor has been heard for longer than dead_man.heaters_off_delay_s"
            } else {
                "heaters off and job given up, as the supervisor or a person past it demands"
            });
        }
        if self.in_force.request == Request::EmergencyStop && self.mains_on {
            self.mains_on = false;
            self.note("mains relay opened");
        }
    }
}
