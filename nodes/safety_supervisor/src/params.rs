//! Every number of the supervisor, as in `config/safety_supervisor.param.yaml`, where ranges and sources stand too.

mod heater;
mod oscillation;
mod readings;
mod required;
mod rest;
mod thermal;
mod vision;

use models::command::{Limits, Mode};
use models::params::{ParamError, in_range};
use models::units::Seconds;
use serde::{Deserialize, Serialize};

pub use heater::{HeaterParams, ObserverParams, RawHeaterParams, RawObserverParams};
pub use oscillation::{OscillationParams, RawOscillationParams};
pub use readings::{
    DetachedParams, DriftParams, JumpParams, NoiseParams, PartFanParams, RawDetachedParams, StopInputParams,
};
pub use required::Streams;
pub use rest::{
    AttentionParams, BurstParams, FilamentParams, ModeParams, RawAttentionParams, RawBurstParams,
    RawFilamentParams, RawModeParams, RawRunOutParams, RawStaleParams, RunOutParams, StaleParams,
};
pub use thermal::{FrozenParams, RangeParams, RawFrozenParams, RawRangeParams};
pub use vision::{
    DefectParams, ImpulseParams, RawDefectParams, RawImpulseParams, RawShiftParams, ShiftParams,
};

/// Mode after the start, one of those that a person may set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StartMode {
    /// Watch only.
    Observe,
    /// Corrections wait for approval.
    Advise,
    /// Corrections are sent.
    Act,
}

impl StartMode {
    /// The mode as one that can be set; `None` where it follows from a cause alone.
    #[must_use]
    pub fn of(mode: Mode) -> Option<Self> {
        [Self::Observe, Self::Advise, Self::Act].into_iter().find(|set| Mode::from(*set) == mode)
    }
}

impl From<StartMode> for Mode {
    fn from(mode: StartMode) -> Self {
        match mode {
            StartMode::Observe => Self::Observe,
            StartMode::Advise => Self::Advise,
            StartMode::Act => Self::Act,
        }
    }
}

/// K6, C8: commands.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnvelopeParams {
    /// Period of the controller `[s]`: the shortest span over which the slew of a command is taken.
    pub period_s: f64,
    /// How long a second publisher is remembered `[s]`.
    pub rival_hold_s: f64,
    /// Commands outside that degrade.
    pub outside: BurstParams,
    /// Trims of coming moves.
    pub schedule: ScheduleParams,
}

/// K6, C8: trims of coming moves.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScheduleParams {
    /// Longest validity that is accepted `[s]`.
    pub validity_max_s: f64,
    /// Highest advance of a law at `feed_m_s` `[s]`.
    pub advance_max_s: f64,
    /// Feed of the filament at which that is taken `[m/s]`.
    pub feed_m_s: f64,
    /// Most filament that may be said to be held without an advance that pushed it `[m]`.
    pub carried_max_m: f64,
}

impl ScheduleParams {
    /// Longest validity that is accepted.
    #[must_use]
    pub fn validity_max(&self) -> Seconds {
        Seconds(self.validity_max_s)
    }

    fn check(&self) -> Result<(), ParamError> {
        in_range("envelope.schedule.validity_max_s", self.validity_max_s, "s", (0.05, 60.0))?;
        in_range("envelope.schedule.advance_max_s", self.advance_max_s, "s", (0.0, 5.0))?;
        in_range("envelope.schedule.feed_m_s", self.feed_m_s, "m/s", (1e-5, 0.1))?;
        in_range("envelope.schedule.carried_max_m", self.carried_max_m, "m", (0.0, 0.01)).map(drop)
    }
}

/// S7: one block a stream.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stales {
    /// Hot end temperature.
    pub hotend: StaleParams,
    /// Bed temperature.
    pub bed: StaleParams,
    /// Filament encoder.
    pub encoder: StaleParams,
    /// Printer state.
    pub printer: StaleParams,
    /// Controller commands.
    pub command: StaleParams,
    /// State estimate.
    pub estimate: StaleParams,
    /// Accelerations.
    pub imu: StaleParams,
    /// Reports of the camera's judge.
    pub vision: StaleParams,
    /// C4: silence of a process's heart that degrades `[s]`, of real time.
    pub hang_s: f64,
    /// C4: time without the work that is due that degrades `[s]`, of the node's clock and of real time.
    pub work_s: f64,
    /// P1, P2: time for which a hot end in use may go unjudged until it is switched off `[s]`.
    pub hotend_unjudged_s: f64,
    /// P12: as of the hot end, of the bed `[s]`.
    pub bed_unjudged_s: f64,
    /// P1: time for which heaters that are off by order may go unseen until the mains relay opens `[s]`.
    pub unseen_s: f64,
}

/// All parameters. Built only from valid [`RawParams`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawParams")]
pub struct Params(RawParams);

impl std::ops::Deref for Params {
    type Target = RawParams;
    fn deref(&self) -> &RawParams {
        &self.0
    }
}

/// The parameter file as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawParams {
    /// Mode after the start.
    pub start_mode: StartMode,
    /// Streams without which it does not start, and whose silence counts from then on.
    #[serde(default = "required::at_start")]
    pub required: Streams,
    /// Streams that must come as well once corrections may be sent.
    #[serde(default = "required::to_act")]
    pub required_to_act: Streams,
    /// Validity of a permit `[s]`.
    pub permit_validity_s: f64,
    /// Envelope of corrections.
    pub limits: Limits,
    /// Commands.
    pub envelope: EnvelopeParams,
    /// Swinging corrections.
    pub oscillation: OscillationParams,
    /// Times of the mode machine.
    pub modes: ModeParams,
    /// Ages of streams.
    pub stale: Stales,
    /// Refused values that degrade.
    pub bad_values: BurstParams,
    /// Range of the hot end.
    pub hotend_range: RangeParams,
    /// Range of the bed.
    pub bed_range: RangeParams,
    /// Frozen hot end reading.
    pub frozen: FrozenParams,
    /// Thermistor fell out.
    pub detached: DetachedParams,
    /// Energy balance of the hot end.
    pub heater: HeaterParams,
    /// Hot end readings that step.
    pub hotend_step: JumpParams,
    /// Hot end readings that jump about.
    pub noise: NoiseParams,
    /// Hot end readings that drift.
    pub drift: DriftParams,
    /// Frozen bed reading.
    pub bed_frozen: FrozenParams,
    /// The bed's thermistor fell out.
    pub bed_detached: DetachedParams,
    /// Energy balance of the bed.
    pub bed_heater: HeaterParams,
    /// Part fan.
    pub part_fan: PartFanParams,
    /// Stop contact.
    pub stop_input: StopInputParams,
    /// Encoder against motor.
    pub filament: FilamentParams,
    /// Run-out switch.
    pub run_out: RunOutParams,
    /// Impulses at the tool.
    pub impulse: ImpulseParams,
    /// Offset of what was laid.
    pub shift: ShiftParams,
    /// What the camera's judge confirms.
    pub defect: DefectParams,
    /// Soft and hard states.
    pub attention: AttentionParams,
}

impl TryFrom<RawParams> for Params {
    type Error = ParamError;

    fn try_from(raw: RawParams) -> Result<Self, ParamError> {
        required::check(raw.required)?;
        in_range("permit_validity_s", raw.permit_validity_s, "s", (0.05, 0.25))?;
        in_range("envelope.period_s", raw.envelope.period_s, "s", (0.01, 2.0))?;
        in_range("envelope.rival_hold_s", raw.envelope.rival_hold_s, "s", (0.1, 60.0))?;
        raw.envelope.schedule.check()?;
        in_range("stale.hang_s", raw.stale.hang_s, "s", (0.2, 10.0))?;
        in_range("stale.work_s", raw.stale.work_s, "s", (1.0, 60.0))?;
        in_range("stale.hotend_unjudged_s", raw.stale.hotend_unjudged_s, "s", (1.0, 600.0))?;
        in_range("stale.bed_unjudged_s", raw.stale.bed_unjudged_s, "s", (1.0, 600.0))?;
        in_range("stale.unseen_s", raw.stale.unseen_s, "s", (1.0, 600.0))?;
        // The range of hot ends takes a bed's limit in kelvin, too.
        in_range("bed_range.max_c", raw.bed_range.max_c, "degC", (50.0, 300.0))?;
        raw.hotend_step.check()?;
        raw.noise.check()?;
        raw.drift.check()?;
        raw.part_fan.check()?;
        raw.stop_input.check()?;
        Ok(Self(raw))
    }
}
