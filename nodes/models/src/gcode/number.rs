//! Decimal numbers as G-code writes them: `22.`, `.5`, `+21.0`, `-0.0`; no exponent, for E is an axis.

const POWERS_OF_TEN: [f64; 20] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19,
];

/// Largest integer up to which every integer is a double.
const EXACT_MAX: u64 = 1 << 53;

/// Value and length of the number at the start of `bytes`; `None` where there is none.
///
/// Correctly rounded: one division of two exact doubles, or the standard library's parser for longer numbers.
pub(super) fn number(bytes: &[u8]) -> Option<(f64, usize)> {
    let (negative, sign) = match bytes.first()? {
        b'-' => (true, 1),
        b'+' => (false, 1),
        _ => (false, 0),
    };
    let (mut mantissa, mut digits, mut fraction, mut at) = (0_u64, 0_usize, 0_usize, sign);
    let mut dot = false;
    while let Some(&byte) = bytes.get(at) {
        match byte {
            b'0'..=b'9' => {
                mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
                digits += 1;
                fraction += usize::from(dot);
            }
            b'.' if !dot => dot = true,
            _ => break,
        }
        at += 1;
    }
    if digits == 0 {
        return None;
    }
    if digits < POWERS_OF_TEN.len() && mantissa <= EXACT_MAX {
        #[allow(clippy::cast_precision_loss, reason = "exact up to EXACT_MAX")]
        let value = mantissa as f64 / POWERS_OF_TEN[fraction];
        return Some((if negative { -value } else { value }, at));
    }
    let text = std::str::from_utf8(&bytes[..at]).ok()?;
    text.parse().ok().map(|value| (value, at))
}
