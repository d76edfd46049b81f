//! Every number of the node, as in `config/defect_classifier.param.yaml`.

use crate::annotate::PictureParams;
use crate::camera::Camera;
use crate::frame::FrameChecks;
use crate::fusion::FusionParams;
use crate::layer::LayerParams;
use crate::offset::OffsetParams;
use crate::path::HistoryParams;
use crate::pressure::PressureParams;
use crate::seam::SeamParams;
use crate::unexplained::UnexplainedParams;
use crate::usual::UsualParams;
use crate::width::WidthParams;
use models::params::{ParamError, in_range};
use serde::Deserialize;
use std::path::PathBuf;

/// All parameters. Each block checks its own numbers.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Files with trained networks.
    pub models: ModelFiles,
    /// Geometry of the camera.
    pub camera: Camera,
    /// Which frames can be judged.
    pub checks: FrameChecks,
    /// How much of the path is kept.
    pub history: HistoryParams,
    /// Measurement of the road's width.
    pub width: WidthParams,
    /// How the commanded filament is followed.
    pub pressure: PressureParams,
    /// What widths are usual here.
    pub usual: UsualParams,
    /// Shade of the seams between roads.
    pub seam: SeamParams,
    /// Where what was laid before lies.
    pub offset: OffsetParams,
    /// Edges that no road explains.
    pub unexplained: UnexplainedParams,
    /// Memory over frames.
    pub fusion: FusionParams,
    /// Quality of the layers.
    pub layer: LayerParams,
    /// Annotated pictures.
    pub picture: PictureParams,
    /// Error budget of the machine itself, published beside the quality; offsets within it are no defect.
    #[serde(default)]
    pub machine: MachineParams,
}

/// How far a layer may lie off that the machine's own kinematics explains. Built only from valid [`RawMachine`].
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(try_from = "RawMachine")]
pub struct MachineParams {
    /// The budget `[m]`; `None` where none is known.
    pub error_m: Option<f64>,
}

/// The `machine` block as it is written: what `fdm kinematics budget` prints.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawMachine {
    /// A budget is known.
    pub error_known: bool,
    /// The budget `[m]`, in `[0, 0.01]`; 0 where none is known.
    pub error_m: f64,
}

impl TryFrom<RawMachine> for MachineParams {
    type Error = ParamError;

    fn try_from(raw: RawMachine) -> Result<Self, ParamError> {
        let most_m = if raw.error_known { 0.01 } else { 0.0 };
        let error_m = in_range("error_m", raw.error_m, "m", (0.0, most_m))?;
        Ok(Self { error_m: raw.error_known.then_some(error_m) })
    }
}

/// Files that the shell reads.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelFiles {
    /// Network over the features of a frame; relative to the folder of the parameter file.
    pub network: PathBuf,
    /// Network that finds the edge of a road; likewise.
    pub edge: PathBuf,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_that_is_none_has_no_size() {
        let machine = |error_known, error_m| MachineParams::try_from(RawMachine { error_known, error_m });
        assert_eq!(machine(true, 2.47e-4).unwrap().error_m, Some(2.47e-4));
        assert_eq!(machine(false, 0.0).unwrap(), MachineParams::default());
        for (known, error_m) in [(false, 2.47e-4), (true, 0.011), (true, -1e-4), (true, f64::NAN)] {
            assert!(machine(known, error_m).is_err(), "{known} {error_m}");
        }
    }
}
