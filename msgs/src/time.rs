//! Stamps and seconds.

use crate::standard::{Header, Time};

/// Nanoseconds in a second.
const NANOS_PER_S: f64 = 1e9;

impl Time {
    /// Stamp of `seconds` since the clock's epoch, rounded to a nanosecond. What cannot be written (not finite,
    /// beyond 68 years) becomes the nearest stamp that can.
    #[must_use]
    pub fn from_seconds(seconds: f64) -> Self {
        let whole = seconds.floor();
        let nanos = ((seconds - whole) * NANOS_PER_S).round();
        let (whole, nanos) = if nanos >= NANOS_PER_S { (whole + 1.0, 0.0) } else { (whole, nanos) };
        // A float to integer cast saturates, and NaN becomes 0.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        Self { sec: whole as i32, nanosec: nanos as u32 }
    }

    /// Seconds since the clock's epoch; `None` where the nanoseconds are no fraction of a second.
    #[must_use]
    pub fn seconds(&self) -> Option<f64> {
        let nanos = f64::from(self.nanosec);
        (nanos < NANOS_PER_S).then(|| f64::from(self.sec) + nanos / NANOS_PER_S)
    }
}

impl Header {
    /// Header with a stamp and no frame.
    #[must_use]
    pub fn at(seconds: f64) -> Self {
        Self { stamp: Time::from_seconds(seconds), frame_id: String::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stamp_keeps_the_nanosecond() {
        for seconds in [0.0, 0.1, 1.999_999_999, 12_345.678_901_234, -0.25] {
            let back = Time::from_seconds(seconds).seconds().unwrap();
            assert!(
                (back - seconds).abs() <= 0.5e-9 + seconds.abs() * f64::EPSILON,
                "{seconds} became {back}"
            );
        }
    }

    #[test]
    fn rounding_carries_into_the_next_second() {
        assert_eq!(Time::from_seconds(1.999_999_999_9), Time { sec: 2, nanosec: 0 });
    }

    #[test]
    fn an_impossible_stamp_is_refused() {
        assert_eq!(Time { sec: 1, nanosec: 1_000_000_000 }.seconds(), None);
    }
}
