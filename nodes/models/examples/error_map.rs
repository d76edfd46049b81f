//! Checks a dome of 10 000 triangles and maps its kinematic error on one core, as `fdm kinematics map` does: triangles,
//! even pieces, and the end of the machine's reach; prints the times.
//!
//! `cargo run --release -p models --example error_map -- config/machines/g1.yaml`
#![allow(
    clippy::print_stdout,
    clippy::expect_used,
    reason = "an example prints and stops at the first failure"
)]

use models::hybrid::mesh::Triangle;
use models::hybrid::{AxisError, Geometry, Mesh};
use nalgebra::Vector3;
use serde::Deserialize;
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::time::Instant;

/// Sides and rings: two triangles each, one ring of them at the top and one in the base.
const SIDES: u32 = 100;
const RINGS: u32 = 50;

#[derive(Deserialize)]
struct Blocks {
    machine: Geometry,
}

/// A dome with four lobes, so that the table's axis has a part in the error.
fn dome() -> Vec<Triangle> {
    let corner = |side: u32, ring: u32| {
        let azimuth = f64::from(side % SIDES) / f64::from(SIDES) * TAU;
        let rise = f64::from(ring) / f64::from(RINGS) * FRAC_PI_2;
        let radius_m = 0.06 * (1.0 + 0.15 * (4.0 * azimuth).cos()) * rise.cos();
        Vector3::new(radius_m * azimuth.cos(), radius_m * azimuth.sin(), 0.06 * rise.sin())
    };
    let mut triangles = Vec::new();
    for side in 0..SIDES {
        for ring in 0..RINGS - 1 {
            let (low, high) = (
                [corner(side, ring), corner(side + 1, ring)],
                [corner(side, ring + 1), corner(side + 1, ring + 1)],
            );
            triangles.push([low[0], low[1], high[1]]);
            triangles.push([low[0], high[1], high[0]]);
        }
        triangles.push([corner(side, RINGS - 1), corner(side + 1, RINGS - 1), Vector3::new(0.0, 0.0, 0.06)]);
        triangles.push([corner(side + 1, 0), corner(side, 0), Vector3::zeros()]);
    }
    triangles
}

fn main() {
    let path = std::env::args().nth(1).expect("parameter file");
    let text = std::fs::read_to_string(path).expect("parameter file");
    type Tree = HashMap<String, HashMap<String, Blocks>>;
    let mut tree: Tree = serde_saphyr::from_str(&text).expect("parameters");
    let machine =
        tree.remove("/**").and_then(|mut node| node.remove("ros__parameters")).expect("a block").machine;
    let triangles = dome();
    let error = AxisError::of_motors(0.1125_f64.to_radians(), machine.lead_m);
    let started = Instant::now();
    let mesh = Mesh::closed(triangles).expect("a closed dome").on_the_table();
    let checked_s = started.elapsed().as_secs_f64();
    let whole = machine.error_map(&mesh, &error);
    let mapped_s = started.elapsed().as_secs_f64() - checked_s;
    let summary = machine.error_map_of(&mesh.sampled(2e-3, 10_000), &whole, &error).summary();
    println!(
        "{} triangles: checked in {:.3} s, mapped in {:.3} s, pieces and edge in {:.3} s; {:.1} % workable, mean {:.4} mm",
        mesh.triangles().len(),
        checked_s,
        mapped_s,
        started.elapsed().as_secs_f64() - checked_s - mapped_s,
        100.0 * summary.workable,
        1e3 * summary.mean_m
    );
}
