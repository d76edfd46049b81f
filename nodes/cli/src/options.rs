//! Numbers as they are typed and shown: a refused one is named by its option, in the option's unit.

use anyhow::bail;

/// Passes a finite value inside `[low, high]`; all in the option's unit, `-` where it has none.
///
/// # Errors
/// Option, value and range.
pub fn in_range(option: &str, value: f64, unit: &str, (low, high): (f64, f64)) -> anyhow::Result<f64> {
    let (low, high) = (rounded(low), rounded(high));
    if value.is_finite() && (low..=high).contains(&value) {
        return Ok(value);
    }
    let unit = suffix(unit);
    bail!("{option} {value}{unit}: must be in [{low}, {high}]{unit}")
}

/// Passes a finite value above 0.
///
/// # Errors
/// Option and value.
pub fn positive(option: &str, value: f64, unit: &str) -> anyhow::Result<f64> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    let unit = suffix(unit);
    bail!("{option} {value}{unit}: must be finite and > 0{unit}")
}

/// Refuses a list that names something twice: which of the two is meant, or why it stands there again, nobody can tell.
///
/// # Errors
/// Option, list and name.
pub fn distinct(option: &str, names: &[String]) -> anyhow::Result<()> {
    let twice = names.iter().enumerate().find(|(at, name)| names[..*at].contains(name));
    twice.map_or(Ok(()), |(_, name)| bail!("{option} {}: '{name}' stands twice", names.join(",")))
}

/// Refuses options that would change nothing: each of `given` that was typed needs `wanted`, which was typed or not.
///
/// # Errors
/// The first such option, and what it needs.
pub fn needs(wanted: &str, present: bool, given: &[(&str, bool)]) -> anyhow::Result<()> {
    match given.iter().find(|(_, typed)| *typed && !present) {
        Some((option, _)) => {
            bail!("{option}: has an effect only together with {wanted}, which was not given")
        }
        None => Ok(()),
    }
}

/// A value with as many digits as given, whatever its size; plain where that stays readable.
#[must_use]
pub fn significant(value: f64, digits: usize) -> String {
    let digits = digits.max(1);
    if value.abs() <= 0.0 || !value.is_finite() {
        return format!("{}", value + 0.0);
    }
    // Rounded first: 0.99996 with four digits is 1.000.
    let rounded = format!("{value:.*e}", digits - 1);
    let exponent: i32 = rounded.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0);
    match usize::try_from(exponent) {
        Ok(exponent) if exponent < 9 => format!("{value:.*}", digits.saturating_sub(1 + exponent)),
        Err(_) if exponent >= -6 => {
            let zeros = usize::try_from(-exponent).unwrap_or(0);
            format!("{value:.*}", digits - 1 + zeros)
        }
        _ => rounded,
    }
}

fn suffix(unit: &str) -> String {
    if unit == "-" { String::new() } else { format!(" {unit}") }
}

/// Without the last bits that a change of unit leaves.
fn rounded(bound: f64) -> f64 {
    if bound.abs() < 1e5 { (bound * 1e9).round() / 1e9 } else { bound }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_refused_is_named_as_it_was_typed() {
        let said = |result: anyhow::Result<f64>| result.unwrap_err().to_string();
        let range_mm = (1e3 * 1e-4, 1e3 * 0.02);
        let refused = said(in_range("--diameter", -1.0, "mm", range_mm));
        assert_eq!(refused, "--diameter -1 mm: must be in [0.1, 20] mm");
        assert_eq!(said(in_range("--gain", 5.0, "-", (0.0, 4.0))), "--gain 5: must be in [0, 4]");
        assert_eq!(said(positive("--power", 0.0, "W")), "--power 0 W: must be finite and > 0 W");
        assert!(in_range("--height", f64::NAN, "mm", (0.0, 7.0)).is_err());
    }

    #[test]
    fn an_option_without_effect_is_refused() {
        let given = [("--mode", false), ("--gain", true)];
        let said = needs("--height", false, &given).unwrap_err().to_string();
        assert_eq!(said, "--gain: has an effect only together with --height, which was not given");
        assert!(needs("--height", true, &given).is_ok() && needs("--height", false, &given[..1]).is_ok());
    }

    #[test]
    fn a_name_that_stands_twice_is_refused() {
        let names = |names: [&str; 3]| distinct("--control", &names.map(str::to_owned));
        let said = names(["off", "mpc", "off"]).unwrap_err().to_string();
        assert_eq!(said, "--control off,mpc,off: 'off' stands twice");
        assert!(names(["off", "mpc", "encoder"]).is_ok());
    }

    #[test]
    fn small_and_large_figures_keep_their_digits() {
        let cases = [(0.000_001, "0.000001000"), (0.999_96, "1.000"), (12_345.6, "12346"), (0.0, "0")];
        for (value, shown) in cases {
            assert_eq!(significant(value, 4), shown);
        }
        assert_eq!(significant(8e-9, 4), "8.000e-9");
        assert_eq!(significant(-0.0, 4), "0");
    }
}
