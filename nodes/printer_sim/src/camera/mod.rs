//! The simulated printer's camera: what was deposited, seen from the toolhead.
//!
//! ```text
//! road under the nozzle --> Deposit (height field, true bed frame) --> Renderer --> Frame --> JPEG
//! Look (one draw of a Style by seed: light, greys, gloss, bed, noise, blur) ----^
//! ```
//! Geometry, shared with whoever measures in the frames: the camera rides on the toolhead and looks straight down.
//! The projection is orthographic: differences in height are far below the working distance, so a real camera of
//! this kind would deviate by less than `z / working_distance` (an idealisation). Image x points to bed +X, image y
//! to bed -Y. The nozzle's tip lies at the principal point; the pixel `(u, v)`, whose centre has integer
//! coordinates, shows the bed at `X = x_tool + (u - cx) scale`, `Y = y_tool - (v - cy) scale`, see [`Geometry`].
//! Nozzle and camera keep their distance, so the head is a disc that always hides the same pixels.
//!
//! | part | what |
//! |---|---|
//! | [`Deposit`] | height field in tiles; stamps roads and loose strands |
//! | [`Look`] | one draw of the ranges of a [`Style`]: the same seed gives the same camera |
//! | [`Renderer`] | normals, Lambert and Blinn-Phong, occlusion, blur, head, noise |
//! | [`Rig`] | the camera on the printer: roads in, frames out, once a period |
//! | [`synthesize`] | labelled frames of random parts, for training |
//! | [`Tangle`] | filament that missed the part: curves that grow with the extruded volume |
//!
//! Two styles exist, [`Style::Training`] and [`Style::Test`], with other ranges of shading, noise, bed and greys: a
//! classifier trained on the one and judged on the other cannot have learnt the renderer by heart.

mod cast;
mod deposit;
mod geometry;
mod head;
mod image;
mod lens;
mod look;
mod params;
mod part;
mod render;
mod rig;
mod shade;
mod strands;
mod synthesize;
mod texture;

pub use deposit::{Bead, Deposit};
pub use geometry::Geometry;
pub use image::Frame;
pub use look::Look;
pub use params::{CameraParams, FieldParams, RawCamera, Span, Style, StyleRanges, TextureKind};
pub use render::{Renderer, View};
pub use rig::{Camera, Moment, Rig, Shot};
pub use strands::{Tangle, blob, string};
pub use synthesize::{Class, Example, synthesize};

#[cfg(test)]
pub(crate) mod tests;
