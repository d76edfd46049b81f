//! `ImuBatch`.

use super::{WireError, stamp_from_wire, within};
use fdm_loop_msgs::{Header, ImuBatch};
use models::units::Seconds;

/// Samples of one batch, evenly spaced.
#[derive(Debug, Clone, PartialEq)]
pub struct ImuReading {
    /// Time of the first sample.
    pub first: Seconds,
    /// Number of the first sample since start.
    pub first_sequence: u64,
    /// Time between two samples.
    pub period: Seconds,
    /// Largest magnitude an axis can show `[m/s2]`.
    pub range_m_s2: f64,
    /// Accelerations x, y, z, gravity included `[m/s2]`.
    pub samples: Vec<[f64; 3]>,
}

/// Most samples a batch may hold: a second at the fastest rate in use.
const SAMPLES_MAX: usize = 8192;
/// Largest range of any accelerometer in use `[m/s2]`: 400 g.
const RANGE_MAX_M_S2: f64 = 4000.0;

/// A batch of accelerations.
///
/// # Errors
/// [`WireError`] for a value that is not finite or beyond the stated range, axes of different lengths, no sample or
/// too many, a period that is none.
pub fn imu_from_wire(wire: &ImuBatch) -> Result<ImuReading, WireError> {
    let length = wire.x_m_s2.len();
    if length == 0 || length > SAMPLES_MAX {
        return Err(WireError::Missing { field: "x_m_s2" });
    }
    for (field, axis) in [("y_m_s2", &wire.y_m_s2), ("z_m_s2", &wire.z_m_s2)] {
        if axis.len() != length {
            return Err(WireError::Missing { field });
        }
    }
    let range_m_s2 = within("range_m_s2", wire.range_m_s2, (1e-3, RANGE_MAX_M_S2))?;
    let bound = (-range_m_s2, range_m_s2);
    let mut samples = Vec::with_capacity(length);
    for ((x, y), z) in wire.x_m_s2.iter().zip(&wire.y_m_s2).zip(&wire.z_m_s2) {
        samples.push([
            within("x_m_s2", *x, bound)?,
            within("y_m_s2", *y, bound)?,
            within("z_m_s2", *z, bound)?,
        ]);
    }
    Ok(ImuReading {
        first: stamp_from_wire(&wire.header)?,
        first_sequence: wire.first_sequence,
        period: Seconds(within("period_s", wire.period_s, (1e-6, 1.0))?),
        range_m_s2,
        samples,
    })
}

/// A batch as sent; samples at the range are counted.
#[must_use]
pub fn imu_to_wire(reading: &ImuReading, frame: &str) -> ImuBatch {
    let axis = |index: usize| reading.samples.iter().map(|sample| sample[index]).collect();
    let at_range = |sample: &&[f64; 3]| sample.iter().any(|value| value.abs() >= reading.range_m_s2);
    ImuBatch {
        header: Header { frame_id: frame.to_owned(), ..Header::at(reading.first.0) },
        first_sequence: reading.first_sequence,
        period_s: reading.period.0,
        range_m_s2: reading.range_m_s2,
        saturated: u32::try_from(reading.samples.iter().filter(at_range).count()).unwrap_or(u32::MAX),
        x_m_s2: axis(0),
        y_m_s2: axis(1),
        z_m_s2: axis(2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reading() -> ImuReading {
        ImuReading {
            first: Seconds(1.5),
            first_sequence: 7,
            period: Seconds(1e-3),
            range_m_s2: 156.9,
            samples: vec![[0.0, 1.0, 9.81], [156.9, 0.0, 9.81]],
        }
    }

    #[test]
    fn a_batch_comes_back_as_it_went() {
        let wire = imu_to_wire(&reading(), "imu");
        assert_eq!((wire.saturated, wire.header.frame_id.as_str()), (1, "imu"));
        assert_eq!(imu_from_wire(&wire).unwrap(), reading());
    }

    #[test]
    fn what_cannot_be_is_refused_by_name() {
        type Poison = fn(&mut ImuBatch);
        let poisons: [(&str, Poison); 6] = [
            ("z_m_s2 is not finite", |wire| wire.z_m_s2[1] = f64::NAN),
            ("x_m_s2 = 200: must be in", |wire| wire.x_m_s2[0] = 200.0),
            ("y_m_s2 is missing or of a wrong length", |wire| wire.y_m_s2.clear()),
            ("x_m_s2 is missing", |wire| wire.x_m_s2.clear()),
            ("period_s = 0: must be in", |wire| wire.period_s = 0.0),
            ("range_m_s2 = 0: must be in", |wire| wire.range_m_s2 = 0.0),
        ];
        for (text, poison) in poisons {
            let mut wire = imu_to_wire(&reading(), "imu");
            poison(&mut wire);
            let said = imu_from_wire(&wire).unwrap_err().to_string();
            assert!(said.starts_with(text), "{said} is not {text}");
        }
    }
}
