//! Shared by the tests: shipped parameters, a stand-in heater, a printer report.
#![allow(dead_code, clippy::unwrap_used, reason = "each test binary uses its part; a test may panic")]

pub(crate) mod print;

use std::collections::BTreeMap;

use models::command::Trims;
use models::status::JobPhase;
use models::units::{Celsius, Seconds};
use safety_supervisor::{Event, Params, PrinterReport};

#[derive(serde::Deserialize)]
struct File {
    #[serde(rename = "ros__parameters")]
    parameters: Params,
}

/// Parameters as shipped.
pub(crate) fn params() -> Params {
    let text = include_str!("../../../../config/safety_supervisor.param.yaml");
    let file: BTreeMap<String, File> = serde_saphyr::from_str(text).unwrap();
    file.into_values().next().unwrap().parameters
}

/// The shipped file with one line changed.
pub(crate) fn params_with(from: &str, to: &str) -> Params {
    let text = include_str!("../../../../config/safety_supervisor.param.yaml");
    assert!(text.contains(from));
    let file: BTreeMap<String, File> = serde_saphyr::from_str(&text.replace(from, to)).unwrap();
    file.into_values().next().unwrap().parameters
}

/// Random numbers of a seed: SplitMix64.
#[derive(Clone)]
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// Uniform in `[0, 1)`.
    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Standard normal, Box-Muller.
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }

    /// A factor in `[0.9, 1.1]`.
    fn tolerance(&mut self) -> f64 {
        0.9 + 0.2 * self.uniform()
    }
}

/// A report of a printer at work.
pub(crate) fn report(now_s: f64) -> PrinterReport {
    PrinterReport {
        stamp: Seconds(now_s),
        phase: JobPhase::Printing,
        layer: None,
        motor_position_m: 0.0,
        wanted_position_m: 0.0,
        hotend_duty: 0.0,
        bed_duty: 0.0,
        hotend_target: Celsius(0.0),
        hotend_sliced_target: Celsius(0.0),
        bed_target: Celsius(0.0),
        fan: 0.0,
        trims: Trims::NEUTRAL,
        path_speed_m_s: 0.0,
        filament_present: None,
        homed: true,
        mains_on: true,
        part_fan_speed_1_s: None,
        stop_input: None,
    }
}

/// Two-node heater with thermistor and PID, each constant up to 10 % off the nominal one.
pub(crate) struct Heater {
    pub(crate) random: Random,
    pub(crate) now_s: f64,
    pub(crate) target_c: f64,
    pub(crate) fan: f64,
    pub(crate) flow_mm3_s: f64,
    pub(crate) ambient_c: f64,
    pub(crate) loss_factor: f64,
    /// Share of the ordered power that arrives.
    pub(crate) gain: f64,
    pub(crate) stuck_on: bool,
    /// Coupling of the thermistor to the block; its remainder couples to air.
    pub(crate) coupling: f64,
    pub(crate) frozen: bool,
    /// Noise of a reading, one standard deviation `[K]`.
    pub(crate) noise_k: f64,
    /// Added to the next reading.
    pub(crate) spike_k: f64,
    pub(crate) duty: f64,
    pub(crate) reading_c: f64,
    pub(crate) block_c: f64,
    nozzle_c: f64,
    sensor_c: f64,
    integral_w: f64,
    previous_c: f64,
    motor_m: f64,
    constants: [f64; 8],
    ticks: u64,
    /// Steps between two readings.
    sample_ticks: u64,
}

impl Heater {
    pub(crate) fn new(seed: u64) -> Self {
        let mut random = Random(seed);
        let nominal = [14.5, 2.2, 0.45, 0.068, 0.029, 40.0, 4.5, 1240.0 * 1800.0 * 1e-9];
        let constants = nominal.map(|value| value * random.tolerance());
        Self {
            random,
            now_s: 0.0,
            target_c: 0.0,
            fan: 0.0,
            flow_mm3_s: 0.0,
            ambient_c: 25.0,
            loss_factor: 1.0,
            gain: 1.0,
            stuck_on: false,
            coupling: 1.0,
            frozen: false,
            noise_k: 0.15,
            spike_k: 0.0,
            duty: 0.0,
            reading_c: 25.0,
            block_c: 25.0,
            nozzle_c: 25.0,
            sensor_c: 25.0,
            integral_w: 0.0,
            previous_c: 25.0,
            motor_m: 0.0,
            constants,
            ticks: 0,
            sample_ticks: 5,
        }
    }

    /// With readings so rough `[K]`.
    pub(crate) fn with_noise(mut self, noise_k: f64) -> Self {
        self.noise_k = noise_k;
        self
    }

    /// Read every so many steps of 20 ms; it is regulated ten times a second all the same.
    pub(crate) fn read_every(mut self, sample_ticks: u64) -> Self {
        self.sample_ticks = sample_ticks;
        self
    }

    /// At rest at a temperature, with the duty that holds it.
    pub(crate) fn settled(seed: u64, target_c: f64, fan: f64, flow_mm3_s: f64) -> Self {
        let mut heater = Self::new(seed);
        (heater.target_c, heater.fan, heater.flow_mm3_s) = (target_c, fan, flow_mm3_s);
        for temp in [&mut heater.block_c, &mut heater.nozzle_c, &mut heater.sensor_c, &mut heater.previous_c]
        {
            *temp = target_c;
        }
        heater.reading_c = target_c;
        let (loss, fan_loss, feed) = (heater.constants[3], heater.constants[4], heater.constants[7]);
        heater.integral_w = (loss + fan_loss * fan + feed * flow_mm3_s) * (target_c - 25.0);
        heater
    }

    /// One step of 20 ms; every fifth one samples and regulates. Returns the events in their order.
    pub(crate) fn step(&mut self) -> Vec<Event> {
        const DT_S: f64 = 0.02;
        let [c_block, c_nozzle, link, loss, fan_loss, power, lag, feed] = self.constants;
        self.now_s += DT_S;
        self.ticks += 1;
        let supplied_w = if self.stuck_on { power } else { power * self.duty * self.gain };
        let air = self.ambient_c;
        let block_loss = 0.85 * loss * self.loss_factor + 0.31 * fan_loss * self.fan;
        let nozzle_loss =
            0.15 * loss * self.loss_factor + 0.69 * fan_loss * self.fan + feed * self.flow_mm3_s;
        let across_w = link * (self.block_c - self.nozzle_c);
        let seen_c = air + self.coupling * (self.block_c - air);
        self.sensor_c += (seen_c - self.sensor_c) / lag * DT_S;
        self.block_c += (supplied_w - across_w - block_loss * (self.block_c - air)) / c_block * DT_S;
        self.nozzle_c += (across_w - nozzle_loss * (self.nozzle_c - air)) / c_nozzle * DT_S;
        self.motor_m += self.flow_mm3_s * 1e-9 / 2.405e-6 * DT_S;

        let mut events = Vec::with_capacity(3);
        if self.ticks.is_multiple_of(self.sample_ticks) {
            let noise_k = self.noise_k * self.random.normal();
            if !self.frozen {
                self.reading_c = self.sensor_c + noise_k + std::mem::take(&mut self.spike_k);
            }
            events.push(Event::Hotend { stamp: Seconds(self.now_s), temp: Celsius(self.reading_c) });
        }
        if self.ticks.is_multiple_of(5) {
            self.regulate();
        }
        events.push(Event::Printer(PrinterReport {
            motor_position_m: self.motor_m,
            hotend_duty: self.duty,
            hotend_target: Celsius(self.target_c),
            hotend_sliced_target: Celsius(self.target_c),
            fan: self.fan,
            ..report(self.now_s)
        }));
        events.push(Event::Encoder { stamp: Seconds(self.now_s), position_m: self.motor_m });
        events.push(Event::Tick { now: Seconds(self.now_s) });
        events
    }

    /// PID of the Ender 3, the derivative on the measurement filtered over 0.5 s, anti-windup by clamping.
    fn regulate(&mut self) {
        const DT_S: f64 = 0.1;
        let error_k = self.target_c - self.reading_c;
        let smooth_c = self.previous_c + (self.reading_c - self.previous_c) * DT_S / 0.5;
        let rate_k_s = (smooth_c - self.previous_c) / DT_S;
        self.previous_c = smooth_c;
        let power_w = 3.41 * error_k + self.integral_w - 12.0 * rate_k_s;
        let max_w = self.constants[5];
        if (0.0..max_w).contains(&power_w) {
            self.integral_w = (self.integral_w + 0.242 * error_k * DT_S).clamp(0.0, max_w);
        }
        self.duty = if self.target_c > 0.0 { (power_w / max_w).clamp(0.0, 1.0) } else { 0.0 };
    }
}
