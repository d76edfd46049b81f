//! Moves that the host knows before they begin, and the trims that are attached to them.

use super::{CONTROLLER_SESSION, Printing};
use models::command::Scheduled;
use models::motion::Segment;
use models::units::Seconds;

impl Printing {
    /// A move is known, told when, with its start on the slicer's plan `[s]` and its number: the printer gets what the supervisor
    /// lets through of the controller's trim of it, where there is one.
    pub(super) fn foresee(&mut self, now: Seconds, coming: (Seconds, f64, u64), segment: &Segment) {
        if !self.simulator.schedules() {
            return;
        }
        let wished = if self.bagging.is_none() {
            let (stamp, _, sequence) = coming;
            self.wish_ahead((stamp, sequence), segment)
        } else {
            self.wish_ahead_by_wire(now, coming, segment)
        };
        let Some(allowed) = wished.and_then(|wished| self.supervisor.on_scheduled(now, wished)) else {
            return;
        };
        if let Some(bagging) = &mut self.bagging {
            bagging.allow_ahead(now, &allowed);
        }
        // As the node does: beside permits of this supervisor, until it lapses. The first moves after a halt come too late.
        _ = self.simulator.on_scheduled(&allowed);
    }

    fn wish_ahead(&mut self, (stamp, sequence): (Seconds, u64), segment: &Segment) -> Option<Scheduled> {
        let trim = self.controller.on_coming(stamp, sequence, segment)?;
        self.scheduled += 1;
        let validity = self.schedule_validity;
        Some(Scheduled { session: CONTROLLER_SESSION, sequence: self.scheduled, validity, trim })
    }

    /// The same with all that is said of it over DDS.
    fn wish_ahead_by_wire(
        &mut self,
        now: Seconds,
        (stamp, start_s, sequence): (Seconds, f64, u64),
        segment: &Segment,
    ) -> Option<Scheduled> {
        let bagging = self.bagging.as_mut()?;
        let (sequence, segment) = bagging.coming(now, (stamp, start_s), (sequence, segment))?;
        let trim = self.controller.on_coming(now, sequence, &segment)?;
        bagging.wish_ahead(now, self.schedule_validity, trim)
    }
}
