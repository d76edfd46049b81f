//! The test line: a stretch at low speed, one at high speed with its ramps inside, one at low speed (model book 2.2).

use serde::Deserialize;

use crate::motion::{PathState, Trapezoid};
use crate::params::{ParamError, in_range, ordered};
use crate::units::Seconds;

/// A test line. Built only from a valid [`RawTestLine`], whose fields it shows.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawTestLine")]
pub struct TestLine(RawTestLine);

read_only!(TestLine(RawTestLine));

/// The `test_line` block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawTestLine {
    /// Low speed `[m/s]`, in `[1e-4, 1]`.
    pub low_m_s: f64,
    /// High speed `[m/s]`, above the low one.
    pub high_m_s: f64,
    /// Acceleration of both ramps `[m/s2]`, in `[0.01, 100]`.
    pub acceleration_m_s2: f64,
    /// Length of each slow stretch `[m]`, in `[1e-4, 10]`.
    pub low_m: f64,
    /// Length of the fast stretch with both ramps `[m]`, in `[1e-4, 10]`; longer than its ramps.
    pub high_m: f64,
}

impl TryFrom<RawTestLine> for TestLine {
    type Error = ParamError;

    fn try_from(raw: RawTestLine) -> Result<Self, ParamError> {
        in_range("test_line.low_m_s", raw.low_m_s, "m/s", (1e-4, 1.0))?;
        in_range("test_line.high_m_s", raw.high_m_s, "m/s", (1e-4, 1.0))?;
        ordered(("test_line.low_m_s", raw.low_m_s), ("test_line.high_m_s", raw.high_m_s))?;
        in_range("test_line.acceleration_m_s2", raw.acceleration_m_s2, "m/s2", (0.01, 100.0))?;
        in_range("test_line.low_m", raw.low_m, "m", (1e-4, 10.0))?;
        in_range("test_line.high_m", raw.high_m, "m", (1e-4, 10.0))?;
        let line = Self(raw);
        ordered(("ramps", 2.0 * line.ramp_m()), ("test_line.high_m", raw.high_m))?;
        Ok(line)
    }
}

impl TestLine {
    fn ramp_s(&self) -> f64 {
        (self.high_m_s - self.low_m_s) / self.acceleration_m_s2
    }

    fn ramp_m(&self) -> f64 {
        0.5 * (self.low_m_s + self.high_m_s) * self.ramp_s()
    }

    /// Length of the plateau at high speed `[m]`.
    #[must_use]
    pub fn plateau_m(&self) -> f64 {
        self.high_m - 2.0 * self.ramp_m()
    }

    /// Time of the plateau.
    #[must_use]
    pub fn plateau(&self) -> Seconds {
        Seconds(self.plateau_m() / self.high_m_s)
    }

    /// Ends of the five parts, slow, ramp, plateau, ramp, slow, from the start of the line `[s]`.
    #[must_use]
    pub fn ends_s(&self) -> [f64; 5] {
        let slow_s = self.low_m / self.low_m_s;
        let parts = [slow_s, self.ramp_s(), self.plateau().0, self.ramp_s(), slow_s];
        let mut end_s = 0.0;
        parts.map(|part_s| {
            end_s += part_s;
            end_s
        })
    }

    /// Speeds at the start and at [`TestLine::ends_s`]; linear in between `[m/s]`.
    #[must_use]
    pub fn knots_m_s(&self) -> [f64; 6] {
        let (low, high) = (self.low_m_s, self.high_m_s);
        [low, low, high, high, low, low]
    }

    /// Way, speed and acceleration of the head at `time` since the start of the line.
    #[must_use]
    pub fn at(&self, time: Seconds) -> PathState {
        let (low_m_s, ends_s) = (self.low_m_s, self.ends_s());
        let fast = Trapezoid::new(self.high_m, (low_m_s, low_m_s), self.high_m_s, self.acceleration_m_s2);
        let slow = |distance_m| PathState { distance_m, speed_m_s: low_m_s, acceleration_m_s2: 0.0 };
        if time.0 < ends_s[0] {
            slow(low_m_s * time.0)
        } else if time.0 < ends_s[3] {
            let state = fast.at(time - Seconds(ends_s[0]));
            PathState { distance_m: self.low_m + state.distance_m, ..state }
        } else {
            slow(self.low_m + self.high_m + low_m_s * (time.0 - ends_s[3]))
        }
    }
}
