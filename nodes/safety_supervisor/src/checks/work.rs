//! C4: a process whose loop turns without doing its work beats on, and the work that it tells with every beat stands still.
//!
//! Work goes by the node's clock and hearts by the host's: it stands still when both say so. A simulation that stands holds
//! no work up, and one that runs twenty times as fast leaves two simulated seconds between two beats.

use models::units::Seconds;

use crate::event::Worker;

/// Real time between two beats `[s]`.
const BEAT_S: f64 = 0.1;
/// Frames passed on, less one, that no beat of the judge has answered: of the last one its beat may have told already.
const FRAMES_UNJUDGED: u64 = 2;

/// What one heart has told.
#[derive(Debug, Clone, Copy)]
struct Told {
    work: u64,
    /// When it rose last, or was due first.
    since: Seconds,
    /// Beats since then.
    beats: u32,
    /// Frames that the camera had passed on then.
    frames: Option<u64>,
}

/// Watches the work of those whose heart is listened to.
#[derive(Debug, Clone)]
pub struct WorkCheck {
    work_s: f64,
    told: [Option<Told>; Worker::ALL.len()],
}

impl WorkCheck {
    /// Nobody heard yet; who does nothing for `work_s` `[s]` while its work is due is missed.
    #[must_use]
    pub fn new(work_s: f64) -> Self {
        Self { work_s, told: [None; Worker::ALL.len()] }
    }

    /// A beat was heard at `now`. A process that was started again counts from zero, which is work as well.
    pub fn beat(&mut self, now: Seconds, worker: Worker, work: u64) {
        let frames = self.frames();
        let told = &mut self.told[worker as usize];
        match told {
            Some(told) if told.work == work => told.beats = told.beats.saturating_add(1),
            _ => *told = Some(Told { work, since: now, beats: 0, frames }),
        }
    }

    /// Whether there is something to judge: frames were passed on that the judge has not answered.
    #[must_use]
    pub fn has_frames(&self) -> bool {
        let answered = self.told[Worker::Judge as usize].and_then(|judge| judge.frames);
        let passed = self.frames().zip(answered).and_then(|(passed, answered)| passed.checked_sub(answered));
        passed.is_some_and(|frames| frames >= FRAMES_UNJUDGED)
    }

    /// Nothing is due of this process until `now`.
    pub fn rest(&mut self, now: Seconds, worker: Worker) {
        if let Some(told) = &mut self.told[worker as usize] {
            (told.since, told.beats) = (now, 0);
        }
    }

    /// For how long nothing has come of a process that is due, and what is allowed `[s]`; `None` where that is not too long.
    #[must_use]
    pub fn idle_s(&self, now: Seconds, worker: Worker) -> Option<(f64, f64)> {
        let told = self.told[worker as usize]?;
        let idle_s = (f64::from(told.beats) * BEAT_S).min((now - told.since).0);
        (idle_s > self.work_s).then_some((idle_s, self.work_s))
    }

    fn frames(&self) -> Option<u64> {
        self.told[Worker::Camera as usize].map(|camera| camera.work)
    }
}
