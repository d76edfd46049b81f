//! Bytes that nobody sends: every reader of the wire answers, and what it lets through lies in its physical range.
//!
//! Random bytes and sound messages that were flipped, cut, lengthened, or given lengths and floats of the worst kind go
//! through the decoder of the middleware and the readers that all nodes use (readers of one node alone: `convert.rs` of
//! that node). `FDM_MALFORMED_PAYLOADS` sets how many for each type; a payload is made of its number alone, so that a
//! failure can be made again.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may panic and says what it did")]

#[path = "malformed/messages.rs"]
mod messages;
#[path = "malformed/others.rs"]
mod others;
#[path = "malformed/storm.rs"]
mod storm;
#[path = "malformed/text.rs"]
mod text;
