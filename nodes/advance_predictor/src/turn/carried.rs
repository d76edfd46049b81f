//! The path carried on as it goes: splines and arcs are chopped at even steps, so that the newest chords tell the next ones.

use super::params::TurnParams;
use super::path::Piece;

/// Chords that are carried on, and the one before them that tells how well: four newest.
const CHORDS: usize = 4;
/// Steps at most: a cusp's chords become shorter and shorter.
const STEPS_MAX: u32 = 64;

/// What the newest chords say of the way behind them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Carried {
    /// Way to the first turn of the path carried on; what was asked for where none is nearer `[m]`.
    pub(super) way_m: f64,
    /// How far the newest chord is off what those before it said, by its length `[-]`; at most 1, which is no such curve.
    pub(super) misfit: f64,
}

/// Carries the path on behind its newest pieces, newest first, no farther than `way_m`.
///
/// A cubic Bezier curve at even steps of its parameter has chords whose second differences grow evenly: the next one is
/// `3 d_1 - 3 d_2 + d_3`. So does a straight line, and an arc nearly so.
pub(super) fn carry_on(newest: &[&Piece], way_m: f64, params: &TurnParams) -> Carried {
    let none = Carried { way_m, misfit: 1.0 };
    if newest.len() < CHORDS {
        return none;
    }
    let chord = |place: usize| newest[place].direction.map(|part| part * newest[place].length_m);
    let mut chords = [chord(0), chord(1), chord(2)];
    let told = next([chords[1], chords[2], chord(3)]);
    let off_m = (chords[0][0] - told[0]).hypot(chords[0][1] - told[1]);
    let misfit = (off_m / newest[0].length_m).min(1.0);
    let cos = params.threshold_rad.cos();
    let mut gone_m = 0.0;
    for _ in 0..STEPS_MAX {
        let coming = next(chords);
        let [before_m, length_m] = [chords[0], coming].map(|chord| chord[0].hypot(chord[1]));
        // A NaN or a cusp is no direction.
        if !length_m.is_normal() {
            break;
        }
        let along = chords[0][0] * coming[0] + chords[0][1] * coming[1];
        if along < cos * before_m * length_m {
            return Carried { way_m: gone_m, misfit };
        }
        gone_m += length_m;
        if gone_m > way_m {
            break;
        }
        chords = [coming, chords[0], chords[1]];
    }
    Carried { way_m, misfit }
}

/// The chord behind three, newest first.
fn next([one, two, three]: [[f64; 2]; 3]) -> [f64; 2] {
    [0, 1].map(|axis| 3.0 * (one[axis] - two[axis]) + three[axis])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensation::tests::params;
    use crate::turn::splines::chopped;
    use crate::turn::tests::pieces;

    /// What the newest of these pieces say, no farther than 8 mm.
    fn carried(path: &[Piece]) -> Carried {
        let newest: Vec<&Piece> = path.iter().rev().collect();
        carry_on(&newest, 8e-3, &params().turn)
    }

    /// Points in millimetres as pieces.
    fn path(points_mm: &[[f64; 2]]) -> Vec<Piece> {
        pieces(points_mm)
    }

    /// A curve that goes up to 3 mm on the left of where it begins and comes back in a hairpin: from its fourth chord on the
    /// way to the turn in it is known to a micrometre.
    #[test]
    fn a_hairpin_of_a_spline_is_seen_in_its_first_chords() {
        let ends = [[0.0, 0.0], [4.0, 0.5], [-3.0, 2.0], [1.0, 0.8]];
        let points: Vec<[f64; 2]> = [ends[0]].into_iter().chain(chopped(ends, 0.01)).collect();
        let path = path(&points);
        let turns =
            |place: &usize| path[*place].turn_into(&path[place + 1]).abs() > params().turn.threshold_rad;
        let turn = (0..path.len() - 1).find(turns).unwrap();
        assert!(turn > 6, "{turn}");
        for known in 4..=turn {
            let seen = carried(&path[..known]);
            let way_m: f64 = path[known..=turn].iter().map(|piece| piece.length_m).sum();
            assert!((seen.way_m - way_m).abs() < 1e-6 && seen.misfit < 1e-9, "{known}: {seen:?}, {way_m}");
        }
    }

    /// Neither a line nor an arc turns; chords of 10 degrees are off by 0.17 rad cubed.
    #[test]
    fn lines_and_arcs_go_on() {
        let line: Vec<[f64; 2]> = (0..5).map(|step| [0.3 * f64::from(step), 0.0]).collect();
        let arc: Vec<[f64; 2]> = (0..6)
            .map(|step| {
                let (sin, cos) = (10.0 * f64::from(step)).to_radians().sin_cos();
                [2.0 * cos, 2.0 * sin]
            })
            .collect();
        let (line, arc) = (carried(&path(&line)), carried(&path(&arc)));
        assert!((line.way_m - 8e-3).abs() < 1e-12 && line.misfit < 1e-9, "{line:?}");
        assert!(arc.misfit > 4e-3 && arc.misfit < 6e-3 && arc.way_m > 2e-3, "{arc:?}");
    }

    /// A corner among the chords is no curve; three chords are too few to tell, and none at all are.
    #[test]
    fn what_is_no_curve_is_not_trusted() {
        let corner = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 2.0]];
        assert!((carried(&path(&corner)).misfit - 1.0).abs() < 1e-12);
        for known in 0..3 {
            let few = carried(&path(&corner)[..known]);
            assert_eq!(few, Carried { way_m: 8e-3, misfit: 1.0 });
        }
    }

    /// Chords that shrink to nothing, or would never come to an end, end.
    #[test]
    fn it_is_bounded() {
        let shrinking: Vec<[f64; 2]> = (0..5).map(|step| [1.0 - 0.5_f64.powi(step), 0.0]).collect();
        assert!(carried(&path(&shrinking)).way_m > 0.0);
        let tiny: Vec<[f64; 2]> = (0..5).map(|step| [1e-9 * f64::from(step), 0.0]).collect();
        assert!((carried(&path(&tiny)).way_m - 8e-3).abs() < 1e-12);
    }
}
