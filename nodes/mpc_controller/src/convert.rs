//! Between messages and the brain's types.

use fdm_loop_msgs::{BeadWidth, FilamentMotion, LayerHeight, PrinterState, StateEstimate};
use models::units::Seconds;
use runtime::Reason;
use runtime::wire::{self, WireError};

use crate::input::{Estimate, Event, Refused};
use crate::wire::{Measured, WireEvent};

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

/// A height; layers count from 0 on the wire, from 1 in the profile.
pub(crate) fn height(message: &LayerHeight) -> Result<(Seconds, WireEvent), WireError> {
    let read = wire::layer_height_from_wire(message)?;
    let measured = Measured {
        stamp: read.stamp,
        layer: read.layer.saturating_add(1),
        position_m: read.along_m,
        height_m: read.height_m,
    };
    Ok((read.stamp, WireEvent::Height(measured)))
}

pub(crate) fn wire_printer(message: &PrinterState) -> Result<(Seconds, WireEvent), WireError> {
    let status = wire::status_from_wire(message)?;
    Ok((status.stamp, WireEvent::Printer(Box::new(status))))
}

/// The brain's counters by the reasons of the diagnostics.
pub(crate) fn reasons(refused: &Refused) -> [(Reason, u64); 2] {
    [(Reason::OutOfRange, refused.invalid), (Reason::Order, refused.late)]
}
