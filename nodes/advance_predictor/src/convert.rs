//! Between messages and the brain's types.

use fdm_loop_msgs::{AdvancePrediction, Header, MotionSegment, PrinterState};
use models::units::{Celsius, Seconds};
use runtime::wire::{WireError, motion_from_wire, stamp_from_wire};

use crate::compensation::Source;
use crate::predictor::{Event, Output};

/// Highest set-point that is believed `[degC]`.
const TARGET_MAX_C: f64 = 600.0;

/// A move that begins.
pub fn motion(wire: &MotionSegment) -> Result<(Seconds, Event), WireError> {
    let planned = motion_from_wire(wire)?;
    Ok((planned.start, Event::Move(planned.segment)))
}

/// The set-point in force.
pub fn printer(wire: &PrinterState) -> Result<(Seconds, Event), WireError> {
    let stamp = stamp_from_wire(&wire.header)?;
    let value = wire.hotend_target_degc;
    if !value.is_finite() {
        return Err(WireError::NotFinite { field: "hotend_target_degc" });
    }
    if !(0.0..=TARGET_MAX_C).contains(&value) {
        return Err(WireError::OutOfRange {
            field: "hotend_target_degc",
            value,
            low: 0.0,
            high: TARGET_MAX_C,
        });
    }
    Ok((stamp, Event::Target(stamp, Celsius(value))))
}

/// What is known at `now`.
pub fn prediction(now: Seconds, output: &Output) -> AdvancePrediction {
    let mut wire = AdvancePrediction { header: Header::at(now.0), ..AdvancePrediction::default() };
    if let Some(advance) = &output.advance {
        wire.advance_known = true;
        wire.advance_s = advance.advance().0;
        wire.advance_half_width_s = advance.half_width().0;
        wire.advance_linear_s = advance.law.linear_s;
        wire.advance_shear_m = advance.law.shear;
        wire.advance_index = advance.law.index;
        wire.in_hull = advance.prediction.source == Source::Network;
        wire.source = match advance.prediction.source {
            Source::Network => AdvancePrediction::SOURCE_NETWORK,
            Source::Physics => AdvancePrediction::SOURCE_PHYSICS,
        };
        wire.temperature_degc = advance.at.temperature.0;
        wire.layer_height_m = advance.at.height_m;
        wire.line_width_m = advance.at.width_m;
    }
    if let Some(turn) = &output.turn {
        wire.turn_known = true;
        wire.turn_probability = turn.probability;
        wire.turn_expected = output.expected;
        wire.turn_lead_s = turn.lead.0;
        wire.turn_way_m = turn.way_m;
        wire.turn_shown = turn.basis == crate::turn::Basis::Buffer;
        wire.known_way_m = turn.known_m;
    }
    wire
}

#[cfg(test)]
#[path = "../../runtime/tests/malformed/storm.rs"]
mod storm;

#[cfg(test)]
mod tests {
    use super::storm::{all, is_a_stamp, storm};
    use super::*;

    /// C9: what nobody sends is refused, or a set-point that a printer may have.
    #[test]
    fn malformed_states_are_refused() {
        let sound =
            PrinterState { header: Header::at(12.5), hotend_target_degc: 210.0, ..PrinterState::default() };
        storm(&sound, printer, |(stamp, event)| {
            let Event::Target(at, target) = event else { return false };
            is_a_stamp(*stamp) && at == stamp && all(&[target.0], 0.0, TARGET_MAX_C)
        });
    }
}
