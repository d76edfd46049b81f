//! The choice of motor step, microsteps and lead for a wanted accuracy, and whether a carriage needs an encoder.
//!
//! Two models of error stand side by side. "One microstep" is what the paper varies: a bound of resolution. A real
//! stepper is wrong by about 5 % of a full step, whatever its driver divides it into; where that alone exceeds the
//! target no microstepping helps, only a finer step, a smaller lead or a scale on the carriage.

use serde::Deserialize;

use super::error::AxisError;
use super::kinematics::Station;
use crate::params::{ParamError, in_range, positive};

/// Motors and screws to choose from. Built only from valid [`RawChoices`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawChoices")]
pub struct Choices(RawChoices);

read_only!(Choices(RawChoices));

/// The `synthesis` block of `config/machines/*.yaml` as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawChoices {
    /// Full steps of motors `[rad]`, each above 0.
    pub steps_rad: Vec<f64>,
    /// Leads of screws or belts `[m]`, each above 0.
    pub leads_m: Vec<f64>,
    /// Most microsteps of a driver, `[1, 65536]`; powers of two up to it are tried.
    pub microsteps_max: u32,
    /// A motor's own error in parts of a full step `[-]`, in `[0, 1]`.
    pub motor_error: f64,
}

impl TryFrom<RawChoices> for Choices {
    type Error = ParamError;

    fn try_from(raw: RawChoices) -> Result<Self, ParamError> {
        for step_rad in &raw.steps_rad {
            positive("steps_rad", *step_rad, "rad")?;
        }
        for lead_m in &raw.leads_m {
            positive("leads_m", *lead_m, "m")?;
        }
        in_range("microsteps_max", f64::from(raw.microsteps_max), "-", (1.0, 65_536.0))?;
        in_range("motor_error", raw.motor_error, "-", (0.0, 1.0))?;
        Ok(Self(raw))
    }
}

/// The fewest microsteps that meet a target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Microsteps {
    /// Microsteps per full step, a power of two.
    pub count: u32,
    /// Worst error of one microstep `[m]`.
    pub largest_m: f64,
}

/// One motor with one lead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Design {
    /// Full step `[rad]`.
    pub step_rad: f64,
    /// Travel per turn `[m]`.
    pub lead_m: f64,
    /// Microsteps that meet the target; none where the driver's most do not.
    pub microsteps: Option<Microsteps>,
    /// Worst error of the motors' own `[m]`; none where a combination has no pose.
    pub motor_m: Option<f64>,
    /// Whether the motors' own error is above the target: a carriage then needs an encoder.
    pub encoder: bool,
}

/// Worst error over the stations; none where a combination has no pose on the nominal branch.
fn worst_m(stations: &[Station<'_>], error: &AxisError) -> Option<f64> {
    let mut worst_m = 0.0_f64;
    for station in stations {
        let extremal = station.extremal(error);
        if extremal.failed > 0 {
            return None;
        }
        worst_m = worst_m.max(extremal.largest_m);
    }
    Some(worst_m)
}

/// Smallest power of two of microsteps with every worst error of one microstep at most `target_m`.
#[must_use]
pub fn microsteps(
    stations: &[Station<'_>],
    (step_rad, lead_m): (f64, f64),
    target_m: f64,
    most: u32,
) -> Option<Microsteps> {
    let mut count = 1;
    while count <= most {
        let error = AxisError::of_motors(step_rad / f64::from(count), lead_m);
        match worst_m(stations, &error) {
            Some(largest_m) if largest_m <= target_m => return Some(Microsteps { count, largest_m }),
            _ => count *= 2,
        }
    }
    None
}

/// Error of a carriage that keeps every station within `target_m`, first order, the table without error `[m]`:
/// `delta <= target/sum|G|`. What a scale on the carriage has to resolve.
#[must_use]
pub fn carriage_error_m(stations: &[Station<'_>], target_m: f64) -> Option<f64> {
    let gains = stations.iter().map(|station| station.gain().carriage_sum());
    gains.reduce(f64::max).map(|largest| target_m / largest)
}

impl Choices {
    /// Every motor with every lead, judged at the stations.
    ///
    /// # Errors
    /// [`ParamError::OutOfRange`] for a target not above 0.
    pub fn designs(&self, stations: &[Station<'_>], target_m: f64) -> Result<Vec<Design>, ParamError> {
        positive("target_m", target_m, "m")?;
        let pairs =
            self.steps_rad.iter().flat_map(|step| self.leads_m.iter().map(move |lead| (*step, *lead)));
        Ok(pairs
            .map(|(step_rad, lead_m)| {
                let own = AxisError::of_motors(step_rad * self.motor_error, lead_m);
                let motor_m = worst_m(stations, &own);
                Design {
                    step_rad,
                    lead_m,
                    microsteps: microsteps(stations, (step_rad, lead_m), target_m, self.microsteps_max),
                    motor_m,
                    encoder: motor_m.is_none_or(|error_m| error_m > target_m),
                }
            })
            .collect())
    }
}
