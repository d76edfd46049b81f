//! Every number of the node, as in `config/imu.param.yaml`.

use models::params::{ParamError, frame_name, in_range, ordered};
use serde::Deserialize;

use crate::axis::{Axis, Mounting};

/// What may change while the node is active: how a sample is judged, not where it comes from or how it is thinned out.
pub const LIVE: [&str; 4] =
    ["unit.sigma_m_s2", "unit.rate_tolerance", "unit.gravity_tolerance", "unit.tilt_max_deg"];

/// All parameters.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Where the samples come from.
    pub driver: Driver,
    /// The industrial I/O device, for the driver `iio`.
    pub iio: IioParams,
    /// The unit itself.
    pub unit: UnitParams,
}

/// Where the samples come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Driver {
    /// Reports of the printer, over a topic: from a bridge or the simulator.
    Printer,
    /// A buffer of Linux industrial I/O.
    Iio,
}

/// A device of Linux industrial I/O.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawIioParams")]
pub struct IioParams {
    /// Folder of the devices.
    pub devices: String,
    /// Folder of the device files.
    pub device_files: String,
    /// Name of the device, as its file `name` has it.
    pub name: String,
    /// Which axis of the sensor is x, y and z of the tool.
    pub axes: Mounting,
    /// Time between two batches `[s]`.
    pub batch_s: f64,
    /// Silence after which the device is opened anew `[s]`.
    pub silence_max_s: f64,
    /// First pause after the device was lost `[s]`; it doubles with each try.
    pub retry_min_s: f64,
    /// Longest pause `[s]`.
    pub retry_max_s: f64,
}

/// As [`IioParams`], as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "as the checked struct")]
pub struct RawIioParams {
    pub devices: String,
    pub device_files: String,
    pub name: String,
    pub axes: [AxisName; 3],
    pub batch_s: f64,
    pub silence_max_s: f64,
    pub retry_min_s: f64,
    pub retry_max_s: f64,
}

/// An axis by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub struct AxisName(pub Axis);

impl TryFrom<String> for AxisName {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        Axis::parse(&text).map(Self).ok_or_else(|| format!("{text} is no axis: x, y, z, -x, -y or -z"))
    }
}

impl TryFrom<RawIioParams> for IioParams {
    type Error = ParamError;

    fn try_from(raw: RawIioParams) -> Result<Self, ParamError> {
        ordered(("retry_min_s", raw.retry_min_s), ("retry_max_s", raw.retry_max_s))?;
        Ok(Self {
            devices: raw.devices,
            device_files: raw.device_files,
            name: raw.name,
            axes: Mounting::new(raw.axes.map(|axis| axis.0))?,
            batch_s: in_range("batch_s", raw.batch_s, "s", (0.005, 0.5))?,
            silence_max_s: in_range("silence_max_s", raw.silence_max_s, "s", (0.2, 60.0))?,
            retry_min_s: in_range("retry_min_s", raw.retry_min_s, "s", (0.01, 60.0))?,
            retry_max_s: in_range("retry_max_s", raw.retry_max_s, "s", (0.01, 600.0))?,
        })
    }
}

/// The unit: what it must show, and how stale it may be.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawUnitParams")]
pub struct UnitParams {
    /// Frame of the samples.
    pub frame: Frame,
    /// Axis that shows gravity's reaction while the tool is upright.
    pub up: Axis,
    /// Samples a second `[Hz]`.
    pub rate_hz: f64,
    /// How far rates may differ from it `[-]`.
    pub rate_tolerance: f64,
    /// Largest magnitude an axis can show `[m/s2]`.
    pub range_m_s2: f64,
    /// Noise of a sample, standard deviation `[m/s2]`.
    pub sigma_m_s2: f64,
    /// Time over which unit, axis and rate are judged `[s]`.
    pub window_s: f64,
    /// How far the mean may be from gravity `[-]`.
    pub gravity_tolerance: f64,
    /// How far it may lean `[deg]`.
    pub tilt_max_deg: f64,
    /// Samples a second for tools `[Hz]`.
    pub output_hz: f64,
    /// How far ahead of the clock a stamp may be `[s]`.
    pub stamp_future_max_s: f64,
    /// How old the newest sample of a batch may be `[s]`.
    pub stamp_age_max_s: f64,
    /// Silence after which the unit counts as lost `[s]`.
    pub lost_after_s: f64,
}

/// Name of a frame; clones are cheap enough.
pub type Frame = std::sync::Arc<str>;

/// As [`UnitParams`], as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "as the checked struct")]
pub struct RawUnitParams {
    pub frame: String,
    pub up: AxisName,
    pub rate_hz: f64,
    pub rate_tolerance: f64,
    pub range_m_s2: f64,
    pub sigma_m_s2: f64,
    pub window_s: f64,
    pub gravity_tolerance: f64,
    pub tilt_max_deg: f64,
    pub output_hz: f64,
    pub stamp_future_max_s: f64,
    pub stamp_age_max_s: f64,
    pub lost_after_s: f64,
}

impl TryFrom<RawUnitParams> for UnitParams {
    type Error = ParamError;

    fn try_from(raw: RawUnitParams) -> Result<Self, ParamError> {
        Ok(Self {
            frame: frame_name("frame", raw.frame)?.into(),
            up: raw.up.0,
            rate_hz: in_range("rate_hz", raw.rate_hz, "Hz", (20.0, 8000.0))?,
            rate_tolerance: in_range("rate_tolerance", raw.rate_tolerance, "-", (0.001, 0.5))?,
            range_m_s2: in_range("range_m_s2", raw.range_m_s2, "m/s2", (15.0, 4000.0))?,
            sigma_m_s2: in_range("sigma_m_s2", raw.sigma_m_s2, "m/s2", (0.001, 10.0))?,
            window_s: in_range("window_s", raw.window_s, "s", (0.2, 10.0))?,
            gravity_tolerance: in_range("gravity_tolerance", raw.gravity_tolerance, "-", (0.02, 0.5))?,
            tilt_max_deg: in_range("tilt_max_deg", raw.tilt_max_deg, "deg", (2.0, 44.0))?,
            output_hz: in_range("output_hz", raw.output_hz, "Hz", (1.0, 100.0))?,
            stamp_future_max_s: in_range("stamp_future_max_s", raw.stamp_future_max_s, "s", (0.0, 10.0))?,
            stamp_age_max_s: in_range("stamp_age_max_s", raw.stamp_age_max_s, "s", (0.01, 60.0))?,
            lost_after_s: in_range("lost_after_s", raw.lost_after_s, "s", (0.05, 60.0))?,
        })
    }
}
