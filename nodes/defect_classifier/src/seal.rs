//! The checksum that a network's file carries of everything else in it: a digit that a bad disk or a bad copy has changed
//! makes a number as good as any other, and a probe misses what its inputs leave at rest.

use sha2::{Digest, Sha256};
use std::fmt::Write;

/// The field before anything is known of it.
const EMPTY: &str = "\"sha256\": \"\"";

/// A text with its checksum in the field that is empty.
pub(crate) fn sealed(text: &str) -> String {
    text.replacen(EMPTY, &format!("\"sha256\": \"{}\"", digest(text, "")), 1)
}

/// The checksum of a text in which `written` stands for it.
pub(crate) fn digest(text: &str, written: &str) -> String {
    let bytes = Sha256::digest(text.replacen(written, "", 1));
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        _ = write!(text, "{byte:02x}");
        text
    })
}

/// Flips each `step`th bit of a text alone; what is still text has to be refused. For the tests of what is sealed.
#[cfg(test)]
#[allow(clippy::panic, reason = "a test may")]
pub(crate) fn flip_bits<E: std::fmt::Display>(text: &str, step: usize, refusal: impl Fn(&str) -> Option<E>) {
    for place in (0..text.len() * 8).step_by(step) {
        let mut bytes = text.as_bytes().to_vec();
        bytes[place / 8] ^= 1 << (place % 8);
        // What is no text any more is refused where the file is read.
        let Ok(flipped) = String::from_utf8(bytes) else { continue };
        match refusal(&flipped) {
            Some(reason) => assert!(!reason.to_string().is_empty()),
            None => panic!("bit {} of byte {} was flipped, and the file taken", place % 8, place / 8),
        }
    }
}
