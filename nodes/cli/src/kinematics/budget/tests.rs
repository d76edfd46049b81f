use super::*;
use crate::config::ConfigDir;
use nalgebra::Vector3;

/// A cube of 20 mm with every side cut into `cells` times `cells` squares of two triangles.
fn cube(cells: u32) -> Mesh {
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

/// The budget is the part's, not its triangles': 12 and 1200 of them agree to the pieces' millimetre of a cube of 20.
#[test]
fn the_budget_of_a_cube_does_not_depend_on_its_triangles() {
    let config =
        ConfigDir::find(Some(std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config"))))
            .unwrap();
    let geometry: Geometry = crate::process::block(&config, "machines/g1.yaml", "machine").unwrap();
    let error = AxisError::of_motors(0.09_f64.to_radians(), geometry.lead_m);
    let budget = |cells: u32| {
        let surface = of_mesh(&cube(cells), 0.015);
        assert!(surface.below > FEWEST && surface.edge_m.unwrap() < 1.001e-3, "{:?}", surface.edge_m);
        let laterals = laterals_m(&geometry, &surface.points, &error);
        assert!(laterals.len() > FEWEST, "{}", laterals.len());
        laterals.into_iter().fold(0.0, f64::max)
    };
    let (coarse, fine) = (budget(1), budget(10));
    assert!((coarse / fine - 1.0).abs() < 0.05, "{coarse} {fine}");
}
