//! What a bag holds and how its folder looks: the pure part of the recorder.
//!
//! A bag is a folder that the ROS 2 tools read: `<bag>/<bag>_0.mcap`, `<bag>_1.mcap`, ... and `metadata.yaml`.
//!
//! | while | the folder holds |
//! |---|---|
//! | recording | `<bag>_<n>.mcap.active`, unchunked: each whole record in it survives a kill; `metadata.yaml` lists the files before it |
//! | a file later, and after an orderly end | `<bag>_<n>.mcap` with summary, listed; written anew in compressed chunks with an index as time allows, at the next start at the latest |
//! | beside a file that must not be dropped | `<bag>_<n>.mcap.keep`, empty |
//! | after a kill | the `.active` file stays; the next recorder copies its whole records to `<bag>_<n>.mcap` and writes to `<bag>_<n+1>` |
//! | after damage in the midst of a file | `fdm recover` copies what can be read before and behind it, and keeps the file as `<bag>_<n>.mcap.torn` |
//!
//! `counts.json` says how many messages each topic has in the bag; readers of bags pass over it.
//!
//! | module | what |
//! |---|---|
//! | [`layout`] | names of files, what a folder needs before recording |
//! | [`contents`] | files, channels and counts of a bag |
//! | [`metadata`] | text of `metadata.yaml` and `counts.json` |
//! | [`offered_qos`] | quality of service as bags write it |
//! | [`order`] | log time of each message |
//! | [`params`] | the parameters |
//! | [`retention`] | which file goes where room is short |
//! | [`ring`] | the last seconds in memory, for a snapshot |
//! | `node`, `clock`, `writer`, `file`, `folder`, `recovery`, `walk` | the shell, behind the feature `ros`: files and threads; `fdm` uses them too |
#![forbid(unsafe_code)]

#[cfg(feature = "ros")]
mod clock;
pub mod contents;
#[cfg(feature = "ros")]
mod convert;
#[cfg(feature = "ros")]
pub mod error;
#[cfg(feature = "ros")]
pub mod file;
#[cfg(feature = "ros")]
pub mod folder;
pub mod layout;
pub mod metadata;
#[cfg(feature = "ros")]
pub mod node;
pub mod offered_qos;
pub mod order;
pub mod params;
#[cfg(feature = "ros")]
pub mod record;
#[cfg(feature = "ros")]
pub mod recovery;
pub mod retention;
pub mod ring;
#[cfg(feature = "ros")]
pub mod tally;
#[cfg(feature = "ros")]
pub mod walk;
#[cfg(feature = "ros")]
pub mod whole;
#[cfg(feature = "ros")]
pub mod writer;

#[cfg(feature = "ros")]
pub use convert::recorded;
