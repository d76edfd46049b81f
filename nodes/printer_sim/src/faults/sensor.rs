//! Faults of a thermistor and its converter.

use super::Kind;

/// What is wrong with a thermistor and its converter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorFaults {
    /// Its circuit.
    pub circuit: Thermistor,
    /// Added to the reading `[K]`.
    pub bias_k: f64,
    /// Factor on the standard deviation of the noise `[-]`.
    pub noise: f64,
    /// Share of the readings that are spikes `[-]`.
    pub spikes: f64,
    /// Share of the readings that are taken while the plug is open `[-]`.
    pub loose: f64,
}

impl SensorFaults {
    /// A sound sensor.
    pub const NONE: Self =
        Self { circuit: Thermistor::Sound, bias_k: 0.0, noise: 1.0, spikes: 0.0, loose: 0.0 };

    pub(super) fn overlay(&mut self, kind: Kind, size: f64, share: f64) {
        match kind {
            Kind::Open => self.circuit = Thermistor::Open,
            Kind::Short => self.circuit = Thermistor::Short,
            Kind::Detached => self.circuit = Thermistor::Detached(size),
            Kind::Stuck => self.circuit = Thermistor::Stuck,
            Kind::Bias => self.bias_k += share * size,
            Kind::Noise => self.noise *= 1.0 + share * (size - 1.0),
            Kind::Spikes => self.spikes = (self.spikes + share * size).min(1.0),
            Kind::Loose => self.loose = (self.loose + share * size).min(1.0),
            _ => {}
        }
    }
}

/// State of the thermistor circuit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Thermistor {
    /// Reads the block.
    Sound,
    /// Open circuit.
    Open,
    /// Short circuit.
    Short,
    /// Hangs beside the block; share of the coupling left `[-]`.
    Detached(f64),
    /// Repeats its last reading.
    Stuck,
}
