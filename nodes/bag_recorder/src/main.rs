//! Records every topic of a printer to a rosbag2-compatible MCAP bag.
#![forbid(unsafe_code)]

mod convert;
mod error;
mod file;
mod folder;
mod node;
mod recovery;
mod tally;
mod writer;

/// Entry point.
fn main() -> std::process::ExitCode {
    runtime::run("bag_recorder", node::run)
}
