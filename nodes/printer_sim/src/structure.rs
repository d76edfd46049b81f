//! The tool head on frame and belts: one resonance along each axis, and blows.
//!
//! ```text
//! y'' = -2 d w (y' - x') - w^2 (y - x)      y tool, x commanded position, w = 2 pi f, d damping ratio
//! z = y - x:  z'' + 2 d w z' + w^2 z = -x'' solved exactly for x'' constant over a step
//! ```

use models::params::{ParamError, in_range, ordered};
use models::units::Seconds;
use serde::Deserialize;
use std::f64::consts::TAU;

/// A resonance along one axis. Built only from a valid [`RawMode`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawMode")]
pub struct Mode {
    frequency_hz: f64,
    damping: f64,
}

/// A resonance as it is written.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "unit, range and meaning stand beside each value in the file")]
pub struct RawMode {
    pub frequency_hz: f64,
    pub damping: f64,
}

impl TryFrom<RawMode> for Mode {
    type Error = ParamError;
    fn try_from(raw: RawMode) -> Result<Self, ParamError> {
        Ok(Self {
            frequency_hz: in_range("frequency_hz", raw.frequency_hz, "Hz", (1.0, 400.0))?,
            // At 1 and above nothing rings: another solution of the equation.
            damping: in_range("damping", raw.damping, "-", (1e-3, 0.9))?,
        })
    }
}

/// Resonances of the tool head: the `structure` block of a plant file.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StructureParams {
    /// Along x.
    pub along_x: Mode,
    /// Along y.
    pub along_y: Mode,
    /// Along z.
    pub along_z: Mode,
}

/// Exact solution of one mode over one step: `(z, z')` to `(z, z')`, about its equilibrium.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Transition {
    keep: f64,
    keep_speed_s: f64,
    turn_1_s: f64,
    turn_speed: f64,
}

impl Mode {
    fn transition(&self, dt: Seconds) -> Transition {
        let omega_1_s = TAU * self.frequency_hz;
        let decay_1_s = self.damping * omega_1_s;
        let ringing_1_s = omega_1_s * (1.0 - self.damping * self.damping).sqrt();
        let (sin, cos) = (ringing_1_s * dt.0).sin_cos();
        let left = (-decay_1_s * dt.0).exp();
        let in_quadrature = decay_1_s / ringing_1_s * sin;
        Transition {
            keep: left * (cos + in_quadrature),
            keep_speed_s: left * sin / ringing_1_s,
            turn_1_s: -left * sin * omega_1_s * omega_1_s / ringing_1_s,
            turn_speed: left * (cos - in_quadrature),
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Axis {
    transition: Transition,
    stiffness_1_s2: f64,
    decay_1_s: f64,
    offset_m: f64,
    offset_m_s: f64,
}

impl Axis {
    fn new(mode: &Mode, dt: Seconds) -> Self {
        let omega_1_s = TAU * mode.frequency_hz;
        Self {
            transition: mode.transition(dt),
            stiffness_1_s2: omega_1_s * omega_1_s,
            decay_1_s: mode.damping * omega_1_s,
            offset_m: 0.0,
            offset_m_s: 0.0,
        }
    }

    /// One step under a commanded acceleration; returns that of the tool `[m/s2]` at the end of it.
    fn step(&mut self, commanded_m_s2: f64) -> f64 {
        let rest_m = -commanded_m_s2 / self.stiffness_1_s2;
        let (by_m, by_m_s, t) = (self.offset_m - rest_m, self.offset_m_s, &self.transition);
        self.offset_m = rest_m + t.keep * by_m + t.keep_speed_s * by_m_s;
        self.offset_m_s = t.turn_1_s * by_m + t.turn_speed * by_m_s;
        -2.0 * self.decay_1_s * self.offset_m_s - self.stiffness_1_s2 * self.offset_m
    }
}

/// The tool head's own motion about its commanded one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Structure {
    params: StructureParams,
    dt: Seconds,
    axes: [Axis; 3],
    velocity_m_s: [f64; 3],
}

impl Structure {
    /// At rest; steps of `dt` cost least.
    #[must_use]
    pub fn new(params: StructureParams, dt: Seconds) -> Self {
        let axes = [params.along_x, params.along_y, params.along_z].map(|mode| Axis::new(&mode, dt));
        Self { params, dt, axes, velocity_m_s: [0.0; 3] }
    }

    /// One step of `dt` at a commanded mean velocity `[m/s]`; returns the tool's acceleration `[m/s2]` at its end.
    ///
    /// A corner's jump of speed is an acceleration over one step: the belts have no corner either.
    pub fn step(&mut self, velocity_m_s: [f64; 3], dt: Seconds) -> [f64; 3] {
        if dt != self.dt {
            self.dt = dt;
            let modes = [self.params.along_x, self.params.along_y, self.params.along_z];
            for (axis, mode) in self.axes.iter_mut().zip(modes) {
                axis.transition = mode.transition(dt);
            }
        }
        let mut tool_m_s2 = [0.0; 3];
        for (index, axis) in self.axes.iter_mut().enumerate() {
            tool_m_s2[index] = axis.step((velocity_m_s[index] - self.velocity_m_s[index]) / dt.0);
        }
        self.velocity_m_s = velocity_m_s;
        tool_m_s2
    }
}

/// What a blow to the tool head looks like: the `impact` block of a plant file. Built only from a valid [`RawImpact`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawImpact")]
pub struct ImpactParams {
    /// Frequency of the wave train `[Hz]`.
    pub frequency_hz: f64,
    /// Its length `[s]`: shortest and longest.
    pub length_s: (f64, f64),
    /// Its peak when a motor skips `[m/s2]`: lowest and highest.
    pub skip_m_s2: (f64, f64),
}

/// Blows as they are written.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "unit, range and meaning stand beside each value in the file")]
pub struct RawImpact {
    pub frequency_hz: f64,
    pub shortest_s: f64,
    pub longest_s: f64,
    pub skip_low_m_s2: f64,
    pub skip_high_m_s2: f64,
}

impl TryFrom<RawImpact> for ImpactParams {
    type Error = ParamError;
    fn try_from(raw: RawImpact) -> Result<Self, ParamError> {
        ordered(("shortest_s", raw.shortest_s), ("longest_s", raw.longest_s))?;
        ordered(("skip_low_m_s2", raw.skip_low_m_s2), ("skip_high_m_s2", raw.skip_high_m_s2))?;
        let length = |name, value| in_range(name, value, "s", (1e-3, 0.1));
        let peak = |name, value| in_range(name, value, "m/s2", (0.0, 200.0));
        Ok(Self {
            frequency_hz: in_range("frequency_hz", raw.frequency_hz, "Hz", (10.0, 500.0))?,
            length_s: (length("shortest_s", raw.shortest_s)?, length("longest_s", raw.longest_s)?),
            skip_m_s2: (
                peak("skip_low_m_s2", raw.skip_low_m_s2)?,
                peak("skip_high_m_s2", raw.skip_high_m_s2)?,
            ),
        })
    }
}

/// One blow: a wave train of the tool head under a sine window, peak in its middle.
///
/// `a(t) = A sin(pi t/T) cos(2 pi f (t - T/2))`, of energy `A^2 T/4`; it has no mean, so that the frame does not move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blow {
    /// When it begins.
    pub start: Seconds,
    /// How long it lasts `[s]`.
    pub length_s: f64,
    /// Peak along each axis `[m/s2]`.
    pub peak_m_s2: [f64; 3],
    /// Frequency of the wave train `[Hz]`.
    pub frequency_hz: f64,
}

impl Blow {
    /// It has passed.
    #[must_use]
    pub fn over(&self, now: Seconds) -> bool {
        (now - self.start).0 >= self.length_s
    }

    /// Acceleration now `[m/s2]`.
    #[must_use]
    pub fn at(&self, now: Seconds) -> [f64; 3] {
        let into_s = (now - self.start).0;
        if !(0.0..self.length_s).contains(&into_s) {
            return [0.0; 3];
        }
        let window = (0.5 * TAU * into_s / self.length_s).sin();
        let wave = (TAU * self.frequency_hz * (into_s - 0.5 * self.length_s)).cos();
        self.peak_m_s2.map(|peak_m_s2| peak_m_s2 * window * wave)
    }
}

#[cfg(test)]
mod tests;
