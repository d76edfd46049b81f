//! What the printer tells of itself.

use models::params::{ParamError, in_range};
use models::status::PrinterStatus;
use serde::Deserialize;

/// The printer's own telemetry.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawTelemetry {
    /// Beyond this age of the newest status nothing is estimated `[s]`.
    pub age_limit_s: f64,
    /// A gap longer than this starts the filter anew `[s]`.
    pub restart_s: f64,
    /// Samples may be stamped this far ahead of the tick `[s]`.
    pub lead_limit_s: f64,
    /// Fastest credible motor `[m/s]`; a faster jump is a new count.
    pub motor_speed_max_m_s: f64,
    /// Revolutions of the part fan at full flow `[1/s]`: what its tachometer shows, where it has one, counts.
    pub part_fan_full_1_s: f64,
}

impl RawTelemetry {
    /// Share of the part fan's full flow `[0, 1]`: by its tachometer, else as it is told.
    pub(crate) fn part_fan(&self, status: &PrinterStatus) -> f64 {
        let shown = status.part_fan_speed_1_s.map(|speed_1_s| speed_1_s / self.part_fan_full_1_s);
        shown.map_or(status.fan, |share| share.clamp(0.0, 1.0))
    }
}

pub(super) fn check_telemetry(raw: &RawTelemetry) -> Result<(), ParamError> {
    in_range("telemetry.age_limit_s", raw.age_limit_s, "s", (0.02, 5.0))?;
    in_range("telemetry.restart_s", raw.restart_s, "s", (0.1, 60.0))?;
    in_range("telemetry.lead_limit_s", raw.lead_limit_s, "s", (0.0, 5.0))?;
    in_range("telemetry.motor_speed_max_m_s", raw.motor_speed_max_m_s, "m/s", (0.01, 2.0))?;
    in_range("telemetry.part_fan_full_1_s", raw.part_fan_full_1_s, "1/s", (1.0, 2000.0))?;
    Ok(())
}
