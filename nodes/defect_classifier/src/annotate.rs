//! The frame with what was found in it drawn, for people.

use crate::camera::Camera;
use crate::path::Road;
use crate::width::SeenEdge;
use models::params::{ParamError, in_range};
use opencv::core::{Mat, Point, Rect, Scalar, Vector, VectorToVec};
use opencv::{imgcodecs, imgproc};
use serde::Deserialize;

/// How pictures are drawn. Built only from a valid [`RawPicture`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawPicture")]
pub struct PictureParams(RawPicture);

/// The `picture` block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawPicture {
    /// One frame of so many is drawn; 0 for none.
    pub every: u32,
    /// Quality of the JPEG, 1 to 100.
    pub jpeg_quality: u8,
}

impl TryFrom<RawPicture> for PictureParams {
    type Error = ParamError;

    fn try_from(raw: RawPicture) -> Result<Self, ParamError> {
        in_range("picture.every", f64::from(raw.every), "frames", (0.0, 1e6))?;
        in_range("picture.jpeg_quality", f64::from(raw.jpeg_quality), "-", (1.0, 100.0))?;
        Ok(Self(raw))
    }
}

impl PictureParams {
    /// Whether this frame is drawn; frames count from 1.
    #[must_use]
    pub fn wants(&self, frame: u64) -> bool {
        self.0.every > 0 && frame.is_multiple_of(u64::from(self.0.every))
    }
}

/// What is drawn over a frame.
#[derive(Debug, Clone, Copy)]
pub struct Overlay<'a> {
    /// Roads with the part laid `[m]`: their commanded centre lines.
    pub roads: &'a [(Road, f64)],
    /// Camera and where the tool was.
    pub view: (&'a Camera, [f64; 2]),
    /// Edges that were measured.
    pub edges: &'a [SeenEdge],
    /// Place of a defect: column, row, width, height `[px]`.
    pub region_px: Option<[u32; 4]>,
    /// Lines of text, from the top.
    pub lines: &'a [String],
}

/// Blue, green, red.
const PATH: [f64; 3] = [200.0, 120.0, 40.0];
const EDGE: [f64; 3] = [60.0, 230.0, 60.0];
const REGION: [f64; 3] = [40.0, 40.0, 255.0];
const TEXT: [f64; 3] = [255.0, 255.0, 255.0];
/// Below the text, so that it can be read on any ground.
const SHADE: [f64; 3] = [0.0, 0.0, 0.0];
const FONT_SCALE: f64 = 0.45;
const LINE_PX: i32 = 17;
const LEFT_PX: i32 = 6;
/// Bits of a fraction of a pixel.
const SHIFT: i32 = 4;
/// Largest coordinate that drawing takes without overflow `[px]`.
const FAR_PX: f64 = 1e5;

/// The frame in colour as JPEG.
///
/// # Errors
/// A picture operation that failed.
pub fn draw(grey: &Mat, overlay: &Overlay<'_>, params: &PictureParams) -> Result<Vec<u8>, opencv::Error> {
    let mut picture = Mat::default();
    imgproc::cvt_color_def(grey, &mut picture, imgproc::COLOR_GRAY2BGR)?;
    let (camera, tool_m) = overlay.view;
    for (road, laid_m) in overlay.roads.iter().filter(|(_, laid_m)| *laid_m > 0.0) {
        let ends_px = [camera.pixel(tool_m, road.from_m), camera.pixel(tool_m, road.point_m(*laid_m))];
        line(&mut picture, ends_px, PATH)?;
    }
    for edge in overlay.edges {
        line(&mut picture, edge.ends_px, EDGE)?;
    }
    if let Some(region) = overlay.region_px {
        let [left, top, width, height] = region.map(|value| i32::try_from(value).unwrap_or(i32::MAX));
        imgproc::rectangle(
            &mut picture,
            Rect::new(left, top, width, height),
            colour(REGION),
            2,
            imgproc::LINE_8,
            0,
        )?;
    }
    let mut base = LINE_PX;
    for text in overlay.lines {
        for (ink, thickness) in [(SHADE, 3), (TEXT, 1)] {
            let (at, font) = (Point::new(LEFT_PX, base), imgproc::FONT_HERSHEY_SIMPLEX);
            let ink = colour(ink);
            imgproc::put_text(
                &mut picture,
                text,
                at,
                font,
                FONT_SCALE,
                ink,
                thickness,
                imgproc::LINE_8,
                false,
            )?;
        }
        base += LINE_PX;
    }
    let mut bytes = Vector::new();
    let quality = Vector::from_slice(&[imgcodecs::IMWRITE_JPEG_QUALITY, i32::from(params.0.jpeg_quality)]);
    imgcodecs::imencode(".jpg", &picture, &mut bytes, &quality)?;
    Ok(bytes.to_vec())
}

fn line(picture: &mut Mat, ends_px: [[f64; 2]; 2], ink: [f64; 3]) -> Result<(), opencv::Error> {
    let [from, to] = ends_px.map(fine);
    imgproc::line(picture, from, to, colour(ink), 1, imgproc::LINE_8, SHIFT)
}

fn colour([blue, green, red]: [f64; 3]) -> Scalar {
    Scalar::new(blue, green, red, 0.0)
}

#[expect(clippy::cast_possible_truncation, reason = "bounded just before")]
fn fine(pixel: [f64; 2]) -> Point {
    let scale = f64::from(1 << SHIFT);
    let [x, y] = pixel.map(|value| (value.clamp(-FAR_PX, FAR_PX) * scale).round() as i32);
    Point::new(x, y)
}
