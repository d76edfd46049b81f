//! What holds of everything that is let through.

use std::fmt::Debug;

/// Every number in a value is finite, as far as it shows itself.
pub(crate) fn is_finite(value: &impl Debug) {
    let shown = format!("{value:?}");
    let broken =
        shown.split(|letter: char| !letter.is_ascii_alphanumeric()).any(|word| matches!(word, "NaN" | "inf"));
    assert!(!broken, "let through: {shown}");
}

/// Text for a log or a line: one line, and not without end.
pub(crate) fn is_one_line(text: &str) {
    assert!(!text.contains(char::is_control), "{text:?}");
    assert!(text.len() <= 4096, "{} bytes: {:.200?}", text.len(), text);
}
