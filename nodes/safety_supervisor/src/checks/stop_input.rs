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

    /// Takes the contact; `None` where none is fitted. One that is open is not closed by being told no more.
    pub fn on_input(&mut self, open: Option<bool>) {
        self.open = match open {
            Some(true) => self.open.saturating_add(1),
            None if self.tripped() => self.open,
            _ => 0,
        };
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
    fn two_reports_in_a_row_trip_and_only_a_closed_contact_ends_it() {
        let mut check = StopInputCheck::new(StopInputParams { reports: 2 });
        for (open, trips) in [
            (Some(true), false),
            (Some(false), false),
            (Some(true), false),
            (None, false),
            (Some(true), false),
            (Some(true), true),
            (None, true),
            (Some(false), false),
        ] {
            check.on_input(open);
            assert_eq!(check.tripped(), trips);
        }
    }
}
