//! What cameras and layers tell. The definitions in `msg/` are the truth.

use crate::definition::{Definition, RosType};
use crate::standard::Header;
use serde::{Deserialize, Serialize};

/// What one frame shows of the print, and how sure the whole is (topic vision/defects).
/// A frame that cannot be judged is UNKNOWN, never OK: `usable` is false then and nothing else counts but `why`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct DefectReport {
    /// stamp [s]: time of exposure on the node's clock; frame_id: the camera's frame.
    pub header: Header,
    /// The frame can be judged.
    pub usable: bool,
    /// Why it cannot; empty where it can.
    pub why: String,
    /// Frames judged or refused since start.
    pub frame: u64,
    /// Names of the classes; the first is 'ok'.
    pub classes: Vec<String>,
    /// Softmax of the network, one per class. Range `[0, 1]`.
    pub probabilities: Vec<f64>,
    /// One less the probability of 'ok', smoothed over frames. Range `[0, 1]`.
    pub detection: f64,
    /// Windowed innovation statistic a_k of the estimator. Range `[0, inf)`.
    pub residual: f64,
    /// Its 99 % point, the scale of a_k in the confidence. Range `(0, inf)`.
    pub residual_limit: f64,
    /// Fused confidence c_k that the print fails. Range `[0, 1]`.
    pub confidence: f64,
    /// Class that carries it; 'ok' where none does.
    pub cause: String,
    /// Enough of the last frames say the same cause.
    pub confirmed: bool,
    /// Frames of the window that say so.
    pub in_favour: u32,
    /// Frames in the window.
    pub window: u32,
    /// The layers below were found in the frame.
    pub offset_known: bool,
    /// Where they lie beside where they were laid, bed x and y `[m]`. Invalid where offset_known is false.
    pub offset_m: [f64; 2],
    /// Standard deviation of it, per axis `[m]`. Range `[0, inf)`; invalid where offset_known is false.
    pub offset_sigma_m: f64,
    /// The picture shows a place of the defect.
    pub region_known: bool,
    /// Column, row, width and height of that place `[px]`. Invalid where region_known is false.
    pub region_px: [u32; 4],
    /// The frame itself could tell of the cause; where not, what earlier frames said stands.
    pub cause_told: bool,
}

impl RosType for DefectReport {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "DefectReport",
        text: include_str!("../msg/DefectReport.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}

/// Quality of one layer, Q_k and its terms, 0 is perfect (topic quality/layer; model book 1.6).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct LayerQuality {
    /// stamp [s]: time of the figure on the node's clock.
    pub header: Header,
    /// Layer from 0.
    pub layer: u32,
    /// The layer is done; false while it is printed.
    pub complete: bool,
    /// Q_k, the weighted sum of the terms. Range `[0, inf)`.
    pub quality: f64,
    /// Geometry features against their tolerance, the layer's offset. Range `[0, inf)`.
    pub feature_term: f64,
    /// Width of the road. Range `[0, inf)`.
    pub width_term: f64,
    /// Temperature at the nozzle, as estimated. Range `[0, inf)`.
    pub temperature_term: f64,
    /// Latent adhesion, by model. Range `[0, inf)`.
    pub adhesion_term: f64,
    /// Latent porosity, by model. Range `[0, inf)`.
    pub porosity_term: f64,
    /// Mean of width over target width less one.
    pub width_error_rel: f64,
    /// Root mean square of it. Range `[0, inf)`.
    pub width_rms_rel: f64,
    /// Width measurements in it.
    pub widths: u32,
    /// Frames of the layer that could be judged.
    pub frames: u32,
    /// The machine's own error budget is configured.
    pub machine_error_known: bool,
    /// Largest deviation that the machine's own kinematics explains `[m]`. Range `[0, inf)`; invalid where machine_error_known is false.
    pub machine_error_m: f64,
}

impl RosType for LayerQuality {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "LayerQuality",
        text: include_str!("../msg/LayerQuality.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}

/// Measured height of a deposited layer of the wire process (topic sensors/layer/height).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct LayerHeight {
    /// stamp [s]: time of the measurement on the node's clock.
    pub header: Header,
    /// Layer from 0.
    pub layer: u32,
    /// Place along the bead `[m]`. Range `[0, inf)`.
    pub along_m: f64,
    /// Height of the wall above its base at this place, this layer included `[m]`.
    pub height_m: f64,
    /// Standard deviation of the measurement `[m]`. Range `(0, inf)`.
    pub sigma_m: f64,
}

impl RosType for LayerHeight {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "LayerHeight",
        text: include_str!("../msg/LayerHeight.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}
