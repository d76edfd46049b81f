//! Speed over one move: a ramp up, a plateau, a ramp down, each at the same acceleration.

use crate::units::Seconds;
use serde::Serialize;

/// Where a move stands at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathState {
    /// Way done since the start of the move `[m]`.
    pub distance_m: f64,
    /// Speed along the path `[m/s]`.
    pub speed_m_s: f64,
    /// Acceleration along the path `[m/s2]`, negative in the ramp down.
    pub acceleration_m_s2: f64,
}

/// Speed profile of one move over its path variable: the way of the tool, or |filament| where only filament moves.
///
/// `v(t)`: `entry -> cruise` in `accel_s`, `cruise` for `cruise_s`, `cruise -> exit` in `decel_s`. In a short move
/// `cruise_m_s` is the peak that is reached, not the wished feed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Trapezoid {
    /// Speed at the start `[m/s]`.
    pub entry_m_s: f64,
    /// Highest speed `[m/s]`.
    pub cruise_m_s: f64,
    /// Speed at the end `[m/s]`.
    pub exit_m_s: f64,
    /// Magnitude of the acceleration in both ramps `[m/s2]`.
    pub acceleration_m_s2: f64,
    /// Length of the ramp up `[s]`.
    pub accel_s: f64,
    /// Length of the plateau `[s]`.
    pub cruise_s: f64,
    /// Length of the ramp down `[s]`.
    pub decel_s: f64,
}

impl Trapezoid {
    /// Fastest profile over `path_m` between two speeds, under a speed and an acceleration limit.
    ///
    /// With `s_up = (c^2 - e^2)/2a`, `s_down = (c^2 - x^2)/2a`: where both fit, the rest is the plateau; else the peak
    /// is `c^2 = a s + (e^2 + x^2)/2`. Callers give reachable speeds: `|e^2 - x^2| <= 2 a s`, `e, x <= c`.
    #[must_use]
    pub fn new(
        path_m: f64,
        (entry_m_s, exit_m_s): (f64, f64),
        limit_m_s: f64,
        acceleration_m_s2: f64,
    ) -> Self {
        let (entry_sq, exit_sq) = (entry_m_s * entry_m_s, exit_m_s * exit_m_s);
        let peak_sq = acceleration_m_s2 * path_m + 0.5 * (entry_sq + exit_sq);
        let cruise_m_s = peak_sq.sqrt().min(limit_m_s).max(entry_m_s).max(exit_m_s);
        let ramps_m = (2.0 * cruise_m_s * cruise_m_s - entry_sq - exit_sq) / (2.0 * acceleration_m_s2);
        let plateau_m = (path_m - ramps_m).max(0.0);
        Self {
            entry_m_s,
            cruise_m_s,
            exit_m_s,
            acceleration_m_s2,
            accel_s: (cruise_m_s - entry_m_s) / acceleration_m_s2,
            cruise_s: if cruise_m_s > 0.0 { plateau_m / cruise_m_s } else { 0.0 },
            decel_s: (cruise_m_s - exit_m_s) / acceleration_m_s2,
        }
    }

    /// Time from start to end.
    #[must_use]
    pub fn duration(&self) -> Seconds {
        Seconds(self.accel_s + self.cruise_s + self.decel_s)
    }

    /// Way from start to end `[m]`.
    #[must_use]
    pub fn path_m(&self) -> f64 {
        0.5 * (self.entry_m_s + self.cruise_m_s) * self.accel_s
            + self.cruise_m_s * self.cruise_s
            + 0.5 * (self.cruise_m_s + self.exit_m_s) * self.decel_s
    }

    /// State at `time` since the start of the move; before the start and past the end the ends are held.
    #[must_use]
    pub fn at(&self, time: Seconds) -> PathState {
        let time_s = time.0.max(0.0);
        if time_s < self.accel_s {
            return ramp(0.0, self.entry_m_s, self.acceleration_m_s2, time_s);
        }
        let ramp_up_m = 0.5 * (self.entry_m_s + self.cruise_m_s) * self.accel_s;
        let on_plateau_s = time_s - self.accel_s;
        if on_plateau_s < self.cruise_s {
            return ramp(ramp_up_m, self.cruise_m_s, 0.0, on_plateau_s);
        }
        let braking_s = (on_plateau_s - self.cruise_s).min(self.decel_s);
        let start_m = ramp_up_m + self.cruise_m_s * self.cruise_s;
        ramp(start_m, self.cruise_m_s, -self.acceleration_m_s2, braking_s)
    }
}

fn ramp(start_m: f64, speed_m_s: f64, acceleration_m_s2: f64, time_s: f64) -> PathState {
    PathState {
        distance_m: start_m + (speed_m_s + 0.5 * acceleration_m_s2 * time_s) * time_s,
        speed_m_s: speed_m_s + acceleration_m_s2 * time_s,
        acceleration_m_s2,
    }
}
