//! Moves that the host knows before they begin, and the trims that are attached to them.

use super::Printing;
use models::command::MotionTrim;
use models::motion::Segment;
use models::units::Seconds;

impl Printing {
    /// A move is known: the printer gets the controller's trim of it, where there is one.
    pub(super) fn foresee(&mut self, now: Seconds, (stamp, sequence): (Seconds, u64), segment: &Segment) {
        let trim = if self.bagging.is_none() {
            self.controller.on_coming(stamp, sequence, segment)
        } else {
            self.foresee_by_wire(now, (stamp, sequence), segment)
        };
        if let Some(trim) = trim {
            _ = self.simulator.on_schedule(trim, Seconds(f64::INFINITY));
        }
    }

    /// The same with all that is said of it over DDS. As without a bag the printer takes what the controller wishes, beside
    /// permits to act alone; the supervisor's word of it is kept.
    fn foresee_by_wire(
        &mut self,
        now: Seconds,
        (stamp, sequence): (Seconds, u64),
        segment: &Segment,
    ) -> Option<MotionTrim> {
        if !self.simulator.schedules() {
            return None;
        }
        let path_time_s = self.simulator.truth().path_time_s;
        let bagging = self.bagging.as_mut()?;
        let (sequence, segment) = bagging.coming(now, (stamp, path_time_s), (sequence, segment))?;
        let trim = self.controller.on_coming(now, sequence, &segment)?;
        let wished = bagging.wish_ahead(now, self.schedule_validity, trim)?;
        if let Some(allowed) = self.supervisor.on_scheduled(now, wished) {
            bagging.allow_ahead(now, &allowed);
        }
        Some(wished.trim)
    }
}
