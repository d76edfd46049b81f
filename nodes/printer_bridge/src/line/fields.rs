//! Values inside of a line.

use super::{Card, LineError, Says};
use models::units::Celsius;

/// Millimetres in a metre: Marlin reports millimetres, also under inches.
const MM_M: f64 = 1000.0;

/// A temperature report. Values are as they stand there, also where they are no finite number.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Temperatures {
    /// Hot end.
    pub hotend: Option<Celsius>,
    /// Its set-point.
    pub hotend_target: Option<Celsius>,
    /// Its heater, in the firmware's steps `[-]`.
    pub hotend_power: Option<f64>,
    /// Bed.
    pub bed: Option<Celsius>,
    /// Its set-point.
    pub bed_target: Option<Celsius>,
    /// Its heater, in the firmware's steps `[-]`.
    pub bed_power: Option<f64>,
}

/// `T:210.06 /210.00 B:59.9 /60.00 @:67 B@:30`, spaces around the slash as the firmware likes; `None` where neither
/// sensor is named. `T:` is the active hot end.
pub(super) fn temperatures(text: &str) -> Result<Option<Temperatures>, LineError> {
    let hotend = reading(text, "T:")?;
    let hotend = if hotend.is_some() { hotend } else { reading(text, "T0:")? };
    let bed = reading(text, "B:")?;
    if hotend.is_none() && bed.is_none() {
        return Ok(None);
    }
    let power = |key| after(text, key).map(|rest| number(rest).map(|(value, _)| value)).transpose();
    Ok(Some(Temperatures {
        hotend: hotend.map(|(temp, _)| Celsius(temp)),
        hotend_target: hotend.and_then(|(_, target)| target).map(Celsius),
        hotend_power: power("@:")?,
        bed: bed.map(|(temp, _)| Celsius(temp)),
        bed_target: bed.and_then(|(_, target)| target).map(Celsius),
        bed_power: power("B@:")?,
    }))
}

/// `X:10.00 Y:5.00 Z:0.30 E:1.00 Count X:800 Y:400 Z:120` `[m]`; `None` for any other line.
pub(super) fn position(text: &str) -> Result<Option<[f64; 3]>, LineError> {
    let commanded = text.split("Count").next().unwrap_or_default();
    let mut position_m = [0.0; 3];
    for (slot, key) in position_m.iter_mut().zip(["X:", "Y:", "Z:"]) {
        let Some(rest) = after(commanded, key) else { return Ok(None) };
        *slot = number(rest)?.0 / MM_M;
    }
    Ok(Some(position_m))
}

/// `EMERGENCY_PARSER:1`.
pub(super) fn capability(text: &str) -> Result<Says, LineError> {
    let (name, on) = text.split_once(':').ok_or(LineError::NotNumber)?;
    let on = match on.trim() {
        "0" => false,
        "1" => true,
        _ => return Err(LineError::NotNumber),
    };
    Ok(Says::Capability { name: name.trim().to_owned(), on })
}

/// What stands between `FIRMWARE_NAME:` and the next key in capitals.
pub(super) fn firmware_name(text: &str) -> String {
    let rest = after(text, "FIRMWARE_NAME:").unwrap_or_default();
    let is_key = |word: &&str| {
        word.split_once(':').is_some_and(|(key, _)| {
            !key.is_empty() && key.chars().all(|letter| letter.is_ascii_uppercase() || letter == '_')
        })
    };
    let words: Vec<&str> = rest.split_ascii_whitespace().take_while(|word| !is_key(word)).collect();
    words.join(" ")
}

/// `1234/56789`; a file of no bytes is none.
pub(super) fn bytes(text: &str) -> Result<Card, LineError> {
    let (done, total) = text.trim().split_once('/').ok_or(LineError::NotNumber)?;
    let whole = |digits: &str| digits.trim().parse().map_err(|_| LineError::NotNumber);
    match (whole(done)?, whole(total)?) {
        (_, 0) => Ok(Card::NotPrinting),
        (done, total) if done <= total => Ok(Card::Printing { done, total }),
        _ => Err(LineError::NotNumber),
    }
}

/// A value and, after a slash, its set-point.
fn reading(text: &str, key: &str) -> Result<Option<(f64, Option<f64>)>, LineError> {
    let Some(rest) = after(text, key) else { return Ok(None) };
    let (value, rest) = number(rest)?;
    let target = rest.trim_start().strip_prefix('/').map(|rest| number(rest).map(|(target, _)| target));
    Ok(Some((value, target.transpose()?)))
}

/// What stands behind the first `key` that begins a word.
fn after<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    text.match_indices(key)
        .find(|(at, _)| text[..*at].chars().next_back().is_none_or(char::is_whitespace))
        .map(|(at, _)| &text[at + key.len()..])
}

/// The number at the beginning, and what follows it.
fn number(text: &str) -> Result<(f64, &str), LineError> {
    let text = text.trim_start();
    let end = text.find(|letter: char| letter.is_whitespace() || letter == '/').unwrap_or(text.len());
    let value = text[..end].parse().map_err(|_| LineError::NotNumber)?;
    Ok((value, &text[end..]))
}
