//! State estimate. The definitions in `msg/` and `srv/` are the truth.

use crate::definition::{Definition, RosType};
use crate::standard::Header;
use serde::{Deserialize, Serialize};

/// State of the process with its uncertainty and consistency (topic estimate/state).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct StateEstimate {
    /// stamp [s]: time of validity on the node's clock
    pub header: Header,
    /// Name of each state, unit as its suffix.
    pub names: Vec<String>,
    /// Estimate, one per name `[unit of the name's suffix]`.
    pub x: Vec<f64>,
    /// Row-major, names x names `[products of the units]`.
    pub covariance: Vec<f64>,
    /// Names of the measurement channels.
    pub channels: Vec<String>,
    /// Normalised innovation squared of the newest update per channel. Range `[0, inf)`.
    pub nis: Vec<f64>,
    /// False where the channel had no update yet.
    pub nis_known: Vec<bool>,
    /// The newest measurement of the channel was refused by the gate.
    pub gated: Vec<bool>,
    /// Sum of NIS over the window. Range `[0, inf)`.
    pub chi_square: f64,
    /// Updates in the window: degrees of freedom of chi_square.
    pub chi_square_window: u32,
    /// Resets to the prior since start.
    pub resets: u32,
}

impl RosType for StateEstimate {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "StateEstimate",
        text: include_str!("../msg/StateEstimate.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}
