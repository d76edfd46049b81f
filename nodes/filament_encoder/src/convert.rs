//! Between messages and the brain's types.

use fdm_loop_msgs::{FilamentMotion, FilamentReport, Header};
use models::units::Seconds;
use runtime::Reason;
use runtime::wire::{WireError, stamp_from_wire};

use crate::encoder::{Refusals, Sample};

/// Rounding that two writings of the same quantum may differ by `[-]`.
const SAME: f64 = 1e-9;

/// Counts of a report whose quantum is the node's own: other counts mean other lengths.
pub(crate) fn report(wire: &FilamentReport, quantum_m: f64) -> Result<(Seconds, (Seconds, i64)), WireError> {
    let stamp = stamp_from_wire(&wire.header)?;
    let (low, high) = (quantum_m * (1.0 - SAME), quantum_m * (1.0 + SAME));
    if !wire.quantum_m.is_finite() {
        return Err(WireError::NotFinite { field: "quantum_m" });
    }
    if !(low..=high).contains(&wire.quantum_m) {
        return Err(WireError::OutOfRange { field: "quantum_m", value: wire.quantum_m, low, high });
    }
    Ok((stamp, (stamp, wire.counts)))
}

/// A checked position; `None` while no speed is known, since the message has no sign for that.
pub(crate) fn motion(sample: &Sample) -> Option<FilamentMotion> {
    Some(FilamentMotion {
        header: Header { frame_id: "filament".to_owned(), ..Header::at(sample.stamp.0) },
        position_m: sample.position_m,
        speed_m_s: sample.speed_m_s?,
    })
}

/// The brain's counters by the reasons of the diagnostics.
pub(crate) fn reasons(refusals: &Refusals) -> [(Reason, u64); 4] {
    [
        (Reason::NotFinite, refusals.not_finite),
        (Reason::OutOfRange, refusals.future + refusals.step),
        (Reason::Stale, refusals.stale),
        (Reason::Order, refusals.order),
    ]
}

#[cfg(test)]
#[path = "../../runtime/tests/malformed/storm.rs"]
mod storm;

#[cfg(test)]
mod tests {
    use super::storm::{is_a_stamp, storm};
    use super::*;
    use crate::{Encoder, Params};

    #[derive(serde::Deserialize)]
    struct File {
        #[serde(rename = "ros__parameters")]
        parameters: Params,
    }

    fn params() -> Params {
        let text = include_str!("../../../config/filament_encoder.param.yaml");
        let file: std::collections::BTreeMap<String, File> = serde_saphyr::from_str(text).unwrap();
        file.into_values().next().unwrap().parameters
    }

    /// C9: what nobody sends is refused, or moves the filament no faster than the drive can.
    #[test]
    fn malformed_reports_end_at_reader_or_brain() {
        let params = params().encoder;
        let sound = FilamentReport { header: Header::at(12.5), counts: 500, quantum_m: params.quantum_m };
        let read = |wire: &FilamentReport| report(wire, params.quantum_m);
        storm(&sound, read, |(stamp, (_, counts))| {
            let mut encoder = Encoder::new(params);
            encoder.on_counts(*stamp, *stamp, 500).unwrap();
            let next = *stamp + Seconds(0.01);
            let speed = encoder.on_counts(next, next, *counts).ok().and_then(|sample| sample.speed_m_s);
            // One count either way is the quantum, at any speed.
            let fastest_m_s = params.speed_max_m_s.max(params.quantum_m / 0.01) * 1.001;
            is_a_stamp(*stamp) && speed.is_none_or(|speed| speed.abs() <= fastest_m_s)
        });
    }
}
