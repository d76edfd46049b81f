//! What two or more nodes share, as plain arithmetic: no ROS, no clock, no thread, no file, no log.
//!
//! | module | what |
//! |---|---|
//! | [`units`] | newtypes for time, temperature and duty |
//! | [`params`] | errors of parameters and the checks that raise them |
//! | [`material`] [`hotend`] [`heater`] [`bed`] [`melt`] [`extruder`] [`bead`] [`latent`] [`quality`] | System 1 of the model book |
//! | [`gcode`] [`motion`] | dialects, interpreter, look-ahead planner |
//! | [`command`] | trims, permits, validity, clamping and the dead-man |
//! | [`printer`] | the nominal printer of a parameter file |
//! | [`status`] | what a printer says of itself |
//! | [`transient`] | a dip of the flow that passes by itself |
//! | [`advance`] | System 2 of the model book: pressure advance, its test line, turns |
//! | [`wire`] [`hybrid`] | Systems 3 and 4 of the model book: metal wire, five-axis machine |
//!
//! SI units throughout; a field that has a unit carries it in its name. Millimetres exist in [`gcode`] alone.

#![forbid(unsafe_code)]

#[macro_use]
mod read_only;

pub mod advance;
pub mod bead;
pub mod bed;
pub mod command;
pub mod extruder;
pub mod gcode;
pub mod heater;
pub mod hotend;
pub mod hybrid;
pub mod latent;
pub mod material;
pub mod melt;
pub mod motion;
pub mod params;
pub mod printer;
pub mod quality;
pub mod status;
pub mod transient;
pub mod units;
pub mod wire;
