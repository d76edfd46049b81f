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
    /// One per name: a sensor that is used tells of the state itself, not only the model.
    pub observed: Vec<bool>,
    /// One per name: nothing tells of the state, which is frozen while its variance grows.
    pub held: Vec<bool>,
    /// Slow mean of the slicer's feed: the scale of the flow `[m/s]`. Range `(0, inf)`.
    pub reference_feed_m_s: f64,
    /// Names of the measurement channels.
    pub channels: Vec<String>,
    /// The newest sample of the channel is recent.
    pub alive: Vec<bool>,
    /// False where the channel had no update yet.
    pub measured: Vec<bool>,
    /// Normalised innovation squared of the newest update. Range `[0, inf)`; invalid where measured is false.
    pub nis: Vec<f64>,
    /// Mean of all of them. Range `[0, inf)`; invalid where measured is false.
    pub nis_mean: Vec<f64>,
    /// Measurements refused by the gate since start.
    pub gated: Vec<u64>,
    /// Sum of NIS over the window; 0 before it is full. Range `[0, inf)`.
    pub chi_square: Vec<f64>,
    /// Updates in the window: degrees of freedom of `chi_square`.
    pub chi_square_window: u32,
    /// Steps of slip, gain or temperature taken as given since start.
    pub steps: u64,
    /// Resets to the prior since start.
    pub resets: u64,
    /// Variance of the channel's noise over the configured one, as adapted from its innovations. Range `(0, inf)`.
    pub noise_scale: Vec<f64>,
    /// One of HEALTH_*. Range `[0, 3]`.
    pub health: u8,
}

impl StateEstimate {
    /// `HEALTH_SOUND` of the definition.
    pub const HEALTH_SOUND: u8 = 0;
    /// `HEALTH_RESET` of the definition.
    pub const HEALTH_RESET: u8 = 1;
    /// `HEALTH_MISMATCH` of the definition.
    pub const HEALTH_MISMATCH: u8 = 2;
    /// `HEALTH_DIVERGING` of the definition.
    pub const HEALTH_DIVERGING: u8 = 3;
}

impl RosType for StateEstimate {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "StateEstimate",
        text: include_str!("../msg/StateEstimate.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}
