use super::*;
use crate::camera::tests::camera;
use crate::path::tests::road;

const TOOL_M: [f64; 2] = [0.1, 0.1];
const WIDTH_M: f64 = 4.5e-4;

fn surface() -> Surface {
    Surface::new(
        RawUnexplained {
            bed_low_m: [0.0, 0.0],
            bed_high_m: [0.2, 0.2],
            cell_m: 1e-4,
            beside_m: 2e-4,
            turn_max_rad: 0.6,
            strong_share: 0.8,
            texture_rise: 0.02,
            texture_fall: 0.2,
            texture_margin: 1.0,
            roads_share_min: 0.25,
            pixels_min: 1000,
        }
        .try_into()
        .unwrap(),
    )
}

/// Roads one width apart over the whole view, along bed x or bed y.
fn covered(along_x: bool) -> Surface {
    let mut surface = surface();
    for step in -24..=24 {
        let away_m = f64::from(step) * WIDTH_M;
        let ends = [-0.012, 0.012].map(|way_m| {
            if along_x {
                [TOOL_M[0] + way_m, TOOL_M[1] + away_m]
            } else {
                [TOOL_M[0] + away_m, TOOL_M[1] + way_m]
            }
        });
        surface.on_move(&road(0, ends[0], ends[1]));
    }
    surface
}

/// Bright roads one width apart (15 px) with dark seams, across the picture's rows or columns.
fn picture(along_x: bool) -> Vec<Vec<u8>> {
    let level = |place: i32| (140.0 + 60.0 * (std::f64::consts::TAU * f64::from(place) / 15.0).cos()).round();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 80 to 200")]
    let row = |y: i32| (0..640).map(|x: i32| level(if along_x { y } else { x }) as u8).collect();
    (0..480).map(row).collect()
}

fn share(surface: &mut Surface, picture: &[Vec<u8>]) -> f64 {
    surface.find(&Mat::from_slice_2d(picture).unwrap(), (&camera(), TOOL_M)).unwrap()
}

#[test]
fn roads_as_commanded_explain_their_edges_whichever_way_they_run() {
    for along_x in [true, false] {
        assert!(share(&mut covered(along_x), &picture(along_x)) < 1e-9, "along x: {along_x}");
    }
}

#[test]
fn edges_across_the_commanded_roads_are_unexplained() {
    assert!(share(&mut covered(true), &picture(false)) > 0.99);
}

/// A quarter of the view covered by stripes the other way leaves about a quarter of the edges unexplained.
#[test]
fn the_share_follows_the_disturbed_area() {
    let (mut seen, other) = (picture(true), picture(false));
    for y in 0..240 {
        seen[y][..320].copy_from_slice(&other[y][..320]);
    }
    let found = share(&mut covered(true), &seen);
    assert!((found - 0.25).abs() < 0.03, "{found}");
}

/// The bed's texture is there from the beginning and is not counted; what comes to it later is.
#[test]
fn texture_of_the_bare_bed_is_learned_and_what_is_new_on_it_counts() {
    let mut surface = surface();
    for step in 0..=20 {
        let y_m = TOOL_M[1] + f64::from(step) * WIDTH_M;
        surface.on_move(&road(0, [TOOL_M[0] - 0.012, y_m], [TOOL_M[0] + 0.012, y_m]));
    }
    // Roads in the upper half only; a texture of few edges below.
    let mut seen = picture(true);
    for (y, row) in seen.iter_mut().enumerate().skip(250) {
        for (x, level) in row.iter_mut().enumerate() {
            *level = if x % 40 < 20 && y % 64 < 32 { 200 } else { 80 };
        }
    }
    assert!(share(&mut surface, &seen) < 1e-9);
    let other = picture(false);
    for y in 250..480 {
        seen[y].copy_from_slice(&other[y]);
    }
    assert!(share(&mut surface, &seen) > 0.2);
    surface.clear();
    assert!(share(&mut surface, &seen) < 1e-9, "an empty bed was commanded: nothing can have gone wrong");
}

/// Travels over roads that run the other way: had they laid anything, nothing would explain the roads' edges.
#[test]
fn a_move_that_lays_nothing_or_lies_outside_changes_nothing() {
    let across = |surface: &mut Surface, kind: MoveKind, beside_m: f64| {
        for step in -24..=24 {
            let x_m = TOOL_M[0] + beside_m + f64::from(step) * WIDTH_M;
            let mut segment = road(0, [x_m, TOOL_M[1] - 0.012], [x_m, TOOL_M[1] + 0.012]);
            segment.kind = kind;
            surface.on_move(&segment);
        }
    };
    let mut surface = covered(true);
    across(&mut surface, MoveKind::Travel, 0.0);
    across(&mut surface, MoveKind::Deposit, 5.0);
    assert!(share(&mut surface, &picture(true)) < 1e-9);
    assert_eq!(surface.refused(), 0);
    across(&mut surface, MoveKind::Deposit, 0.0);
    assert!(share(&mut surface, &picture(true)) > 0.99, "the same moves, laying");
}
