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
    let reading = Reading { hotend: Some(Celsius(wire.hotend_degc)), bed: Some(Celsius(wire.bed_degc)) };
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
