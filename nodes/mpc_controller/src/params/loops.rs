//! The loops around the plan: calibration of the spool, fast trims, extruder loop, switching.

use serde::Deserialize;

/// Calibration of the spool: what of the road's section is a constant of the print.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawBase {
    /// Time over which the estimated gain is averaged `[s]`.
    pub averaging_s: f64,
    /// Shortest time of the mean at the start of a print `[s]`.
    pub first_s: f64,
    /// Fastest change `[1/s]`.
    pub rate_1_s: f64,
    /// Largest magnitude `[-]`; 0 calibrates nothing.
    pub limit: f64,
}

/// Fast trims between solves.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawTrims {
    /// Feed per relative width error and frame `[-]`.
    pub feed_gain: f64,
    /// Speed per relative width error and frame `[-]`.
    pub speed_gain: f64,
    /// Time between frames `[s]`.
    pub frame_period_s: f64,
    /// Exposure to effect `[s]`.
    pub delay_s: f64,
    /// A larger relative width error is one of the flow while the encoder speaks: a diameter does not jump `[-]`.
    pub transient: f64,
    /// Share of the section from which on a slower path makes up for it while it passes `[-]`.
    pub transient_slowed: f64,
    /// Relative width error that is one of the flow in a road that has settled, and has not been steady for long `[-]`.
    pub transient_settled: f64,
    /// Share of such an error that the speed of the path makes up for while it passes `[-]`.
    pub transient_speed: f64,
    /// Time constant with which such an error passes by itself `[lags of the melt]`.
    pub transient_lags: f64,
    /// Wait after a change of path speed `[s]`.
    pub steady_s: f64,
    /// The same behind a nozzle that has narrowed beyond what the laws of coming moves follow `[s]`.
    pub steady_clogged_s: f64,
    /// What counts as a change of path speed `[-]`.
    pub speed_spread: f64,
}

/// Extruder loop.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawSlip {
    /// A filament encoder is fitted: without its word no slip is made up for. Where none is, what widths tell of it is.
    pub encoder_fitted: bool,
    /// Lowest slip made up for `[-]`.
    pub low: f64,
    /// Highest slip made up for `[-]`.
    pub high: f64,
    /// Catch-up for hosts without a loop `[1/s]`.
    pub serial_gain_1_s: f64,
    /// Largest catch-up relative to the reference feed `[-]`.
    pub serial_limit: f64,
    /// Time constant with which what the melt lacks is corrected by the count `[s]`.
    pub serial_smooths_s: f64,
    /// Time constant with which a slip that is told slightly wrong is learned from the count `[s]`.
    pub serial_learns_s: f64,
    /// Encoder samples further apart are not interpolated `[s]`.
    pub pairing_s: f64,
    /// A larger jump of the wanted position is a new count `[m]`.
    pub wanted_jump_m: f64,
}

/// Switching without a bump.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawBumpless {
    /// Trims in force that differ this long from the sent ones are taken over `[s]`.
    pub adopt_s: f64,
    /// Difference that counts `[-]`.
    pub tolerance: f64,
    /// Below this share of the reference feed the flow's error is not judged `[-]`.
    pub flow_min_rel: f64,
    /// Lags after which the start of the slicer's flow is forgotten `[-]`.
    pub settle_lags: f64,
    /// Time constant of the flow error `[s]`.
    pub flow_averaging_s: f64,
    /// The same where no encoder closes a loop `[s]`.
    pub flow_averaging_alone_s: f64,
}
