//! Numbers of what camera and inertial unit say.

use models::params::{ParamError, in_range};
use serde::Deserialize;

use super::thermal::count;

/// P8: impulses at the tool.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawImpulseParams")]
pub struct ImpulseParams {
    /// Most that commanded moves and the structure's own ringing show `[m/s2]`.
    pub commanded_max_m_s2: f64,
    /// Beyond that by this much is an impulse `[m/s2]`.
    pub residual_m_s2: f64,
    /// Samples beyond it until it is flagged `[-]`.
    pub samples: u32,
    /// Span in which they must lie `[s]`.
    pub span_s: f64,
    /// Two impulses closer than this are one `[s]`.
    pub apart_s: f64,
    /// Time constant of the mean that is taken for gravity `[s]`.
    pub still_s: f64,
}

/// As [`ImpulseParams`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawImpulseParams {
    /// Most that commanded moves and the structure's own ringing show `[m/s2]`.
    pub commanded_max_m_s2: f64,
    /// Beyond that by this much is an impulse `[m/s2]`.
    pub residual_m_s2: f64,
    /// Samples beyond it until it is flagged `[-]`.
    pub samples: u32,
    /// Span in which they must lie `[s]`.
    pub span_s: f64,
    /// Two impulses closer than this are one `[s]`.
    pub apart_s: f64,
    /// Time constant of the mean that is taken for gravity `[s]`.
    pub still_s: f64,
}

impl TryFrom<RawImpulseParams> for ImpulseParams {
    type Error = ParamError;

    fn try_from(raw: RawImpulseParams) -> Result<Self, ParamError> {
        Ok(Self {
            commanded_max_m_s2: in_range("commanded_max_m_s2", raw.commanded_max_m_s2, "m/s2", (0.1, 200.0))?,
            residual_m_s2: in_range("residual_m_s2", raw.residual_m_s2, "m/s2", (1.0, 500.0))?,
            samples: count("samples", raw.samples, 1000)?,
            span_s: in_range("span_s", raw.span_s, "s", (0.001, 1.0))?,
            apart_s: in_range("apart_s", raw.apart_s, "s", (0.0, 10.0))?,
            still_s: in_range("still_s", raw.still_s, "s", (0.05, 60.0))?,
        })
    }
}

/// P8: offset of what was laid.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawShiftParams")]
pub struct ShiftParams {
    /// Largest offset of a sound print `[m]`.
    pub offset_max_m: f64,
    /// What the machine's own kinematics explains; added to the largest offset `[m]`.
    pub machine_error_m: f64,
    /// Frames in a row beyond it `[-]`.
    pub frames: u32,
    /// The same shortly after an impulse `[-]`.
    pub frames_after_impulse: u32,
    /// How long an impulse counts as a hint `[s]`.
    pub impulse_s: f64,
}

/// As [`ShiftParams`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawShiftParams {
    /// Largest offset of a sound print `[m]`.
    pub offset_max_m: f64,
    /// What the machine's own kinematics explains; added to the largest offset `[m]`.
    pub machine_error_m: f64,
    /// Frames in a row beyond it `[-]`.
    pub frames: u32,
    /// The same shortly after an impulse `[-]`.
    pub frames_after_impulse: u32,
    /// How long an impulse counts as a hint `[s]`.
    pub impulse_s: f64,
}

impl TryFrom<RawShiftParams> for ShiftParams {
    type Error = ParamError;

    fn try_from(raw: RawShiftParams) -> Result<Self, ParamError> {
        Ok(Self {
            offset_max_m: in_range("offset_max_m", raw.offset_max_m, "m", (1e-5, 0.01))?,
            machine_error_m: in_range("machine_error_m", raw.machine_error_m, "m", (0.0, 0.01))?,
            frames: count("frames", raw.frames, 100)?,
            frames_after_impulse: count("frames_after_impulse", raw.frames_after_impulse, 100)?,
            impulse_s: in_range("impulse_s", raw.impulse_s, "s", (0.0, 600.0))?,
        })
    }
}

/// P5, P9, S8: what the camera's judge confirms.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawDefectParams")]
pub struct DefectParams {
    /// How long a wrong road must be confirmed until the job pauses `[s]`.
    pub persist_s: f64,
    /// How long no frame may be fit to judge `[s]`.
    pub blind_s: f64,
}

/// As [`DefectParams`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawDefectParams {
    /// How long a wrong road must be confirmed until the job pauses `[s]`.
    pub persist_s: f64,
    /// How long no frame may be fit to judge `[s]`.
    pub blind_s: f64,
}

impl TryFrom<RawDefectParams> for DefectParams {
    type Error = ParamError;

    fn try_from(raw: RawDefectParams) -> Result<Self, ParamError> {
        Ok(Self {
            persist_s: in_range("persist_s", raw.persist_s, "s", (0.0, 600.0))?,
            blind_s: in_range("blind_s", raw.blind_s, "s", (0.5, 600.0))?,
        })
    }
}
