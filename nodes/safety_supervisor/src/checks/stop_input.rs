//! P13: the stop contact of button and door is open.

use crate::params::StopInputParams;

/// Reports of a closed contact in a row that end what was open before: one that chatters is not closed, and whoever
/// acknowledges beside it would have the heaters back.
const CLOSED: u32 = 5;

/// Watches the contact.
#[derive(Debug, Clone)]
pub struct StopInputCheck {
    params: StopInputParams,
    open: u32,
    closed: u32,
}

impl StopInputCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: StopInputParams) -> Self {
        Self { params, open: 0, closed: 0 }
    }

    /// Takes the contact; `None` where none is fitted. One that is open is not closed by being told no more.
    pub fn on_input(&mut self, open: Option<bool>) {
        match open {
            Some(true) => (self.open, self.closed) = (self.open.saturating_add(1), 0),
            Some(false) => self.closed = self.closed.saturating_add(1),
            None if self.tripped() => {}
            None => self.open = 0,
        }
        if self.closed >= CLOSED {
            self.open = 0;
        }
    }

    /// Whether enough reports say open, with no rest between them: one may be a disturbed wire.
    #[must_use]
    pub fn tripped(&self) -> bool {
        self.open >= self.params.reports
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPEN: Option<bool> = Some(true);
    const SHUT: Option<bool> = Some(false);

    /// Whether it has tripped after each report.
    fn trips(inputs: impl IntoIterator<Item = Option<bool>>) -> Vec<bool> {
        let mut check = StopInputCheck::new(StopInputParams { reports: 2 });
        let after = |open| {
            check.on_input(open);
            check.tripped()
        };
        inputs.into_iter().map(after).collect()
    }

    #[test]
    fn a_second_report_trips_and_only_a_contact_that_stays_closed_ends_it() {
        assert_eq!(trips([OPEN, OPEN, None, SHUT]), [false, true, true, true]);
        let mut inputs = vec![OPEN, OPEN];
        inputs.extend([SHUT; CLOSED as usize]);
        assert_eq!(trips(inputs), [false, true, true, true, true, true, false]);
        assert_eq!(trips([OPEN, None, OPEN]), [false; 3], "none fitted meanwhile");
    }

    /// Half open and half closed is no closed contact; two disturbances with a rest between them are no open one.
    #[test]
    fn a_contact_that_chatters_is_open() {
        assert!(trips([OPEN, SHUT].repeat(20))[2..].iter().all(|tripped| *tripped));
        let mut rare = vec![OPEN];
        rare.extend([SHUT; CLOSED as usize]);
        assert!(!trips(rare.repeat(20)).contains(&true));
    }
}
