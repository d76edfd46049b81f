//! The bodies of a mesh: each closed by itself, wound outward, apart from the others.

use nalgebra::Vector3;
use std::f64::consts::PI;

use super::mesh::{MeshError, Triangle};

/// Places of a body that are looked at: whether others lie around them.
const PLACES: usize = 64;
/// Solid angles that are looked at in all, so that many bodies take seconds.
const SOLID_ANGLES: usize = 20_000_000;
/// Of one winding: a place inside of another body has 1, one on its surface a half or less, one outside 0.
const INSIDE: f64 = 0.9;
const TOUCHES: f64 = 0.1;

/// One connected surface.
struct Body<'a> {
    triangles: Vec<&'a Triangle>,
    volume_m3: f64,
    low_m: Vector3<f64>,
    high_m: Vector3<f64>,
}

impl<'a> Body<'a> {
    fn of(triangles: Vec<&'a Triangle>) -> Self {
        let corners = || triangles.iter().flat_map(|triangle| triangle.iter());
        // Counted from one of its corners: far from the origin little would be left of the difference.
        let from_m = triangles.first().map_or_else(Vector3::zeros, |triangle| triangle[0]);
        let cone_m3 = |triangle: &&Triangle| {
            let [a, b, c] = triangle.map(|corner| corner - from_m);
            a.dot(&b.cross(&c)) / 6.0
        };
        Self {
            volume_m3: triangles.iter().map(cone_m3).sum(),
            low_m: corners().fold(Vector3::repeat(f64::INFINITY), |low, corner| low.inf(corner)),
            high_m: corners().fold(Vector3::repeat(f64::NEG_INFINITY), |high, corner| high.sup(corner)),
            triangles,
        }
    }

    /// How often the surface winds around a place: 1 inside, 0 outside, -1 in a body that is wound inside out.
    fn winding(&self, place_m: &Vector3<f64>) -> f64 {
        let within = (0..3).all(|axis| (self.low_m[axis]..=self.high_m[axis]).contains(&place_m[axis]));
        if !within {
            return 0.0;
        }
        self.triangles.iter().map(|triangle| solid_angle(triangle, place_m)).sum::<f64>() / (4.0 * PI)
    }

    /// Middles of some of its triangles, spread over all.
    fn places(&self, most: usize) -> impl Iterator<Item = Vector3<f64>> {
        let step = self.triangles.len().div_ceil(most.max(1)).max(1);
        self.triangles.iter().step_by(step).map(|triangle| (triangle[0] + triangle[1] + triangle[2]) / 3.0)
    }
}

/// Solid angle of a triangle `[sr]`, above 0 seen from inside (van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30
/// (1983) 125).
fn solid_angle(triangle: &Triangle, place_m: &Vector3<f64>) -> f64 {
    let [a, b, c] = triangle.map(|corner| corner - place_m);
    let [along_a, along_b, along_c] = [a.norm(), b.norm(), c.norm()];
    let across =
        along_a * along_b * along_c + a.dot(&b) * along_c + a.dot(&c) * along_b + b.dot(&c) * along_a;
    2.0 * a.dot(&b.cross(&c)).atan2(across)
}

/// Volume of all bodies together `[m3]`; `body_of` names the body of every triangle, from 0.
///
/// A body that is wound inside out is a cavity where it lies inside of another one, and a mistake elsewhere; one wound
/// outward must not lie in another.
///
/// # Errors
/// [`MeshError::InsideOut`], [`MeshError::Overlap`].
pub(super) fn volume_m3(triangles: &[Triangle], body_of: &[usize]) -> Result<f64, MeshError> {
    let count = body_of.iter().max().map_or(0, |last| last + 1);
    let mut parts: Vec<Vec<&Triangle>> = vec![Vec::new(); count];
    for (triangle, body) in triangles.iter().zip(body_of) {
        parts[*body].push(triangle);
    }
    let bodies: Vec<Body<'_>> = parts.into_iter().map(Body::of).collect();
    let places = (SOLID_ANGLES / (triangles.len() * count).max(1)).clamp(1, PLACES);
    for (index, body) in bodies.iter().enumerate() {
        let inside_out = MeshError::InsideOut { volume_m3: body.volume_m3, body: index + 1, bodies: count };
        if body.volume_m3.is_nan() || body.volume_m3.abs() <= 0.0 || (count == 1 && body.volume_m3 < 0.0) {
            return Err(inside_out);
        }
        if count == 1 {
            continue;
        }
        for place_m in body.places(places) {
            let others = bodies.iter().enumerate().filter(|(other, _)| *other != index);
            let winding: f64 = others.map(|(_, other)| other.winding(&place_m)).sum();
            if body.volume_m3 > 0.0 && winding > INSIDE {
                return Err(MeshError::Overlap { body: index + 1, bodies: count, at_m: place_m.into() });
            }
            if body.volume_m3 < 0.0 && winding < TOUCHES {
                return Err(inside_out);
            }
        }
    }
    Ok(bodies.iter().map(|body| body.volume_m3).sum())
}
