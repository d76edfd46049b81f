//! Who beats without doing what is due.

use models::units::Seconds;

use super::Supervisor;
use crate::cause::{Cause, Reaction};
use crate::event::{Stream, Worker};

/// Whose work is watched, the cause, and the stream that it has a part in. The encoder's node counts what its device sends,
/// a hundred times a second: its own stream tells the same long before.
const WATCHED: [(Worker, Cause, Stream); 4] = [
    (Worker::Estimator, Cause::EstimatorIdle, Stream::Estimate),
    (Worker::Controller, Cause::ControllerIdle, Stream::Command),
    (Worker::Camera, Cause::CameraIdle, Stream::Vision),
    (Worker::Judge, Cause::JudgeIdle, Stream::Vision),
];

impl Supervisor {
    /// Work is due while the job prints, of whom has been heard of before; of the judge while there are frames.
    pub(super) fn idlers(&mut self, now: Seconds, printing: bool) -> [(Cause, Option<Reaction>); 4] {
        WATCHED.map(|(worker, cause, stream)| {
            let heard = self.ages.of(stream).is_seen();
            let due = printing && heard && (worker != Worker::Judge || self.ages.work.has_frames());
            if !due {
                self.ages.work.rest(now, worker);
            }
            (cause, self.ages.work.idle_s(now, worker).map(|_| Reaction::Degrade))
        })
    }

    /// For how long nothing has come of the process behind a cause, and what is allowed `[s]`.
    pub(super) fn of_idleness(&self, now: Seconds, cause: Cause) -> Option<(f64, f64)> {
        let (worker, ..) = WATCHED.into_iter().find(|(_, watched, _)| *watched == cause)?;
        self.ages.work.idle_s(now, worker)
    }
}
