//! What each measurement channel has said: consistency, gating, steps (model book 1.6).

use crate::history::Ring;
use crate::params::RawTrust;
use crate::ukf::Update;

/// Number of channels.
pub const CHANNELS: usize = 3;
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
}

impl Channel {
    /// All channels in the order of their index.
    pub const ALL: [Self; CHANNELS] = [Self::Thermistor, Self::Encoder, Self::Width];
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
    /// The innovations stand on one side: the state behind the channel has stepped.
    Stepped,
    Diverged,
}

/// Record of one channel.
#[derive(Debug, Clone)]
pub(crate) struct Record {
    trust: RawTrust,
    normalised: Ring<f64>,
    recent: Ring<f64>,
    sum_nis: f64,
    pub(crate) seen_s: Option<f64>,
    pub(crate) nis: Option<f64>,
    pub(crate) innovation: Option<f64>,
    pub(crate) count: u64,
    pub(crate) gated: u64,
}

impl Record {
    pub(crate) fn new(trust: RawTrust) -> Self {
        Self {
            trust,
            normalised: Ring::new(WINDOW),
            recent: Ring::new(trust.step_samples as usize),
            sum_nis: 0.0,
            seen_s: None,
            nis: None,
            innovation: None,
            count: 0,
            gated: 0,
        }
    }

    pub(crate) fn note(&mut self, update: &Update<1>) -> Verdict {
        let innovation = match update {
            Update::Applied(innovation) => innovation,
            Update::Rejected(innovation) => {
                self.gated += 1;
                innovation
            }
            Update::Diverged => return Verdict::Diverged,
        };
        let normalised = innovation.residual.x / innovation.covariance.x.sqrt();
        self.count += 1;
        self.sum_nis += innovation.nis;
        self.nis = Some(innovation.nis);
        self.innovation = Some(innovation.residual.x);
        self.normalised.push(normalised);
        self.recent.push(normalised);
        let stepped = mean_of(&self.recent, self.trust.step_samples as usize)
            .is_some_and(|mean| mean.abs() > self.trust.step_threshold);
        if stepped {
            self.recent.clear();
            Verdict::Stepped
        } else {
            Verdict::Consistent
        }
    }

    /// Newest sample not older than the channel's limit.
    pub(crate) fn alive(&self, now_s: f64) -> bool {
        self.seen_s.is_some_and(|seen_s| now_s - seen_s <= self.trust.age_limit_s)
    }

    pub(crate) fn gate(&self) -> f64 {
        self.trust.gate
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

/// `sum / sqrt(N)` of a full ring.
fn mean_of(ring: &Ring<f64>, full: usize) -> Option<f64> {
    #[expect(clippy::cast_precision_loss, reason = "at most the length of a window")]
    let root = (full as f64).sqrt();
    (ring.iter().len() == full).then(|| ring.iter().sum::<f64>() / root)
}
