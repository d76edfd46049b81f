//! Range and slew of trims. A value out of range is clamped and flagged, a value that is not finite is refused.

use serde::Deserialize;

use super::Trims;
use crate::params::{ParamError, in_range, ordered};
use crate::units::Seconds;

/// Slip below this is none `[-]`: the ramp's last step sets the trim free.
const SLIP_NONE: f64 = 1e-9;

/// Allowed range and slew of one trim; unit of the trim, slew per second.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Band {
    min: f64,
    max: f64,
    slew_per_s: f64,
}

impl Band {
    fn clamp(&self, value: f64) -> (f64, bool) {
        let kept = value.clamp(self.min, self.max);
        (kept, !(self.min..=self.max).contains(&value))
    }

    fn slew(&self, from: f64, to: f64, dt_s: f64) -> (f64, bool) {
        let step_max = self.slew_per_s * dt_s;
        if (to - from).abs() <= step_max { (to, false) } else { (from + step_max.copysign(to - from), true) }
    }
}

/// Envelope of trims. Built only from valid [`RawLimits`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawLimits")]
pub struct Limits {
    flow: Band,
    speed: Band,
    setpoint_offset_k: Band,
    advance_s: Band,
    slip: Band,
    validity_max_s: f64,
}

/// The `limits` block of a parameter file as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawLimits {
    /// Lowest flow trim `[-]`, at most 1.
    pub flow_min: f64,
    /// Highest flow trim `[-]`, at least 1.
    pub flow_max: f64,
    /// Fastest change of the flow trim `[1/s]`.
    pub flow_slew_1_s: f64,
    /// Lowest speed trim `[-]`, at most 1.
    pub speed_min: f64,
    /// Highest speed trim `[-]`, at least 1.
    pub speed_max: f64,
    /// Fastest change of the speed trim `[1/s]`.
    pub speed_slew_1_s: f64,
    /// Lowest set-point offset `[K]`, at most 0.
    pub setpoint_offset_min_k: f64,
    /// Highest set-point offset `[K]`, at least 0.
    pub setpoint_offset_max_k: f64,
    /// Fastest change of the set-point offset `[K/s]`.
    pub setpoint_offset_slew_k_s: f64,
    /// Highest pressure advance `[s]`; the lowest is 0.
    pub advance_max_s: f64,
    /// Fastest change of the pressure advance `[s/s]`.
    pub advance_slew_s_s: f64,
    /// Lowest slip made up for `[-]`, at most 0.
    pub slip_min: f64,
    /// Highest slip made up for `[-]`, below 1.
    pub slip_max: f64,
    /// Fastest change of the slip trim `[1/s]`.
    pub slip_slew_1_s: f64,
    /// Longest validity that is accepted `[s]`.
    pub validity_max_s: f64,
}

impl TryFrom<RawLimits> for Limits {
    type Error = ParamError;

    fn try_from(raw: RawLimits) -> Result<Self, ParamError> {
        ordered(("flow_min", raw.flow_min), ("flow_max", raw.flow_max))?;
        ordered(("speed_min", raw.speed_min), ("speed_max", raw.speed_max))?;
        Ok(Self {
            flow: Band {
                min: in_range("flow_min", raw.flow_min, "-", (0.1, 1.0))?,
                max: in_range("flow_max", raw.flow_max, "-", (1.0, 2.0))?,
                slew_per_s: in_range("flow_slew_1_s", raw.flow_slew_1_s, "1/s", (0.01, 10.0))?,
            },
            speed: Band {
                min: in_range("speed_min", raw.speed_min, "-", (0.1, 1.0))?,
                max: in_range("speed_max", raw.speed_max, "-", (1.0, 2.0))?,
                slew_per_s: in_range("speed_slew_1_s", raw.speed_slew_1_s, "1/s", (0.01, 10.0))?,
            },
            setpoint_offset_k: Band {
                min: in_range("setpoint_offset_min_k", raw.setpoint_offset_min_k, "K", (-30.0, 0.0))?,
                max: in_range("setpoint_offset_max_k", raw.setpoint_offset_max_k, "K", (0.0, 30.0))?,
                slew_per_s: in_range(
                    "setpoint_offset_slew_k_s",
                    raw.setpoint_offset_slew_k_s,
                    "K/s",
                    (0.1, 100.0),
                )?,
            },
            advance_s: Band {
                min: 0.0,
                max: in_range("advance_max_s", raw.advance_max_s, "s", (0.0, 5.0))?,
                slew_per_s: in_range("advance_slew_s_s", raw.advance_slew_s_s, "s/s", (0.01, 20.0))?,
            },
            slip: Band {
                min: in_range("slip_min", raw.slip_min, "-", (-0.2, 0.0))?,
                max: in_range("slip_max", raw.slip_max, "-", (0.0, 0.9))?,
                slew_per_s: in_range("slip_slew_1_s", raw.slip_slew_1_s, "1/s", (0.01, 20.0))?,
            },
            validity_max_s: in_range("validity_max_s", raw.validity_max_s, "s", (0.01, 10.0))?,
        })
    }
}

/// Which trims a limit has moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Changed {
    /// Flow.
    pub flow: bool,
    /// Speed.
    pub speed: bool,
    /// Set-point offset.
    pub setpoint_offset: bool,
    /// Pressure advance.
    pub advance: bool,
    /// Slip.
    pub slip: bool,
}

impl Changed {
    /// Whether any trim was moved.
    #[must_use]
    pub fn any(&self) -> bool {
        self.flow || self.speed || self.setpoint_offset || self.advance || self.slip
    }
}

/// Trims inside the limits, and what had to be moved to get there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clamped {
    /// The trims to use.
    pub trims: Trims,
    /// What was moved.
    pub changed: Changed,
}

/// A trim was NaN or infinite: nothing to clamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a trim is not finite")]
pub struct NotFinite;

impl Limits {
    /// Lowest speed trim `[-]`.
    #[must_use]
    pub fn speed_min(&self) -> f64 {
        self.speed.min
    }

    /// Longest validity that is accepted.
    #[must_use]
    pub fn validity_max(&self) -> Seconds {
        Seconds(self.validity_max_s)
    }

    /// Moves each trim to the nearest allowed value.
    ///
    /// # Errors
    /// [`NotFinite`] if a trim is NaN or infinite: such trims are refused whole.
    pub fn clamp(&self, trims: &Trims) -> Result<Clamped, NotFinite> {
        if !trims.is_finite() {
            return Err(NotFinite);
        }
        let (flow, flow_changed) = self.flow.clamp(trims.flow);
        let (speed, speed_changed) = self.speed.clamp(trims.speed);
        let (setpoint_offset_k, offset_changed) = self.setpoint_offset_k.clamp(trims.setpoint_offset_k);
        let advance = trims.advance_s.map(|value| self.advance_s.clamp(value));
        let slip = trims.slip.map(|value| self.slip.clamp(value));
        Ok(Clamped {
            trims: Trims {
                flow,
                speed,
                setpoint_offset_k,
                advance_s: advance.map(|(value, _)| value),
                slip: slip.map(|(value, _)| value),
            },
            changed: Changed {
                flow: flow_changed,
                speed: speed_changed,
                setpoint_offset: offset_changed,
                advance: advance.is_some_and(|(_, changed)| changed),
                slip: slip.is_some_and(|(_, changed)| changed),
            },
        })
    }

    /// Moves from one set of trims towards another, each no faster than its slew. Both must be finite.
    ///
    /// Slip `None` counts as zero: it starts from there, and is set free once back there. The file's own advance
    /// is not known here, so that trim is taken and released in one step. A span that is not positive moves nothing.
    #[must_use]
    pub fn slew(&self, from: &Trims, to: &Trims, dt: Seconds) -> Clamped {
        let dt_s = dt.0.max(0.0);
        let (flow, flow_changed) = self.flow.slew(from.flow, to.flow, dt_s);
        let (speed, speed_changed) = self.speed.slew(from.speed, to.speed, dt_s);
        let (setpoint_offset_k, offset_changed) =
            self.setpoint_offset_k.slew(from.setpoint_offset_k, to.setpoint_offset_k, dt_s);
        let (advance_s, advance_changed) = match (from.advance_s, to.advance_s) {
            (Some(start_s), Some(end_s)) => {
                let (value_s, changed) = self.advance_s.slew(start_s, end_s, dt_s);
                (Some(value_s), changed)
            }
            (_, end) => (end, false),
        };
        let (slip, slip_changed) = self.slip.slew(from.slip.unwrap_or(0.0), to.slip.unwrap_or(0.0), dt_s);
        let slip_set = to.slip.is_some() || slip.abs() > SLIP_NONE;
        Clamped {
            trims: Trims { flow, speed, setpoint_offset_k, advance_s, slip: slip_set.then_some(slip) },
            changed: Changed {
                flow: flow_changed,
                speed: speed_changed,
                setpoint_offset: offset_changed,
                advance: advance_changed,
                slip: slip_changed,
            },
        }
    }
}

impl Trims {
    /// The way back to the slicer's values: a straight line from `self` that ends after `within`.
    ///
    /// The advance is the file's own from the first moment, since no ramp to an unknown value can be drawn.
    #[must_use]
    pub fn ramp_to_neutral(&self, elapsed: Seconds, within: Seconds) -> Self {
        let left = 1.0 - elapsed.0 / within.0;
        if !(left > 0.0 && within.0 > 0.0) {
            return Self::NEUTRAL;
        }
        let left = left.min(1.0);
        Self {
            flow: 1.0 + (self.flow - 1.0) * left,
            speed: 1.0 + (self.speed - 1.0) * left,
            setpoint_offset_k: self.setpoint_offset_k * left,
            advance_s: None,
            slip: self.slip.map(|slip| slip * left),
        }
    }
}

#[cfg(test)]
#[path = "limits_tests.rs"]
pub(super) mod tests;
