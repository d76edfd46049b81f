//! Moves that the host knows before they begin, and the trims that are attached to them.

use super::{CONTROLLER_SESSION, Printing};
use models::command::{MotionTrim, Scheduled};
use models::motion::Segment;
use models::units::Seconds;
use mpc_controller::Coming;

impl Printing {
    /// A move is known, told when, with its start on the slicer's plan `[s]` and its number: the printer gets what the supervisor
    /// lets through of the controller's trim of it, where there is one.
    pub(super) fn foresee(&mut self, now: Seconds, coming: (Seconds, f64, u64), segment: &Segment) {
        if !self.simulator.schedules() {
            return;
        }
        let wished = if self.bagging.is_none() {
            let (stamp, start_s, sequence) = coming;
            self.wish_ahead(stamp, &Coming { sequence, start: Seconds(start_s), segment: *segment })
        } else {
            self.wish_ahead_by_wire(now, coming, segment)
        };
        if let Some(wished) = wished {
            self.attach(now, wished);
        }
    }

    /// Trims that the controller sends anew, of moves that have not begun.
    pub(super) fn attach_anew(&mut self, now: Seconds) {
        for trim in self.controller.take_anew(now) {
            let wished = match &mut self.bagging {
                None => Some(self.numbered(trim)),
                Some(bagging) => bagging.wish_ahead(now, self.schedule_validity, trim),
            };
            if let Some(wished) = wished {
                self.attach(now, wished);
            }
        }
    }

    /// The printer gets what the supervisor lets through. As the node does: beside permits of this supervisor, until it lapses. The first
    /// moves after a halt come too late.
    fn attach(&mut self, now: Seconds, wished: Scheduled) {
        let Some(allowed) = self.supervisor.on_scheduled(now, wished) else { return };
        if let Some(bagging) = &mut self.bagging {
            bagging.allow_ahead(now, &allowed);
        }
        _ = self.simulator.on_scheduled(&allowed);
    }

    fn wish_ahead(&mut self, stamp: Seconds, coming: &Coming) -> Option<Scheduled> {
        let trim = self.controller.on_coming(stamp, coming)?;
        Some(self.numbered(trim))
    }

    fn numbered(&mut self, trim: MotionTrim) -> Scheduled {
        self.scheduled += 1;
        Scheduled {
            session: CONTROLLER_SESSION,
            sequence: self.scheduled,
            validity: self.schedule_validity,
            trim,
        }
    }

    /// The same with all that is said of it over DDS.
    fn wish_ahead_by_wire(
        &mut self,
        now: Seconds,
        (stamp, start_s, sequence): (Seconds, f64, u64),
        segment: &Segment,
    ) -> Option<Scheduled> {
        let bagging = self.bagging.as_mut()?;
        let coming = bagging.coming(now, (stamp, start_s), (sequence, segment))?;
        let trim = self.controller.on_coming(now, &coming)?;
        bagging.wish_ahead(now, self.schedule_validity, trim)
    }
}
