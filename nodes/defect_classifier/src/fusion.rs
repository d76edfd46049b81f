//! What the frames say together, and with the estimator's residuals: smoothing, k of n, fused confidence c_k.
//!
//! What was measured in a frame outweighs what it looks like: a width as wanted acquits it of `under` and `over`, one
//! far off convicts it; likewise the offset of the layers and `shift`.
//!
//! `c = beta min(1, a / tau_a) + (1 - beta) p_det` (model book 1.6) with `p_det` smoothed over frames, `a` the sum of
//! the estimator's full windows of normalised innovations squared, `tau_a` its chi-square point.

mod evidence;
mod params;
#[cfg(test)]
mod tests;

pub use evidence::RawEvidence;
pub use params::{ConfirmRule, FusionError, FusionParams, RawFusionParams};

use crate::features::Measured;
use crate::network::Scores;
use models::quality::fused_confidence;
use models::units::Seconds;
use std::collections::VecDeque;

/// What is known after a frame: the fields of the message `DefectReport`.
#[derive(Debug, Clone, PartialEq)]
pub struct Fused {
    /// `p_det` smoothed over frames `[0, 1]`.
    pub detection: f64,
    /// a_k, the summed windows `[0, inf)`.
    pub residual: f64,
    /// tau_a, its chi-square point `(0, inf)`.
    pub residual_limit: f64,
    /// c_k `[0, 1]`.
    pub confidence: f64,
    /// Class that carries it; `ok` where none does.
    pub cause: String,
    /// Enough of the last frames say the same cause.
    pub confirmed: bool,
    /// This frame could tell of the cause; where not, what earlier ones said stands.
    pub told: bool,
    /// Frames of the cause's window that say so.
    pub in_favour: u32,
    /// Frames that the cause's window holds when full.
    pub window: u32,
}

/// Memory over frames and residuals. Knows no clock.
#[derive(Debug, Clone)]
pub struct Fusion {
    params: FusionParams,
    classes: Vec<String>,
    /// A rule per class, in the order of `classes`; `None`: never confirmed.
    rules: Vec<Option<ConfirmRule>>,
    /// Votes per class, newest last.
    votes: Vec<VecDeque<bool>>,
    /// When a frame could tell of a class last.
    told: Vec<Option<Seconds>>,
    smoothed: Option<(Seconds, Vec<f64>)>,
    residual: Option<(Seconds, f64, f64)>,
    grace_until: Option<Seconds>,
}

impl Fusion {
    /// Memory for a network of these classes.
    ///
    /// # Errors
    /// [`FusionError`] for a rule of a class that the network does not have.
    pub fn new(params: FusionParams, classes: &[String]) -> Result<Self, FusionError> {
        let rules = params.rules_of(classes)?;
        Ok(Self {
            params,
            classes: classes.to_vec(),
            votes: vec![VecDeque::new(); rules.len()],
            told: vec![None; rules.len()],
            rules,
            smoothed: None,
            residual: None,
            grace_until: None,
        })
    }

    /// Forgets the frames; what is seen within the grace time after `now` counts for nothing (print start, resume).
    pub fn reset(&mut self, now: Seconds) {
        self.votes.iter_mut().for_each(VecDeque::clear);
        self.told.fill(None);
        self.smoothed = None;
        self.residual = None;
        self.grace_until = Some(Seconds(now.0 + self.params.grace_s));
    }

    /// Takes the estimator's windowed statistics: `chi_square` per channel, 0 where its window of `window` updates is
    /// not full yet. False, and nothing taken, where one is negative or not finite.
    pub fn on_estimate(&mut self, now: Seconds, chi_square: &[f64], window: u32) -> bool {
        if chi_square.iter().any(|sum| !(sum.is_finite() && *sum >= 0.0)) {
            return false;
        }
        let full = chi_square.iter().filter(|sum| **sum > 0.0);
        #[expect(clippy::cast_precision_loss, reason = "a count of channels")]
        let freedom = full.clone().count() as f64 * f64::from(window);
        self.residual = (freedom > 0.0)
            .then(|| (now, full.sum(), chi_square_point(freedom, self.params.residual_normal_quantile)));
        true
    }

    /// Takes the scores of a usable frame exposed at `exposed`, and what was measured in it. `None`, and nothing
    /// taken, where the scores do not belong to the classes, a value is not finite, or the frame is older than the
    /// last.
    pub fn on_frame(&mut self, exposed: Seconds, scores: &Scores, measured: &Measured) -> Option<Fused> {
        let sound = scores.probabilities.iter().all(|p| (0.0..=1.0).contains(p)) && measured.is_finite();
        if scores.probabilities.len() != self.classes.len() || !sound || !exposed.0.is_finite() {
            return None;
        }
        if self.smoothed.as_ref().is_some_and(|(last, _)| exposed.0 < last.0) {
            return None;
        }
        let graced = self.grace_until.is_some_and(|until| exposed.0 < until.0);
        if !graced {
            let (judged, told) = self.params.evidence.weigh(&self.classes, scores, measured);
            self.smooth(exposed, &judged);
            self.vote(exposed, &judged, &told);
        }
        self.fuse(exposed)
    }

    /// `s += (1 - e^{-dt/tau}) (p - s)`: the same memory in seconds whatever the frame rate.
    fn smooth(&mut self, exposed: Seconds, scores: &Scores) {
        let gap_s = self.smoothed.as_ref().map(|(last, _)| exposed.0 - last.0);
        match (&mut self.smoothed, gap_s) {
            (Some((last, smoothed)), Some(gap_s)) if gap_s <= self.params.gap_max_s => {
                let share = 1.0 - (-gap_s / self.params.smoothing_s).exp();
                for (old, new) in smoothed.iter_mut().zip(&scores.probabilities) {
                    *old += share * (new - *old);
                }
                *last = exposed;
            }
            // After a gap the past says nothing of now.
            _ => {
                // The first frame counts as one frame of an unknown past that was fine.
                let mut calm = vec![0.0; self.classes.len()];
                calm[0] = 1.0;
                self.smoothed = Some((exposed, calm));
            }
        }
    }

    /// A frame that could not tell a class has no vote on it; where none could for too long, nothing is known of it.
    fn vote(&mut self, exposed: Seconds, scores: &Scores, told: &[bool]) {
        let best = scores.best();
        for (class, (votes, rule)) in self.votes.iter_mut().zip(&self.rules).enumerate() {
            if self.told[class].is_some_and(|last| exposed.0 - last.0 > self.params.gap_max_s) {
                votes.clear();
            }
            if !told[class] {
                continue;
            }
            self.told[class] = Some(exposed);
            let Some(rule) = rule else { continue };
            votes.push_back(class == best && scores.probabilities[class] >= rule.probability_min);
            while votes.len() > rule.frames as usize {
                votes.pop_front();
            }
        }
    }

    fn fuse(&self, now: Seconds) -> Option<Fused> {
        let detection = self.smoothed.as_ref().map_or(0.0, |(_, p)| (1.0 - p[0]).clamp(0.0, 1.0));
        let fresh = self.residual.filter(|(at, ..)| now.0 - at.0 <= self.params.residual_age_max_s);
        // Without a residual the frames speak alone: a of 0.
        let (residual, residual_limit) =
            fresh.map_or((0.0, self.params.idle_limit()), |(_, a, tau)| (a, tau));
        let confidence = fused_confidence(residual, residual_limit, detection, self.params.residual_share)?;
        let cause = self.cause();
        let (in_favour, rule) = self.tally(cause);
        Some(Fused {
            detection,
            residual,
            residual_limit,
            confidence,
            cause: self.classes[cause].clone(),
            confirmed: rule.is_some_and(|rule| in_favour >= rule.in_favour),
            told: self.tells(&self.classes[cause], now),
            in_favour,
            window: rule.map_or(0, |rule| rule.frames),
        })
    }

    /// Whether the frame exposed then could tell of a class.
    pub(crate) fn tells(&self, class: &str, exposed: Seconds) -> bool {
        let place = self.classes.iter().position(|name| name == class);
        place.and_then(|place| self.told[place]) == Some(exposed)
    }

    /// The confirmed class with the most votes, else the most probable one after smoothing.
    fn cause(&self) -> usize {
        let confirmed = (1..self.classes.len()).filter_map(|class| {
            let (in_favour, rule) = self.tally(class);
            rule.filter(|rule| in_favour >= rule.in_favour).map(|_| (in_favour, class))
        });
        let (mut cause, mut most) = (0, 0);
        for (in_favour, class) in confirmed {
            if in_favour > most {
                (cause, most) = (class, in_favour);
            }
        }
        if most == 0
            && let Some((_, smoothed)) = &self.smoothed
        {
            cause = Scores { probabilities: smoothed.clone() }.best();
        }
        cause
    }

    fn tally(&self, class: usize) -> (u32, Option<ConfirmRule>) {
        let votes = self.votes[class].iter().filter(|vote| **vote).count();
        (u32::try_from(votes).unwrap_or(u32::MAX), self.rules[class])
    }
}

/// Point of the chi-square distribution with `freedom` degrees of freedom at the quantile whose normal point is
/// `normal` `[-]`; Wilson and Hilferty (1931), within 0.1 % for 20 and more degrees of freedom at 99 %.
#[must_use]
pub fn chi_square_point(freedom: f64, normal: f64) -> f64 {
    let part = 2.0 / (9.0 * freedom);
    freedom * (1.0 - part + normal * part.sqrt()).powi(3)
}
