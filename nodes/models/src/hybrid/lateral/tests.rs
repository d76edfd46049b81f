use super::super::kinematics::tests::g1;
use super::super::mesh::{Mesh, Triangle};
use super::*;
use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};

/// A sphere of 30 mm in bands and sectors, on the table.
pub(crate) fn sphere(bands: u32, sectors: u32) -> Mesh {
    let place = |band: u32, sector: u32| {
        let down = PI * f64::from(band) / f64::from(bands);
        let round = TAU * f64::from(sector % sectors) / f64::from(sectors);
        // The poles are one corner each.
        let out = if band == 0 || band == bands { 0.0 } else { down.sin() };
        Vector3::new(out * round.cos(), out * round.sin(), down.cos()) * 0.03
    };
    let mut triangles: Vec<Triangle> = Vec::new();
    for (band, sector) in (0..bands).flat_map(|band| (0..sectors).map(move |sector| (band, sector))) {
        let [a, b] = [place(band, sector), place(band + 1, sector)];
        let [c, d] = [place(band + 1, sector + 1), place(band, sector + 1)];
        if band > 0 {
            triangles.push([a, b, d]);
        }
        if band < bands - 1 {
            triangles.push([b, c, d]);
        }
    }
    Mesh::closed(triangles).unwrap().on_the_table()
}

/// One sphere in four triangulations: facets of 3 to 13 mm and 4 to 24 degrees. The error grows towards the guard before
/// the singular pose, where no facet's middle lies; both figures agree all the same.
#[test]
fn a_sphere_has_one_largest_error_however_it_is_cut() {
    let machine = g1();
    let error = AxisError::of_motors(0.09_f64.to_radians(), machine.lead_m);
    let mut figures = Vec::new();
    for (bands, sectors) in [(14, 24), (22, 50), (30, 30), (31, 60)] {
        let mesh = sphere(bands, sectors);
        let sampling = mesh.sampled(3e-3, 5_000);
        let found = machine.laterals(&sampling, 0.0, &error);
        let (lateral_m, ends) = found.largest.unwrap();
        assert_eq!(ends, Ends::Reach, "{found:?}");
        assert!((0.2..0.7).contains(&found.refused_share), "{found:?}");
        let whole = machine.error_map(&mesh, &error);
        let (normal_m, _) = machine.error_map_of(&sampling, &whole, &error).edge.unwrap();
        figures.push((lateral_m, normal_m));
    }
    let spread = |of: &dyn Fn(&(f64, f64)) -> f64| {
        let values: Vec<f64> = figures.iter().map(of).collect();
        let (low, high) = values
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(*value), high.max(*value)));
        high / low - 1.0
    };
    assert!(spread(&|figure| figure.0) < 0.03 && spread(&|figure| figure.1) < 0.03, "{figures:?}");
}

/// From a height on the figure is that of the height, not of the piece that begins next above it.
#[test]
fn a_cut_is_looked_at_where_it_is() {
    let machine = g1();
    let error = AxisError::of_motors(0.09_f64.to_radians(), machine.lead_m);
    let at = |bands, sectors, lowest_m| {
        let found = machine.laterals(&sphere(bands, sectors).sampled(3e-3, 5_000), lowest_m, &error);
        assert!(found.refused == 0 && found.below > 0 && found.on_table == 0, "{found:?}");
        found.largest.unwrap()
    };
    let (coarse, fine) = (at(14, 24, 0.040), at(31, 60, 0.040));
    assert_eq!((coarse.1, fine.1), (Ends::Cut, Ends::Cut));
    assert!((coarse.0 / fine.0 - 1.0).abs() < 0.02, "{coarse:?} {fine:?}");
}
