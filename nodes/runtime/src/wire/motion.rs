//! `MotionSegment`.

use super::{WireError, finite, optional, stamp_from_wire, within};
use fdm_loop_msgs::{Header, MotionSegment};
use models::motion::{MoveKind, Role, Segment, Trapezoid};
use models::units::Seconds;

/// A move as published.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlannedMove {
    /// Time of its publication, which is its start at the executor.
    pub start: Seconds,
    /// Its start on the slicer's own plan `[s]`.
    pub path_time_s: f64,
    /// Number since the start of the print.
    pub sequence: u64,
    /// The move; the slicer's stated width is not sent, and chords of arcs are not marked.
    pub segment: Segment,
}

/// Farthest place and longest move that any printer has `[m]`.
const FAR_M: f64 = 100.0;
/// Longest part of one move `[s]`.
const LONG_S: f64 = 1e5;
/// Longest plan `[s]`: 30 years.
const PLAN_S: f64 = 1e9;

/// A move.
///
/// # Errors
/// [`WireError`] for a value that is not finite or out of range, and an unknown kind or role.
pub fn motion_from_wire(wire: &MotionSegment) -> Result<PlannedMove, WireError> {
    let place = |field, values: &[f64; 3]| {
        values.iter().try_for_each(|value| within(field, *value, (-FAR_M, FAR_M)).map(drop)).map(|()| *values)
    };
    let speed = |field, value| within(field, value, (0.0, 10.0));
    let lasts = |field, value| within(field, value, (0.0, LONG_S));
    let (accel_s, decel_s) =
        (lasts("accelerate_s", wire.accelerate_s)?, lasts("decelerate_s", wire.decelerate_s)?);
    let entry_m_s = speed("entry_speed_m_s", wire.entry_speed_m_s)?;
    let cruise_m_s = speed("cruise_speed_m_s", wire.cruise_speed_m_s)?;
    let exit_m_s = speed("exit_speed_m_s", wire.exit_speed_m_s)?;
    let ramp = |change_m_s: f64, time_s: f64| if time_s > 0.0 { change_m_s / time_s } else { 0.0 };
    let up_m_s2 = ramp(cruise_m_s - entry_m_s, accel_s);
    let down_m_s2 = ramp(cruise_m_s - exit_m_s, decel_s);
    // Of a speed changed in next to no time nothing finite is left.
    let acceleration_m_s2 = finite("accelerate_s", if accel_s > 0.0 { up_m_s2 } else { down_m_s2 })?;
    let road = |known, field, value| optional(known, field, value, (0.0, 0.1));
    Ok(PlannedMove {
        start: stamp_from_wire(&wire.header)?,
        path_time_s: within("start_time_s", wire.start_time_s, (0.0, PLAN_S))?,
        sequence: wire.sequence,
        segment: Segment {
            line: wire.line,
            layer: wire.layer_known.then_some(wire.layer),
            start_m: place("start_m", &wire.start_m)?,
            end_m: place("end_m", &wire.end_m)?,
            length_m: within("length_m", wire.length_m, (0.0, FAR_M))?,
            filament_m: within("filament_m", wire.filament_m, (-FAR_M, FAR_M))?,
            kind: kind_from_wire(wire.kind)?,
            role: role_from_wire(wire.role)?,
            arc: false,
            target_width_m: road(wire.target_width_known, "target_width_m", wire.target_width_m)?,
            stated_width_m: None,
            layer_height_m: road(wire.target_height_known, "target_height_m", wire.target_height_m)?,
            profile: Trapezoid {
                entry_m_s,
                cruise_m_s,
                exit_m_s,
                acceleration_m_s2,
                accel_s,
                cruise_s: lasts("cruise_s", wire.cruise_s)?,
                decel_s,
            },
        },
    })
}

/// A move as sent: `start` on the node's clock, `path_time_s` on the slicer's plan.
#[must_use]
pub fn motion_to_wire(start: Seconds, path_time_s: f64, sequence: u64, segment: &Segment) -> MotionSegment {
    let profile = &segment.profile;
    MotionSegment {
        header: Header::at(start.0),
        sequence,
        start_time_s: path_time_s,
        line: segment.line,
        layer_known: segment.layer.is_some(),
        layer: segment.layer.unwrap_or(0),
        kind: kind_to_wire(segment.kind),
        role: role_to_wire(segment.role),
        start_m: segment.start_m,
        end_m: segment.end_m,
        length_m: segment.length_m,
        entry_speed_m_s: profile.entry_m_s,
        cruise_speed_m_s: profile.cruise_m_s,
        exit_speed_m_s: profile.exit_m_s,
        accelerate_s: profile.accel_s,
        cruise_s: profile.cruise_s,
        decelerate_s: profile.decel_s,
        filament_m: segment.filament_m,
        target_width_known: segment.target_width_m.is_some(),
        target_width_m: segment.target_width_m.unwrap_or(0.0),
        target_height_known: segment.layer_height_m.is_some(),
        target_height_m: segment.layer_height_m.unwrap_or(0.0),
    }
}

fn kind_to_wire(kind: MoveKind) -> u8 {
    match kind {
        MoveKind::Travel => MotionSegment::KIND_TRAVEL,
        MoveKind::Deposit => MotionSegment::KIND_DEPOSIT,
        MoveKind::Retract => MotionSegment::KIND_RETRACT,
        MoveKind::Prime => MotionSegment::KIND_PRIME,
        MoveKind::Wipe => MotionSegment::KIND_WIPE,
    }
}

fn kind_from_wire(kind: u8) -> Result<MoveKind, WireError> {
    use MoveKind::{Deposit, Prime, Retract, Travel, Wipe};
    let known =
        [Travel, Deposit, Retract, Prime, Wipe].into_iter().find(|known| kind_to_wire(*known) == kind);
    known.ok_or(WireError::OutOfRange { field: "kind", value: f64::from(kind), low: 0.0, high: 4.0 })
}

fn role_from_wire(role: u8) -> Result<Role, WireError> {
    const ALL: [Role; 14] = [
        Role::Unknown,
        Role::Custom,
        Role::Skirt,
        Role::ExternalPerimeter,
        Role::Perimeter,
        Role::Overhang,
        Role::Infill,
        Role::Solid,
        Role::TopSolid,
        Role::Bridge,
        Role::GapFill,
        Role::Support,
        Role::Ironing,
        Role::Tower,
    ];
    let known = ALL.into_iter().find(|known| role_to_wire(*known) == role);
    known.ok_or(WireError::OutOfRange { field: "role", value: f64::from(role), low: 0.0, high: 13.0 })
}

fn role_to_wire(role: Role) -> u8 {
    match role {
        Role::Unknown => MotionSegment::ROLE_UNKNOWN,
        Role::Custom => MotionSegment::ROLE_CUSTOM,
        Role::Skirt => MotionSegment::ROLE_SKIRT,
        Role::ExternalPerimeter => MotionSegment::ROLE_EXTERNAL_PERIMETER,
        Role::Perimeter => MotionSegment::ROLE_PERIMETER,
        Role::Overhang => MotionSegment::ROLE_OVERHANG,
        Role::Infill => MotionSegment::ROLE_INFILL,
        Role::Solid => MotionSegment::ROLE_SOLID,
        Role::TopSolid => MotionSegment::ROLE_TOP_SOLID,
        Role::Bridge => MotionSegment::ROLE_BRIDGE,
        Role::GapFill => MotionSegment::ROLE_GAP_FILL,
        Role::Support => MotionSegment::ROLE_SUPPORT,
        Role::Ironing => MotionSegment::ROLE_IRONING,
        Role::Tower => MotionSegment::ROLE_TOWER,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment() -> Segment {
        Segment {
            line: 12,
            layer: Some(3),
            start_m: [0.01, 0.02, 0.0008],
            end_m: [0.03, 0.02, 0.0008],
            length_m: 0.02,
            filament_m: 6e-4,
            kind: MoveKind::Deposit,
            role: Role::Perimeter,
            arc: false,
            target_width_m: Some(4.5e-4),
            stated_width_m: None,
            layer_height_m: Some(2e-4),
            profile: Trapezoid::new(0.02, (0.005, 0.0), 0.05, 1.0),
        }
    }

    #[test]
    fn a_move_comes_back_as_it_went() {
        let wire = motion_to_wire(Seconds(7.25), 5.5, 42, &segment());
        let back = motion_from_wire(&wire).unwrap();
        assert_eq!((back.start, back.path_time_s, back.sequence), (Seconds(7.25), 5.5, 42));
        let accel_m_s2 = back.segment.profile.acceleration_m_s2;
        assert!((accel_m_s2 - 1.0).abs() < 1e-12, "{accel_m_s2}");
        let mut same = back.segment;
        same.profile.acceleration_m_s2 = 1.0;
        assert_eq!(same, segment());
    }

    #[test]
    fn what_cannot_be_is_refused_by_name() {
        type Poison = fn(&mut MotionSegment);
        let poisons: [(&str, Poison); 4] = [
            ("kind = 9", |wire| wire.kind = 9),
            ("role = 99", |wire| wire.role = 99),
            ("end_m is not finite", |wire| wire.end_m[2] = f64::NAN),
            ("target_width_m = 1", |wire| wire.target_width_m = 1.0),
        ];
        for (text, poison) in poisons {
            let mut wire = motion_to_wire(Seconds(1.0), 0.0, 0, &segment());
            poison(&mut wire);
            let said = motion_from_wire(&wire).unwrap_err().to_string();
            assert!(said.starts_with(text), "{said} is not {text}");
        }
    }
}
