//! S5, K6: so many bad values within a span.

use models::units::Seconds;

use crate::params::BurstParams;

/// Most occurrences that a parameter may ask for.
pub const COUNT_MAX: usize = 8;

/// Counts occurrences in a sliding span.
#[derive(Debug, Clone)]
pub struct Burst {
    params: BurstParams,
    times: [Option<Seconds>; COUNT_MAX],
    total: u64,
}

impl Burst {
    /// Nothing has occurred.
    #[must_use]
    pub fn new(params: BurstParams) -> Self {
        Self { params, times: [None; COUNT_MAX], total: 0 }
    }

    /// Notes an occurrence.
    pub fn note(&mut self, now: Seconds) {
        self.times.rotate_right(1);
        self.times[0] = Some(now);
        self.total = self.total.saturating_add(1);
    }

    /// Whether the last `count` occurrences lie within the span that ends now.
    #[must_use]
    pub fn tripped(&self, now: Seconds) -> bool {
        self.times[self.params.count - 1].is_some_and(|oldest| now.0 - oldest.0 <= self.params.span_s)
    }

    /// Forgets when it was, not how often.
    pub fn forget(&mut self) {
        self.times = [None; COUNT_MAX];
    }

    /// All occurrences so far.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.total
    }
}
