//! Every number of the node, as in `config/defect_classifier.param.yaml`.

use crate::annotate::PictureParams;
use crate::camera::Camera;
use crate::frame::FrameChecks;
use crate::fusion::FusionParams;
use crate::layer::LayerParams;
use crate::offset::OffsetParams;
use crate::path::HistoryParams;
use crate::unexplained::UnexplainedParams;
use crate::width::WidthParams;
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
