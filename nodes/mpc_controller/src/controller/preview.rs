//! Preview: trims attached to coming moves. A corner is planned before it comes, not chased after it.

use super::{Controller, Printer};
use crate::advance::{Driven, Nozzle, Sent};
use crate::input::{Coming, Estimate};
use crate::params::{AdvanceSource, Level};
use crate::reference::nozzle_reference;
use models::command::{AdvanceLaw, MotionTrim};
use models::extruder::StaticLaw;
use models::motion::MoveKind;
use models::status::PrinterStatus;
use models::units::{Kelvin, Seconds};

/// Flow over that of a move's cruise at which its law is exact, too `[-]`. A fast flow cools the melt far more than half of it does,
/// so that a power law from a corner's 0.3 on holds too much on the way down: corners of the bracket 3 % worse; seeds 2001..2010.
const RAMP: f64 = 0.5;

impl Controller {
    /// The trim of a coming move that became known at `now`; `None` where corrections or preview are off, nothing is laid, or its
    /// law of the advance is not known; the flow is the plan's, the speed the drive's force's.
    #[must_use]
    pub fn on_coming(&mut self, now: Seconds, coming: &Coming) -> Option<MotionTrim> {
        let Coming { sequence, start, segment } = coming;
        if self.params.control == Level::Off || segment.kind != MoveKind::Deposit {
            return None;
        }
        let sliced_m_s = segment.filament_per_path() * segment.profile.cruise_m_s;
        let sent = self.sent(now, (*sequence, start.0), sliced_m_s)?;
        self.report.scheduled += 1;
        self.advance.attached_mut().push(sent);
        Some(sent.trim)
    }

    /// Trims, at `now`, of moves that have not begun and were sent with laws that are others since; none where a host has no use for
    /// them.
    pub fn take_anew(&mut self, now: Seconds) -> Vec<MotionTrim> {
        let status = self.status.filter(|status| status.host.takes_trims_anew());
        let (true, Some(status)) = (std::mem::take(&mut self.anew), status) else { return Vec::new() };
        let open: Vec<Sent> = self.advance.attached_mut().open(&status).map(|sent| *sent).collect();
        let anew = open.iter().map(|before| {
            let id = (before.trim.sequence, before.start_s);
            let sent = self.sent(now, id, before.sliced_m_s);
            // Nobody knows its law for now: another time.
            self.anew |= sent.is_none();
            sent.unwrap_or(*before)
        });
        let anew: Vec<Sent> = anew.collect();
        self.advance.attached_mut().open(&status).zip(&anew).for_each(|(sent, anew)| *sent = *anew);
        anew.into_iter()
            .zip(open)
            .filter(|(anew, before)| anew != before)
            .map(|(anew, _)| anew.trim)
            .collect()
    }

    /// What a move, number `sequence`, that begins at `start_s` of the slicer's plan with a fastest feed of `sliced_m_s` is sent with.
    fn sent(&mut self, now: Seconds, (sequence, start_s): (u64, f64), sliced_m_s: f64) -> Option<Sent> {
        let (flow, in_force) = self.scheduled();
        let speed = self.pace_of(now, sliced_m_s);
        let cruise_m_s = sliced_m_s * flow * in_force * speed;
        let (advance, driven) = match self.params.advance.source {
            AdvanceSource::Planned => {
                let sound = self.melt_law(now, cruise_m_s)?;
                let driven = Driven { force: self.clog.factor(), carried_m: self.clog.carried_m() };
                (self.advance.with_learnt(self.clog.law(sound)), driven)
            }
            AdvanceSource::Predicted => (self.advance.law(now.0)?, Driven::SOUND),
            AdvanceSource::None | AdvanceSource::File | AdvanceSource::Material => return None,
        };
        let bound = self.advance.bound(advance);
        let carried_m = driven.carried_m * bound;
        let trim = MotionTrim { sequence, flow, speed, advance: advance.scaled(bound), carried_m };
        trim.is_valid().then_some(Sent { start_s, sliced_m_s, cruise_m_s, trim, force: driven.force })
    }

    /// Follows what is held compressed, by the law for the speeds of the move under way.
    pub(super) fn follow_advance(&mut self, status: &PrinterStatus) {
        let before = self.advance.driven(status);
        let fastest_m_s = self.advance.on_move(status);
        if self.advance.driven(status).force > before.force {
            self.slowing.on_push();
        }
        let law = self.estimate.and_then(|estimate| {
            self.outlet_law(&estimate, fastest_m_s.unwrap_or(estimate.reference_feed_m_s))
        });
        let melt = law.map(|law| self.clog.law(law.advance()));
        let nozzle = Nozzle { force: self.clog.factor(), doubt: self.clog.doubt() };
        let grown_m = self.advance.on_status(status, melt, nozzle);
        self.clog.carry(grown_m);
    }

    /// Speed of a coming move relative to the slicer's at which the drive's force suffices for its fastest feed, `sliced_m_s` in the
    /// file `[-]`. With
    /// its advance the melt's force follows each move at once: a plan over seconds could only chase it.
    fn pace_of(&self, now: Seconds, sliced_m_s: f64) -> f64 {
        let Some(estimate) = self.recent(now).filter(|_| self.params.control == Level::Mpc) else {
            return 1.0;
        };
        let fastest_m_s = sliced_m_s * self.base.feed();
        let stiffness = self.advance.stiffness() * self.clog.factor();
        let most = self.feed_max_at(&estimate, stiffness) / fastest_m_s;
        if most.is_finite() { most.clamp(1.0 + self.params.limits.speed_low, 1.0) } else { 1.0 }
    }

    /// The nominal law of the filament held compressed up to a move's cruise; `None` where no recent estimate tells the
    /// nozzle's temperature, or that is colder than at the lowest set-point of the material: a law of a melt that nothing
    /// drives says nothing of the one that is going to be laid.
    fn melt_law(&self, now: Seconds, cruise_m_s: f64) -> Option<AdvanceLaw> {
        let estimate = self.recent(now).filter(|made| made.nozzle.0 >= self.least_nozzle().0)?;
        (cruise_m_s > 0.0).then(|| self.outlet_law(&estimate, cruise_m_s))?.map(|law| law.advance())
    }

    /// The estimate, where it is not too old to act on.
    pub(super) fn recent(&self, now: Seconds) -> Option<Estimate> {
        self.estimate.filter(|made| now.0 - made.stamp.0 <= self.params.estimate_age_limit_s)
    }

    /// The status, where it is not too old to act on.
    pub(super) fn fresh_status(&self, at: Seconds) -> Option<PrinterStatus> {
        self.status.filter(|status| at.0 - status.stamp.0 <= self.params.status_age_limit_s)
    }

    /// Temperature of a nozzle whose block is at the lowest set-point of the material, while the material is laid.
    fn least_nozzle(&self) -> Kelvin {
        let Printer { hotend, material, .. } = &self.printer;
        let ambient = Kelvin(self.params.ambient_k);
        let flow = (self.params.reference.flow_m3_s, ambient);
        nozzle_reference(hotend, material, Kelvin(material.min_temp_k), flow)
    }

    /// The nominal law `x = a u^n + K_lin u` of the outlet (model book 1.2) on the ramps up to `fastest_m_s`, > 0, at
    /// the nozzle's estimated temperature; `None` where the melt is frozen.
    pub(super) fn outlet_law(&self, estimate: &Estimate, fastest_m_s: f64) -> Option<StaticLaw> {
        let Printer { melt, extruder, .. } = &self.printer;
        let temperatures = (estimate.nozzle, Kelvin(self.params.ambient_k));
        StaticLaw::of_melting((melt, extruder), temperatures, (RAMP * fastest_m_s, fastest_m_s))
    }
}
