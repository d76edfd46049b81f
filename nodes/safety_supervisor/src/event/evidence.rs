//! The number that a cause rests on.

use std::fmt;

/// A number with its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// What was measured or counted.
    pub value: f64,
    /// Its unit, or what was counted; the first word is the unit of the limit too.
    pub unit: &'static str,
    /// Digits behind the point for people.
    pub digits: usize,
    /// What it went beyond, where one number says that.
    pub limit: Option<f64>,
}

impl Evidence {
    /// Beside the limit that it went beyond.
    #[must_use]
    pub fn beyond(self, limit: f64) -> Self {
        Self { limit: Some(limit), ..self }
    }
}

impl fmt::Display for Evidence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (unit, digits) = (self.unit, self.digits);
        write!(f, "{:.digits$} {unit}", self.value)?;
        let Some(limit) = self.limit else { return Ok(()) };
        let (unit, _) = unit.split_once(' ').unwrap_or((unit, ""));
        write!(f, ", limit {limit:.digits$} {unit}")
    }
}
