//! Conversions between metres, cells and pixels, with the reason why each cannot lose anything that counts.

/// Image arithmetic runs in single precision: eight bits leave the camera.
#[allow(clippy::cast_possible_truncation, reason = "rounding to single precision is meant")]
pub(super) fn single(value: f64) -> f32 {
    value as f32
}

/// Largest whole number not above `value`; saturates far outside any bed.
#[allow(
    clippy::cast_possible_truncation,
    reason = "a bed has fewer than 2^31 cells to a side; others saturate"
)]
pub(super) fn floor(value: f64) -> i32 {
    value.floor() as i32
}

/// A count as a number.
#[allow(clippy::cast_precision_loss, reason = "pixels and cells of an image are far below 2^24")]
pub(super) fn count(value: usize) -> f32 {
    value as f32
}

/// An index of a pixel or cell as a number.
#[allow(clippy::cast_precision_loss, reason = "pixels and cells of an image are far below 2^24")]
pub(super) fn number(value: i32) -> f32 {
    value as f32
}

/// A size as a coordinate.
pub(super) fn signed(value: usize) -> i32 {
    i32::try_from(value).unwrap_or(i32::MAX)
}

/// A coordinate that is known not to be negative as an index; zero otherwise.
pub(super) fn index(value: i32) -> usize {
    usize::try_from(value).unwrap_or(0)
}

/// A grey level in [0, 255], rounded. The sum with 2^23 leaves the rounded level in the lowest bits of the
/// significand, which costs an addition where a conversion would cost a branch.
#[allow(clippy::cast_possible_truncation, reason = "the lowest eight bits are meant")]
pub(super) fn grey(level: f32) -> u8 {
    (level.clamp(0.0, 255.0) + 8_388_608.0).to_bits() as u8
}
