//! Parameters of the controller, checked once: `config/mpc_controller.param.yaml`.

use crate::qp::Move;
use models::params::{ParamError, in_range, ordered};
use models::units::Seconds;
use serde::Deserialize;

/// Parameters of [`crate::Controller`], built only from a valid file.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawParams")]
pub struct Params(RawParams);

impl std::ops::Deref for Params {
    type Target = RawParams;
    fn deref(&self) -> &RawParams {
        &self.0
    }
}

impl Params {
    /// A frame older than the time to its effect and the period of frames has a newer one on its way.
    #[must_use]
    pub fn frame_age_limit(&self) -> Seconds {
        Seconds(self.trims.delay_s + self.trims.frame_period_s)
    }

    /// The same parameters with another source of the pressure advance.
    #[must_use]
    pub fn with_advance(self, source: AdvanceSource) -> Self {
        Self(RawParams { advance: RawAdvance { source, ..self.0.advance }, ..self.0 })
    }

    /// The same parameters for a loop that runs faster or slower than the clock: iterations alone end a solve, so that
    /// a busy machine changes nothing.
    #[must_use]
    pub fn in_virtual_time(self) -> Self {
        Self(RawParams { solver: RawSolver { time_limit_s: f64::INFINITY, ..self.0.solver }, ..self.0 })
    }

    /// The same parameters with another level of control.
    #[must_use]
    pub fn with_level(self, control: Level) -> Self {
        Self(RawParams { control, ..self.0 })
    }
}

/// The file as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawParams {
    /// What is corrected.
    pub control: Level,
    /// Tick and step of the prediction `[s]`.
    pub period_s: f64,
    /// Validity of a command `[s]`.
    pub validity_s: f64,
    /// An older estimate is not acted on `[s]`.
    pub estimate_age_limit_s: f64,
    /// An older printer status is not acted on `[s]`.
    pub status_age_limit_s: f64,
    /// Air and incoming filament `[K]`.
    pub ambient_k: f64,
    /// Prediction.
    pub model: RawModel,
    /// Cost.
    pub cost: RawCost,
    /// Bounds and rates.
    pub limits: RawLimits,
    /// Solver.
    pub solver: RawSolver,
    /// When a command is not to be trusted.
    pub health: RawHealth,
    /// Errors that are left alone.
    pub deadband: RawDeadband,
    /// Reference of the nozzle temperature.
    pub reference: RawReference,
    /// Calibration of the spool.
    pub base: RawBase,
    /// Fast trims.
    pub trims: RawTrims,
    /// Extruder loop.
    pub slip: RawSlip,
    /// Pressure advance.
    pub advance: RawAdvance,
    /// A nozzle that narrows.
    pub clog: RawClog,
    /// Switching without a bump.
    pub bumpless: RawBumpless,
}

/// Prediction.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawModel {
    /// Steps.
    pub horizon: u32,
    /// Set-point to nozzle `[s]`.
    pub thermal_lag_s: f64,
}

/// Cost of a step (model book 1.7).
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawCost {
    /// Width error that costs one `[-]`.
    pub width_scale: f64,
    /// Temperature error that costs its weight `[K]`.
    pub temperature_scale_k: f64,
    /// `[-]`.
    pub temperature_weight: f64,
    /// Speed trim that costs one `[-]`.
    pub speed_scale: f64,
    /// Feed trim that costs one `[-]`.
    pub feed_scale: f64,
    /// `[1/K²]`.
    pub setpoint_weight_1_k2: f64,
    /// Weight of all changes `[-]`.
    pub change_weight: f64,
    /// Change of feed that costs the weight `[-]`.
    pub feed_change: f64,
    /// Change of speed that costs the weight `[-]`.
    pub speed_change: f64,
    /// Change of set-point that costs the weight `[K]`.
    pub setpoint_change_k: f64,
}

impl RawCost {
    /// Weights of the squared changes of each move.
    #[must_use]
    pub fn change_weights(&self) -> Move {
        [self.feed_change, self.speed_change, self.setpoint_change_k]
            .map(|size| self.change_weight / size.powi(2))
    }
}

/// Bounds and rates per period.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawLimits {
    /// Magnitude of the feed trim `[-]`.
    pub feed: f64,
    /// `[-]`.
    pub speed_low: f64,
    /// `[-]`.
    pub speed_high: f64,
    /// Magnitude of the set-point offset `[K]`.
    pub setpoint_k: f64,
    /// Per period `[-]`.
    pub feed_rate: f64,
    /// Per period `[-]`.
    pub speed_rate: f64,
    /// Per period `[K]`.
    pub setpoint_rate_k: f64,
    /// Share of the drive's largest force that sets the flow ceiling `[-]`.
    pub force_margin: f64,
}

impl RawLimits {
    /// Lower bounds.
    #[must_use]
    pub fn low(&self) -> Move {
        [-self.feed, self.speed_low, -self.setpoint_k]
    }

    /// Upper bounds.
    #[must_use]
    pub fn high(&self) -> Move {
        [self.feed, self.speed_high, self.setpoint_k]
    }

    /// Largest change per period.
    #[must_use]
    pub fn rate(&self) -> Move {
        [self.feed_rate, self.speed_rate, self.setpoint_rate_k]
    }
}

/// Limits of a solve.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawSolver {
    /// Guesses of the limits that hold, before the interior point is asked; 0: it alone.
    pub guesses: u32,
    /// Interior point steps.
    pub iterations: u32,
    /// `[s]`.
    pub time_limit_s: f64,
}

/// Errors below `start` are left alone, above `full` they count in full, in between in proportion.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawDeadband {
    /// Gain and flow `[-]`.
    pub start: f64,
    /// `[-]`.
    pub full: f64,
    /// Temperature `[K]`.
    pub start_k: f64,
    /// `[K]`.
    pub full_k: f64,
}

/// Reference of the nozzle temperature.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawReference {
    /// Flow at which a slicer's set-point is meant `[m³/s]`.
    pub flow_m3_s: f64,
}

impl TryFrom<RawParams> for Params {
    type Error = ParamError;

    fn try_from(raw: RawParams) -> Result<Self, ParamError> {
        in_range("period_s", raw.period_s, "s", (0.05, 1.0))?;
        // A command counts until the next one comes.
        in_range("validity_s", raw.validity_s, "s", (raw.period_s.max(0.1), 1.0))?;
        in_range("estimate_age_limit_s", raw.estimate_age_limit_s, "s", (0.05, 2.0))?;
        in_range("status_age_limit_s", raw.status_age_limit_s, "s", (0.05, 2.0))?;
        in_range("ambient_k", raw.ambient_k, "K", (200.0, 400.0))?;
        in_range("model.horizon", f64::from(raw.model.horizon), "steps", (2.0, 40.0))?;
        in_range("model.thermal_lag_s", raw.model.thermal_lag_s, "s", (0.1, 600.0))?;
        check::cost(&raw.cost)?;
        check::limits(&raw.limits)?;
        in_range("solver.guesses", f64::from(raw.solver.guesses), "guesses", (0.0, 100.0))?;
        in_range("solver.iterations", f64::from(raw.solver.iterations), "steps", (1.0, 1000.0))?;
        in_range("solver.time_limit_s", raw.solver.time_limit_s, "s", (1e-9, 10.0))?;
        check::health(&raw.health)?;
        in_range("deadband.start", raw.deadband.start, "-", (0.0, 0.2))?;
        in_range("deadband.full", raw.deadband.full, "-", (0.0, 0.2))?;
        ordered(("deadband.start", raw.deadband.start), ("deadband.full", raw.deadband.full))?;
        in_range("deadband.start_k", raw.deadband.start_k, "K", (0.0, 20.0))?;
        in_range("deadband.full_k", raw.deadband.full_k, "K", (0.0, 20.0))?;
        ordered(("deadband.start_k", raw.deadband.start_k), ("deadband.full_k", raw.deadband.full_k))?;
        in_range("reference.flow_m3_s", raw.reference.flow_m3_s, "m3/s", (1e-11, 1e-6))?;
        check::base(&raw.base)?;
        check::trims(&raw.trims)?;
        check::slip(&raw.slip)?;
        raw.advance.check()?;
        raw.clog.check()?;
        in_range("bumpless.adopt_s", raw.bumpless.adopt_s, "s", (0.0, 10.0))?;
        in_range("bumpless.tolerance", raw.bumpless.tolerance, "-", (0.0, 0.1))?;
        in_range("bumpless.flow_min_rel", raw.bumpless.flow_min_rel, "-", (0.0, 1.0))?;
        in_range("bumpless.settle_lags", raw.bumpless.settle_lags, "-", (0.0, 20.0))?;
        in_range("bumpless.flow_averaging_s", raw.bumpless.flow_averaging_s, "s", (0.01, 600.0))?;
        in_range("bumpless.flow_averaging_alone_s", raw.bumpless.flow_averaging_alone_s, "s", (0.01, 600.0))?;
        Ok(Self(raw))
    }
}

mod advance;
mod check;
mod clog;
mod health;
mod level;
mod loops;

pub use clog::RawClog;
pub use health::RawHealth;
pub use level::Level;
pub use loops::{RawBase, RawBumpless, RawSlip, RawTrims};

pub use advance::{AdvanceSource, RawAdvance, RawLearning};
