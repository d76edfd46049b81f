//! What the advance predictor tells. The definition in `msg/` is the truth.

use crate::definition::{Definition, RosType};
use crate::standard::Header;
use serde::{Deserialize, Serialize};

/// Pressure advance for what is printed now, and the next turn of the path (topic advance/prediction).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct AdvancePrediction {
    /// stamp [s]: time of validity on the node's clock
    pub header: Header,
    /// False before the first road, and where the conditions are out of bounds.
    pub advance_known: bool,
    /// `K_A` for these conditions `[s]`. Range `[0, inf)`; invalid where advance_known is false.
    pub advance_s: f64,
    /// Half width of its 95 % interval `[s]`. Range `[0, inf)`; invalid where advance_known is false.
    pub advance_half_width_s: f64,
    /// The same as a law over the filament's feed `u`: its linear part `[s]`. Range `[0, 10]`; invalid where
    /// advance_known is false.
    pub advance_linear_s: f64,
    /// Scale of the melt's part `a u^(index - 1)` `[m (s/m)^index]`. Range `[0, 10]`; invalid where advance_known is false.
    pub advance_shear_m: f64,
    /// Flow index of the melt `[-]`. Range `(0, 1]`; invalid where advance_known is false.
    pub advance_index: f64,
    /// One of SOURCE_*. Range `[0, 1]`; invalid where advance_known is false.
    pub source: u8,
    /// The conditions lie inside the networks' data. Invalid where advance_known is false.
    pub in_hull: bool,
    /// Hot end set-point it is meant for `[degC]`. Invalid where advance_known is false.
    pub temperature_degc: f64,
    /// Height of the road it is meant for `[m]`. Range `[0, inf)`; invalid where advance_known is false.
    pub layer_height_m: f64,
    /// Cross section of the road over its height `[m]`. Range `[0, inf)`; invalid where advance_known is false.
    pub line_width_m: f64,
    /// False before the first move.
    pub turn_known: bool,
    /// Of a turn within the horizon. Range `[0, 1]`; invalid where turn_known is false.
    pub turn_probability: f64,
    /// The probability is above the network's threshold. Invalid where turn_known is false.
    pub turn_expected: bool,
    /// Time until it begins `[s]`. Range `[0, inf)`; invalid where turn_expected is false.
    pub turn_lead_s: f64,
    /// Way until it begins `[m]`. Range `[0, inf)`; invalid where turn_expected is false.
    pub turn_way_m: f64,
    /// The known moves show it, or show that there is none. Invalid where turn_known is false.
    pub turn_shown: bool,
    /// Way that the known moves show `[m]`. Range `[0, inf)`; invalid where turn_known is false.
    pub known_way_m: f64,
}

impl AdvancePrediction {
    /// `SOURCE_NETWORK` of the definition.
    pub const SOURCE_NETWORK: u8 = 0;
    /// `SOURCE_PHYSICS` of the definition.
    pub const SOURCE_PHYSICS: u8 = 1;
}

impl RosType for AdvancePrediction {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "AdvancePrediction",
        text: include_str!("../msg/AdvancePrediction.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}
