//! The ROS 2 runtime of every node, and the only crate that names the ROS client and the DDS.
//!
//! ```no_run
//! use models::units::Seconds;
//! use runtime::{Node, RuntimeError, topics};
//!
//! async fn run(mut node: Node) -> Result<(), RuntimeError> {
//!     let mut temperatures = node.subscribe(&topics::HOTEND_TEMPERATURE)?;
//!     let estimates = node.publish_on(&topics::ESTIMATE)?;
//!     let mut ticks = node.timer(Seconds(0.05)); // on the node's clock
//!     let (diagnostics, work) = (node.diagnostics(), node.work());
//!     node.activated().await; // all is loaded and open: from here on it may act
//!     loop {
//!         tokio::select! {
//!             reading = temperatures.recv() => {
//!                 if !reading.message.temperature.is_finite() {
//!                     diagnostics.count("refused_not_finite");
//!                 }
//!             }
//!             _now = ticks.next() => {
//!                 estimates.send(Default::default()); // never waits; drops are counted
//!                 work.done();
//!             }
//!             () = node.shutdown() => return Ok(()),
//!         }
//!     }
//! }
//!
//! fn main() -> std::process::ExitCode {
//!     runtime::run("state_estimator", run)
//! }
//! ```
//!
//! | part | what |
//! |---|---|
//! | [`run`], [`Node`] | start from `--ros-args` and the environment, end on signals within 2 s |
//! | [`topics`], [`qos`] | every topic and service with type and quality of service at both ends |
//! | [`Publisher`] | synchronous, never waiting; drops counted |
//! | [`Subscription`], [`RawSubscription`] | time of receipt on the node's clock, publisher, age watchdog |
//! | [`Presence`] | sources that are lost and found again, as events |
//! | [`Inlet`], [`wire`] | subscriptions that refuse and count; readers of the shared messages |
//! | [`serial`] | serial lines of devices: read, sent, connected again |
//! | [`Server`], [`Client`] | services; calls with a limit |
//! | [`Clock`], [`ClockDriver`], [`Timer`] | monotonic, or `/clock` under `use_sim_time` |
//! | [`params`] | parameter files, merged, checked, hashed |
//! | [`input`] | files that people name: plain ones alone, up to a length |
//! | [`Diagnostics`], [`Work`] | `/diagnostics`, heartbeat |
//!
//! Each process watches its own middleware through a message to itself and ends when it is deaf (`self_loop`), and bounds
//! the memory that others can make it use (`bounds`).
//! A node that [`run`] starts is managed (`lifecycle`): its states can be asked for and changed, and it goes to active by itself.
#![forbid(unsafe_code)]

mod args;
mod background;
mod bounds;
mod build;
mod clock;
mod crowd;
mod diagnostics;
mod environment;
mod error;
mod frames;
mod heartbeat;
mod inlet;
pub mod input;
mod installed;
mod lifecycle;
mod logging;
mod matches;
mod names;
mod node;
mod owner;
pub mod params;
mod participants;
mod presence;
mod publisher;
pub mod qos;
mod raw;
mod raw_publisher;
mod self_ack;
mod self_loop;
pub mod serial;
mod service;
mod sessions;
mod shutdown;
mod start;
mod stats;
mod subscription;
pub mod topics;
pub mod wire;
mod witness;

pub use args::{Args, ArgsError, LogLevel};
pub use bounds::{DRIVEN_OUT, MEMORY_LIMIT, STARTED_AGAIN};
pub use build::build;
pub use clock::{Clock, ClockDriver, TICKS_LATE_MS, Timer};
pub use diagnostics::{Diagnostics, Level};
pub use environment::{Environment, Range};
pub use error::RuntimeError;
pub use frames::{FrameParams, Frames};
pub use heartbeat::Work;
pub use inlet::{FRAMES_HANDOVER, HANDOVER, Inlet, Reason, Refused, check_age};
pub use logging::write_last_lines;
pub use names::{NamespaceError, check_namespace};
pub use node::Node;
pub use params::store::LiveParameters;
pub use params::{NodePath, ParamFileError, Parameters};
pub use presence::Presence;
pub use publisher::Publisher;
pub use raw::{RawMessage, RawSubscription};
pub use raw_publisher::RawPublisher;
pub use self_loop::SelfLoopAge;
pub use service::{Asked, CallError, Client, Patience, Server};
pub use sessions::Sessions;
pub use shutdown::{STOP_WITH_PARENT, Shutdown};
pub use start::run;
pub use subscription::{Gid, Received, Subscription};
pub use witness::WITNESS;
