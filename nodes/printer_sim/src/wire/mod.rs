//! Simulated wire process: a second plant, drop by drop and layer over layer.
//!
//! ```text
//! speeds of wire and head -> drives with lag -> drops -> surface H(x) -> trailing sensor -> samples, later
//!                                                 ^ dips and bumps, scatter          ^ noise, delay
//! ```
//! A drop of volume V leaves `V/(bead width)` of area in the plane of the wall, as a bell over the place where its wire
//! was molten; what would fall beyond the ends of the wall is held there by surface tension. Its parameters
//! (`config/plants/wire.yaml`) deviate from those that plan and correction believe. All figures are simulated.
//!
//! Not here yet: the topic `sensors/layer/height` and a node; [`HeightSample`] is what it will carry.

mod params;
mod plant;
mod surface;

pub use params::{Params, RawParams, RawSensor};
pub use plant::{HeightSample, Speeds, WirePlant};
pub use surface::Surface;

#[cfg(test)]
mod tests;
