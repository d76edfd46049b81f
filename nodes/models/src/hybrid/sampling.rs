//! Points spread evenly over a surface, however it is cut into triangles.

use super::map::Cell;
use super::mesh::{Mesh, Triangle};

/// One piece of a triangle, looked at in its centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Corners of the piece `[m]`.
    pub piece: Triangle,
    /// Number of the triangle, from 0.
    pub triangle: usize,
    /// Whether the piece is the whole triangle.
    pub whole: bool,
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
        loop {
            if let Some(samples) = self.pieces(edge_m, most) {
                return Sampling { samples, edge_m };
            }
            edge_m *= std::f64::consts::SQRT_2;
        }
    }

    /// The pieces; none where there are more than `most`.
    fn pieces(&self, edge_m: f64, most: usize) -> Option<Vec<Sample>> {
        let mut samples = Vec::new();
        let mut open = Vec::new();
        for (triangle, corners) in self.triangles().iter().enumerate() {
            open.push((*corners, true));
            while let Some((piece, whole)) = open.pop() {
                let (side, length_m) = longest(&piece);
                if length_m <= edge_m {
                    samples.push(Sample { piece, triangle, whole });
                } else {
                    open.extend(halves(&piece, side).map(|half| (half, false)));
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
