//! Colours: names that the page's style sheet gives a value for light and for dark.

use plotters::style::RGBColor;

/// A colour by its part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ink {
    /// Letters.
    Text,
    /// Grid and axes.
    Grid,
    /// What is asked for.
    Target,
    /// What was measured.
    Measured,
    /// What was estimated.
    Estimated,
    /// A fourth signal.
    Fourth,
    /// A fifth signal.
    Fifth,
    /// An event to know of.
    Info,
    /// A warning.
    Warn,
    /// An error.
    Error,
    /// Where a consistent signal lies.
    Good,
}

/// Every ink with the name of its style.
pub(crate) const INKS: [(Ink, &str); 11] = [
    (Ink::Text, "text"),
    (Ink::Grid, "grid"),
    (Ink::Target, "target"),
    (Ink::Measured, "measured"),
    (Ink::Estimated, "estimated"),
    (Ink::Fourth, "fourth"),
    (Ink::Fifth, "fifth"),
    (Ink::Info, "info"),
    (Ink::Warn, "warn"),
    (Ink::Error, "error"),
    (Ink::Good, "good"),
];

impl Ink {
    /// A colour that stands for this one until the drawing is done: the plotting library writes fixed colours.
    pub(crate) fn stand_in(self) -> RGBColor {
        RGBColor(1, 2, self as u8)
    }

    /// Name of its style.
    pub(crate) fn style(self) -> &'static str {
        INKS.iter().find(|(ink, _)| *ink == self).map_or("text", |(_, name)| name)
    }
}

/// Gives the colours of a drawing over to the style sheet, and leaves out what says nothing.
pub(crate) fn styled(drawing: &str) -> String {
    let mut text = drawing.to_owned();
    for (ink, name) in INKS {
        text = text.replace(&format!("\"#0102{:02X}\"", ink as u8), &format!("\"var(--{name})\""));
    }
    for nothing in [" opacity=\"1\"", " stroke-width=\"1\"", " font-family=\"sans-serif\""] {
        text = text.replace(nothing, "");
    }
    text
}
