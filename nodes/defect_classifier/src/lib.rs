//! Defects, road width and layer quality from camera frames, ROS node.
#![forbid(unsafe_code)]

pub mod features;
pub mod fusion;
pub mod network;
