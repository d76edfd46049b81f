//! The path of the tool in the layer, piece by piece.

use models::advance::turn::turn_rad;
use models::motion::{MoveKind, Role, Segment};

/// One straight move of the tool in the layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// Where it ends `[m]`.
    pub end_m: [f64; 2],
    /// Its direction, length 1.
    pub direction: [f64; 2],
    /// Its length `[m]`, above 0.
    pub length_m: f64,
    /// Highest speed `[m/s]`.
    pub speed_m_s: f64,
    /// Time that it takes `[s]`.
    pub duration_s: f64,
    /// Change of speed over it `[m/s2]`.
    pub along_m_s2: f64,
    /// A road is laid.
    pub deposit: bool,
    /// Layer that it belongs to, where the file tells.
    pub layer: Option<u32>,
    /// The road fills an area: infill, skins, support.
    pub fill: bool,
}

impl Piece {
    /// A move as a piece; `None` where the tool stands still in the layer, or has no speed: it would never arrive.
    #[must_use]
    pub fn of(segment: &Segment) -> Option<Self> {
        let way = [0, 1].map(|axis| segment.end_m[axis] - segment.start_m[axis]);
        let length_m = way[0].hypot(way[1]);
        let profile = &segment.profile;
        // A NaN is no way and no speed.
        if !(length_m > 0.0 && profile.cruise_m_s > 0.0) {
            return None;
        }
        Some(Self {
            end_m: [segment.end_m[0], segment.end_m[1]],
            direction: way.map(|part| part / length_m),
            length_m,
            speed_m_s: profile.cruise_m_s,
            duration_s: profile.duration().0,
            along_m_s2: (profile.exit_m_s.powi(2) - profile.entry_m_s.powi(2)) / (2.0 * length_m),
            deposit: segment.kind == MoveKind::Deposit,
            layer: segment.layer,
            fill: matches!(segment.role, Role::Infill | Role::Solid | Role::TopSolid | Role::Support),
        })
    }

    /// Signed turn from this piece into the next one `[rad]`.
    #[must_use]
    pub fn turn_into(&self, next: &Self) -> f64 {
        turn_rad(self.direction, next.direction)
    }
}
