//! Parameters are parsed, not validated: a parameter struct is built only from a raw one through these checks.
//!
//! The message starts with `name = value`, so that the loader can find file and line of the field again.

mod serial;

pub use serial::{RawSerialParams, SerialParams};

/// Why a parameter was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ParamError {
    /// A value outside its allowed range.
    #[error("{name} = {}: must be {rule}", with_unit(value, unit))]
    OutOfRange {
        /// Field as written in the file, relative to its block.
        name: &'static str,
        /// The refused value.
        value: f64,
        /// Unit of value and rule.
        unit: &'static str,
        /// The allowed range, for people.
        rule: String,
    },
    /// Two values that must stand in order do not.
    #[error("{lower} = {lower_value}: must be below {upper} = {upper_value}")]
    NotOrdered {
        /// Field that must be the smaller one.
        lower: &'static str,
        /// Its value.
        lower_value: f64,
        /// Field that must be the larger one.
        upper: &'static str,
        /// Its value.
        upper_value: f64,
    },
    /// A text that is no name of a frame.
    #[error("{name} = '{value}': must be a frame's name, without blanks and without '/' in front")]
    NoFrame {
        /// Field as written in the file, relative to its block.
        name: &'static str,
        /// What it says.
        value: String,
    },
}

/// A value with its unit behind it, for people; `-` is the unit of what has none.
#[must_use]
pub fn with_unit(value: impl std::fmt::Display, unit: &str) -> String {
    match unit {
        "" => value.to_string(),
        "-" => format!("{value} (no unit)"),
        unit => format!("{value} {unit}"),
    }
}

/// Passes a finite value above zero.
///
/// # Errors
/// [`ParamError::OutOfRange`] for zero, negative and not finite values.
pub fn positive(name: &'static str, value: f64, unit: &'static str) -> Result<f64, ParamError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(ParamError::OutOfRange { name, value, unit, rule: "finite and > 0".into() })
    }
}

/// Passes a finite value inside `[low, high]`.
///
/// # Errors
/// [`ParamError::OutOfRange`] outside of it.
pub fn in_range(
    name: &'static str,
    value: f64,
    unit: &'static str,
    (low, high): (f64, f64),
) -> Result<f64, ParamError> {
    if value.is_finite() && (low..=high).contains(&value) {
        Ok(value)
    } else {
        Err(ParamError::OutOfRange { name, value, unit, rule: format!("in [{low}, {high}]") })
    }
}

/// Demands `lower < upper`.
///
/// # Errors
/// [`ParamError::NotOrdered`] where it does not hold.
pub fn ordered(lower: (&'static str, f64), upper: (&'static str, f64)) -> Result<(), ParamError> {
    if lower.1 < upper.1 {
        Ok(())
    } else {
        Err(ParamError::NotOrdered {
            lower: lower.0,
            lower_value: lower.1,
            upper: upper.0,
            upper_value: upper.1,
        })
    }
}

/// Whether readers of transforms take a text for the name of a frame.
#[must_use]
pub fn is_frame_name(text: &str) -> bool {
    let blank = |letter: char| letter.is_whitespace() || letter.is_control();
    !(text.is_empty() || text.starts_with('/') || text.contains(blank))
}

/// Passes the name of a frame.
///
/// # Errors
/// [`ParamError::NoFrame`] for any other text.
pub fn frame_name(name: &'static str, value: String) -> Result<String, ParamError> {
    if is_frame_name(&value) { Ok(value) } else { Err(ParamError::NoFrame { name, value }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_names_field_value_unit_and_range() {
        let error = in_range("flow_max", 3.0, "-", (1.0, 2.0)).unwrap_err();
        assert_eq!(error.to_string(), "flow_max = 3 (no unit): must be in [1, 2]");
    }

    #[test]
    fn a_frame_has_a_name_without_blanks() {
        for blank in ["", " ", "two words", "tab\t", "/bed", "line\n"] {
            let said = frame_name("frame", blank.to_owned()).unwrap_err().to_string();
            assert!(said.starts_with(&format!("frame = '{blank}': must be a frame's name")), "{said}");
        }
        assert_eq!(frame_name("frame", "left/imu".to_owned()).as_deref(), Ok("left/imu"));
    }

    #[test]
    fn not_finite_values_are_never_in_range() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(positive("x", value, "m").is_err());
            assert!(in_range("x", value, "m", (f64::MIN, f64::MAX)).is_err());
        }
    }
}
