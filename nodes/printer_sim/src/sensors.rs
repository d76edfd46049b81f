//! Sensors at the simulated printer: noise, rate, quantum and delay as in section 1.4 of the model book.
//!
//! Every sensor draws from a random stream of its own, so that a fault in one leaves the others' noise as it was.

use crate::faults::{Kind, SensorFaults, Thermistor};
use models::units::{Celsius, Kelvin, Seconds};
use rand::{Rng, SeedableRng, rngs::StdRng};
use rand_distr::{Distribution, StandardNormal};
use std::collections::VecDeque;

/// Reading of the firmware's table with an open circuit.
pub const OPEN_READING: Celsius = Celsius(-14.0);
/// Reading of the firmware's table with a short circuit.
pub const SHORT_READING: Celsius = Celsius(450.0);
/// Random streams of faults with a seed of their own, by kind; those of the printer itself are below ten.
const FAULT_STREAM: u64 = 20;
/// How far a spike is off: a loose plug or a disturbed converter, inside the possible range of a hot end `[K]`.
const SPIKE_K: f64 = 30.0;

/// Settings of all sensors; from `config/printer_sim.param.yaml`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Period of the temperature converter `[s]`.
    pub temperature_period_s: f64,
    /// Noise of a temperature reading, standard deviation `[K]`.
    pub temperature_sigma_k: f64,
    /// A sensor in the nozzle is fitted, read with the others.
    pub nozzle_sensor: bool,
    /// Period of the encoder `[s]`; 0 for none.
    pub encoder_period_s: f64,
    /// Length of filament per count `[m]`.
    pub encoder_quantum_m: f64,
    /// Period of the width stand-in `[s]`; 0 for none, where widths come from pictures.
    pub width_period_s: f64,
    /// Most by which it exposes sooner or later `[-]`, of the period.
    pub width_dither: f64,
    /// Time from exposure to result `[s]`.
    pub width_delay_s: f64,
    /// Noise of a width, standard deviation `[m]`.
    pub width_sigma_m: f64,
}

/// Standard normal numbers from a stream of their own.
#[derive(Debug, Clone)]
pub struct Noise(StdRng);

impl Noise {
    /// Stream number `stream` of the run with this seed.
    #[must_use]
    pub fn new(seed: u64, stream: u64) -> Self {
        Self(StdRng::seed_from_u64(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(stream)))
    }

    /// Next number.
    pub fn draw(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// A number that is equally likely anywhere between two, `low < high`.
    pub fn between(&mut self, (low, high): (f64, f64)) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }
}

/// A thermistor with its converter.
#[derive(Debug, Clone)]
pub struct Thermometer {
    sigma_k: f64,
    noise: Noise,
    /// What is random in faults with a seed of their own.
    of_noise: Option<Noise>,
    of_spikes: Option<Noise>,
    of_loose: Option<Noise>,
    last: Celsius,
}

impl Thermometer {
    /// A sound sensor at `start`.
    #[must_use]
    pub fn new(sigma_k: f64, noise: Noise, start: Kelvin) -> Self {
        Self { sigma_k, noise, of_noise: None, of_spikes: None, of_loose: None, last: start.into() }
    }

    /// Reads the bead's temperature under the faults in force.
    pub fn read(&mut self, bead: Kelvin, faults: &SensorFaults) -> Celsius {
        // Drawn whatever is in force: after a fault with a seed of its own the noise is that of a run without it.
        let own = self.noise.draw();
        let of_fault = self.of_noise.as_mut().filter(|_| faults.noise > 1.0);
        let noise_k = faults.noise * self.sigma_k * of_fault.map_or(own, Noise::draw);
        // A sound sensor draws nothing more: its noise is the same whatever other runs inject.
        let spike_k = if faults.spikes > 0.0 { self.spike_k(faults.spikes) } else { 0.0 };
        let opens = faults.loose > 0.0 && self.opens(faults.loose);
        let noisy = Celsius(Celsius::from(bead).0 + noise_k + spike_k + faults.bias_k);
        let shown = match faults.circuit {
            Thermistor::Sound | Thermistor::Detached(_) if !opens => noisy,
            Thermistor::Sound | Thermistor::Detached(_) | Thermistor::Open => OPEN_READING,
            Thermistor::Short => SHORT_READING,
            Thermistor::Stuck => return self.last,
        };
        self.last = shown;
        shown
    }

    fn spike_k(&mut self, share: f64) -> f64 {
        let noise = self.of_spikes.as_mut().unwrap_or(&mut self.noise);
        let (is_one, sign) = (noise.between((0.0, 1.0)) < share, noise.between((-1.0, 1.0)));
        if is_one { SPIKE_K.copysign(sign) } else { 0.0 }
    }

    fn opens(&mut self, share: f64) -> bool {
        self.of_loose.as_mut().unwrap_or(&mut self.noise).between((0.0, 1.0)) < share
    }

    /// A fault set in whose random part is drawn from a seed of its own, or from the run's; the newest fault of a kind counts.
    pub fn draw_from(&mut self, kind: Kind, seed: Option<u64>) {
        match kind {
            Kind::Noise => self.of_noise = seed.map(|seed| Noise::new(seed, FAULT_STREAM)),
            Kind::Spikes => self.of_spikes = seed.map(|seed| Noise::new(seed, FAULT_STREAM + 1)),
            Kind::Loose => self.of_loose = seed.map(|seed| Noise::new(seed, FAULT_STREAM + 2)),
            _ => {}
        }
    }

    /// The bead is at another temperature at once.
    pub fn set(&mut self, bead: Kelvin) {
        self.last = bead.into();
    }

    /// The last reading: what the firmware regulates on.
    #[must_use]
    pub fn last(&self) -> Celsius {
        self.last
    }
}

/// The width as a camera would give it, late.
#[derive(Debug, Clone)]
pub struct WidthGauge {
    delay_s: f64,
    sigma_m: f64,
    noise: Noise,
    waiting: VecDeque<(Seconds, f64)>,
}

impl WidthGauge {
    /// A gauge with nothing on its way.
    #[must_use]
    pub fn new(settings: &Settings, noise: Noise) -> Self {
        Self {
            delay_s: settings.width_delay_s,
            sigma_m: settings.width_sigma_m,
            noise,
            waiting: VecDeque::new(),
        }
    }

    /// Exposes a frame on a road of this width.
    pub fn expose(&mut self, now: Seconds, width_m: f64) {
        let measured_m = width_m + self.sigma_m * self.noise.draw();
        self.waiting.push_back((now, measured_m));
    }

    /// The next frame whose delay has passed: exposure and width.
    pub fn ready(&mut self, now: Seconds) -> Option<(Seconds, f64)> {
        let &(exposed, _) = self.waiting.front()?;
        ((now - exposed).0 >= self.delay_s).then(|| self.waiting.pop_front()).flatten()
    }

    /// Stated noise `[m]`.
    #[must_use]
    pub fn sigma_m(&self) -> f64 {
        self.sigma_m
    }
}

/// What a thermistor's bead follows: its block, or the air beside it once it fell out.
#[must_use]
pub fn bead_surroundings(block: Kelvin, air: Kelvin, circuit: Thermistor) -> Kelvin {
    match circuit {
        Thermistor::Detached(coupling) => Kelvin(air.0 + coupling * (block.0 - air.0)),
        _ => block,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_of_one_seed_differ_and_repeat() {
        let three = |seed, stream| {
            let mut noise = Noise::new(seed, stream);
            [noise.draw(), noise.draw(), noise.draw()].map(f64::to_bits)
        };
        assert_eq!(three(1, 2), three(1, 2));
        assert_ne!(three(1, 2), three(1, 3));
        assert_ne!(three(1, 2), three(2, 2));
    }

    #[test]
    fn a_frame_arrives_after_its_delay_with_its_exposure() {
        let settings = Settings {
            temperature_period_s: 0.1,
            temperature_sigma_k: 0.15,
            nozzle_sensor: false,
            encoder_period_s: 0.01,
            encoder_quantum_m: 1e-5,
            width_period_s: 0.5,
            width_dither: 0.2,
            width_delay_s: 0.4,
            width_sigma_m: 0.0,
        };
        let mut gauge = WidthGauge::new(&settings, Noise::new(1, 1));
        gauge.expose(Seconds(1.0), 4.5e-4);
        assert_eq!(gauge.ready(Seconds(1.39)), None);
        assert_eq!(gauge.ready(Seconds(1.41)), Some((Seconds(1.0), 4.5e-4)));
        assert_eq!(gauge.ready(Seconds(9.0)), None);
    }

    #[test]
    fn open_short_and_stuck_read_as_a_firmware_shows_them() {
        let mut thermometer = Thermometer::new(0.15, Noise::new(1, 1), Kelvin(488.15));
        let mut read =
            |circuit| thermometer.read(Kelvin(488.15), &SensorFaults { circuit, ..SensorFaults::NONE });
        let sound = read(Thermistor::Sound);
        assert!((sound.0 - 215.0).abs() < 1.0);
        assert_eq!(read(Thermistor::Stuck), sound);
        assert_eq!(read(Thermistor::Open), OPEN_READING);
        assert_eq!(read(Thermistor::Short), SHORT_READING);
    }

    /// Standard error of a deviation from 4000 readings: 1/sqrt(8000) = 1.1 %; of a share of 0.3: 0.7 %.
    #[test]
    fn noise_and_spikes_have_the_size_that_was_asked_for() {
        let mut thermometer = Thermometer::new(0.15, Noise::new(1, 1), Kelvin(488.15));
        let mut off_k = |faults: SensorFaults| {
            let read = |_| thermometer.read(Kelvin(488.15), &faults).0 - 215.0;
            (0..4000).map(read).collect::<Vec<f64>>()
        };
        let noisy = off_k(SensorFaults { noise: 10.0, ..SensorFaults::NONE });
        let deviation_k = (noisy.iter().map(|k| k * k).sum::<f64>() / 4000.0).sqrt();
        assert!((deviation_k - 1.5).abs() < 0.06, "{deviation_k} K");
        let spiky = off_k(SensorFaults { spikes: 0.3, ..SensorFaults::NONE });
        let spikes = spiky.iter().filter(|k| k.abs() > 20.0).count();
        assert!((1100..1300).contains(&spikes), "{spikes}");
    }

    /// What a fault draws from a seed of its own is the same in each, and leaves the sensor's own noise as it was.
    #[test]
    fn a_fault_with_a_seed_of_its_own_repeats_and_leaves_no_trace() {
        let read = |run: u64, kind, faults: SensorFaults, seed: Option<u64>| {
            let mut thermometer = Thermometer::new(0.15, Noise::new(run, 1), Kelvin(488.15));
            thermometer.draw_from(kind, seed);
            let mut three = |faults| [(); 3].map(|()| thermometer.read(Kelvin(488.15), faults).0.to_bits());
            (three(&faults), three(&SensorFaults::NONE))
        };
        let noise = SensorFaults { noise: 10.0, ..SensorFaults::NONE };
        let spikes = SensorFaults { spikes: 0.5, ..SensorFaults::NONE };
        let sound = read(1, Kind::Noise, SensorFaults::NONE, None);
        for (kind, faults) in [(Kind::Noise, noise), (Kind::Spikes, spikes)] {
            let (during, after) = read(1, kind, faults, Some(7));
            assert_eq!((during, after), read(1, kind, faults, Some(7)));
            assert_ne!(during, read(1, kind, faults, Some(8)).0, "{kind:?}");
            assert_eq!(after, sound.1, "{kind:?}");
        }
        assert_eq!(read(1, Kind::Noise, noise, Some(7)).0, read(2, Kind::Noise, noise, Some(7)).0);
    }
}
