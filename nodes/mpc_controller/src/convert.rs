//! Between messages and the brain's types.

use fdm_loop_msgs::{BeadWidth, FilamentMotion, PrinterState, StateEstimate};
use models::units::Seconds;
use runtime::Reason;
use runtime::wire::{self, WireError};

use crate::input::{Estimate, Event, Refused};

pub(crate) fn estimate(message: &StateEstimate) -> Result<(Seconds, Event), WireError> {
    let read = wire::estimate_from_wire(message)?;
    let estimate = Estimate {
        stamp: read.stamp,
        nozzle: read.nozzle,
        // At rest the estimate scatters around zero; control knows no flow backwards.
        flow_m_s: read.flow_m_s.max(0.0),
        slip: read.slip,
        gain: read.gain,
        reference_feed_m_s: read.reference_feed_m_s,
        encoder_alive: read.encoder_alive,
    };
    Ok((read.stamp, Event::Estimate(estimate)))
}

pub(crate) fn printer(message: &PrinterState) -> Result<(Seconds, Event), WireError> {
    let status = wire::status_from_wire(message)?;
    Ok((status.stamp, Event::Printer(status)))
}

pub(crate) fn encoder(message: &FilamentMotion) -> Result<(Seconds, Event), WireError> {
    let read = wire::filament_from_wire(message)?;
    Ok((read.stamp, Event::Encoder { stamp: read.stamp, position_m: read.position_m }))
}

pub(crate) fn width(message: &BeadWidth) -> Result<(Seconds, Event), WireError> {
    let read = wire::bead_width_from_wire(message)?;
    Ok((read.exposed, Event::Width { exposed: read.exposed, width_m: read.width_m }))
}

/// The brain's counters by the reasons of the diagnostics.
pub(crate) fn reasons(refused: &Refused) -> [(Reason, u64); 2] {
    [(Reason::OutOfRange, refused.invalid), (Reason::Order, refused.late)]
}
