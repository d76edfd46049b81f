//! Defects, road width and layer quality from camera frames.
//!
//! | module | what |
//! |---|---|
//! | [`classifier`] | the brain: events in, outputs out |
//! | [`camera`] [`frame`] | where a pixel lies on the bed; from a JPEG to a grey picture that can be judged |
//! | [`path`] | which road was laid where and when, as commanded |
//! | [`pressure`] | share of the wanted flow that a sound nozzle lays while pressure builds up |
//! | [`width`] | width of fresh road from its edges in the picture |
//! | [`seam`] | shade of the seams between roads, beside the same places on the layers below |
//! | [`offset`] | where what was laid before lies, beside where it was laid |
//! | [`unexplained`] | edges in the picture that no commanded road explains |
//! | [`features`] [`network`] [`fusion`] | what the picture looks like, what that means, and how sure it is over time |
//! | [`layer`] | quality Q_k of a layer and its terms |
//! | [`annotate`] | the frame with what was found drawn in it |

#![forbid(unsafe_code)]

pub mod annotate;
pub mod camera;
pub mod classifier;
#[cfg(feature = "ros")]
#[doc(hidden)] // for `fdm replay`, which reads and says what the node does
pub mod convert;
mod event;
pub mod features;
pub mod frame;
pub mod fusion;
pub mod layer;
pub mod network;
#[cfg(feature = "ros")]
pub mod node;
pub mod offset;
pub mod params;
pub mod path;
pub mod pressure;
mod seal;
pub mod seam;
mod surroundings;
pub mod unexplained;
pub mod usual;
pub mod width;

pub use classifier::{Classifier, Counts, Models};
pub use event::{Defects, EstimateReading, Event, Judged, Note, Output, Weight};
pub use params::Params;
