//! C4: a process that hangs is missed by its heart, before what it sends is late.
//!
//! Time is counted in looks of the shell, which are of real time: a node beats ten times a second whatever `/clock` does.
//! A supervisor that stood still looks once at all that has come meanwhile, and has missed nobody.

use crate::event::Worker;

/// Real time between two looks `[s]`.
pub const LOOK_S: f64 = 0.05;

/// Watches the hearts of those whose own messages come too rarely to tell a hang.
#[derive(Debug, Clone)]
pub struct HeartsCheck {
    hang_s: f64,
    /// Looks since the last beat; `None` of whom was never heard, and so is never missed.
    looks: [Option<u32>; Worker::ALL.len()],
}

impl HeartsCheck {
    /// Nobody heard yet; who is silent for `hang_s` `[s]` hangs.
    #[must_use]
    pub fn new(hang_s: f64) -> Self {
        Self { hang_s, looks: [None; Worker::ALL.len()] }
    }

    /// A beat was heard.
    pub fn beat(&mut self, worker: Worker) {
        self.looks[worker as usize] = Some(0);
    }

    /// All that has come was heard.
    pub fn look(&mut self) {
        self.looks.iter_mut().flatten().for_each(|looks| *looks = looks.saturating_add(1));
    }

    /// The silence of whom has been silent for too long, and what is allowed `[s]`.
    #[must_use]
    pub fn hang_s(&self, worker: Worker) -> Option<(f64, f64)> {
        let silent_s = f64::from(self.looks[worker as usize]?) * LOOK_S;
        // A look later or earlier is no difference.
        (silent_s > self.hang_s - 0.5 * LOOK_S).then_some((silent_s, self.hang_s))
    }
}
