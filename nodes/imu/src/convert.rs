//! Between messages and the brain's types.

use fdm_loop_msgs::{Header, Imu, ImuBatch, Quaternion, Vector3};
use models::units::Seconds;
use runtime::Reason;
use runtime::wire::{ImuReading, WireError, imu_to_wire, stamp_from_wire};

use crate::accelerometer::{Checked, Refusals, Report};
use crate::thin::Thinned;

/// Most samples a batch may hold, as `runtime::wire` has it for those who read our batches.
const SAMPLES_MAX: usize = 8192;

/// A report as it is: its values are for the brain to judge, who can tell a wrong unit from a bad sample.
pub(crate) fn report(wire: &ImuBatch) -> Result<(Seconds, Report), WireError> {
    let length = wire.x_m_s2.len();
    if length > SAMPLES_MAX {
        return Err(WireError::Missing { field: "x_m_s2" });
    }
    for (field, axis) in [("y_m_s2", &wire.y_m_s2), ("z_m_s2", &wire.z_m_s2)] {
        if axis.len() != length {
            return Err(WireError::Missing { field });
        }
    }
    let first = stamp_from_wire(&wire.header)?;
    let samples = wire.x_m_s2.iter().zip(&wire.y_m_s2).zip(&wire.z_m_s2);
    let report = Report {
        frame: wire.header.frame_id.clone(),
        first,
        first_sequence: wire.first_sequence,
        period: Seconds(wire.period_s),
        range_m_s2: wire.range_m_s2,
        samples: samples.map(|((x, y), z)| [*x, *y, *z]).collect(),
    };
    Ok((first, report))
}

/// A checked batch; stamps and sequence stay the report's.
pub(crate) fn batch(checked: Checked) -> ImuBatch {
    let Report { frame, first, first_sequence, period, range_m_s2, samples } = checked.report;
    imu_to_wire(&ImuReading { first, first_sequence, period, range_m_s2, samples }, &frame)
}

/// A sample for tools. REP 145: what is not measured has -1 in the first element of its covariance.
pub(crate) fn thinned(thinned: &Thinned, frame: &str) -> Imu {
    let mut unknown = [0.0; 9];
    unknown[0] = -1.0;
    let mut covariance = [0.0; 9];
    for axis in 0..3 {
        covariance[4 * axis] = thinned.variance_m2_s4;
    }
    let [x, y, z] = thinned.mean_m_s2;
    Imu {
        header: Header { frame_id: frame.to_owned(), ..Header::at(thinned.stamp.0) },
        orientation: Quaternion { w: 1.0, ..Quaternion::default() },
        orientation_covariance: unknown,
        angular_velocity: Vector3::default(),
        angular_velocity_covariance: unknown,
        linear_acceleration: Vector3 { x, y, z },
        linear_acceleration_covariance: covariance,
    }
}

/// The brain's counters by the reasons of the diagnostics.
pub(crate) fn reasons(refusals: &Refusals) -> [(Reason, u64); 5] {
    let range = refusals.out_of_range + refusals.future + refusals.period + refusals.untrue;
    [
        (Reason::NotFinite, refusals.not_finite),
        (Reason::OutOfRange, range),
        (Reason::Stale, refusals.stale),
        (Reason::Order, refusals.order),
        (Reason::Malformed, refusals.empty + refusals.frame),
    ]
}

#[cfg(test)]
#[path = "../../runtime/tests/malformed/storm.rs"]
mod storm;

#[cfg(test)]
mod tests {
    use super::storm::{all, is_a_stamp, storm};
    use super::*;
    use crate::{Accelerometer, Params};

    #[derive(serde::Deserialize)]
    struct File {
        #[serde(rename = "ros__parameters")]
        parameters: Params,
    }

    fn params() -> Params {
        let text = include_str!("../../../config/imu.param.yaml");
        let file: std::collections::BTreeMap<String, File> = serde_saphyr::from_str(text).unwrap();
        file.into_values().next().unwrap().parameters
    }

    /// C9: what nobody sends is refused, or does not pass a unit that has proven nothing yet; before one that has, it is
    /// refused or has samples within the range of the unit.
    #[test]
    fn malformed_reports_end_at_reader_or_brain() {
        let params = params().unit;
        let rest = |count: usize| vec![0.0; count];
        let sound = ImuBatch {
            header: Header { frame_id: "imu".into(), ..Header::at(12.5) },
            period_s: 1e-3,
            range_m_s2: 156.9064,
            x_m_s2: rest(50),
            y_m_s2: rest(50),
            z_m_s2: vec![9.81; 50],
            ..ImuBatch::default()
        };
        let proven = {
            let mut unit = Accelerometer::new(params.clone());
            for index in 0..21_u32 {
                let at_s = 11.45 + 0.05 * f64::from(index);
                let wire = ImuBatch {
                    header: Header { frame_id: "imu".into(), ..Header::at(at_s) },
                    first_sequence: u64::from(index) * 50,
                    ..sound.clone()
                };
                _ = unit.on_report(Seconds(at_s + 0.05), report(&wire).unwrap().1);
            }
            unit
        };
        let taken = proven.clone().on_report(Seconds(12.55), report(&sound).unwrap().1);
        assert!(taken.is_ok(), "a proven unit takes a sound batch: {taken:?}");
        storm(&sound, report, |(stamp, read)| {
            let checked = proven.clone().on_report(Seconds(12.55), read.clone());
            let limit = params.range_m_s2;
            is_a_stamp(*stamp)
                && read.samples.len() <= SAMPLES_MAX
                && checked.map_or(true, |checked| {
                    checked.report.samples.iter().all(|sample| all(sample, -limit, limit))
                })
        });
    }

    /// REP 145: an accelerometer alone says that it knows neither orientation nor angular velocity.
    #[test]
    fn what_is_not_measured_is_marked() {
        let sample = Thinned { stamp: Seconds(2.5), mean_m_s2: [1.0, 2.0, 9.8], variance_m2_s4: 0.009 };
        let wire = thinned(&sample, "imu");
        assert_eq!((wire.orientation_covariance[0], wire.angular_velocity_covariance[0]), (-1.0, -1.0));
        let expected = [0.009, 0.0, 0.0, 0.0, 0.009, 0.0, 0.0, 0.0, 0.009];
        let covariance = wire.linear_acceleration_covariance;
        assert!(covariance.iter().zip(expected).all(|(value, wanted)| (value - wanted).abs() < 1e-15));
        assert_eq!((wire.linear_acceleration.z, wire.header.frame_id.as_str()), (9.8, "imu"));
    }

    #[test]
    fn axes_of_different_lengths_are_no_report() {
        let wire = ImuBatch {
            x_m_s2: vec![0.0; 3],
            y_m_s2: vec![0.0; 3],
            z_m_s2: vec![0.0; 2],
            ..ImuBatch::default()
        };
        assert_eq!(report(&wire).unwrap_err(), WireError::Missing { field: "z_m_s2" });
    }
}
