//! Triangle meshes: closed, outward, placed on the table.

use nalgebra::Vector3;
use std::collections::HashMap;

use super::bodies;

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
    /// Edges that stand there more than once each way: doubled faces, or bodies that share an edge.
    #[error(
        "doubled edges = {edges}: must be 0 (faces stand there twice, or two bodies share an edge; one lies between \
         ({:.6}, {:.6}, {:.6}) and ({:.6}, {:.6}, {:.6}) m)",
        from_m[0], from_m[1], from_m[2], to_m[0], to_m[1], to_m[2]
    )]
    Doubled {
        /// Number of such edges.
        edges: usize,
        /// Start of one of them `[m]`.
        from_m: [f64; 3],
        /// Its end `[m]`.
        to_m: [f64; 3],
    },
    /// Normals that point into the material.
    #[error(
        "volume = {volume_m3:.3e} m3 of body {body} of {bodies}: must be > 0 (the triangles are wound inside out, and it \
         is no cavity of another body)"
    )]
    InsideOut {
        /// Signed volume `[m3]`.
        volume_m3: f64,
        /// Number of the body, from 1.
        body: usize,
        /// All bodies.
        bodies: usize,
    },
    /// A body inside of another one.
    #[error(
        "body {body} of {bodies} lies inside of another at ({:.6}, {:.6}, {:.6}) m: bodies must not overlap",
        at_m[0], at_m[1], at_m[2]
    )]
    Overlap {
        /// Number of the body, from 1.
        body: usize,
        /// All bodies.
        bodies: usize,
        /// Place of its surface that lies inside of another `[m]`.
        at_m: [f64; 3],
    },
}

/// A closed mesh with its normals outward.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    triangles: Vec<Triangle>,
    volume_m3: f64,
}

/// Bits of a corner.
pub(super) type Key = [u64; 3];

/// Bits of a corner: what a file writes for one corner is the same in every triangle. -0 and 0 are one value.
pub(super) fn key(corner_m: &Vector3<f64>) -> Key {
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
        for (index, triangle) in triangles.iter().enumerate() {
            if let Some(value) = triangle.iter().flatten().find(|value| !value.is_finite()) {
                return Err(MeshError::NotFinite { triangle: index, value: *value });
            }
            let area_m2 = 0.5 * doubled_area(triangle).norm();
            // Corners far apart overflow.
            if area_m2.is_nan() || area_m2 <= 0.0 {
                return Err(MeshError::Flat { triangle: index, area_m2 });
            }
        }
        let body_of = check_edges(&triangles)?;
        let volume_m3 = bodies::volume_m3(&triangles, &body_of)?;
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

/// One edge: how often it stands there one way and the other, and where it was met first.
struct Edge {
    ways: [u32; 2],
    place: [usize; 2],
}

/// Every directed edge must stand there once, and once the other way; the number of each triangle's body, from 0.
fn check_edges(triangles: &[Triangle]) -> Result<Vec<usize>, MeshError> {
    let mut edges: HashMap<(Key, Key), Edge> = HashMap::new();
    let mut joined = Joined((0..triangles.len()).collect());
    for (index, triangle) in triangles.iter().enumerate() {
        for side in 0..3 {
            let (from, to) = (key(&triangle[side]), key(&triangle[(side + 1) % 3]));
            let (edge, way) = if from < to { ((from, to), 0) } else { ((to, from), 1) };
            let entry = edges.entry(edge).or_insert(Edge { ways: [0, 0], place: [index, side] });
            entry.ways[way] += 1;
            joined.join(entry.place[0], index);
        }
    }
    // The map has no order of its own; the same file gives the same message.
    let first = |wrong: &dyn Fn([u32; 2]) -> bool| {
        let mut places: Vec<[usize; 2]> =
            edges.values().filter(|edge| wrong(edge.ways)).map(|edge| edge.place).collect();
        places.sort_unstable();
        let [triangle, side] = *places.first()?;
        let (from, to) = (triangles[triangle][side], triangles[triangle][(side + 1) % 3]);
        Some((places.len(), from.into(), to.into()))
    };
    if let Some((edges, from_m, to_m)) = first(&|[there, back]| there != back) {
        return Err(MeshError::Open { edges, from_m, to_m });
    }
    if let Some((edges, from_m, to_m)) = first(&|[there, _]| there > 1) {
        return Err(MeshError::Doubled { edges, from_m, to_m });
    }
    Ok(joined.numbered())
}

/// Which triangles belong together: each names another of its body, the first one itself.
struct Joined(Vec<usize>);

impl Joined {
    fn root(&mut self, mut index: usize) -> usize {
        while self.0[index] != index {
            self.0[index] = self.0[self.0[index]];
            index = self.0[index];
        }
        index
    }

    fn join(&mut self, one: usize, other: usize) {
        let (one, other) = (self.root(one), self.root(other));
        self.0[one.max(other)] = one.min(other);
    }

    /// Numbers of the bodies in the order of their first triangles.
    fn numbered(mut self) -> Vec<usize> {
        let mut numbers = HashMap::new();
        let roots: Vec<usize> = (0..self.0.len()).map(|index| self.root(index)).collect();
        roots
            .into_iter()
            .map(|root| {
                let next = numbers.len();
                *numbers.entry(root).or_insert(next)
            })
            .collect()
    }
}
