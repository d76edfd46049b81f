//! Which way the edges of a measurement face, and on what they lie.
//!
//! How far beside the true edge a camera finds it depends on where the light comes from and on what lies beside the
//! road: on one printer, edges that face alike err alike, by up to 45 um on 600 simulated cameras.

use super::side::Side;
use super::stretch::Piece;
use std::f64::consts::TAU;

/// Directions that are told apart over a full turn.
const SECTORS: f64 = 8.0;
/// Largest height of what a road of the first layer lies on, in its own heights `[-]`.
const ON_BED: f64 = 0.5;

/// Edges that light falls on alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Facing {
    /// Sector of the direction that the edge faces; of the first one where both edges of a road were measured.
    sector: u8,
    both: bool,
    on_bed: bool,
}

impl Facing {
    /// Of a piece whose edge was found on these sides; `None` without one.
    pub(super) fn of(piece: &Piece, sides: &[&Side]) -> Option<Self> {
        let (first, both) = (sides.first()?, sides.len() > 1);
        let left = first.stations.get(first.stations.len() / 2)?.left;
        let normal = left.map(|part| first.sign * part);
        let turn = normal[1].atan2(normal[0]).rem_euclid(TAU) / TAU;
        // A road seen from both sides may have been laid either way.
        let sectors = if both { 0.5 * SECTORS } else { SECTORS };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 7")]
        let sector = ((turn * SECTORS).round() % sectors) as u8;
        Some(Self { sector, both, on_bed: piece.top_m - piece.height_m <= ON_BED * piece.height_m })
    }

    /// Any one of them, for tests.
    #[cfg(test)]
    pub(crate) fn numbered(sector: u8) -> Self {
        Self { sector, both: false, on_bed: true }
    }
}

#[cfg(test)]
mod tests {
    use super::super::stretch::Station;
    use super::*;
    use models::units::Seconds;

    fn facing(left: [f64; 2], signs: &[f64], top_m: f64) -> Option<Facing> {
        let stations = vec![Station { point_m: [0.1, 0.1], left }];
        let piece =
            Piece { stations: stations.clone(), width_m: 4.5e-4, height_m: 2e-4, top_m, laid: Seconds(1.0) };
        let side = |sign: &f64| Side { sign: *sign, stations: stations.clone(), stacked: false };
        let sides: Vec<Side> = signs.iter().map(side).collect();
        Facing::of(&piece, &sides.iter().collect::<Vec<_>>())
    }

    #[test]
    fn the_same_edge_faces_alike_whichever_way_its_road_was_laid() {
        let there = facing([0.0, 1.0], &[1.0], 6e-4);
        assert!(there.is_some() && there == facing([0.0, -1.0], &[-1.0], 6e-4));
        assert_ne!(there, facing([0.0, 1.0], &[-1.0], 6e-4));
        assert_ne!(there, facing([0.7, 0.7], &[1.0], 6e-4));
        let both = facing([0.0, 1.0], &[1.0, -1.0], 6e-4);
        assert!(both != there && both == facing([0.0, -1.0], &[1.0, -1.0], 6e-4));
        assert_eq!(facing([0.0, 1.0], &[], 6e-4), None);
    }

    /// A first layer of 0.24 mm lies on the bed, the second of 0.2 mm does not.
    #[test]
    fn what_lies_on_the_bed_looks_otherwise() {
        assert_ne!(facing([0.0, 1.0], &[1.0], 2.4e-4), facing([0.0, 1.0], &[1.0], 4.4e-4));
    }
}
