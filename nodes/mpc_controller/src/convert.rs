//! Between messages and the brain's types.

use fdm_loop_msgs::{
    AdvancePrediction, BeadWidth, FilamentMotion, LayerHeight, MotionSegment, PrinterState, StateEstimate,
};
use models::command::AdvanceLaw;
use models::units::Seconds;
use runtime::Reason;
use runtime::wire::{self, WireError};

use crate::advance::{Basis, Foretold, Prediction, Turn};
use crate::input::{Coming, Estimate, Event, Refused};
use crate::wire::{Measured, WireEvent};

/// Highest advance that is believed `[s]`, as in commands.
const ADVANCE_MAX_S: f64 = 10.0;

pub fn estimate(message: &StateEstimate) -> Result<(Seconds, Event), WireError> {
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
        width_alive: read.width_alive,
    };
    Ok((read.stamp, Event::Estimate(estimate)))
}

pub fn printer(message: &PrinterState) -> Result<(Seconds, Event), WireError> {
    let status = wire::status_from_wire(message)?;
    Ok((status.stamp, Event::Printer(status)))
}

pub fn encoder(message: &FilamentMotion) -> Result<(Seconds, Event), WireError> {
    let read = wire::filament_from_wire(message)?;
    Ok((read.stamp, Event::Encoder { stamp: read.stamp, position_m: read.position_m }))
}

pub fn width(message: &BeadWidth) -> Result<(Seconds, Event), WireError> {
    let read = wire::bead_width_from_wire(message)?;
    Ok((read.exposed, Event::Width { exposed: read.exposed, width_m: read.width_m }))
}

/// A move that is known before it begins, with its number; the brain counts from 0.
pub fn coming(message: &MotionSegment) -> Result<(Seconds, Coming), WireError> {
    let read = wire::motion_from_wire(message)?;
    let no_move = WireError::OutOfRange { field: "sequence", value: 0.0, low: 1.0, high: f64::INFINITY };
    let sequence = read.sequence.checked_sub(1).ok_or(no_move)?;
    Ok((read.start, Coming { sequence, start: Seconds(read.path_time_s), segment: read.segment }))
}

/// A word of the advance predictor; what a flag declares unknown is not read.
pub fn prediction(message: &AdvancePrediction) -> Result<(Seconds, Event), WireError> {
    let stamp = wire::stamp_from_wire(&message.header)?;
    let advance = message.advance_known.then_some(message).map(foretold).transpose()?;
    let turn = message.turn_known.then_some(message).map(turn).transpose()?;
    Ok((stamp, Event::Prediction(Prediction { stamp, advance, turn })))
}

fn foretold(message: &AdvancePrediction) -> Result<Foretold, WireError> {
    Ok(Foretold {
        advance_s: within("advance_s", message.advance_s, ADVANCE_MAX_S)?,
        half_width_s: within("advance_half_width_s", message.advance_half_width_s, ADVANCE_MAX_S)?,
        law: AdvanceLaw {
            linear_s: within("advance_linear_s", message.advance_linear_s, ADVANCE_MAX_S)?,
            shear: within("advance_shear_m", message.advance_shear_m, ADVANCE_MAX_S)?,
            index: within("advance_index", message.advance_index, 1.0)?,
        },
        basis: match message.source {
            AdvancePrediction::SOURCE_NETWORK => Basis::Network,
            AdvancePrediction::SOURCE_PHYSICS => Basis::Physics,
            other => {
                return Err(WireError::OutOfRange {
                    field: "source",
                    value: f64::from(other),
                    low: 0.0,
                    high: 1.0,
                });
            }
        },
    })
}

fn turn(message: &AdvancePrediction) -> Result<Turn, WireError> {
    // Without a turn in sight the time to it means nothing.
    let lead_s =
        if message.turn_expected { within("turn_lead_s", message.turn_lead_s, f64::MAX)? } else { 0.0 };
    Ok(Turn {
        probability: within("turn_probability", message.turn_probability, 1.0)?,
        expected: message.turn_expected,
        lead: Seconds(lead_s),
    })
}

fn within(field: &'static str, value: f64, high: f64) -> Result<f64, WireError> {
    if !value.is_finite() {
        return Err(WireError::NotFinite { field });
    }
    if !(0.0..=high).contains(&value) {
        return Err(WireError::OutOfRange { field, value, low: 0.0, high });
    }
    Ok(value)
}

/// A height; layers count from 0 on the wire, from 1 in the profile.
pub fn height(message: &LayerHeight) -> Result<(Seconds, WireEvent), WireError> {
    let read = wire::layer_height_from_wire(message)?;
    let measured = Measured {
        stamp: read.stamp,
        layer: read.layer.saturating_add(1),
        position_m: read.along_m,
        height_m: read.height_m,
    };
    Ok((read.stamp, WireEvent::Height(measured)))
}

pub fn wire_printer(message: &PrinterState) -> Result<(Seconds, WireEvent), WireError> {
    let status = wire::status_from_wire(message)?;
    Ok((status.stamp, WireEvent::Printer(Box::new(status))))
}

/// The brain's counters by the reasons of the diagnostics.
pub fn reasons(refused: &Refused) -> [(Reason, u64); 2] {
    [(Reason::OutOfRange, refused.invalid), (Reason::Order, refused.late)]
}

#[cfg(test)]
#[path = "../../runtime/tests/malformed/storm.rs"]
mod storm;

#[cfg(test)]
mod tests {
    use super::storm::{all, is_a_stamp, storm};
    use super::*;
    use fdm_loop_msgs::Header;

    /// C9: what nobody sends is refused, or an advance that a printer may have.
    #[test]
    fn malformed_predictions_are_refused() {
        let sound = AdvancePrediction {
            header: Header::at(12.5),
            advance_known: true,
            advance_s: 0.5,
            advance_half_width_s: 0.1,
            advance_linear_s: 0.4,
            advance_shear_m: 1e-3,
            advance_index: 0.5,
            turn_known: true,
            turn_expected: true,
            turn_probability: 0.5,
            turn_lead_s: 0.3,
            ..AdvancePrediction::default()
        };
        storm(&sound, prediction, |(stamp, event)| {
            let Event::Prediction(read) = event else { return false };
            let advance = read.advance.as_ref();
            let turn = read.turn.as_ref();
            is_a_stamp(*stamp)
                && advance.is_none_or(|read| {
                    let law = [read.law.linear_s, read.law.shear];
                    all(&[read.advance_s, read.half_width_s], 0.0, ADVANCE_MAX_S)
                        && all(&law, 0.0, ADVANCE_MAX_S)
                        && all(&[read.law.index], 0.0, 1.0)
                })
                && turn.is_none_or(|read| all(&[read.probability], 0.0, 1.0) && read.lead.0.is_finite())
        });
    }
}
