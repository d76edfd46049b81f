//! Normals of the surface that a mesh stands for: facets of one round surface share them, facets across a crease do not.
//!
//! A facet's own normal belongs to one of its points alone. Where the error grows fast with the tilt, facets of some
//! degrees would let the triangulation choose the worst point.

use nalgebra::Vector3;
use std::collections::HashMap;

use super::mesh::{Key, Mesh, Triangle, doubled_area, key};

/// Facets that meet at a larger angle have an edge between them `[rad]`: half a right angle's rounding, 30 degrees.
const CREASE_RAD: f64 = std::f64::consts::FRAC_PI_6;
/// Corners where more facets meet are tips of fans: each facet keeps its own normal there.
const FAN: usize = 1000;

/// Angle of a triangle at a corner `[rad]`.
fn angle_at(triangle: &Triangle, corner: usize) -> f64 {
    let [at, one, other] = [0, 1, 2].map(|step| triangle[(corner + step) % 3]);
    (one - at).angle(&(other - at))
}

impl Mesh {
    /// Normals of length 1 at the corners of every triangle: the mean of the facets that meet there, weighed by their
    /// angles, without those across a crease.
    pub(super) fn corner_normals(&self) -> Vec<Triangle> {
        let own: Vec<Vector3<f64>> =
            self.triangles().iter().map(|triangle| doubled_area(triangle).normalize()).collect();
        let mut meeting: HashMap<Key, Vec<(usize, f64)>> = HashMap::new();
        for (index, triangle) in self.triangles().iter().enumerate() {
            for corner in 0..3 {
                let facet = (index, angle_at(triangle, corner));
                meeting.entry(key(&triangle[corner])).or_default().push(facet);
            }
        }
        let smooth = |index: usize, corner: &Vector3<f64>| {
            let facets = meeting.get(&key(corner)).map_or(&[][..], Vec::as_slice);
            let alike = |other: usize| own[index].dot(&own[other]) >= CREASE_RAD.cos();
            let sum: Vector3<f64> = facets
                .iter()
                .filter(|(other, _)| facets.len() <= FAN && alike(*other))
                .map(|(other, angle)| own[*other] * *angle)
                .sum();
            // Needles have no angle to weigh.
            sum.try_normalize(1e-12).unwrap_or(own[index])
        };
        let triangles = self.triangles().iter().enumerate();
        triangles.map(|(index, triangle)| triangle.map(|corner| smooth(index, &corner))).collect()
    }
}
