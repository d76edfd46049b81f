//! `MotionSegment`.

use fdm_loop_msgs::{Header, MotionSegment};
use models::motion::{MoveKind, Role, Segment};
use models::units::Seconds;

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
