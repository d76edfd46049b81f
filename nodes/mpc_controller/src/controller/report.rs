//! What the controller tells of itself.

use crate::advance::AdvanceReport;
use crate::input::Refusals;
use crate::qp::Outcome;

/// What the controller has done and seen, for diagnostics.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Report {
    /// How the last solve ended; `None` before the first.
    pub outcome: Option<Outcome>,
    /// Solves that ended optimal.
    pub solved: u64,
    /// Solves without a solution of their own.
    pub fallbacks: u64,
    /// Solves whose ceiling of the feed had to give way.
    pub softened: u64,
    /// Coming moves with a trim of their own.
    pub scheduled: u64,
    /// How long an actuator has stood at its stop `[s]`.
    pub saturated_s: f64,
    /// Estimates or ticks without a command, since an input was too old.
    pub starved: u64,
    /// Times the trims in force were taken over.
    pub adopted: u64,
    /// Flow error of the last solve `[-]`.
    pub flow_error: f64,
    /// What of the section is the spool's own, less one `[-]`: the feed is divided by one plus it.
    pub base: f64,
    /// Gain error about the base of the last solve `[-]`.
    pub gain_error: f64,
    /// Temperature error of the last solve `[K]`.
    pub temperature_error_k: f64,
    /// Melt's force over that of a sound nozzle, as laws of coming moves have it `[-]`.
    pub force: f64,
    /// Filament still owed by a host without a loop `[m]`.
    pub shortfall_m: f64,
    /// Pressure advance.
    pub advance: AdvanceReport,
    /// Inputs not used.
    pub refusals: Refusals,
}
