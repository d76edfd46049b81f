//! The number that a cause rests on.

use std::fmt;

/// A number with its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// What was measured or counted.
    pub value: f64,
    /// Its unit, or what was counted.
    pub unit: &'static str,
    /// Digits behind the point for people.
    pub digits: usize,
}

impl fmt::Display for Evidence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.*} {}", self.digits, self.value, self.unit)
    }
}
