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
//! [`Machine`] makes a printer of it: it executes the supervisor's permits, and reports state and heights.

mod figures;
mod machine;
mod params;
mod plant;
mod surface;

pub use figures::Figures;
pub use machine::{Machine, MachineOutput, MachineParams, WireTruth};
pub use params::{MachineSettings, Params, RawMachine, RawParams, RawSensor, RawWireRun, WireRun};
pub use plant::{HeightSample, Speeds, WirePlant};
pub use surface::Surface;

#[cfg(test)]
mod tests;
