//! What may be said to a firmware: a list of orders, and one writer for all of them.
//!
//! Klipper splits a script at its line ends, so whatever reaches a command as text is a command itself. Nothing here
//! takes text: an order holds numbers alone, [`Order::line`] writes them clamped and with fixed decimals, and
//! [`is_allowed`] reads a line on its own terms before it leaves. The bounds are those of the hardware that anybody
//! builds; what a printer allows is narrower and stands in its configuration ([`crate::command::Limits`]).

use crate::units::Celsius;

/// Firmware that is spoken to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Firmware {
    /// Marlin, and those that speak as it does.
    Marlin,
    /// Klipper.
    Klipper,
}

/// An order to a printer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Order {
    /// Path speed relative to the file's `[-]`.
    Speed(f64),
    /// Filament relative to the file's `[-]`.
    Flow(f64),
    /// Hot end set-point; does not wait. 0 switches it off.
    Hotend(Celsius),
    /// Bed set-point; does not wait. 0 switches it off.
    Bed(Celsius),
    /// Part fan `[0, 1]`.
    Fan(f64),
    /// Pressure advance `[s]`.
    Advance(f64),
    /// Pause and park.
    Pause,
    /// Print on.
    Resume,
    /// Give the job up.
    Cancel,
    /// Stop everything at once.
    EmergencyStop,
}

/// A value of an order is NaN or infinite: there is nothing to write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a value of the order is not finite")]
pub struct NotFinite;

/// How a number is written: bounds and decimals in the unit of the line.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Field {
    low: f64,
    high: f64,
    decimals: usize,
}

/// Marlin reads whole percents of `M220` and `M221` and cuts off what follows; Klipper reads decimals.
const SPEED_PERCENT: Field = Field { low: 10.0, high: 200.0, decimals: 0 };
const FLOW_PERCENT: Field = Field { low: 50.0, high: 150.0, decimals: 0 };
const SPEED_FINE_PERCENT: Field = Field { decimals: 1, ..SPEED_PERCENT };
const FLOW_FINE_PERCENT: Field = Field { decimals: 1, ..FLOW_PERCENT };
const HOTEND_DEGC: Field = Field { low: 0.0, high: 350.0, decimals: 1 };
const BED_DEGC: Field = Field { low: 0.0, high: 150.0, decimals: 1 };
const FAN_255: Field = Field { low: 0.0, high: 255.0, decimals: 0 };
const ADVANCE_S: Field = Field { low: 0.0, high: 2.0, decimals: 4 };

/// Every line that may leave: what stands before its number, and the number.
const NUMBERED: [(&str, Field); 9] = [
    ("M220 S", SPEED_PERCENT),
    ("M220 S", SPEED_FINE_PERCENT),
    ("M221 S", FLOW_PERCENT),
    ("M221 S", FLOW_FINE_PERCENT),
    ("M104 S", HOTEND_DEGC),
    ("M140 S", BED_DEGC),
    ("M106 S", FAN_255),
    ("M900 K", ADVANCE_S),
    ("SET_PRESSURE_ADVANCE ADVANCE=", ADVANCE_S),
];
/// As above, for lines without a number: pause, resume and cancel of a card or of macros, and the stop.
const BARE: [&str; 7] = ["M25", "M24", "M524", "PAUSE", "RESUME", "CANCEL_PRINT", "M112"];

impl Order {
    /// The line of the order, without its end.
    ///
    /// # Errors
    /// [`NotFinite`] for a value that is NaN or infinite.
    pub fn line(self, firmware: Firmware) -> Result<String, NotFinite> {
        let klipper = firmware == Firmware::Klipper;
        let either = |marlin: usize, other: usize| if klipper { other } else { marlin };
        match self {
            Self::Speed(factor) => numbered(either(0, 1), factor * 100.0),
            Self::Flow(factor) => numbered(either(2, 3), factor * 100.0),
            Self::Hotend(target) => numbered(4, target.0),
            Self::Bed(target) => numbered(5, target.0),
            Self::Fan(share) => numbered(6, share * 255.0),
            Self::Advance(advance_s) => numbered(either(7, 8), advance_s),
            Self::Pause => Ok(BARE[either(0, 3)].to_owned()),
            Self::Resume => Ok(BARE[either(1, 4)].to_owned()),
            Self::Cancel => Ok(BARE[either(2, 5)].to_owned()),
            Self::EmergencyStop => Ok(BARE[6].to_owned()),
        }
    }
}

fn numbered(index: usize, value: f64) -> Result<String, NotFinite> {
    if !value.is_finite() {
        return Err(NotFinite);
    }
    let (head, field) = NUMBERED[index];
    // The sum has no minus zero.
    let kept = value.clamp(field.low, field.high) + 0.0;
    Ok(format!("{head}{kept:.*}", field.decimals))
}

/// Whether a line is one of those that an order writes: its word known, one number in its bounds with its decimals,
/// nothing before, behind or between.
#[must_use]
pub fn is_allowed(line: &str) -> bool {
    let number_fits =
        |(head, field): &(&str, Field)| line.strip_prefix(head).is_some_and(|number| field.fits(number));
    BARE.contains(&line) || NUMBERED.iter().any(number_fits)
}

impl Field {
    /// Digits with a point before the decimals, no sign, no exponent, no zeros in front, and a value in the bounds.
    fn fits(&self, text: &str) -> bool {
        let (whole, rest) = text.split_once('.').unwrap_or((text, ""));
        let digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
        let begun = whole == "0" || !(whole.is_empty() || whole.starts_with('0'));
        let written = begun && digits(whole) && digits(rest) && rest.len() == self.decimals;
        let pointed = text.contains('.') == (self.decimals > 0);
        let inside = text.parse().is_ok_and(|value: f64| (self.low..=self.high).contains(&value));
        written && pointed && inside
    }
}

#[cfg(test)]
mod tests;
