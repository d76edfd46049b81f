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
    use crate::compensation::Prediction;
    use crate::predictor::Advance;
    use crate::turn::{Basis, Foresight};
    use models::advance::Condition;
    use models::command::AdvanceLaw;

    /// Every number stands in its own field; what is not known is said so.
    #[test]
    fn what_is_known_is_said_field_by_field() {
        let advance = Advance {
            prediction: Prediction {
                advance: Seconds(0.6),
                half_width: Seconds(0.02),
                source: Source::Network,
            },
            at: Condition { temperature: Celsius(215.0), height_m: 2e-4, width_m: 4e-4 },
            law: AdvanceLaw { linear_s: 0.44, shear: 0.003, index: 0.55 },
            speeds: 1.5,
        };
        let turn = Foresight {
            probability: 0.8,
            lead: Seconds(0.06),
            way_m: 0.003,
            basis: Basis::Buffer,
            known_m: 0.002,
        };
        let output = Output { advance: Some(advance), turn: Some(turn), expected: true };
        let said = prediction(Seconds(12.5), &output);
        assert_eq!(said.header, Header::at(12.5));
        let close = |said: f64, meant: f64| assert!((said - meant).abs() < 1e-12, "{said} {meant}");
        close(said.advance_s, 0.9);
        close(said.advance_half_width_s, 0.03);
        for (said, meant) in [
            (said.advance_linear_s, 0.44),
            (said.advance_shear_m, 0.003),
            (said.advance_index, 0.55),
            (said.temperature_degc, 215.0),
            (said.layer_height_m, 2e-4),
            (said.line_width_m, 4e-4),
            (said.turn_probability, 0.8),
            (said.turn_lead_s, 0.06),
            (said.turn_way_m, 0.003),
            (said.known_way_m, 0.002),
        ] {
            close(said, meant);
        }
        assert!(said.advance_known && said.in_hull && said.source == AdvancePrediction::SOURCE_NETWORK);
        assert!(said.turn_known && said.turn_expected && said.turn_shown);
        let physics = Prediction { source: Source::Physics, ..advance.prediction };
        let turn = Foresight { basis: Basis::Network, ..turn };
        let advance = Some(Advance { prediction: physics, ..advance });
        let said = prediction(Seconds(12.5), &Output { advance, turn: Some(turn), expected: false });
        assert!(!said.in_hull && said.source == AdvancePrediction::SOURCE_PHYSICS);
        assert!(said.turn_known && !said.turn_expected && !said.turn_shown);
        let nothing = prediction(Seconds(12.5), &Output { advance: None, turn: None, expected: false });
        assert!(!nothing.advance_known && !nothing.turn_known);
    }

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
