//! Between messages and the brain's types.

use fdm_loop_msgs::{Header, Temperature, TemperatureReport};
use models::units::{Celsius, Seconds};
use runtime::Reason;
use runtime::wire::{WireError, stamp_from_wire};

use crate::channel::{Refusals, Sample};
use crate::serial_line::Reading;

/// A report as it is: its values are for the brain to judge.
pub(crate) fn report(wire: &TemperatureReport) -> Result<(Seconds, (Seconds, Reading)), WireError> {
    let stamp = stamp_from_wire(&wire.header)?;
    let told = |temp_degc: f64| Some(Celsius(temp_degc));
    let reading =
        Reading { hotend: told(wire.hotend_degc), bed: told(wire.bed_degc), nozzle: told(wire.nozzle_degc) };
    Ok((stamp, (stamp, reading)))
}

/// A checked temperature; the stamp stays the report's.
pub(crate) fn temperature(sample: &Sample, frame: &str) -> Temperature {
    Temperature {
        header: Header { frame_id: frame.to_owned(), ..Header::at(sample.stamp.0) },
        temperature: sample.temp.0,
        variance: sample.variance_k2,
    }
}

/// The brain's counters by the reasons of the diagnostics.
pub(crate) fn reasons(refusals: &Refusals) -> [(Reason, u64); 4] {
    [
        (Reason::NotFinite, refusals.not_finite),
        (Reason::OutOfRange, refusals.out_of_range + refusals.future),
        (Reason::Stale, refusals.stale),
        (Reason::Order, refusals.order),
    ]
}

#[cfg(test)]
#[path = "../../runtime/tests/malformed/storm.rs"]
mod storm;

#[cfg(test)]
mod tests {
    use super::storm::{all, is_a_stamp, storm};
    use super::*;
    use crate::{Channel, Params};

    #[derive(serde::Deserialize)]
    struct File {
        #[serde(rename = "ros__parameters")]
        parameters: Params,
    }

    fn params() -> Params {
        let text = include_str!("../../../config/thermistor.param.yaml");
        let file: std::collections::BTreeMap<String, File> = serde_saphyr::from_str(text).unwrap();
        file.into_values().next().unwrap().parameters
    }

    /// C9: what nobody sends is refused, or a temperature that a table gives.
    #[test]
    fn malformed_reports_end_at_reader_or_brain() {
        let params = params();
        let header = Header::at(12.5);
        let sound = TemperatureReport { header, hotend_degc: 210.0, bed_degc: 60.0, nozzle_degc: 201.0 };
        storm(&sound, report, |(stamp, (_, reading))| {
            let told =
                [(reading.hotend, params.hotend), (reading.bed, params.bed), (reading.nozzle, params.nozzle)];
            let judged = told.map(|(temp, params)| {
                let sample = Channel::new(params).on_report(*stamp, *stamp, temp.unwrap());
                sample.map_or(true, |sample| all(&[sample.temp.0], params.min_c, params.max_c))
            });
            is_a_stamp(*stamp) && judged == [true; 3]
        });
    }
}
