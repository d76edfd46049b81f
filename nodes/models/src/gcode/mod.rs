//! G-code of the dialects in use: lines, words, modal state, header, survey. Millimetres end here.
//!
//! Decisions, each visible in the warnings where it matters:
//! - A line with a bad value, a word twice, a letter that lacks its value or a strange byte is refused as a whole:
//!   half a move is a guess. Absolute E loses nothing by it.
//! - E is an axis: `X1e2` is X1 E2, never X100. `0x10` is 0 and an X word.
//! - Lines are counted by LF, as editors do; a lone CR separates commands inside a line.
//! - E is relative under `M83` or `G91` (Klipper, PrusaSlicer's estimator); `G92` alone zeroes all axes (Klipper).
//! - `G10`/`G11` retract; with P, L or R they would set tool offsets and are skipped.
//! - Layers follow the slicer's marks; without marks the height of the first level extrusion.
//! - Start and end macros of Klipper: see `macros`.

mod arc;
mod comment;
mod execute;
mod header;
mod interpret;
mod lex;
mod macros;
mod modal;
mod moves;
mod number;
mod oddity;
pub mod order;
mod read;
mod settings;
pub mod survey;
mod words;

#[cfg(test)]
mod tests;

pub use header::Header;
pub use interpret::{Instruction, Interpreter, LimitChange};
pub use lex::{Head, Lexed, lex};
pub use oddity::{Oddities, Oddity, Warning};
pub use read::LineReader;
pub use words::Words;
