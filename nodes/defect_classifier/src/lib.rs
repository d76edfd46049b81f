//! Defects, road width and layer quality from camera frames.
//!
//! | module | what |
//! |---|---|
//! | [`camera`] | where a pixel lies on the bed |
//! | [`frame`] | from a JPEG to a grey picture that can be judged |
//! | [`path`] | which road was laid where and when |
//! | [`features`] [`network`] [`fusion`] | what the picture looks like, what that means, and how sure it is over time |

#![forbid(unsafe_code)]

pub mod camera;
pub mod features;
pub mod frame;
pub mod fusion;
pub mod network;
pub mod path;
