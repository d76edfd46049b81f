//! `ControlCommand` as a controller's wish and as a supervisor's permit.

use super::{WireError, within};
use fdm_loop_msgs::{ControlCommand, Header};
use models::command::{Command, ControlHealth, Mode, Permit, Request, Trims};
use models::units::Seconds;

/// Ranges of the definition; what a printer or a supervisor allows is narrower and its own affair.
pub(super) const FACTOR: (f64, f64) = (0.0, 10.0);
const OFFSET_K: (f64, f64) = (-300.0, 300.0);
pub(super) const ADVANCE_S: (f64, f64) = (0.0, 10.0);
const SLIP: (f64, f64) = (-0.2, 0.99);
pub(super) const VALIDITY_S: (f64, f64) = (1e-3, 60.0);

/// A controller's wish.
///
/// # Errors
/// [`WireError`] for a value that is not finite or out of the range of the definition.
pub fn command_from_wire(wire: &ControlCommand) -> Result<Command, WireError> {
    Ok(Command {
        session: wire.session_id,
        sequence: wire.sequence,
        validity: Seconds(within("validity_s", wire.validity_s, VALIDITY_S)?),
        trims: trims_from_wire(wire)?,
    })
}

/// What the controller says of the work behind its wish.
///
/// # Errors
/// [`WireError`] for an unknown code.
pub fn control_health_from_wire(wire: &ControlCommand) -> Result<ControlHealth, WireError> {
    ControlHealth::from_code(wire.health).ok_or(unknown("health", wire.health, 4.0))
}

/// A supervisor's permit.
///
/// # Errors
/// [`WireError`] for a value that is not finite, out of the range of the definition, or an unknown mode or request.
pub fn permit_from_wire(wire: &ControlCommand) -> Result<Permit, WireError> {
    Ok(Permit {
        session: wire.session_id,
        sequence: wire.sequence,
        validity: Seconds(within("validity_s", wire.validity_s, VALIDITY_S)?),
        mode: mode_from_wire(wire.mode)?,
        request: request_from_wire(wire.request)?,
        trims: trims_from_wire(wire)?,
    })
}

/// A wish as sent at `now`.
#[must_use]
pub fn command_to_wire(now: Seconds, command: &Command) -> ControlCommand {
    permit_to_wire(
        now,
        &Permit {
            session: command.session,
            sequence: command.sequence,
            validity: command.validity,
            mode: Mode::Init,
            request: Request::Run,
            trims: command.trims,
        },
    )
}

/// A permit as sent at `now`.
#[must_use]
pub fn permit_to_wire(now: Seconds, permit: &Permit) -> ControlCommand {
    let trims = &permit.trims;
    ControlCommand {
        header: Header::at(now.0),
        session_id: permit.session,
        sequence: permit.sequence,
        validity_s: permit.validity.0,
        mode: permit.mode as u8,
        request: permit.request as u8,
        flow_factor: trims.flow,
        speed_factor: trims.speed,
        nozzle_setpoint_offset_k: trims.setpoint_offset_k,
        set_advance: trims.advance_s.is_some(),
        advance_s: trims.advance_s.unwrap_or(0.0),
        close_extruder_loop: trims.slip.is_some(),
        slip_compensation: trims.slip.unwrap_or(0.0),
        health: ControlHealth::Sound as u8,
    }
}

pub(super) fn trims_from_wire(wire: &ControlCommand) -> Result<Trims, WireError> {
    // A value whose flag is not set is no command, but NaN in it tells of a broken sender all the same.
    let advance_s = within("advance_s", wire.advance_s, ADVANCE_S)?;
    let slip = within("slip_compensation", wire.slip_compensation, SLIP)?;
    Ok(Trims {
        flow: within("flow_factor", wire.flow_factor, FACTOR)?,
        speed: within("speed_factor", wire.speed_factor, FACTOR)?,
        setpoint_offset_k: within("nozzle_setpoint_offset_k", wire.nozzle_setpoint_offset_k, OFFSET_K)?,
        advance_s: wire.set_advance.then_some(advance_s),
        slip: wire.close_extruder_loop.then_some(slip),
    })
}

fn mode_from_wire(value: u8) -> Result<Mode, WireError> {
    const MODES: [Mode; 8] = [
        Mode::Init,
        Mode::Observe,
        Mode::Advise,
        Mode::Act,
        Mode::Degraded,
        Mode::Paused,
        Mode::SafeOff,
        Mode::Estop,
    ];
    MODES.get(usize::from(value)).copied().ok_or(unknown("mode", value, 7.0))
}

fn request_from_wire(value: u8) -> Result<Request, WireError> {
    const REQUESTS: [Request; 5] =
        [Request::Run, Request::Pause, Request::Standby, Request::HeatersOff, Request::EmergencyStop];
    REQUESTS.get(usize::from(value)).copied().ok_or(unknown("request", value, 4.0))
}

pub(super) fn unknown(field: &'static str, value: u8, high: f64) -> WireError {
    WireError::OutOfRange { field, value: f64::from(value), low: 0.0, high }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn permit() -> Permit {
        Permit {
            session: 7,
            sequence: 3,
            validity: Seconds(0.25),
            mode: Mode::Act,
            request: Request::Standby,
            trims: Trims {
                flow: 1.1,
                speed: 0.9,
                setpoint_offset_k: -2.0,
                advance_s: Some(0.6),
                slip: Some(0.09),
            },
        }
    }

    #[test]
    fn a_permit_survives_the_wire() {
        assert_eq!(permit_from_wire(&permit_to_wire(Seconds(1.0), &permit())), Ok(permit()));
        let neutral = Permit { trims: Trims::NEUTRAL, ..permit() };
        assert_eq!(permit_from_wire(&permit_to_wire(Seconds(1.0), &neutral)), Ok(neutral));
    }

    #[test]
    fn every_float_that_is_not_a_number_is_refused_by_name() {
        type Poison = fn(&mut ControlCommand);
        let poisons: [(&str, Poison); 6] = [
            ("validity_s", |wire| wire.validity_s = f64::NAN),
            ("flow_factor", |wire| wire.flow_factor = f64::INFINITY),
            ("speed_factor", |wire| wire.speed_factor = f64::NAN),
            ("nozzle_setpoint_offset_k", |wire| wire.nozzle_setpoint_offset_k = f64::NAN),
            ("advance_s", |wire| wire.advance_s = f64::NAN),
            ("slip_compensation", |wire| wire.slip_compensation = f64::NEG_INFINITY),
        ];
        for (field, poison) in poisons {
            let mut wire = permit_to_wire(Seconds(1.0), &permit());
            poison(&mut wire);
            assert_eq!(permit_from_wire(&wire), Err(WireError::NotFinite { field }));
            assert_eq!(command_from_wire(&wire), Err(WireError::NotFinite { field }));
        }
    }

    #[test]
    fn unknown_modes_and_requests_are_refused() {
        let mut wire = permit_to_wire(Seconds(1.0), &permit());
        wire.mode = 8;
        assert!(permit_from_wire(&wire).is_err());
        wire.mode = 0;
        wire.request = 5;
        assert!(permit_from_wire(&wire).is_err());
    }
}
