//! Points spread evenly over a surface, however it is cut into triangles, and the last ones before the machine's reach ends.

use super::map::Cell;
use super::mesh::{Mesh, Triangle};
use super::pose::SurfacePoint;

/// One piece of a triangle, looked at in its centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Corners of the piece `[m]`.
    pub piece: Triangle,
    /// Normals of the surface there: facets of one round surface share them.
    pub normals: Triangle,
    /// Number of the triangle, from 0.
    pub triangle: usize,
    /// Whether the piece is the whole triangle.
    pub whole: bool,
}

/// Halvings of a way from a point that can be worked on to one that cannot: a piece of 1 mm over 4096.
const HALVINGS: u32 = 12;
/// A piece with every corner below this height lies on the table `[m]`.
const TABLE_M: f64 = 1e-6;

impl Sample {
    /// The point of the surface with these parts of the corners, which make 1.
    fn point(&self, parts: [f64; 3]) -> SurfacePoint {
        let mix = |of: &Triangle| of[0] * parts[0] + of[1] * parts[1] + of[2] * parts[2];
        SurfacePoint { position_m: mix(&self.piece), normal: mix(&self.normals) }
    }

    /// Its middle.
    #[must_use]
    pub fn middle(&self) -> SurfacePoint {
        self.point([1.0 / 3.0; 3])
    }

    /// Area `[m2]`.
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        Cell::area_m2(&self.piece)
    }

    /// Whether the piece of a part on the table is a piece of the face that the part stands on.
    #[must_use]
    pub fn is_on_the_table(&self) -> bool {
        on_the_table(&self.piece)
    }

    /// The last points that hold `can`, where the end of what does runs through the piece: an error that grows towards
    /// that end is largest there, and the middles of pieces would leave it to chance how near they come.
    pub fn last_points(&self, can: &impl Fn(&SurfacePoint) -> bool) -> Vec<SurfacePoint> {
        const PLACES: [[f64; 3]; 4] = [[1.0 / 3.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let (inside, outside): (Vec<_>, Vec<_>) =
            PLACES.into_iter().partition(|parts| can(&self.point(*parts)));
        let ways = inside.iter().flat_map(|from| outside.iter().map(move |to| (*from, *to)));
        ways.map(|(mut from, mut to)| {
            for _ in 0..HALVINGS {
                let half = [0, 1, 2].map(|corner| 0.5 * (from[corner] + to[corner]));
                if can(&self.point(half)) { from = half } else { to = half }
            }
            self.point(from)
        })
        .collect()
    }
}

/// Whether a triangle of a part on the table is part of the face that it stands on.
#[must_use]
pub fn on_the_table(triangle: &Triangle) -> bool {
    triangle.iter().all(|corner| corner.z < TABLE_M)
}

/// A surface in pieces.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampling {
    /// The pieces, in the order of their triangles.
    pub samples: Vec<Sample>,
    /// No edge of a divided triangle's piece is longer `[m]`: what was asked for, or more where the number was bounded.
    pub edge_m: f64,
}

impl Mesh {
    /// Halves every triangle across its longest edge until no edge is longer than `edge_m`. A surface that would give
    /// more than `most` pieces gets longer edges; a mesh of more triangles than that stays as it is.
    #[must_use]
    pub fn sampled(&self, edge_m: f64, most: usize) -> Sampling {
        let most = most.max(self.triangles().len());
        #[allow(clippy::cast_precision_loss, reason = "far below 2^52 pieces")]
        let share_m2 = self.triangles().iter().map(Cell::area_m2).sum::<f64>() / most as f64;
        // A piece is no larger than half the square of its longest edge.
        let mut edge_m = edge_m.max(share_m2.sqrt());
        let normals = self.corner_normals();
        loop {
            if let Some(samples) = self.pieces(&normals, edge_m, most) {
                return Sampling { samples, edge_m };
            }
            edge_m *= std::f64::consts::SQRT_2;
        }
    }

    /// The pieces; none where there are more than `most`.
    fn pieces(&self, normals: &[Triangle], edge_m: f64, most: usize) -> Option<Vec<Sample>> {
        let mut samples = Vec::new();
        let mut open = Vec::new();
        for (triangle, (piece, normals)) in self.triangles().iter().zip(normals).enumerate() {
            open.push(Sample { piece: *piece, normals: *normals, triangle, whole: true });
            while let Some(sample) = open.pop() {
                let (side, length_m) = longest(&sample.piece);
                if length_m <= edge_m {
                    samples.push(sample);
                } else {
                    let pieces = halves(&sample.piece, side).into_iter().zip(halves(&sample.normals, side));
                    open.extend(pieces.map(|(piece, normals)| Sample {
                        piece,
                        normals,
                        whole: false,
                        ..sample
                    }));
                }
                if samples.len() + open.len() > most {
                    return None;
                }
            }
        }
        Some(samples)
    }
}

/// The corner where the longest edge begins, and its length `[m]`.
fn longest(piece: &Triangle) -> (usize, f64) {
    let length_m = |side: usize| (piece[(side + 1) % 3] - piece[side]).norm();
    (0..3)
        .map(|side| (side, length_m(side)))
        .fold((0, 0.0), |long, edge| if edge.1 > long.1 { edge } else { long })
}

/// Both halves, wound as the whole.
fn halves(piece: &Triangle, side: usize) -> [Triangle; 2] {
    let [from, to, across] = [piece[side], piece[(side + 1) % 3], piece[(side + 2) % 3]];
    let middle = (from + to) / 2.0;
    [[from, middle, across], [middle, to, across]]
}

#[cfg(test)]
pub(crate) mod tests;
