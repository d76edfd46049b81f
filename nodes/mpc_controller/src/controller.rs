//! The controller: events in, a command per estimate out, a plan per tick.

use crate::advance::{Advance, Prediction};
use crate::base::Base;
use crate::catch_up::CatchUp;
use crate::clog::Clog;
use crate::fallback::Ladder;
use crate::flow_error::FlowError;
use crate::input::{Estimate, Event, is_valid};
use crate::nominal::Nominal;
use crate::params::{Level, Params};
use crate::qp::{BuildError, Move, Qp, input};
use crate::roads::Roads;
use crate::saturation::Saturation;
use crate::shortfall::Shortfall;
use crate::slowing::Slowing;
use models::command::{Command, ControlHealth};
use models::extruder::Extruder;
use models::hotend::Hotend;
use models::material::Material;
use models::melt::Melt;
use models::status::{JobPhase, PrinterStatus};
use models::transient::Transient;
use models::units::Seconds;

/// The nominal printer, as far as control needs it.
#[derive(Debug, Clone)]
struct Printer {
    hotend: Hotend,
    material: Material,
    melt: Melt,
    extruder: Extruder,
}

/// Receding-horizon controller over slicer values. Knows no clock and no middleware.
#[derive(Debug)]
pub struct Controller {
    params: Params,
    printer: Printer,
    session: u64,
    sequence: u64,
    qp: Qp,
    catch_up: CatchUp,
    /// The slicer's own feed, calibrated, against what passed the encoder.
    balance: Shortfall,
    advance: Advance,
    nominal: Nominal,
    base: Base,
    transient: Transient,
    slowing: Slowing,
    ladder: Ladder,
    saturation: Saturation,
    /// Slow mean of the flow error `[-]`.
    flow_error: FlowError,
    status: Option<PrinterStatus>,
    estimate: Option<Estimate>,
    /// Move in force, about the base.
    held: Move,
    /// Exposure of the newest width `[s]`.
    width_s: Option<f64>,
    /// Since when path, width and deposition are steady `[s]`.
    steady_since_s: f64,
    roads: Roads,
    clog: Clog,
    /// Laws are others than those that coming moves were sent with.
    anew: bool,
    /// Filament that passed the encoder beyond the slicer's feed so far `[m]`.
    excess_m: f64,
    /// Since when the trims in force differ from the held ones `[s]`.
    differ_since_s: Option<f64>,
    report: Report,
}

impl Controller {
    /// A controller that has seen nothing, for a nominal printer and a material. `session` tells this run's commands
    /// from another's.
    ///
    /// # Errors
    /// [`BuildError`] if the quadratic problem cannot be built from the parameters.
    pub fn new(
        params: Params,
        (hotend, extruder): (&Hotend, &Extruder),
        material: &Material,
        session: u64,
    ) -> Result<Self, BuildError> {
        Ok(Self {
            params,
            printer: Printer {
                hotend: *hotend,
                material: material.clone(),
                melt: Melt::new(material, extruder),
                extruder: *extruder,
            },
            session,
            sequence: 0,
            qp: retune::problem(&params, material)?,
            catch_up: CatchUp::new(params.slip),
            balance: Shortfall::new(params.slip),
            advance: Advance::new(params.advance, params.control),
            nominal: Nominal::new(material.lag_s),
            base: Base::new(params.base, params.limits.feed),
            transient: Transient::default(),
            slowing: Slowing::default(),
            ladder: Ladder::new(&params.health),
            saturation: Saturation::new(params.health, params.limits.low(), params.limits.high()),
            flow_error: FlowError::default(),
            status: None,
            estimate: None,
            held: [0.0; input::COUNT],
            width_s: None,
            steady_since_s: f64::NEG_INFINITY,
            roads: Roads::new(),
            clog: Clog::new(params.clog),
            anew: false,
            excess_m: 0.0,
            differ_since_s: None,
            report: Report::default(),
        })
    }

    /// What was done and seen so far.
    #[must_use]
    pub fn report(&self) -> Report {
        Report {
            shortfall_m: self.catch_up.shortfall_m(),
            advance: self.advance.report(),
            softened: self.qp.softened(),
            saturated_s: self.saturation.longest_s(),
            base: self.base.error(),
            force: self.clog.factor() * self.advance.narrowing(),
            ..self.report
        }
    }

    /// What is to be told beside the newest command.
    #[must_use]
    pub fn health(&self) -> ControlHealth {
        let stuck = if self.saturation.is_long() { ControlHealth::Saturated } else { ControlHealth::Sound };
        self.ladder.health().max(stuck)
    }

    /// Takes one event in; an estimate yields a command unless an input is too old.
    pub fn on_event(&mut self, event: Event) -> Option<Command> {
        match event {
            Event::Estimate(estimate) => return self.take_estimate(estimate),
            Event::Printer(status) => self.take_status(&status),
            Event::Encoder { stamp, position_m } => self.take_position(stamp, position_m),
            Event::Width { exposed, width_m } => self.take_width(exposed, width_m),
            Event::Prediction(prediction) => self.take_prediction(prediction),
            Event::Tick { now } => self.tick(now),
        }
        None
    }

    fn take_estimate(&mut self, estimate: Estimate) -> Option<Command> {
        if !estimate.is_valid() {
            self.report.refusals.estimate.invalid += 1;
            return None;
        }
        if self.estimate.is_some_and(|before| estimate.stamp <= before.stamp) {
            self.report.refusals.estimate.late += 1;
            return None;
        }
        let before = self.estimate.replace(estimate);
        let Some(status) = self.fresh_status(estimate.stamp) else {
            self.report.starved += 1;
            return None;
        };
        let dt_s = before.map_or(0.0, |before| estimate.stamp.0 - before.stamp.0);
        self.follow_flow(&status, &estimate, dt_s);
        self.calibrate(&status, &estimate, dt_s);
        self.slow_down(&estimate, dt_s);
        let trims = self.trims(&status, &estimate, dt_s);
        self.sequence += 1;
        Some(Command {
            session: self.session,
            sequence: self.sequence,
            validity: Seconds(self.params.validity_s),
            trims,
        })
    }

    fn take_status(&mut self, status: &PrinterStatus) {
        if !is_valid(status) {
            self.report.refusals.printer.invalid += 1;
            return;
        }
        if self.status.is_some_and(|before| status.stamp <= before.stamp) {
            self.report.refusals.printer.late += 1;
            return;
        }
        let law = self.estimate.and_then(|estimate| self.outlet_law(&estimate, estimate.reference_feed_m_s));
        self.nominal.on_status(status, (self.base.feed(), self.params.slip.wanted_jump_m), law.as_ref());
        self.balance.on_wanted(status.stamp.0, self.nominal.fed_m());
        self.catch_up.on_wanted(status.stamp.0, status.wanted_position_m);
        self.catch_up.on_in_force(status.stamp.0, status.trims.slip);
        self.follow_advance(status);
        let held = (self.excess_m, self.advance.driven(status));
        self.roads.on_status(status, held, self.params.clog.feed_spread);
        if self.status.is_none_or(|before| self.unsteady(&before, status)) {
            self.steady_since_s = status.stamp.0;
        }
        if matches!(status.phase, JobPhase::Idle | JobPhase::Done | JobPhase::Failed) {
            self.rest();
        }
        if status.phase == JobPhase::Paused {
            // Whoever paused it may have cleaned the nozzle: moves that are known go on as through a sound one.
            self.anew |= self.clog.factor() > 1.0;
            self.clog = Clog::new(self.params.clog);
        }
        self.adopt(status);
        self.slowing.on_status(status.stamp.0, status.trims.speed / (1.0 + self.held[input::SPEED]));
        self.status = Some(*status);
    }

    fn take_position(&mut self, stamp: Seconds, position_m: f64) {
        if !(stamp.0.is_finite() && position_m.is_finite()) {
            self.report.refusals.encoder.invalid += 1;
        } else if self.catch_up.newest_sample_s().is_some_and(|newest_s| stamp.0 <= newest_s) {
            self.report.refusals.encoder.late += 1;
        } else {
            self.catch_up.on_encoder(stamp.0, position_m);
            self.balance.on_encoder(stamp.0, position_m);
        }
    }

    fn take_prediction(&mut self, prediction: Prediction) {
        if !prediction.is_valid() {
            self.report.refusals.prediction.invalid += 1;
        } else if self.advance.newest_stamp().is_some_and(|newest| prediction.stamp < newest) {
            self.report.refusals.prediction.late += 1;
        } else {
            self.advance.on_prediction(prediction);
        }
    }

    fn unsteady(&self, before: &PrinterStatus, now: &PrinterStatus) -> bool {
        let spread = self.params.trims.speed_spread;
        let changed = |old: f64, new: f64| (new - old).abs() > spread * old.abs().max(new.abs());
        let width = match (before.target_width_m, now.target_width_m) {
            (Some(old), Some(new)) => changed(old, new),
            _ => true,
        };
        !now.depositing || width || changed(before.planned_speed_m_s, now.planned_speed_m_s)
    }

    /// Nothing is printed: forget every correction.
    fn rest(&mut self) {
        self.held = [0.0; input::COUNT];
        self.qp.clear();
        self.nominal.clear();
        self.base.clear();
        self.transient = Transient::default();
        self.slowing.forget();
        self.clog = Clog::new(self.params.clog);
        self.flow_error = FlowError::default();
        self.catch_up.open();
        self.balance.open();
        self.advance.rest();
        self.ladder.clear();
        self.saturation.clear();
    }

    /// Where the printer keeps other trims than the sent ones (observed, limited, lapsed), goes on from those.
    fn adopt(&mut self, status: &PrinterStatus) {
        let in_force = moves_of(&status.trims, self.base.feed());
        let tolerance = self.params.bumpless.tolerance;
        let differ = (in_force[input::FEED] - self.held[input::FEED]).abs() > tolerance
            || (in_force[input::SPEED] - self.held[input::SPEED]).abs() > tolerance;
        // A path that is being slowed down differs by what is on its way.
        if !differ || self.slowing.is_active() || self.params.control != Level::Mpc {
            self.differ_since_s = None;
            return;
        }
        let since_s = *self.differ_since_s.get_or_insert(status.stamp.0);
        if status.stamp.0 - since_s > self.params.bumpless.adopt_s {
            let (low, high) = (self.params.limits.low(), self.params.limits.high());
            self.held = std::array::from_fn(|index| in_force[index].clamp(low[index], high[index]));
            self.qp.clear();
            self.differ_since_s = None;
            self.report.adopted += 1;
        }
    }
}

mod narrowing;
mod passing;
mod planning;
mod preview;
mod report;
mod retune;
mod sending;

pub use report::Report;
use sending::moves_of;

#[cfg(test)]
mod tests;
