//! P13: the stop contact of button and door is open.

use crate::params::StopInputParams;

/// Watches the contact.
#[derive(Debug, Clone)]
pub struct StopInputCheck {
    params: StopInputParams,
    open: u32,
}

impl StopInputCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: StopInputParams) -> Self {
        Self { params, open: 0 }
    }

    /// Takes the contact; `None` where none is fitted.
    pub fn on_input(&mut self, open: Option<bool>) {
        self.open = if open == Some(true) { self.open.saturating_add(1) } else { 0 };
    }

    /// Whether enough reports in a row say open: one may be a disturbed wire.
    #[must_use]
    pub fn tripped(&self) -> bool {
        self.open >= self.params.reports
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_reports_in_a_row_trip_one_or_none_fitted_do_not() {
        let mut check = StopInputCheck::new(StopInputParams { reports: 2 });
        for (open, trips) in [
            (Some(true), false),
            (Some(false), false),
            (Some(true), false),
            (Some(true), true),
            (None, false),
        ] {
            check.on_input(open);
            assert_eq!(check.tripped(), trips);
        }
    }
}
