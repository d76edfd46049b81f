//! G-code of the dialects in use: lines, words, modal state, header, survey. Millimetres end here.

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
