use super::super::kinematics::tests::g1;
use super::super::mesh::{MeshError, Triangle};
use super::*;

/// A pyramid with an open or closed base, apex up.
fn pyramid(closed: bool) -> Vec<Triangle> {
    let corner = |x: f64, y: f64, z: f64| Vector3::new(x, y, z) * 1e-3;
    let base = [
        corner(-10.0, -10.0, 5.0),
        corner(10.0, -10.0, 5.0),
        corner(10.0, 10.0, 5.0),
        corner(-10.0, 10.0, 5.0),
    ];
    let apex = corner(0.0, 0.0, 35.0);
    let mut triangles: Vec<Triangle> = (0..4).map(|side| [base[side], base[(side + 1) % 4], apex]).collect();
    if closed {
        triangles.extend([[base[0], base[2], base[1]], [base[0], base[3], base[2]]]);
    }
    triangles
}

/// A third of base area times height: 400 * 30 / 3 = 4000 mm3.
#[test]
fn a_closed_pyramid_has_its_volume_and_stands_on_the_table() {
    let mesh = Mesh::closed(pyramid(true)).unwrap().on_the_table();
    assert!((mesh.volume_m3() - 4e-6).abs() < 1e-18);
    assert!(mesh.bounds_m().0.z.abs() < 1e-18);
}

#[test]
fn an_open_mesh_is_refused_with_the_number_of_its_edges() {
    let error = Mesh::closed(pyramid(false)).unwrap_err();
    assert!(matches!(error, MeshError::Open { edges: 4, .. }), "{error}");
    assert!(error.to_string().starts_with("open edges = 4: must be 0"), "{error}");
}

#[test]
fn a_mesh_inside_out_without_area_or_numbers_is_refused() {
    let inside_out = pyramid(true).into_iter().map(|[a, b, c]| [a, c, b]).collect();
    assert!(matches!(Mesh::closed(inside_out), Err(MeshError::InsideOut { .. })));
    let mut flat = pyramid(true);
    flat[0][2] = flat[0][0];
    assert!(matches!(Mesh::closed(flat), Err(MeshError::Flat { triangle: 0, .. })));
    let mut broken = pyramid(true);
    broken[1][2].x = f64::NAN;
    assert!(matches!(Mesh::closed(broken), Err(MeshError::NotFinite { triangle: 1, .. })));
    assert_eq!(Mesh::closed(Vec::new()), Err(MeshError::Empty));
}

/// The four sides are alike but for the table: turned by 90 degrees each has the same error. The base looks down.
#[test]
fn the_sides_of_a_pyramid_have_one_error_and_its_base_none() {
    let machine = g1();
    let mesh = Mesh::closed(pyramid(true)).unwrap().on_the_table();
    let error = AxisError::of_motors(0.01, machine.lead_m);
    let map = machine.error_map(&mesh, &error);
    let sides: Vec<f64> =
        map.cells[..4].iter().map(|cell| cell.outcome.unwrap().extremal.largest_m).collect();
    assert!(sides.iter().all(|side| (side / sides[0] - 1.0).abs() < 1e-9), "{sides:?}");
    assert!(map.cells[4..].iter().all(|cell| matches!(cell.outcome, Err(Refused::Tilt { .. }))));
    // Sides 4 * 20 * sqrt(30^2 + 10^2) / 2 = 1264.9 mm2, base 400 mm2.
    let summary = map.summary();
    assert!((summary.workable - 1264.911 / 1664.911).abs() < 1e-6, "{summary:?}");
    assert!((summary.largest.unwrap().0 - sides[0]).abs() < 1e-9 * sides[0]);
}

/// The mean of the worst error weighs area, not triangles: two cuts of one cube agree, and so do their largest errors.
#[test]
fn two_cuts_of_one_cube_have_one_summary() {
    let machine = g1();
    let error = AxisError::of_motors(0.002, machine.lead_m);
    let [coarse, fine] = [1, 10].map(|cells| {
        let mesh = super::super::sampling::tests::cube(cells);
        let whole = machine.error_map(&mesh, &error);
        machine.error_map_of(&mesh.sampled(2e-3, 10_000), &whole, &error).summary()
    });
    for (one, other) in [(coarse.mean_m, fine.mean_m), (coarse.most_m, fine.most_m)] {
        assert!((one / other - 1.0).abs() < 0.02, "{coarse:?} {fine:?}");
    }
    // The piece next to the worst corner is up to 2 mm of 20 away from it.
    assert!((coarse.largest.unwrap().0 / fine.largest.unwrap().0 - 1.0).abs() < 0.05, "{coarse:?} {fine:?}");
    assert!((coarse.workable - fine.workable).abs() < 1e-9);
}

#[test]
fn a_part_out_of_reach_has_no_error_and_no_negative_zero() {
    let machine = g1();
    let far = pyramid(true).into_iter().map(|triangle| triangle.map(|corner| corner * 1e3)).collect();
    let mesh = Mesh::closed(far).unwrap().on_the_table();
    let summary = machine.error_map(&mesh, &AxisError::of_motors(0.01, machine.lead_m)).summary();
    assert!(summary.largest.is_none() && summary.workable.is_sign_positive() && summary.workable < 1e-300);
}
