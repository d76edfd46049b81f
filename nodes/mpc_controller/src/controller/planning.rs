//! The plan: errors now, the solve at every tick, and the fast trims between.

use super::{Controller, Printer, moves_of};
use crate::fallback::Course;
use crate::input::Estimate;
use crate::params::Level;
use crate::qp::{Outcome, Start, input};
use crate::reference::nozzle_reference;
use crate::trims::{Gains, trimmed};
use models::bead::ROUND_SIDES;
use models::command::ControlHealth;
use models::status::PrinterStatus;
use models::units::{Kelvin, Seconds};

impl Controller {
    /// Fast trims on a frame that shows a steady road (model book 1.7).
    pub(super) fn take_width(&mut self, exposed: Seconds, width_m: f64) {
        if !(exposed.0.is_finite() && width_m.is_finite() && width_m > 0.0) {
            self.report.refusals.width.invalid += 1;
            return;
        }
        if self.width_s.is_some_and(|newest_s| exposed.0 <= newest_s) {
            self.report.refusals.width.late += 1;
            return;
        }
        let before_s = self.width_s.replace(exposed.0);
        if self.clog.rest(exposed.0) <= self.params.clog.sound {
            let more_m = self.advance.on_width(exposed, width_m);
            self.clog.carry(more_m);
        }
        self.look_for_clog(exposed, width_m);
        let road = self.roads.at(exposed.0, self.params.clog.settles_s);
        let (Some(road), Level::Mpc) = (road, self.params.control) else { return };
        let steady = exposed.0 >= self.steady_since_s + self.settles_s();
        let error = width_m / road.target_m - 1.0;
        if !error.is_finite() {
            self.report.refusals.width.invalid += 1;
            return;
        }
        if self.sees_dip(exposed, (&road, steady), error) || !steady {
            return;
        }
        let error = self.params.deadband.relative(error);
        // Rates are per period: frames that follow each other faster have a part of it each.
        let share = before_s.map_or(1.0, |before_s| ((exposed.0 - before_s) / self.params.period_s).min(1.0));
        let rate = self.params.limits.rate().map(|rate| share * rate);
        let (low, high) = (self.params.limits.low(), self.params.limits.high());
        let around = |index: usize| {
            (
                (self.held[index] - rate[index]).max(low[index]),
                (self.held[index] + rate[index]).min(high[index]),
            )
        };
        let gains = Gains {
            feed_1_s: self.params.trims.feed_gain,
            features_m_s: 0.0,
            speed_1_s: self.params.trims.speed_gain,
            feed_range_m_s: around(input::FEED),
            speed_range_m_s: around(input::SPEED),
        };
        let (feed, speed) = trimmed(&gains, (self.held[input::FEED], self.held[input::SPEED]), error, &[]);
        self.held[input::FEED] = feed;
        self.held[input::SPEED] = speed;
    }

    /// How long after a change of path speed a frame tells of the plan `[s]`.
    fn settles_s(&self) -> f64 {
        let trims = &self.params.trims;
        if self.clog.is_beyond() { trims.steady_clogged_s } else { trims.steady_s }
    }

    /// Learns what is the spool's own, where nothing else passes through the nozzle. Without an encoder the gain is that of
    /// gear and road together: a slip would be taken for the spool's.
    pub(super) fn calibrate(&mut self, status: &PrinterStatus, estimate: &Estimate, dt_s: f64) {
        let sound = self.ladder.health() == ControlHealth::Sound;
        let told = sound && estimate.encoder_alive && !self.passes(estimate.stamp.0);
        if self.params.control == Level::Mpc && told && status.depositing {
            self.base.on_gain(estimate.gain, dt_s);
        }
    }

    pub(super) fn tick(&mut self, now: Seconds) {
        if !now.0.is_finite() {
            self.report.refusals.tick.invalid += 1;
            return;
        }
        if self.params.control != Level::Mpc {
            return;
        }
        let (Some(estimate), Some(status)) = (self.recent(now), self.fresh_status(now)) else {
            self.report.starved += 1;
            return;
        };
        let Some(start) = self.start(&status, &estimate) else { return };
        let (planned, outcome) = self.qp.solve(&start);
        let mut held = match self.ladder.on_outcome(outcome) {
            Course::Plan | Course::Hold => planned,
            Course::Baseline => {
                self.base.clear();
                self.qp.back(&start)
            }
        };
        if self.saturation.is_heater_at_stop(status.hotend_duty) {
            // A set-point above what the heater reaches would only wind up.
            held[input::SETPOINT] = held[input::SETPOINT].min(self.held[input::SETPOINT].max(0.0));
        }
        self.held = held;
        self.saturation.on_period(self.params.period_s, &held, status.hotend_duty);
        self.report.outcome = Some(outcome);
        match outcome {
            Outcome::Solved { .. } => self.report.solved += 1,
            Outcome::Fallback(_) | Outcome::Infeasible | Outcome::NotFinite => self.report.fallbacks += 1,
        }
    }

    /// Errors now; `None` while no road is deposited: the move is held.
    pub(super) fn start(&mut self, status: &PrinterStatus, estimate: &Estimate) -> Option<Start> {
        if !status.depositing || status.planned_feed_m_s <= 0.0 {
            return None;
        }
        let (width_m, height_m) = (status.target_width_m?, status.layer_height_m?);
        let ratio = 1.0 - height_m * ROUND_SIDES / width_m;
        if ratio <= 0.0 {
            return None;
        }
        let flow_error = self.flow_error.mean();
        let planned_m_s = status.planned_feed_m_s * self.base.feed();
        let ambient = Kelvin(self.params.ambient_k);
        let Printer { hotend, material, .. } = &self.printer;
        let block: Kelvin = status.hotend_sliced_target.into();
        let reference = nozzle_reference(hotend, material, block, (self.params.reference.flow_m3_s, ambient));
        let most_m_s = self.feed_max_m_s(estimate);
        self.report.flow_error = flow_error;
        self.report.gain_error = estimate.gain * self.base.feed() - 1.0;
        self.report.temperature_error_k = estimate.nozzle.0 - reference.0;
        let band = &self.params.deadband;
        Some(Start {
            flow: band.relative(flow_error),
            temperature_k: band.temperature_k(self.report.temperature_error_k),
            gain: band.relative(self.report.gain_error),
            last: self.held,
            feed_cap: Some(most_m_s / planned_m_s - 1.0),
            width_ratio: 1.0 / ratio,
        })
    }

    /// Highest feed that the drive's force allows `[m/s]`: what widths tell of the melt's force lowers it.
    pub(super) fn feed_max_m_s(&self, estimate: &Estimate) -> f64 {
        self.feed_max_at(estimate, self.advance.stiffness())
    }

    /// The same where the melt's force is `stiffness` times the nominal one.
    pub(super) fn feed_max_at(&self, estimate: &Estimate, stiffness: f64) -> f64 {
        let melt = &self.printer.melt;
        let margin = self.params.limits.force_margin / stiffness.max(1.0);
        let ambient = Kelvin(self.params.ambient_k);
        melt.flow_max_m3_s(estimate.nozzle, ambient, margin) / melt.filament_area_m2()
    }

    /// Follows the flow error slowly: a road's transients are over before a correction could act on them.
    ///
    /// Where the printer makes up for the slip, what is lacking is the extruder loop's to give back, and has been laid thin: a
    /// second loop on it would make later roads fat. What is left of the flow's error is what the trims in force make of it.
    ///
    /// Elsewhere, over such a time, what passed the encoder has left the nozzle. In strokes of pressure advance that says more
    /// of the flow than an estimate of it at the moments at which a road is steady: those are not the mean of all.
    pub(super) fn follow_flow(&mut self, status: &PrinterStatus, estimate: &Estimate, dt_s: f64) {
        if !status.depositing || dt_s <= 0.0 {
            return;
        }
        let settings = &self.params.bumpless;
        let planned_m_s = status.planned_feed_m_s.max(0.0) * self.base.feed();
        let excess_m = if estimate.encoder_alive { self.balance.take_excess_m() } else { 0.0 };
        self.excess_m += excess_m;
        if self.is_made_up_for(status, estimate) {
            let most = self.params.limits.feed;
            let fed = moves_of(&status.trims, self.base.feed())[input::FEED].clamp(-most, most);
            let flow_m_s = planned_m_s * (1.0 + fed);
            self.flow_error.follow((flow_m_s, planned_m_s), dt_s, self.printer.material.lag_s);
            return;
        }
        if estimate.encoder_alive {
            let flow_m_s = planned_m_s + excess_m / dt_s;
            self.flow_error.follow((flow_m_s, planned_m_s), dt_s, settings.flow_averaging_s);
            return;
        }
        let least_m_s = settings.flow_min_rel * estimate.reference_feed_m_s;
        let nominal = self.nominal.flow_m_s(settings.settle_lags).filter(|flow_m_s| *flow_m_s > least_m_s);
        if let Some(nominal_m_s) = nominal {
            let flows_m_s = (estimate.flow_m_s, nominal_m_s);
            self.flow_error.follow(flows_m_s, dt_s, settings.flow_averaging_alone_s);
        }
    }

    /// Whether the slip is made up for, and within what can be: by what the encoder tells, or widths where none is fitted.
    fn is_made_up_for(&self, status: &PrinterStatus, estimate: &Estimate) -> bool {
        let reach = self.params.slip.low..=self.params.slip.high;
        let told = estimate.encoder_alive || !self.params.slip.encoder_fitted;
        told && status.trims.slip.is_some() && reach.contains(&estimate.slip)
    }
}
