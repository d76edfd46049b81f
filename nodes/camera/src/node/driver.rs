//! What every driver has to say.

use runtime::Reason;

/// An event of a driver.
#[derive(Debug, Clone, PartialEq)]
pub enum DriverEvent {
    /// The source is open; what was found, for people.
    Found {
        /// For the log.
        text: String,
    },
    /// A JPEG file, not looked into.
    Frame(Vec<u8>),
    /// Something that is no frame was passed over.
    Refused(Reason),
    /// The last frame of a file has been given.
    Ended,
    /// The source could not be opened or was lost.
    Lost {
        /// Why, for people.
        reason: String,
        /// Pause before the next try `[s]`.
        retry_s: f64,
    },
}

/// Pauses between tries: doubled each time, from the start again after a frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BackOff {
    min_s: f64,
    max_s: f64,
    next_s: f64,
}

impl BackOff {
    pub(crate) fn new(min_s: f64, max_s: f64) -> Self {
        Self { min_s, max_s, next_s: min_s }
    }

    pub(crate) fn reset(&mut self) {
        self.next_s = self.min_s;
    }

    pub(crate) fn lost(&mut self, reason: String) -> DriverEvent {
        let retry_s = self.next_s;
        self.next_s = (2.0 * retry_s).min(self.max_s);
        DriverEvent::Lost { reason, retry_s }
    }
}
