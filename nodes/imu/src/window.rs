//! Unit, axis and rate, judged over windows of time.
//!
//! Over a window `T` the mean of what an accelerometer shows is gravity's reaction and `(v(T) - v(0))/T`. A tool no
//! faster than `v_max` therefore deviates from `g` by at most `2 v_max/T`, at rest or printing: 0.5 m/s and 1 s give
//! 1 m/s2, a tenth of `g`. What is further off is no motion but a wrong unit, axis or rate.

use models::units::Seconds;

use crate::axis::Axis;
use crate::params::UnitParams;

/// Standard gravity `[m/s2]`.
pub const GRAVITY_M_S2: f64 = 9.806_65;

/// What a window has shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// No window is complete yet.
    Unproven,
    /// Gravity, in its unit and on its axis, at the configured rate.
    Sound,
    /// The mean is not as long as gravity.
    Unit {
        /// Its length `[m/s2]`, if it were the right unit.
        mean_m_s2: f64,
    },
    /// Gravity lies on another axis.
    Axes {
        /// On this one.
        found: Axis,
        /// It ought to lie here.
        wanted: Axis,
        /// Angle between the two `[deg]`.
        tilt_deg: f64,
    },
    /// Samples come at another pace.
    Rate {
        /// As measured by stamps and sequence `[Hz]`.
        measured_hz: f64,
        /// As configured `[Hz]`.
        wanted_hz: f64,
    },
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unproven => f.write_str("no window of samples is complete yet"),
            Self::Sound => f.write_str("ok"),
            Self::Unit { mean_m_s2 } => {
                let g = GRAVITY_M_S2;
                let like = |factor: f64| (0.7..1.4).contains(&(mean_m_s2 / factor));
                let advice = if like(1.0) {
                    "this looks like g: multiply by 9.80665"
                } else if like(1000.0 * g) {
                    "this looks like mm/s2: divide by 1000"
                } else if like(1000.0) {
                    "this looks like thousandths of g: multiply by 0.00980665"
                } else {
                    "check scale and range of the driver, and that no axis is dead"
                };
                write!(f, "mean acceleration is {mean_m_s2:.4} where gravity is {g:.2} m/s2: {advice}")
            }
            Self::Axes { found, wanted, tilt_deg } => write!(
                f,
                "gravity lies on {found}, {tilt_deg:.0} deg from {wanted}: set axes, or unit.up, to the way the sensor is \
                 mounted"
            ),
            Self::Rate { measured_hz, wanted_hz } => write!(
                f,
                "{measured_hz:.1} samples a second where {wanted_hz:.1} are configured: set unit.rate_hz to what the \
                 sensor does, or look for what loses samples"
            ),
        }
    }
}

/// Collects samples until a window is full.
#[derive(Debug, Clone)]
pub(crate) struct Window {
    params: UnitParams,
    sum_m_s2: [f64; 3],
    count: u64,
    begin: Option<(Seconds, u64)>,
    verdict: Verdict,
    figures: Option<Figures>,
}

/// Of the last window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// Length of the mean `[m/s2]`.
    pub mean_m_s2: f64,
    /// Angle between the mean and the axis that points up `[deg]`.
    pub tilt_deg: f64,
    /// Samples a second by stamps and sequence `[Hz]`.
    pub rate_hz: f64,
}

impl Window {
    /// Other tolerances from the end of this window on.
    pub(crate) fn retune(&mut self, params: UnitParams) {
        self.params = params;
    }

    pub(crate) fn new(params: UnitParams) -> Self {
        Self { params, sum_m_s2: [0.0; 3], count: 0, begin: None, verdict: Verdict::Unproven, figures: None }
    }

    pub(crate) fn verdict(&self) -> Verdict {
        self.verdict
    }

    pub(crate) fn figures(&self) -> Option<Figures> {
        self.figures
    }

    /// What was collected belongs to another run of the device; the verdict stands until the next window.
    pub(crate) fn restart(&mut self) {
        (self.sum_m_s2, self.count, self.begin) = ([0.0; 3], 0, None);
    }

    /// Takes the samples of a batch in. A full window is judged by the stamp of the batch after it.
    pub(crate) fn add(&mut self, first: Seconds, first_sequence: u64, samples: &[[f64; 3]]) {
        if let Some((begin, sequence)) = self.begin {
            let length = first - begin;
            if length.0 >= self.params.window_s {
                self.judge(length, first_sequence.saturating_sub(sequence));
                self.restart();
            }
        }
        self.begin.get_or_insert((first, first_sequence));
        for sample in samples {
            for (sum, value) in self.sum_m_s2.iter_mut().zip(sample) {
                *sum += value;
            }
        }
        self.count += samples.len() as u64;
    }

    #[allow(clippy::cast_precision_loss, reason = "samples of a second")]
    fn judge(&mut self, length: Seconds, steps: u64) {
        let mean = self.sum_m_s2.map(|sum| sum / self.count as f64);
        let mean_m_s2 = mean.iter().map(|value| value * value).sum::<f64>().sqrt();
        let tilt_deg = (self.params.up.of(mean) / mean_m_s2).clamp(-1.0, 1.0).acos().to_degrees();
        let rate_hz = steps as f64 / length.0;
        self.figures = Some(Figures { mean_m_s2, tilt_deg, rate_hz });
        let near = |value: f64, wanted: f64, share: f64| (value / wanted - 1.0).abs() <= share;
        // Written so that what is not finite is not sound.
        self.verdict = if !near(mean_m_s2, GRAVITY_M_S2, self.params.gravity_tolerance) {
            Verdict::Unit { mean_m_s2 }
        } else if tilt_deg > self.params.tilt_max_deg {
            Verdict::Axes { found: Axis::nearest(mean), wanted: self.params.up, tilt_deg }
        } else if !near(rate_hz, self.params.rate_hz, self.params.rate_tolerance) {
            Verdict::Rate { measured_hz: rate_hz, wanted_hz: self.params.rate_hz }
        } else {
            Verdict::Sound
        };
    }
}
