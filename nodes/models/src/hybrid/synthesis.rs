//! The choice of motor step, microsteps and lead for a wanted accuracy, and whether a carriage needs an encoder.
//!
//! Two errors add up. "One microstep" is what the paper varies: a bound of resolution. A real stepper is wrong by about
//! 5 % of a full step besides, whatever its driver divides it into; where both together exceed the target with the finest
//! microstep, only a finer step, a smaller lead or a scale on the carriage helps. With a scale the motor's own error is
//! measured, and the microstep alone is left.

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
    /// Microsteps that meet the target: together with the motors' own error, or alone where an encoder is needed. None
    /// where the driver's most do not: the target is not reachable.
    pub microsteps: Option<Microsteps>,
    /// Worst error of the motors' own `[m]`; none where a combination has no pose.
    pub motor_m: Option<f64>,
    /// Worst error of motors that are wrong by their own error and one of these microsteps `[m]`; none where an encoder is
    /// needed.
    pub sum_m: Option<f64>,
    /// Whether no number of microsteps keeps the target together with the motors' own error: a carriage then needs an
    /// encoder.
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
    drive: (f64, f64),
    target_m: f64,
    most: u32,
) -> Option<Microsteps> {
    microsteps_beside(0.0, stations, drive, target_m, most)
}

/// The same for motors that are wrong by `own_rad` besides; the error is that of both together.
fn microsteps_beside(
    own_rad: f64,
    stations: &[Station<'_>],
    (step_rad, lead_m): (f64, f64),
    target_m: f64,
    most: u32,
) -> Option<Microsteps> {
    let mut count = 1;
    while count <= most {
        let error = AxisError::of_motors(own_rad + step_rad / f64::from(count), lead_m);
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
        Ok(pairs.map(|drive| self.design(stations, drive, target_m)).collect())
    }

    fn design(&self, stations: &[Station<'_>], drive: (f64, f64), target_m: f64) -> Design {
        let (step_rad, lead_m) = drive;
        let (own_rad, most) = (step_rad * self.motor_error, self.microsteps_max);
        let motor_m = worst_m(stations, &AxisError::of_motors(own_rad, lead_m));
        let together = microsteps_beside(own_rad, stations, drive, target_m, most);
        let microsteps = match together {
            Some(Microsteps { count, .. }) => {
                let one = AxisError::of_motors(step_rad / f64::from(count), lead_m);
                worst_m(stations, &one).map(|largest_m| Microsteps { count, largest_m })
            }
            None => microsteps(stations, drive, target_m, most),
        };
        let sum_m = together.map(|found| found.largest_m);
        Design { step_rad, lead_m, microsteps, motor_m, sum_m, encoder: together.is_none() }
    }
}
