//! How long a trial is looked at.

use super::{LATE_S, Trial, off};
use crate::faults::catalogue::Reaction;

/// Time after a reaction in which the block may go on rising `[s]`.
const OVERSHOOT_S: f64 = 20.0;
/// Time after DEGRADED in which nothing worse may follow: what stays away for longer is paused and stopped later `[s]`.
const LASTING_S: f64 = 10.0;
/// How long a run waits for a reaction that has no limit in seconds `[s]`.
const PATIENCE_S: f64 = 20.0;
/// How long a run waits for a reaction whose limit is one of filament or layers `[s]`.
const WORDS_S: f64 = 300.0;

impl Trial<'_> {
    /// How long after the reaction nothing worse may follow `[s]`.
    pub(super) fn watched_s(&self) -> f64 {
        let least_s = if self.spec.overshoot_max_k.is_some() {
            OVERSHOOT_S
        } else if self.reaction == Reaction::Degraded {
            LASTING_S
        } else {
            0.0
        };
        self.spec.watch_s.max(least_s)
    }

    /// How long after the reaction it is seen whether anything is heated all the same `[s]`.
    pub(super) fn off_s(&self) -> f64 {
        if self.reaction >= Reaction::SafeOff { off::WATCHED_S } else { 0.0 }
    }

    /// How long a reaction is waited for `[s]`.
    pub(super) fn patience_s(&self) -> f64 {
        let limit_s = self.spec.limit_s.map_or(PATIENCE_S, |limit_s| limit_s + LATE_S);
        let in_words = self.spec.limit_mm.is_some() || self.spec.limit_layers.is_some();
        if in_words { limit_s.max(WORDS_S) } else { limit_s }
    }
}
