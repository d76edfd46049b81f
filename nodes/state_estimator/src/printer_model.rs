//! The printer as the estimator sees it: six states, three channels (model book 1.2, 1.5).

use models::bead::stadium;
use models::extruder::StaticLaw;
use models::hotend::{Hotend, Inputs, Thermal};
use models::material::Material;
use models::units::{Kelvin, Seconds};
use nalgebra::SVector;

/// Rounding of a quotient of two spans `[-]`: must not add a substep.
const ROUNDING: f64 = 1e-9;

/// Index of each state.
pub mod state {
    /// Heater block `[K]`.
    pub const BLOCK: usize = 0;
    /// Nozzle `[K]`.
    pub const NOZZLE: usize = 1;
    /// Thermistor `[K]`.
    pub const SENSOR: usize = 2;
    /// Flow at the outlet as filament speed `[m/s]`.
    pub const FLOW: usize = 3;
    /// Share of the motor's feed lost in the drive gear `[-]`.
    pub const SLIP: usize = 4;
    /// Road section over nominal section at the same filament speed `[-]`.
    pub const GAIN: usize = 5;
    /// Number of states.
    pub const COUNT: usize = 6;
}

/// State vector, indexed by [`state`].
pub type State = SVector<f64, { state::COUNT }>;

/// What drives the printer during a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// Electrical heater power `[W]`.
    pub heater_power_w: f64,
    /// Mean speed of the extruder motor as filament speed `[m/s]`, negative in a retraction.
    pub motor_speed_m_s: f64,
    /// Mean speed of the motor's strokes back, as far as they are known beside those forth `[m/s]`, 0 or more: only the latter slip.
    pub back_m_s: f64,
    /// Mean speed of the filament past the encoder `[m/s]`, where it is to be believed rather than motor and slip.
    pub filament_speed_m_s: Option<f64>,
    /// Part fan `[0, 1]`.
    pub fan: f64,
}

/// Path and road at a moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Road {
    /// Path speed `[m/s]`, > 0.
    pub path_speed_m_s: f64,
    /// Height of the road `[m]`, > 0.
    pub height_m: f64,
}

/// Nominal printer and filament: what process and measurements are computed from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrinterModel {
    hotend: Hotend,
    ambient_k: f64,
    filament_area_m2: f64,
    /// Heat that the melt takes away per kelvin and filament speed `[J/(K m)]`.
    melt_j_k_m: f64,
    lag_s: f64,
    substep_s: f64,
}

/// Surroundings and discretisation of a [`PrinterModel`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// Air and filament before the hot end.
    pub ambient: Kelvin,
    /// Section of the nominal filament `[m²]`, > 0.
    pub filament_area_m2: f64,
    /// Longest Euler step of the thermal part, > 0.
    pub substep: Seconds,
}

/// How the flow goes on over a step: from the mean along the melt's law, from what is near it along a line.
///
/// A law whose slope has no bound at rest would throw sigma points on either side of a dry outlet apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Course {
    /// Mean flow at the start `[m/s]`.
    pub(crate) from_m_s: f64,
    /// Filament that comes `[m/s]`.
    pub(crate) filament_m_s: f64,
    /// Mean flow at the end `[m/s]`.
    pub(crate) to_m_s: f64,
    kept: f64,
    taken: f64,
}

impl Course {
    fn at(&self, flow_m_s: f64, filament_m_s: f64) -> f64 {
        self.to_m_s + self.kept * (flow_m_s - self.from_m_s) + self.taken * (filament_m_s - self.filament_m_s)
    }

    /// What one of slip has taken of the flow at the end `[m/s]`, of `before_m_s` at the start: all that went forth at
    /// `forth_m_s` meanwhile, behind the same lag.
    pub(crate) fn slipped(&self, before_m_s: f64, forth_m_s: f64) -> f64 {
        self.kept * before_m_s + self.taken * forth_m_s
    }
}

impl PrinterModel {
    /// Model of a hot end that melts a material; the lag of the flow is the material's.
    #[must_use]
    pub fn new(hotend: &Hotend, material: &Material, setting: Setting) -> Self {
        Self {
            hotend: *hotend,
            ambient_k: setting.ambient.0,
            filament_area_m2: setting.filament_area_m2,
            melt_j_k_m: material.heat_flow_w_k(setting.filament_area_m2),
            lag_s: material.lag_s,
            substep_s: setting.substep.0,
        }
    }

    /// Lag of the outlet flow behind the filament, K of [ADV] (4) `[s]`.
    #[must_use]
    pub fn lag_s(&self) -> f64 {
        self.lag_s
    }

    /// Heater power at full duty `[W]`.
    #[must_use]
    pub fn heater_power_w(&self) -> f64 {
        self.hotend.heater_power_w
    }

    /// State after `dt_s` under a constant drive, the flow along a course found for the mean.
    #[must_use]
    pub fn step_along(&self, x: &State, drive: &Drive, course: &Course, dt_s: f64) -> State {
        let mut next = self.heated(x, drive, dt_s);
        next[state::FLOW] = course.at(x[state::FLOW], self.driven(x, drive));
        next
    }

    /// Course of the flow from the mean on, under a law of the outlet; behind the linear lag without one.
    #[must_use]
    pub fn course(&self, mean: &State, drive: &Drive, law: Option<&StaticLaw>, dt_s: f64) -> Course {
        let from_m_s = mean[state::FLOW];
        let filament_m_s = self.driven(mean, drive);
        let to_m_s = law.map_or_else(
            || lagged(from_m_s, filament_m_s, dt_s, self.lag_s),
            |law| law.flow_after(from_m_s, filament_m_s, Seconds(dt_s), Seconds(self.lag_s)),
        );
        let (kept, taken) = if from_m_s > 0.0 {
            let kept = (-dt_s / self.lag_s).exp();
            (kept, 1.0 - kept)
        } else {
            (1.0, dt_s / self.lag_s)
        };
        Course { from_m_s, filament_m_s, to_m_s, kept, taken }
    }

    /// State after `dt_s` under a constant drive, the flow behind the material's linear lag (model book 1.5).
    #[must_use]
    pub fn step(&self, x: &State, drive: &Drive, dt_s: f64) -> State {
        let mut next = self.heated(x, drive, dt_s);
        next[state::FLOW] = lagged(x[state::FLOW], self.driven(x, drive), dt_s, self.lag_s);
        next
    }

    /// Filament speed `[m/s]` past the encoder, measured where it is told.
    fn driven(&self, x: &State, drive: &Drive) -> f64 {
        drive.filament_speed_m_s.unwrap_or_else(|| self.pushed(x, drive))
    }

    /// Filament speed `[m/s]` past the encoder by motor and slip.
    pub(crate) fn pushed(&self, x: &State, drive: &Drive) -> f64 {
        self.filament_speed(x, drive.motor_speed_m_s + drive.back_m_s) - drive.back_m_s
    }

    /// Temperatures after `dt_s` under a constant drive, in Euler steps (model book 1.5); all else stands.
    fn heated(&self, x: &State, drive: &Drive, dt_s: f64) -> State {
        let inputs = Inputs {
            heater_w: drive.heater_power_w,
            fan: drive.fan,
            ambient_k: self.ambient_k,
            filament_k: self.ambient_k,
            melt_w_k: self.melt_j_k_m * x[state::FLOW].max(0.0),
        };
        let count = (dt_s / self.substep_s - ROUNDING).ceil().max(1.0);
        let step_s = dt_s / count;
        let mut next = *x;
        let mut done = 0.0;
        while done < count {
            let at = Thermal {
                block_k: next[state::BLOCK],
                nozzle_k: next[state::NOZZLE],
                sensor_k: next[state::SENSOR],
            };
            let rates = self.hotend.rhs(at, &inputs);
            next[state::BLOCK] += step_s * rates.block_k;
            next[state::NOZZLE] += step_s * rates.nozzle_k;
            next[state::SENSOR] += step_s * rates.sensor_k;
            done += 1.0;
        }
        next
    }

    /// Filament speed `[m/s]` past the encoder while the motor turns at `motor_speed_m_s`: `(1 - s) v`.
    ///
    /// A stroke back is unloaded and does not slip (model book 1.5).
    #[must_use]
    pub fn filament_speed(&self, x: &State, motor_speed_m_s: f64) -> f64 {
        if motor_speed_m_s > 0.0 { (1.0 - x[state::SLIP]) * motor_speed_m_s } else { motor_speed_m_s }
    }

    /// Width `[m]` of a stadium road from outlet flow and gain: `w = u g A_f / (v h) + h (1 - pi/4)`.
    #[must_use]
    pub fn width(&self, flow_m_s: f64, gain: f64, road: Road) -> f64 {
        let flow_m3_s = flow_m_s.max(0.0) * gain * self.filament_area_m2;
        stadium::width_m(flow_m3_s, road.path_speed_m_s, road.height_m)
    }
}

/// First-order lag of the outlet, exact for a constant filament speed: `K du/dt + u = v`.
///
/// Below zero the state stands for the stroke by which the melt is drawn back: nothing flows, so nothing decays
/// and `K du/dt = v`. A retraction is thus taken back by the same length of filament, as in the plant.
#[must_use]
pub fn lagged(flow_m_s: f64, filament_m_s: f64, dt_s: f64, lag_s: f64) -> f64 {
    let (mut flow_m_s, mut left_s) = (flow_m_s, dt_s);
    if flow_m_s < 0.0 {
        let filled_m_s = flow_m_s + filament_m_s * dt_s / lag_s;
        if filled_m_s <= 0.0 {
            return filled_m_s;
        }
        left_s = filled_m_s * lag_s / filament_m_s;
        flow_m_s = 0.0;
    }
    let settled_m_s = filament_m_s + (flow_m_s - filament_m_s) * (-left_s / lag_s).exp();
    if settled_m_s >= 0.0 {
        return settled_m_s;
    }
    // the outlet runs dry where u reaches zero; from there on the stroke is drawn back
    let dry_s = lag_s * ((flow_m_s - filament_m_s) / -filament_m_s).ln();
    (left_s - dry_s) * filament_m_s / lag_s
}

#[cfg(test)]
pub(crate) mod tests;
