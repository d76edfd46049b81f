//! P5, P9, S8: what the camera's judge has confirmed, and whether it can judge at all.

use models::units::Seconds;

use crate::event::{Defect, VisionReport};
use crate::params::DefectParams;

/// A defect, and when frames that could tell of it confirmed it first and last.
#[derive(Debug, Clone, Copy)]
struct Confirmed {
    defect: Defect,
    first: Seconds,
    last: Seconds,
}

/// Watches the judge's confirmed causes.
#[derive(Debug, Clone)]
pub struct DefectCheck {
    params: DefectParams,
    confirmed: Option<Confirmed>,
    blind_since: Option<Seconds>,
}

impl DefectCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: DefectParams) -> Self {
        Self { params, confirmed: None, blind_since: None }
    }

    /// Takes what one frame says. A frame that cannot be judged, or cannot tell of what earlier ones confirmed, neither
    /// confirms nor clears. What was confirmed longer ago than a camera may be blind begins anew.
    pub fn on_report(&mut self, now: Seconds, report: &VisionReport) {
        if !report.usable {
            self.blind_since.get_or_insert(now);
            return;
        }
        self.blind_since = None;
        let Some(defect) = report.defect.filter(|_| report.confirmed) else {
            self.confirmed = None;
            return;
        };
        if report.told {
            let same = self
                .confirmed
                .filter(|known| known.defect == defect && (now - known.last).0 <= self.params.blind_s);
            self.confirmed =
                Some(Confirmed { defect, first: same.map_or(now, |known| known.first), last: now });
        }
    }

    /// The defect that calls for a pause: a loose print at once, a wrong road where frames have confirmed it for long
    /// enough. Time in which nothing was seen confirms nothing.
    #[must_use]
    pub fn tripped(&self) -> Option<Defect> {
        self.confirmed.and_then(|Confirmed { defect, first, last }| {
            let calls = match defect {
                Defect::Spaghetti => true,
                Defect::Under | Defect::Over => (last - first).0 >= self.params.persist_s,
                Defect::Shift | Defect::Stringing | Defect::Blobs | Defect::Other => false,
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
        VisionReport {
            usable,
            confidence: 0.3,
            defect,
            confirmed: defect.is_some(),
            told: true,
            offset_m: None,
        }
    }

    fn check() -> DefectCheck {
        DefectCheck::new(DefectParams { persist_s: 1.0, blind_s: 10.0 })
    }

    #[test]
    fn a_loose_print_trips_at_once_a_thin_road_where_frames_go_on_confirming_it() {
        let mut loose = check();
        loose.on_report(Seconds(1.0), &report(Some(Defect::Spaghetti), true));
        assert_eq!(loose.tripped(), Some(Defect::Spaghetti));
        let thin = report(Some(Defect::Under), true);
        let mut check = check();
        let told = [1.0, 1.9, 2.0].map(|now_s| {
            check.on_report(Seconds(now_s), &thin);
            check.tripped()
        });
        assert_eq!(told, [None, None, Some(Defect::Under)]);
        check.on_report(Seconds(2.5), &report(None, true));
        assert_eq!(check.tripped(), None);
        check.on_report(Seconds(3.0), &thin);
        assert_eq!(check.tripped(), None, "it begins anew");
    }

    /// P5: one thin road, and then nothing that could tell: no frame, none that can be judged, none with a width.
    #[test]
    fn time_in_which_nothing_was_seen_confirms_nothing() {
        let thin = report(Some(Defect::Under), true);
        for unseen in [report(None, false), VisionReport { told: false, ..thin }] {
            let mut check = check();
            check.on_report(Seconds(0.0), &thin);
            for half_seconds in 1..=8 {
                check.on_report(Seconds(0.5 * f64::from(half_seconds)), &unseen);
                assert_eq!(check.tripped(), None, "{unseen:?}");
            }
            // It has not cleared it either: the next one that tells stands 4.5 s behind the first.
            check.on_report(Seconds(4.5), &thin);
            assert_eq!(check.tripped(), Some(Defect::Under), "{unseen:?}");
        }
        let mut check = check();
        check.on_report(Seconds(0.0), &thin);
        check.on_report(Seconds(10.1), &thin);
        assert_eq!(check.tripped(), None, "what was seen before a blind camera's time");
    }

    #[test]
    fn a_frame_that_cannot_be_judged_is_unknown_and_never_ok() {
        let mut check = check();
        check.on_report(Seconds(0.0), &report(Some(Defect::Spaghetti), true));
        check.on_report(Seconds(1.0), &report(None, false));
        assert_eq!(check.tripped(), Some(Defect::Spaghetti));
        check.on_report(Seconds(9.0), &report(None, false));
        assert!(!check.is_blind(Seconds(11.0)) && check.is_blind(Seconds(11.1)));
        check.on_report(Seconds(12.0), &report(None, true));
        assert!(!check.is_blind(Seconds(12.0)) && check.tripped().is_none());
    }
}
