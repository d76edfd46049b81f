//! Where the job stands.

use super::{Executor, Sliced, Wait};
use models::motion::Segment;
use models::status::JobPhase;

impl Executor {
    /// Where the job stands.
    #[must_use]
    pub fn phase(&self) -> JobPhase {
        let held = self.pace <= 0.0;
        match (self.exhausted && self.queue.is_empty() && self.active.is_none(), held, self.started) {
            (true, ..) => JobPhase::Done,
            (false, true, _) => JobPhase::Paused,
            (false, false, true) if self.wait == Wait::None => JobPhase::Printing,
            _ => JobPhase::Preparing,
        }
    }

    /// The file itself demands an emergency stop (`M112`).
    #[must_use]
    pub fn stopped(&self) -> bool {
        self.stopped
    }

    /// Line of the file that asked for the pause in force (`M0`, `M25`, `M600`); `None` where none did.
    #[must_use]
    pub fn paused_by_line(&self) -> Option<u64> {
        self.file_pause
    }

    /// Resumes from a pause that the file asked for.
    pub fn resume(&mut self) {
        self.file_pause = None;
    }

    /// Set-points of the file.
    #[must_use]
    pub fn sliced(&self) -> &Sliced {
        &self.sliced
    }

    /// The move under way.
    #[must_use]
    pub fn segment(&self) -> Option<&Segment> {
        self.active.as_ref().map(|active| active.segment.as_ref())
    }

    /// All axes know their place.
    #[must_use]
    pub fn homed(&self) -> bool {
        self.homed
    }

    /// Layer from 0.
    #[must_use]
    pub fn layer(&self) -> Option<u32> {
        self.layer
    }

    /// Line of the file, from 1.
    #[must_use]
    pub fn line(&self) -> u64 {
        self.line
    }

    /// Tool position in the bed frame `[m]`.
    #[must_use]
    pub fn position_m(&self) -> [f64; 3] {
        self.position_m
    }

    /// Time along the slicer's plan `[s]`.
    #[must_use]
    pub fn path_time_s(&self) -> f64 {
        self.path_time_s
    }

    /// Filament that the file has pushed so far, retractions not subtracted `[m]`.
    #[must_use]
    pub fn fed_m(&self) -> f64 {
        self.fed_m
    }
}
