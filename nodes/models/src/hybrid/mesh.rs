//! Triangle meshes: closed, outward, placed on the table.

use nalgebra::Vector3;
use std::collections::HashMap;

/// Three corners `[m]`, counter-clockwise seen from outside.
pub type Triangle = [Vector3<f64>; 3];

/// Why a mesh was refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// No triangle at all.
    #[error("triangles = 0: must be at least 4, the fewest that close a body")]
    Empty,
    /// A corner that is no number.
    #[error("corner of triangle {triangle} = {value}: must be finite")]
    NotFinite {
        /// Number of the triangle, from 0.
        triangle: usize,
        /// The refused coordinate.
        value: f64,
    },
    /// A triangle without area has no normal.
    #[error("area of triangle {triangle} = {area_m2} m2: must be > 0")]
    Flat {
        /// Number of the triangle, from 0.
        triangle: usize,
        /// Its area `[m2]`.
        area_m2: f64,
    },
    /// Edges that do not have exactly one neighbour in the other direction.
    #[error(
        "open edges = {edges}: must be 0 (the mesh is not closed; one lies between ({:.6}, {:.6}, {:.6}) and \
         ({:.6}, {:.6}, {:.6}) m)",
        from_m[0], from_m[1], from_m[2], to_m[0], to_m[1], to_m[2]
    )]
    Open {
        /// Number of such edges.
        edges: usize,
        /// Start of one of them `[m]`.
        from_m: [f64; 3],
        /// Its end `[m]`.
        to_m: [f64; 3],
    },
    /// Normals that point into the material.
    #[error("volume = {volume_m3:.3e} m3: must be > 0 (the triangles are wound inside out)")]
    InsideOut {
        /// Signed volume `[m3]`.
        volume_m3: f64,
    },
}

/// A closed mesh with its normals outward.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    triangles: Vec<Triangle>,
    volume_m3: f64,
}

/// Bits of a corner.
type Key = [u64; 3];

/// Bits of a corner: what a file writes for one corner is the same in every triangle. -0 and 0 are one value.
fn key(corner_m: &Vector3<f64>) -> Key {
    [corner_m.x, corner_m.y, corner_m.z].map(|value| (value + 0.0).to_bits())
}

/// Normal times twice the area `[m2]`.
pub(super) fn doubled_area(triangle: &Triangle) -> Vector3<f64> {
    (triangle[1] - triangle[0]).cross(&(triangle[2] - triangle[0]))
}

impl Mesh {
    /// Checks that the triangles close a body and look outward.
    ///
    /// # Errors
    /// [`MeshError`] with the first thing that is wrong.
    pub fn closed(triangles: Vec<Triangle>) -> Result<Self, MeshError> {
        if triangles.is_empty() {
            return Err(MeshError::Empty);
        }
        let mut volume_m3 = 0.0;
        for (index, triangle) in triangles.iter().enumerate() {
            if let Some(value) = triangle.iter().flatten().find(|value| !value.is_finite()) {
                return Err(MeshError::NotFinite { triangle: index, value: *value });
            }
            let area_m2 = 0.5 * doubled_area(triangle).norm();
            // Corners far apart overflow.
            if area_m2.is_nan() || area_m2 <= 0.0 {
                return Err(MeshError::Flat { triangle: index, area_m2 });
            }
            volume_m3 += triangle[0].dot(&triangle[1].cross(&triangle[2])) / 6.0;
        }
        check_edges(&triangles)?;
        if volume_m3.is_nan() || volume_m3 <= 0.0 {
            return Err(MeshError::InsideOut { volume_m3 });
        }
        Ok(Self { triangles, volume_m3 })
    }

    /// The triangles.
    #[must_use]
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// Volume of the body `[m3]`, above 0.
    #[must_use]
    pub fn volume_m3(&self) -> f64 {
        self.volume_m3
    }

    /// Lowest and highest coordinates `[m]`.
    #[must_use]
    pub fn bounds_m(&self) -> (Vector3<f64>, Vector3<f64>) {
        let start = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        self.triangles.iter().flatten().fold(start, |(low, high), corner| (low.inf(corner), high.sup(corner)))
    }

    /// The same mesh with its middle on the table's axis and its lowest corner at the part's base.
    #[must_use]
    pub fn on_the_table(mut self) -> Self {
        let (low, high) = self.bounds_m();
        let shift = Vector3::new(0.5 * (low.x + high.x), 0.5 * (low.y + high.y), low.z);
        for corner in self.triangles.iter_mut().flatten() {
            *corner -= shift;
        }
        self
    }
}

/// Every directed edge must stand there once, and once the other way.
fn check_edges(triangles: &[Triangle]) -> Result<(), MeshError> {
    let mut balance: HashMap<(Key, Key), (i32, [usize; 2])> = HashMap::new();
    for (index, triangle) in triangles.iter().enumerate() {
        for side in 0..3 {
            let (from, to) = (key(&triangle[side]), key(&triangle[(side + 1) % 3]));
            let (edge, way) = if from < to { ((from, to), 1) } else { ((to, from), -1) };
            let entry = balance.entry(edge).or_insert((0, [index, side]));
            entry.0 += way;
        }
    }
    let mut open: Vec<[usize; 2]> =
        balance.values().filter(|(sum, _)| *sum != 0).map(|(_, place)| *place).collect();
    // The map has no order of its own; the same file gives the same message.
    open.sort_unstable();
    match open.first() {
        None => Ok(()),
        Some(&[triangle, side]) => Err(MeshError::Open {
            edges: open.len(),
            from_m: triangles[triangle][side].into(),
            to_m: triangles[triangle][(side + 1) % 3].into(),
        }),
    }
}
