//! When a command is not to be trusted: K1, K2 and K5 of the fault catalogue.

use serde::Deserialize;

/// When a command is not to be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawHealth {
    /// A ceiling of the feed that the rates cannot reach in time gives way; otherwise such a plan has no solution.
    pub soften: bool,
    /// Late plans in a row that the shifted last one stands in for.
    pub late_max: u32,
    /// An actuator at its stop for so long `[s]`.
    pub saturated_s: f64,
    /// Duty of the heater that is its stop `[-]`.
    pub duty_stop: f64,
    /// Share of a move's range that counts as at its end `[-]`.
    pub margin: f64,
}
