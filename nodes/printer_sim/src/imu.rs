//! Inertial unit on the tool head: what it measures of motion, resonance and blows.
//!
//! It reads specific force as REP 145 demands: +9.81 m/s2 on z at rest. Its axes are those of the bed frame, and it is
//! taken to feel all three; on a printer whose bed moves along y that axis needs a sensor on the bed.

use crate::pace::Pace;
use crate::sensors::Noise;
use crate::structure::{Blow, ImpactParams, Structure, StructureParams};
use models::params::{ParamError, in_range};
use models::units::Seconds;
use serde::Deserialize;

/// Standard gravity `[m/s2]`.
const GRAVITY_M_S2: f64 = 9.80665;
/// Step that the structure is made for; another one works too `[s]`.
const STEP_S: f64 = 1e-3;

/// Settings of the sensor: `simulator.imu`. Built only from a valid [`RawSettings`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawSettings")]
pub struct Settings {
    /// Time between two samples `[s]`; 0 for no sensor at all.
    pub period_s: f64,
    /// Time between two batches `[s]`.
    pub batch_period_s: f64,
    /// Noise of a sample, standard deviation `[m/s2]`.
    pub sigma_m_s2: f64,
    /// Largest magnitude that an axis can show `[m/s2]`.
    pub range_m_s2: f64,
}

/// Settings as they are written.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "unit, range and meaning stand beside each value in the file")]
pub struct RawSettings {
    pub period_s: f64,
    pub batch_period_s: f64,
    pub sigma_m_s2: f64,
    pub range_m_s2: f64,
}

impl TryFrom<RawSettings> for Settings {
    type Error = ParamError;
    fn try_from(raw: RawSettings) -> Result<Self, ParamError> {
        let steps = raw.period_s / STEP_S;
        // Between two steps of the plant there is nothing to sample.
        if !(raw.period_s == 0.0
            || (1.0..=100.0).contains(&steps.round()) && (steps - steps.round()).abs() < 1e-6)
        {
            return Err(ParamError::OutOfRange {
                name: "imu.period_s",
                value: raw.period_s,
                unit: "s",
                rule: "0 or whole milliseconds in [0.001, 0.1]".into(),
            });
        }
        let shortest_s = raw.period_s.max(STEP_S);
        Ok(Self {
            period_s: raw.period_s,
            batch_period_s: in_range("imu.batch_period_s", raw.batch_period_s, "s", (shortest_s, 1.0))?,
            sigma_m_s2: in_range("imu.sigma_m_s2", raw.sigma_m_s2, "m/s2", (0.0, 100.0))?,
            range_m_s2: in_range("imu.range_m_s2", raw.range_m_s2, "m/s2", (10.0, 4000.0))?,
        })
    }
}

impl Settings {
    /// Whether a sensor is fitted.
    #[must_use]
    pub fn fitted(&self) -> bool {
        self.period_s > 0.0
    }
}

/// All samples since the last batch.
#[derive(Debug, Clone, PartialEq)]
pub struct Batch {
    /// Time of the first sample.
    pub first: Seconds,
    /// Number of the first sample since start.
    pub first_sequence: u64,
    /// Time between two samples.
    pub period: Seconds,
    /// Largest magnitude that an axis can show `[m/s2]`.
    pub range_m_s2: f64,
    /// Accelerations x, y, z, gravity included `[m/s2]`.
    pub samples: Vec<[f64; 3]>,
}

/// A sensor at its tool head.
#[derive(Debug, Clone)]
pub struct Imu {
    settings: Settings,
    impact: ImpactParams,
    structure: Structure,
    blows: Vec<Blow>,
    pace: Pace,
    noise: Noise,
    chance: Noise,
    taken: u64,
    batch_samples: usize,
    samples: Vec<[f64; 3]>,
}

impl Imu {
    /// At rest; `noise` is that of the samples, `chance` that of the blows.
    #[must_use]
    pub fn new(
        settings: Settings,
        (structure, impact): (StructureParams, ImpactParams),
        (noise, chance): (Noise, Noise),
    ) -> Self {
        // At most a thousand: the settings' ranges.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded above")]
        let batch_samples = ((settings.batch_period_s / settings.period_s).round() as usize).max(1);
        Self {
            settings,
            impact,
            structure: Structure::new(structure, Seconds(STEP_S)),
            blows: Vec::new(),
            pace: Pace::new(settings.period_s),
            noise,
            chance,
            taken: 0,
            batch_samples,
            samples: Vec::with_capacity(batch_samples),
        }
    }

    /// Something hits the head from anywhere, with this peak `[m/s2]`.
    pub fn knock(&mut self, now: Seconds, peak_m_s2: f64) {
        let direction = [self.chance.draw(), self.chance.draw(), self.chance.draw()];
        let length = direction.iter().map(|share| share * share).sum::<f64>().sqrt();
        // Three normal numbers that are all zero do not happen; x then.
        let unit = if length > 0.0 { direction.map(|share| share / length) } else { [1.0, 0.0, 0.0] };
        self.blow(now, unit.map(|share| share * peak_m_s2));
    }

    /// A motor skips along an axis, 0 for x.
    pub fn skip(&mut self, now: Seconds, axis: usize) {
        let mut peak_m_s2 = [0.0; 3];
        peak_m_s2[axis] = self.chance.between(self.impact.skip_m_s2);
        self.blow(now, peak_m_s2);
    }

    fn blow(&mut self, start: Seconds, peak_m_s2: [f64; 3]) {
        let length_s = self.chance.between(self.impact.length_s);
        self.blows.push(Blow { start, length_s, peak_m_s2, frequency_hz: self.impact.frequency_hz });
    }

    /// One step of `dt` that ends `now`, at a commanded mean velocity `[m/s]`; yields a batch when one is full.
    pub fn step(&mut self, now: Seconds, velocity_m_s: [f64; 3], dt: Seconds) -> Option<Batch> {
        let tool_m_s2 = self.structure.step(velocity_m_s, dt);
        if !self.pace.due(now) {
            return None;
        }
        let mut sample = tool_m_s2;
        sample[2] += GRAVITY_M_S2;
        if !self.blows.is_empty() {
            for blow in &self.blows {
                let blow_m_s2 = blow.at(now);
                (0..3).for_each(|axis| sample[axis] += blow_m_s2[axis]);
            }
            self.blows.retain(|blow| !blow.over(now));
        }
        let Settings { sigma_m_s2, range_m_s2, .. } = self.settings;
        let noise = &mut self.noise;
        self.samples
            .push(sample.map(|m_s2| (m_s2 + sigma_m_s2 * noise.draw()).clamp(-range_m_s2, range_m_s2)));
        self.taken += 1;
        (self.samples.len() >= self.batch_samples).then(|| self.batch())
    }

    fn batch(&mut self) -> Batch {
        let samples = std::mem::replace(&mut self.samples, Vec::with_capacity(self.batch_samples));
        let first_sequence = self.taken - samples.len() as u64;
        #[allow(clippy::cast_precision_loss, reason = "samples of a print are far below 2^52")]
        let first = Seconds((first_sequence + 1) as f64 * self.settings.period_s);
        Batch {
            first,
            first_sequence,
            period: Seconds(self.settings.period_s),
            range_m_s2: self.settings.range_m_s2,
            samples,
        }
    }
}
