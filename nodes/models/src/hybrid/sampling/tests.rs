use super::super::kinematics::tests::g1;
use super::super::{AxisError, SurfacePoint};
use super::*;
use nalgebra::Vector3;

/// A cube of 20 mm with every side cut into `cells` times `cells` squares of two triangles.
pub(crate) fn cube(cells: u32) -> Mesh {
    let mut triangles = Vec::new();
    for (axis, outward) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)] {
        let corner = |across: u32, along: u32| {
            let place = |index: u32| (f64::from(2 * index) - f64::from(cells)) / f64::from(cells);
            let mut corner = Vector3::zeros();
            corner[axis] = outward;
            corner[(axis + 1) % 3] = outward * place(across);
            corner[(axis + 2) % 3] = place(along);
            corner * 0.01
        };
        for (across, along) in (0..cells).flat_map(|across| (0..cells).map(move |along| (across, along))) {
            let [a, b] = [corner(across, along), corner(across + 1, along)];
            let [c, d] = [corner(across + 1, along + 1), corner(across, along + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Mesh::closed(triangles).unwrap().on_the_table()
}

/// Area and normals stay: halving moves no point of the surface.
#[test]
fn pieces_cover_the_surface_and_look_outward() {
    for cells in [1, 10] {
        let mesh = cube(cells);
        let sampling = mesh.sampled(1e-3, 100_000);
        let area_m2: f64 = sampling.samples.iter().map(|sample| Cell::area_m2(&sample.piece)).sum();
        assert!((area_m2 - 2.4e-3).abs() < 1e-12, "{area_m2}");
        assert!(sampling.samples.iter().all(|sample| longest(&sample.piece).1 <= 1e-3));
        let outward = |sample: &Sample| {
            let normal = |piece: &Triangle| (piece[1] - piece[0]).cross(&(piece[2] - piece[0])).normalize();
            (normal(&sample.piece) - normal(&mesh.triangles()[sample.triangle])).norm() < 1e-9
        };
        assert!(sampling.samples.iter().all(outward));
    }
}

#[test]
fn the_number_of_pieces_is_bounded_by_longer_edges() {
    let mesh = cube(1);
    let sampling = mesh.sampled(1e-5, 500);
    assert!(sampling.samples.len() <= 500 && sampling.edge_m > 1e-3, "{}", sampling.edge_m);
    // More triangles than pieces: each is looked at in its middle.
    let fine = cube(10).sampled(1e-5, 10);
    assert!(fine.samples.len() == 1200 && fine.samples.iter().all(|sample| sample.whole));
}

/// Pieces of 12 and of 1200 triangles are alike, so their extremes over a part are too: 1 mm of 20 at most.
#[test]
fn a_cube_gives_the_same_extremes_however_it_is_cut() {
    let farthest = |mesh: &Mesh| {
        let centres = mesh.sampled(1e-3, 100_000).samples.into_iter();
        centres
            .map(|sample| (sample.piece[0] + sample.piece[1] + sample.piece[2]).norm() / 3.0)
            .fold(0.0, f64::max)
    };
    let (coarse, fine) = (farthest(&cube(1)), farthest(&cube(10)));
    assert!((coarse / fine - 1.0).abs() < 0.03, "{coarse} {fine}");
}

/// The budget of a part is the part's, not its triangles': 12 and 1200 of them agree to the pieces' millimetre of 20.
#[test]
fn the_lateral_error_of_a_cube_does_not_depend_on_its_triangles() {
    let machine = g1();
    let error = AxisError::of_motors(0.09_f64.to_radians(), machine.lead_m);
    let [coarse, fine] = [1, 10].map(|cells| {
        let samples = cube(cells).sampled(1e-3, 20_000).samples;
        let points = samples.iter().map(|sample| SurfacePoint::on_triangle(&sample.piece));
        let upper = points.filter(|point| point.position_m.z >= 0.015);
        let laterals_m: Vec<f64> =
            upper.filter_map(|point| machine.station(&point).ok()?.lateral_m(&error)).collect();
        assert!(laterals_m.len() > 1000, "{}", laterals_m.len());
        laterals_m.into_iter().fold(0.0, f64::max)
    });
    assert!((coarse / fine - 1.0).abs() < 0.05, "{coarse} {fine}");
}
