//! Brain and drivers of the camera: frames in, checked JPEG frames or counted refusals out.
//!
//! A frame is judged by its header alone: magic number, size, dimensions (S9); a JPEG passes untouched. What its
//! picture shows (dark, blurred, defects) is the classifier's to say.

#![forbid(unsafe_code)]

#[cfg(feature = "ros")]
mod convert;
pub mod frames;
#[cfg(test)]
mod live_tests;
pub mod multipart;
#[cfg(feature = "ros")]
pub mod node;
pub mod params;
pub mod picture;
pub mod url;

pub use frames::{Accepted, Frames, Refusal, Refusals};
pub use params::{Driver, Params};
