//! `MotionTrim`: moves count from 1 on the wire, as in `MotionSegment`, from 0 in the brains.

use super::command::{ADVANCE_S, FACTOR, VALIDITY_S};
use super::{WireError, within};
use fdm_loop_msgs::{Header, MotionTrim as Message};
use models::command::{AdvanceLaw, MotionTrim, Scheduled};
use models::units::Seconds;

/// Scale of the melt's part `[m (s/m)^n]`.
const SHEAR: (f64, f64) = (0.0, 10.0);
/// Flow index of the melt `[-]`.
const INDEX: (f64, f64) = (0.0, 1.0);

/// Filament that is held without an advance that pushed it `[m]`.
const CARRIED_M: (f64, f64) = (0.0, 0.01);

/// A trim of a coming move.
///
/// # Errors
/// [`WireError`] for a value that is not finite or out of the range of the definition.
pub fn schedule_from_wire(wire: &Message) -> Result<Scheduled, WireError> {
    let advance = AdvanceLaw {
        linear_s: within("advance_linear_s", wire.advance_linear_s, ADVANCE_S)?,
        shear: within("advance_shear_m", wire.advance_shear_m, SHEAR)?,
        index: within("advance_index", wire.advance_index, INDEX)?,
    };
    let no_move = WireError::OutOfRange { field: "segment", value: 0.0, low: 1.0, high: f64::INFINITY };
    Ok(Scheduled {
        session: wire.session_id,
        sequence: wire.sequence,
        validity: Seconds(within("validity_s", wire.validity_s, VALIDITY_S)?),
        trim: MotionTrim {
            sequence: wire.segment.checked_sub(1).ok_or(no_move)?,
            flow: within("flow_factor", wire.flow_factor, FACTOR)?,
            speed: within("speed_factor", wire.speed_factor, FACTOR)?,
            advance,
            carried_m: within("advance_carried_m", wire.advance_carried_m, CARRIED_M)?,
        },
    })
}

/// A trim of a coming move as sent at `now`.
#[must_use]
pub fn schedule_to_wire(now: Seconds, scheduled: &Scheduled) -> Message {
    let Scheduled { session, sequence, validity, trim } = scheduled;
    Message {
        header: Header::at(now.0),
        session_id: *session,
        sequence: *sequence,
        validity_s: validity.0,
        segment: trim.sequence.saturating_add(1),
        flow_factor: trim.flow,
        speed_factor: trim.speed,
        advance_linear_s: trim.advance.linear_s,
        advance_shear_m: trim.advance.shear,
        advance_index: trim.advance.index,
        advance_carried_m: trim.carried_m,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scheduled() -> Scheduled {
        let advance = AdvanceLaw { linear_s: 0.4, shear: 2e-3, index: 0.4 };
        let trim = MotionTrim { sequence: 0, flow: 1.1, speed: 0.9, advance, carried_m: 1.5e-3 };
        Scheduled { session: 7, sequence: 3, validity: Seconds(5.0), trim }
    }

    #[test]
    fn a_trim_survives_the_wire_and_its_move_has_the_number_that_is_published() {
        let wire = schedule_to_wire(Seconds(1.0), &scheduled());
        assert_eq!(wire.segment, 1);
        assert_eq!(schedule_from_wire(&wire), Ok(scheduled()));
    }

    #[test]
    fn what_cannot_be_is_refused_by_name() {
        type Poison = fn(&mut Message);
        let poisons: [(&str, Poison); 9] = [
            ("validity_s", |wire| wire.validity_s = f64::NAN),
            ("flow_factor", |wire| wire.flow_factor = 11.0),
            ("speed_factor", |wire| wire.speed_factor = f64::INFINITY),
            ("advance_linear_s", |wire| wire.advance_linear_s = -0.1),
            ("advance_shear_m", |wire| wire.advance_shear_m = f64::NAN),
            ("advance_index", |wire| wire.advance_index = 1.1),
            ("advance_carried_m", |wire| wire.advance_carried_m = -1e-4),
            ("advance_carried_m", |wire| wire.advance_carried_m = f64::NAN),
            ("segment", |wire| wire.segment = 0),
        ];
        for (field, poison) in poisons {
            let mut wire = schedule_to_wire(Seconds(1.0), &scheduled());
            poison(&mut wire);
            let said = schedule_from_wire(&wire).unwrap_err().to_string();
            assert!(said.starts_with(field), "{said} is not {field}");
        }
    }
}
