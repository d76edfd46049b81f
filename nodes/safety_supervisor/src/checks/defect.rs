//! P5, P9, S8: what the camera's judge has confirmed, and whether it can judge at all.

use models::units::Seconds;

use crate::event::{Defect, VisionReport};
use crate::params::DefectParams;

/// Watches the judge's confirmed causes.
#[derive(Debug, Clone)]
pub struct DefectCheck {
    params: DefectParams,
    confirmed: Option<(Defect, Seconds)>,
    blind_since: Option<Seconds>,
}

impl DefectCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: DefectParams) -> Self {
        Self { params, confirmed: None, blind_since: None }
    }

    /// Takes what one frame says. A frame that cannot be judged neither confirms nor clears.
    pub fn on_report(&mut self, now: Seconds, report: &VisionReport) {
        if !report.usable {
            self.blind_since.get_or_insert(now);
            return;
        }
        self.blind_since = None;
        self.confirmed = match report.defect.filter(|_| report.confirmed) {
            Some(defect) => {
                let same = self.confirmed.filter(|(known, _)| *known == defect);
                Some(same.unwrap_or((defect, now)))
            }
            None => None,
        };
    }

    /// The defect that calls for a pause: a loose print at once, a wrong road where it lasts.
    #[must_use]
    pub fn tripped(&self, now: Seconds) -> Option<Defect> {
        self.confirmed.and_then(|(defect, since)| {
            let lasts_s = (now - since).0;
            let calls = match defect {
                Defect::Spaghetti => true,
                Defect::Under | Defect::Over => lasts_s >= self.params.persist_s,
                Defect::Other => false,
            };
            calls.then_some(defect)
        })
    }

    /// Whether no frame could be judged for too long.
    #[must_use]
    pub fn is_blind(&self, now: Seconds) -> bool {
        self.blind_since.is_some_and(|since| (now - since).0 > self.params.blind_s)
    }

    /// A person has looked: starts anew.
    pub fn reset(&mut self) {
        *self = Self::new(self.params);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(defect: Option<Defect>, usable: bool) -> VisionReport {
        VisionReport { usable, confidence: 0.3, defect, confirmed: defect.is_some(), offset_m: None }
    }

    fn check() -> DefectCheck {
        DefectCheck::new(DefectParams { persist_s: 1.0, blind_s: 10.0 })
    }

    #[test]
    fn a_loose_print_trips_at_once_a_thin_road_where_it_lasts() {
        let mut loose = check();
        loose.on_report(Seconds(1.0), &report(Some(Defect::Spaghetti), true));
        assert_eq!(loose.tripped(Seconds(1.0)), Some(Defect::Spaghetti));
        let mut thin = check();
        thin.on_report(Seconds(1.0), &report(Some(Defect::Under), true));
        let later = [1.9, 2.0].map(|now_s| thin.tripped(Seconds(now_s)));
        assert_eq!(later, [None, Some(Defect::Under)]);
        thin.on_report(Seconds(2.0), &report(None, true));
        assert_eq!(thin.tripped(Seconds(3.0)), None);
    }

    #[test]
    fn a_frame_that_cannot_be_judged_is_unknown_and_never_ok() {
        let mut check = check();
        check.on_report(Seconds(0.0), &report(Some(Defect::Spaghetti), true));
        check.on_report(Seconds(1.0), &report(None, false));
        assert_eq!(check.tripped(Seconds(1.0)), Some(Defect::Spaghetti));
        check.on_report(Seconds(9.0), &report(None, false));
        assert!(!check.is_blind(Seconds(11.0)) && check.is_blind(Seconds(11.1)));
        check.on_report(Seconds(12.0), &report(None, true));
        assert!(!check.is_blind(Seconds(12.0)) && check.tripped(Seconds(12.0)).is_none());
    }
}
