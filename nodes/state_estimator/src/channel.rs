//! What each measurement channel has said: consistency, gating, steps (model book 1.6).

use crate::history::Ring;
use crate::params::{RawHealth, RawTrust};
use crate::ukf::Update;

/// How long what was used of a channel counts as telling `[s]`: a travel, a pause of the tool or a stretch of corners is shorter.
const TOLD_FOR_S: f64 = 30.0;

/// Number of channels.
pub const CHANNELS: usize = 4;
/// Samples of the windowed statistics: chi-square with 20 degrees of freedom (model book 1.6).
pub const WINDOW: usize = 20;

/// A measurement channel; its value indexes the arrays of an estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(usize)]
pub enum Channel {
    /// Block thermistor.
    Thermistor = 0,
    /// Filament encoder.
    Encoder = 1,
    /// Road width.
    Width = 2,
    /// Sensor in the nozzle, where one is fitted.
    Nozzle = 3,
}

impl Channel {
    /// All channels in the order of their index.
    pub const ALL: [Self; CHANNELS] = [Self::Thermistor, Self::Encoder, Self::Width, Self::Nozzle];
}

/// Whether widths stand for an encoder that is not there: they tell of the slip.
pub(crate) fn widths_tell_slip([_, encoder, width, _]: [bool; CHANNELS]) -> bool {
    !encoder && width
}

/// Statistics of a window of [`WINDOW`] innovations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Sum of the normalised innovations squared `[-]`; 99.9 % of a consistent filter's are below 45.3.
    pub chi2: f64,
    /// Normalised mean `sum(r / sqrt(S)) / sqrt(N)` `[-]`; a magnitude above 4.5 tells a bias.
    pub mean: f64,
}

/// What the caller should do about a channel's newest innovation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    Consistent,
    /// As consistent, but beyond the gate.
    Rejected,
    /// The innovations stand on one side: the state behind the channel has stepped.
    Stepped,
    /// Numerically impossible, or too many innovations speak against the filter.
    Diverged,
}

/// What tells that the state behind a channel has stepped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Step {
    /// Newest innovations looked at, [`WINDOW`] at most.
    pub(crate) samples: usize,
    /// Their normalised mean `sum(r / sqrt(S)) / sqrt(N)` above which they tell it `[-]`.
    pub(crate) threshold: f64,
    /// Share of their older half's mean below which the newer half's tells of a transient instead `[-]`.
    pub(crate) fade: f64,
}

/// Record of one channel.
#[derive(Debug, Clone)]
pub(crate) struct Record {
    trust: RawTrust,
    health: RawHealth,
    resets: bool,
    /// Innovations that speak against the filter, less those that speak for it.
    against: u32,
    normalised: Ring<f64>,
    recent: Ring<f64>,
    sum_nis: f64,
    /// The newest innovation was beyond the gate.
    rejected: bool,
    pub(crate) seen_s: Option<f64>,
    /// When an innovation was last computed: not every sample that is seen can be looked at.
    pub(crate) used_s: Option<f64>,
    pub(crate) nis: Option<f64>,
    pub(crate) innovation: Option<f64>,
    pub(crate) count: u64,
    pub(crate) gated: u64,
}

impl Record {
    /// A record of nothing; `resets` where innovations that speak against the filter reset it.
    pub(crate) fn new(trust: RawTrust, health: RawHealth, resets: bool) -> Self {
        Self {
            trust,
            health,
            resets,
            against: 0,
            normalised: Ring::new(WINDOW),
            recent: Ring::new(WINDOW),
            sum_nis: 0.0,
            rejected: false,
            seen_s: None,
            used_s: None,
            nis: None,
            innovation: None,
            count: 0,
            gated: 0,
        }
    }

    /// Other limits from now on; what was seen stays.
    pub(crate) fn retune(&mut self, trust: RawTrust, health: RawHealth) {
        (self.trust, self.health) = (trust, health);
    }

    /// What tells of a step where nothing else is asked for.
    pub(crate) fn step(&self) -> Step {
        let RawTrust { step_samples, step_threshold, step_fade, .. } = self.trust;
        Step { samples: step_samples as usize, threshold: step_threshold, fade: step_fade }
    }

    /// Takes an innovation whose variance has a part that a passing transient adds.
    pub(crate) fn note(&mut self, update: &Update<1>, passing: f64, step: Step) -> Verdict {
        let (innovation, sound) = match update {
            Update::Applied(innovation) => (innovation, Verdict::Consistent),
            Update::Rejected(innovation) => (innovation, Verdict::Rejected),
            Update::Diverged => return Verdict::Diverged,
        };
        self.gated += u64::from(sound == Verdict::Rejected);
        if innovation.nis > self.health.row_bound {
            self.against += 1;
        } else if self.recent.iter().len() >= step.samples {
            // right after a step the doubt just added makes everything consistent: that speaks for nothing
            self.against = self.against.saturating_sub(1);
        }

        // whether the model fits is judged as if nothing passed; a step is what no passing transient explains
        let normalised = innovation.residual.x / (innovation.covariance.x - passing).sqrt();
        self.count += 1;
        self.sum_nis += innovation.nis;
        self.nis = Some(innovation.nis);
        self.innovation = Some(innovation.residual.x);
        self.normalised.push(normalised);
        self.recent.push(innovation.residual.x / innovation.covariance.x.sqrt());
        self.rejected = sound == Verdict::Rejected;
        let stepped = !self.fades(step)
            && mean_of(&self.recent, step.samples).is_some_and(|mean| mean.abs() > step.threshold);
        if self.resets && self.against >= self.health.row {
            Verdict::Diverged
        } else if stepped {
            self.recent.clear();
            Verdict::Stepped
        } else {
            sound
        }
    }

    /// Whether the newest innovation was beyond the gate.
    pub(crate) fn rejected(&self) -> bool {
        self.rejected
    }

    /// Newest innovation over its own deviation since the last step; 0 without one that is as new as the channel's limit.
    pub(crate) fn deviates(&self, now_s: f64) -> f64 {
        let fresh = self.used_s.is_some_and(|used_s| now_s - used_s <= self.trust.age_limit_s);
        self.recent.newest().copied().filter(|_| fresh).unwrap_or(0.0)
    }

    /// Innovations before now say nothing of what begins.
    pub(crate) fn begin(&mut self) {
        self.recent.clear();
    }

    /// The filter starts anew: what spoke against it is over.
    pub(crate) fn restart(&mut self) {
        self.against = 0;
        self.recent.clear();
        self.normalised.clear();
    }

    /// Newest sample not older than the channel's limit.
    pub(crate) fn alive(&self, now_s: f64) -> bool {
        self.seen_s.is_some_and(|seen_s| now_s - seen_s <= self.trust.age_limit_s)
    }

    /// Whether it is alive and something of it was used lately: what is left out all the time tells of nothing.
    pub(crate) fn tells(&self, now_s: f64) -> bool {
        self.alive(now_s) && self.used_s.is_some_and(|used_s| now_s - used_s <= TOLD_FOR_S)
    }

    /// Whether the window is of now and too large for a model that fits.
    pub(crate) fn is_odd(&self, now_s: f64) -> bool {
        let fresh = self.used_s.is_some_and(|used_s| now_s - used_s <= self.trust.age_limit_s);
        fresh && self.window().is_some_and(|window| window.chi2 > self.health.window_bound)
    }

    /// Gate of the next innovation. What follows a rejected one is the rest of the same transient where another channel
    /// vouches for the flow: it has to fit better to be believed.
    pub(crate) fn gate(&self, vouched: bool) -> f64 {
        if self.rejected && vouched { self.trust.gate_again } else { self.trust.gate }
    }

    /// Whether the recent innovations fade: a transient, not a step.
    fn fades(&self, step: Step) -> bool {
        let half = step.samples / 2;
        let sum = |values: &mut dyn Iterator<Item = &f64>| values.sum::<f64>().abs();
        let older = sum(&mut self.recent.iter().rev().take(step.samples).rev().take(half));
        let newer = sum(&mut self.recent.iter().rev().take(half));
        newer < step.fade * older
    }

    /// Mean of all normalised innovations squared, rejected ones included.
    pub(crate) fn nis_mean(&self) -> Option<f64> {
        #[expect(clippy::cast_precision_loss, reason = "a count of samples, far below 2^52")]
        let count = self.count as f64;
        (self.count > 0).then(|| self.sum_nis / count)
    }

    pub(crate) fn window(&self) -> Option<Window> {
        let mean = mean_of(&self.normalised, WINDOW)?;
        Some(Window { chi2: self.normalised.iter().map(|value| value * value).sum(), mean })
    }
}

/// `sum / sqrt(N)` of the newest `count`, where there are so many.
fn mean_of(ring: &Ring<f64>, count: usize) -> Option<f64> {
    #[expect(clippy::cast_precision_loss, reason = "at most the length of a window")]
    let root = (count as f64).sqrt();
    (ring.iter().len() >= count).then(|| ring.iter().rev().take(count).sum::<f64>() / root)
}

#[cfg(test)]
mod tests;
