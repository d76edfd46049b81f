//! Inertial unit: drivers, checks, ROS node.
#![forbid(unsafe_code)]
