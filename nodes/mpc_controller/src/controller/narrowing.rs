//! A nozzle that narrows: what frames tell of it.

use super::Controller;
use crate::clog::{Ahead, Look};
use crate::params::Level;
use models::units::Seconds;

impl Controller {
    /// Shows a frame of a road that was steady at its exposure, while the encoder speaks.
    pub(super) fn look_for_clog(&mut self, exposed: Seconds, width_m: f64) {
        let encoder = self.estimate.filter(|estimate| estimate.encoder_alive);
        let (Some(estimate), Level::Mpc) = (encoder, self.params.control) else { return };
        let settings = &self.params.clog;
        let road = self.roads.at(exposed.0, settings.settles_s);
        let Some(road) = road else { return };
        let feed_m_s = road.feed_m_s * self.base.feed();
        let Some(law) = self.outlet_law(&estimate, feed_m_s) else { return };
        let law = self.advance.with_learnt(law.advance());
        let melt_m = law.shear * feed_m_s.powf(law.index);
        let Some(ahead) = self.ahead(melt_m) else { return };
        let error = road.section() * (width_m / road.target_m - 1.0);
        if !road.is_settled(settings) {
            self.anew |= self.clog.on_unsettled(feed_m_s, -error, ahead);
            return;
        }
        let look = Look {
            exposed_s: exposed.0,
            lacking: self.slowing.lacking(exposed.0, error),
            excess_m: road.excess_m + road.driven.beyond_m(melt_m),
            feed_m_s,
            melt_m,
            linear_m: law.linear_s * feed_m_s,
            index: law.index,
        };
        self.anew |= self.clog.on_look(look, ahead);
    }

    /// What has come to pass until now behind a sound nozzle whose melt holds `melt_m`, and when a law that is sent now acts.
    fn ahead(&self, melt_m: f64) -> Option<Ahead> {
        let status = self.status?;
        let driven = self.advance.driven(&status);
        Some(Ahead {
            now_s: status.stamp.0,
            acts_s: status.stamp.0
                + self.advance.attached().acts_in_s(&status, status.host.takes_trims_anew()),
            excess_m: self.excess_m + driven.beyond_m(melt_m),
            driven,
        })
    }
}
