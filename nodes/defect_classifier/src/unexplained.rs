//! Edges that no road explains: strands, lumps and whatever else lies where nothing was laid, or across what was.
//!
//! The surface is a map of the bed that knows, cell by cell, which way the road runs that was commanded last there:
//! what a camera above sees of a print that goes as commanded. An edge in the picture is explained where such a road
//! lies under it or beside it and runs along it. The share of strong edges that none explains is near 0 for a print as
//! commanded whatever its shape, and grows with a tangle. The bare bed has edges of its own, its texture: as many per
//! area as it showed so far are not counted. What counts as strong is taken from the edges on roads, so
//! light and colour do not matter.

mod params;
#[cfg(test)]
mod tests;

pub use params::{RawUnexplained, UnexplainedParams};

use crate::camera::Camera;
use crate::features::picture::Plane;
use models::motion::{MoveKind, Segment};
use opencv::core::{
    BORDER_REFLECT_101, CV_8UC1, Mat, MatTraitConst, MatTraitConstManual, Point, Scalar, Size,
};
use opencv::imgproc;

/// Pixels of the picture to one that is looked at, each way.
const REDUCTION: f64 = 2.0;
/// Bits of a fraction of a cell in OpenCV's drawing.
const SHIFT: i32 = 4;
/// Directions that the map tells apart in the half turn; one byte holds them and 0 for no road.
const DIRECTIONS: u8 = 180;

/// Which way the road runs that was commanded last, over the bed.
#[derive(Debug)]
pub struct Surface {
    params: UnexplainedParams,
    /// Direction of the road's normal in the picture, from 1; 0 is no road. Row 0 lies at the lowest bed y.
    map: Mat,
    /// Height of strong edges per pixel of the bare bed, in heights of roads' edges.
    texture: Option<f64>,
    refused: u64,
    /// `cos` and `sin` of twice the direction, by label.
    doubled: [[f32; 2]; DIRECTIONS as usize + 1],
}

impl Surface {
    /// A bed with nothing on it.
    #[must_use]
    pub fn new(params: UnexplainedParams) -> Self {
        let mut doubled = [[0.0; 2]; DIRECTIONS as usize + 1];
        for (label, pair) in (0_u8..).zip(&mut doubled).skip(1) {
            let turn_rad = std::f64::consts::TAU * (f64::from(label) - 0.5) / f64::from(DIRECTIONS);
            *pair = [single(turn_rad.cos()), single(turn_rad.sin())];
        }
        Self { params, map: Mat::default(), texture: None, refused: 0, doubled }
    }

    /// A new print begins on an empty bed.
    pub fn clear(&mut self) {
        self.map = Mat::default();
        self.texture = None;
    }

    /// Moves that could not be drawn.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// Takes a move as it begins: what it lays covers what lay there.
    pub fn on_move(&mut self, segment: &Segment) {
        if self.draw(segment).is_err() {
            self.refused += 1;
        }
    }

    fn draw(&mut self, segment: &Segment) -> Result<(), opencv::Error> {
        let Some(width_m) = segment.target_width_m.filter(|_| segment.kind == MoveKind::Deposit) else {
            return Ok(());
        };
        let ([from_x, from_y, _], [to_x, to_y, _]) = (segment.start_m, segment.end_m);
        let (across_m, up_m) = (to_x - from_x, to_y - from_y);
        // Image y points to bed -Y: the road runs along (x, -y) there, its normal is (y, x).
        let turn = across_m.atan2(up_m).rem_euclid(std::f64::consts::PI) / std::f64::consts::PI;
        let label = 1.0 + (turn * f64::from(DIRECTIONS)).floor().min(f64::from(DIRECTIONS) - 1.0);
        let ends = [[from_x, from_y], [to_x, to_y]].map(|point_m| self.fine(point_m));
        let [Some(from), Some(to)] = ends else { return Ok(()) };
        if self.map.empty() {
            let [columns, rows] = self.params.cells();
            self.map = Mat::new_rows_cols_with_default(rows, columns, CV_8UC1, Scalar::all(0.0))?;
        }
        let thickness = whole((width_m / self.params.cell_m).round()).max(1);
        imgproc::line(&mut self.map, from, to, Scalar::all(label), thickness, imgproc::LINE_8, SHIFT)
    }

    /// Share of the strong edges that no road explains `[0, 1]`, weighed by their height, in a frame taken with the
    /// tool at `tool_m`; 0 where few roads were commanded in view: at the start of a print little can have
    /// gone wrong, and the bare bed's texture would drown it.
    ///
    /// # Errors
    /// Those of OpenCV.
    pub fn find(&mut self, grey: &Mat, (camera, tool_m): (&Camera, [f64; 2])) -> Result<f64, opencv::Error> {
        if self.map.empty() {
            return Ok(0.0);
        }
        let edges = self.edges(&reduced(grey)?, (camera, tool_m))?;
        let mut on_roads: Vec<f32> =
            edges.iter().filter(|edge| edge.on_road).map(|edge| edge.magnitude).collect();
        if on_roads.len() < self.params.pixels_min as usize {
            return Ok(0.0);
        }
        let upper = on_roads.len() * 3 / 4;
        let (_, typical, _) = on_roads.select_nth_unstable_by(upper, f32::total_cmp);
        let typical = typical.max(1e-3);
        let strong = single(self.params.strong_share) * typical;
        let (mut explained, mut across, mut bare, mut bare_pixels) = (0.0, 0.0, 0.0, 0.0);
        for edge in &edges {
            let height = if edge.magnitude > strong { f64::from(edge.magnitude / typical) } else { 0.0 };
            match (edge.explained, edge.on_road) {
                (true, _) => explained += height,
                (false, true) => across += height,
                (false, false) => {
                    bare += height;
                    bare_pixels += 1.0;
                }
            }
        }
        let texture = self.texture_of(bare, bare_pixels);
        let odd = across + (bare - self.params.texture_margin * texture * bare_pixels).max(0.0);
        let (roads, visible) = (pixels(on_roads.len()), pixels(edges.len()));
        if roads < self.params.roads_share_min * visible {
            return Ok(0.0);
        }
        Ok(if odd > 0.0 { odd / (odd + explained) } else { 0.0 })
    }

    /// Height of strong edges per pixel of the bare bed: learned slowly upwards, so that a tangle is not taken for it.
    fn texture_of(&mut self, bare: f64, bare_pixels: f64) -> f64 {
        if bare_pixels < f64::from(self.params.pixels_min) {
            return self.texture.unwrap_or(0.0);
        }
        let now = bare / bare_pixels;
        let known = self.texture.unwrap_or(now);
        let rate = if now > known { self.params.texture_rise } else { self.params.texture_fall };
        let learned = known + rate * (now - known);
        self.texture = Some(learned);
        learned
    }

    /// Gradients at the visible pixels, each held against the roads around it.
    fn edges(
        &self,
        plane: &Plane,
        (camera, tool_m): (&Camera, [f64; 2]),
    ) -> Result<Vec<Edge>, opencv::Error> {
        let labels = self.map.data_bytes()?;
        let agree = single((2.0 * self.params.turn_max_rad).cos());
        let columns = usize::try_from(self.map.cols()).unwrap_or(0);
        let mut seen = Vec::with_capacity(plane.values.len());
        for y in 1..plane.height - 1 {
            for x in 1..plane.width - 1 {
                #[expect(clippy::cast_precision_loss, reason = "pixels of a picture")]
                let pixel = [x as f64, y as f64].map(|place| (place + 0.5) * REDUCTION - 0.5);
                if !camera.sees(pixel, REDUCTION) {
                    continue;
                }
                let Some([column, row]) = self.cell(camera.bed(tool_m, pixel)) else { continue };
                let across = plane.at(x + 1, y) - plane.at(x - 1, y);
                let down = plane.at(x, y + 1) - plane.at(x, y - 1);
                let square = (across * across + down * down).max(1e-12);
                let doubled = [(across * across - down * down) / square, 2.0 * across * down / square];
                let beside = self.params.beside_cells();
                let around = [row - beside, row, row + beside].into_iter().flat_map(|row| {
                    [column - beside, column, column + beside].map(|column| row * columns + column)
                });
                let explains = |label: u8| {
                    let road = self.doubled[usize::from(label)];
                    label > 0 && road[0] * doubled[0] + road[1] * doubled[1] >= agree
                };
                seen.push(Edge {
                    magnitude: square.sqrt(),
                    on_road: labels[row * columns + column] > 0,
                    explained: around.into_iter().any(|at| explains(labels[at])),
                });
            }
        }
        Ok(seen)
    }

    /// Cell under a point of the bed, away from the map's border.
    fn cell(&self, point_m: [f64; 2]) -> Option<[usize; 2]> {
        let border = f64::from(whole_of(self.params.beside_cells()));
        let limits = self.params.cells();
        let place =
            [0, 1].map(|axis| ((point_m[axis] - self.params.bed_low_m[axis]) / self.params.cell_m).floor());
        let inside =
            (0..2).all(|axis| place[axis] >= border && place[axis] < f64::from(limits[axis]) - border);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "inside the map")]
        inside.then(|| place.map(|value| value as usize))
    }

    /// A point of the bed for OpenCV's drawing; `None` far outside of the map.
    fn fine(&self, point_m: [f64; 2]) -> Option<Point> {
        let scale = f64::from(1 << SHIFT);
        let place =
            [0, 1].map(|axis| (point_m[axis] - self.params.bed_low_m[axis]) / self.params.cell_m - 0.5);
        let near = place.iter().all(|value| value.abs() < 3e4);
        let [x, y] = place.map(|value| whole((value * scale).round()));
        near.then(|| Point::new(x, y))
    }
}

/// Gradient at a visible pixel.
struct Edge {
    magnitude: f32,
    on_road: bool,
    explained: bool,
}

fn reduced(grey: &Mat) -> Result<Plane, opencv::Error> {
    let half = |pixels: i32| whole((f64::from(pixels) / REDUCTION).ceil());
    let size = Size::new(half(grey.cols()), half(grey.rows()));
    let (mut small, mut smooth) = (Mat::default(), Mat::default());
    imgproc::resize(grey, &mut small, size, 0.0, 0.0, imgproc::INTER_AREA)?;
    imgproc::gaussian_blur(&small, &mut smooth, Size::new(3, 3), 0.8, 0.8, BORDER_REFLECT_101)?;
    Plane::of(&smooth)
}

#[expect(clippy::cast_possible_truncation, reason = "single precision is meant")]
fn single(value: f64) -> f32 {
    value as f32
}

#[expect(clippy::cast_possible_truncation, reason = "sizes and places of a map; a cast saturates")]
fn whole(value: f64) -> i32 {
    value as i32
}

#[expect(clippy::cast_precision_loss, reason = "pixels of a picture")]
fn pixels(count: usize) -> f64 {
    count as f64
}

fn whole_of(count: usize) -> i32 {
    i32::try_from(count).unwrap_or(i32::MAX)
}
