//! Preview: trims attached to coming moves. A corner is planned before it comes, not chased after it.

use super::Controller;
use crate::params::{AdvanceSource, Level};
use models::command::{AdvanceLaw, MotionTrim};
use models::motion::{MoveKind, Segment};
use models::units::{Kelvin, Seconds};

impl Controller {
    /// The trim of a coming move, number `sequence`, that became known at `now`; `None` where corrections or preview are
    /// off, nothing is laid, or its law of the advance is not known; flow and speed are the plan's.
    #[must_use]
    pub fn on_coming(&mut self, now: Seconds, sequence: u64, segment: &Segment) -> Option<MotionTrim> {
        if self.params.control == Level::Off || segment.kind != MoveKind::Deposit {
            return None;
        }
        let (flow, speed) = self.scheduled();
        let advance = match self.params.advance.source {
            AdvanceSource::Planned => self.melt_law(now, segment, flow * speed)?,
            AdvanceSource::Predicted => self.advance.law(now.0)?,
            AdvanceSource::None | AdvanceSource::File | AdvanceSource::Material => return None,
        };
        let trim = MotionTrim { sequence, flow, speed, advance };
        trim.is_valid().then(|| {
            self.report.scheduled += 1;
            trim
        })
    }

    /// The nominal law `x = a(T_m) u^n + K_lin u` of the filament held compressed (model book 1.2) at the melt's
    /// estimated temperature; `None` where no recent estimate tells the nozzle's.
    fn melt_law(&self, now: Seconds, segment: &Segment, feed: f64) -> Option<AdvanceLaw> {
        let limit_s = self.params.estimate_age_limit_s;
        let estimate = self.estimate.filter(|made| now.0 - made.stamp.0 <= limit_s)?;
        let cruise_m_s = segment.filament_per_path() * segment.profile.cruise_m_s * feed;
        let melt = &self.printer.melt;
        let flow_m3_s = cruise_m_s * melt.filament_area_m2();
        let temp = melt.melt_temperature(estimate.nozzle, Kelvin(self.params.ambient_k), flow_m3_s);
        let extruder = &self.printer.extruder;
        Some(AdvanceLaw {
            linear_s: extruder.linear_lag_s,
            shear: extruder.compliance_m_n * melt.force_n(melt.filament_area_m2(), temp),
            index: melt.flow_index(),
        })
    }
}
