//! Signals over time.

use super::super::decode::short;
use super::super::series::Series;
use fdm_loop_msgs::{
    BeadWidth, ControlCommand, DefectReport, ImuBatch, PrinterState, StateEstimate, Temperature,
};

/// 0 degC `[K]`.
const ZERO_DEGC_K: f64 = 273.15;
/// Half the width of the bands around an estimate, in standard deviations.
const SIGMAS: f64 = 2.0;
/// Measurement channels that are kept.
const CHANNELS_MAX: usize = 8;

/// An estimate and its band.
#[derive(Debug, Default)]
pub(crate) struct Estimated {
    pub(crate) value: Series,
    pub(crate) low: Series,
    pub(crate) high: Series,
}

/// Corrections over time.
#[derive(Debug, Default)]
pub(crate) struct Commands {
    pub(crate) flow_percent: Series,
    pub(crate) speed_percent: Series,
    pub(crate) offset_k: Series,
    pub(crate) advance_s: Series,
    pub(crate) slip_percent: Series,
}

/// Consistency of a measurement channel.
#[derive(Debug)]
pub(crate) struct Channel {
    pub(crate) name: String,
    /// Mean of the normalised innovations squared over the window, as logarithm to base 10.
    pub(crate) windowed_log: Series,
    pub(crate) mean: Option<f64>,
    pub(crate) gated: u64,
    /// Estimates at which the channel was silent.
    pub(crate) silent: u64,
    pub(crate) estimates: u64,
}

/// Shaking of the tool.
#[derive(Debug, Default)]
pub(crate) struct Shaking {
    /// Largest deviation from the mean of its batch `[m/s2]`.
    pub(crate) peak_m_s2: Series,
    pub(crate) samples: u64,
    pub(crate) saturated: u64,
    pub(crate) refused: u64,
}

/// What the page needs of a valid estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Flow {
    pub(crate) flow_m_s: f64,
    pub(crate) gain: f64,
}

/// All signals.
#[derive(Debug, Default)]
pub(crate) struct Signals {
    pub(crate) hotend_degc: Series,
    /// Measured less set-point, while a road is laid `[K]`.
    pub(crate) hotend_error_k: Series,
    /// Set-point in force while a road is laid.
    laying_at_degc: Option<f64>,
    pub(crate) nozzle_sensor_degc: Series,
    pub(crate) bed_degc: Series,
    pub(crate) hotend_target_degc: Series,
    pub(crate) bed_target_degc: Series,
    pub(crate) nozzle_degc: Estimated,
    pub(crate) slip_percent: Estimated,
    pub(crate) gain_percent: Estimated,
    pub(crate) width_target: Series,
    pub(crate) width_measured: Series,
    pub(crate) width_estimated: Series,
    pub(crate) width_sources: Vec<String>,
    pub(crate) wish: Commands,
    pub(crate) permit: Commands,
    pub(crate) channels: Vec<Channel>,
    /// Updates in a channel's window.
    pub(crate) window: u32,
    pub(crate) steps: u64,
    pub(crate) resets: u64,
    pub(crate) estimates: u64,
    /// Estimates with values that cannot be.
    pub(crate) estimates_refused: u64,
    pub(crate) confidence: Series,
    pub(crate) detection: Series,
    pub(crate) residual: Series,
    pub(crate) frames: u64,
    pub(crate) frames_unusable: u64,
    pub(crate) imu: Shaking,
}

impl Signals {
    pub(crate) fn hotend(&mut self, at: f64, message: &Temperature) {
        self.hotend_degc.add(at, message.temperature);
        if let Some(target_degc) = self.laying_at_degc {
            self.hotend_error_k.add(at, message.temperature - target_degc);
        }
    }

    pub(crate) fn nozzle_sensor(&mut self, at: f64, message: &Temperature) {
        self.nozzle_sensor_degc.add(at, message.temperature);
    }

    pub(crate) fn bed(&mut self, at: f64, message: &Temperature) {
        self.bed_degc.add(at, message.temperature);
    }

    pub(crate) fn state(&mut self, at: f64, state: &PrinterState) {
        self.laying_at_degc = state.depositing.then_some(state.hotend_target_degc);
        self.hotend_target_degc.add(at, state.hotend_target_degc);
        self.bed_target_degc.add(at, state.bed_target_degc);
        if state.depositing && state.target_width_known {
            self.width_target.add(at, state.target_width_m * 1e3);
        }
    }

    pub(crate) fn width(&mut self, at: f64, message: &BeadWidth) {
        self.width_measured.add(at, message.width_m * 1e3);
        let source = short(&message.source, 40);
        if self.width_sources.len() < 4 && !self.width_sources.contains(&source) {
            self.width_sources.push(source);
        }
    }

    /// Takes an estimate in; `None` where it cannot be.
    pub(crate) fn estimate(&mut self, at: f64, message: &StateEstimate) -> Option<Flow> {
        self.estimates += 1;
        let Ok(read) = runtime::wire::estimate_from_wire(message) else {
            self.estimates_refused += 1;
            return None;
        };
        for (name, scale, offset, into) in [
            ("nozzle_k", 1.0, -ZERO_DEGC_K, &mut self.nozzle_degc),
            ("slip", 100.0, 0.0, &mut self.slip_percent),
            ("gain", 100.0, 0.0, &mut self.gain_percent),
        ] {
            let Some(index) = message.names.iter().position(|known| known == name) else { continue };
            let variance =
                message.covariance.get(index * (message.names.len() + 1)).copied().unwrap_or(f64::NAN);
            let value = message.x.get(index).copied().unwrap_or(f64::NAN) * scale + offset;
            let reach = SIGMAS * variance.sqrt() * scale;
            into.value.add(at, value);
            into.low.add(at, value - reach);
            into.high.add(at, value + reach);
        }
        (self.window, self.steps, self.resets) = (message.chi_square_window, message.steps, message.resets);
        for index in 0..message.channels.len().min(CHANNELS_MAX) {
            self.channel(at, message, index);
        }
        Some(Flow { flow_m_s: read.flow_m_s, gain: read.gain })
    }

    /// One channel of an estimate whose arrays are known to belong together.
    fn channel(&mut self, at: f64, message: &StateEstimate, index: usize) {
        if self.channels.len() <= index {
            let name = short(&message.channels[index], 40);
            let windowed_log = Series::default();
            self.channels.push(Channel { name, windowed_log, mean: None, gated: 0, silent: 0, estimates: 0 });
        }
        let Some(channel) = self.channels.get_mut(index) else { return };
        channel.estimates += 1;
        channel.silent += u64::from(!message.alive[index]);
        channel.gated = message.gated.get(index).copied().unwrap_or(0);
        if message.measured[index] {
            channel.mean = Some(message.nis_mean[index]);
        }
        let windowed = message.chi_square[index] / f64::from(message.chi_square_window);
        if windowed > 0.0 {
            channel.windowed_log.add(at, windowed.log10());
        }
    }

    pub(crate) fn defects(&mut self, at: f64, report: &DefectReport) {
        self.frames += 1;
        if !report.usable {
            self.frames_unusable += 1;
            return;
        }
        self.confidence.add(at, report.confidence);
        self.detection.add(at, report.detection);
        self.residual.add(at, (report.residual / report.residual_limit).min(1.0));
    }
}

impl Commands {
    /// Takes a command in.
    pub(crate) fn take(&mut self, at: f64, command: &ControlCommand) {
        self.flow_percent.add(at, command.flow_factor * 100.0);
        self.speed_percent.add(at, command.speed_factor * 100.0);
        self.offset_k.add(at, command.nozzle_setpoint_offset_k);
        if command.set_advance {
            self.advance_s.add(at, command.advance_s);
        }
        if command.close_extruder_loop {
            self.slip_percent.add(at, command.slip_compensation * 100.0);
        }
    }
}

impl Shaking {
    /// Takes a batch in; its axes must be of one length.
    pub(crate) fn take(&mut self, at: f64, batch: &ImuBatch) {
        let count = batch.x_m_s2.len();
        if count == 0 || batch.y_m_s2.len() != count || batch.z_m_s2.len() != count {
            self.refused += 1;
            return;
        }
        self.samples += count as u64;
        self.saturated += u64::from(batch.saturated);
        let mean = |axis: &[f64]| axis.iter().sum::<f64>() / count as f64;
        let rest = [mean(&batch.x_m_s2), mean(&batch.y_m_s2), mean(&batch.z_m_s2)];
        let deviation = |(x, (y, z)): (&f64, (&f64, &f64))| {
            ((x - rest[0]).powi(2) + (y - rest[1]).powi(2) + (z - rest[2]).powi(2)).sqrt()
        };
        let peak = batch.x_m_s2.iter().zip(batch.y_m_s2.iter().zip(&batch.z_m_s2)).map(deviation);
        self.peak_m_s2
            .add(at, peak.fold(0.0, |peak, next| if next > peak || next.is_nan() { next } else { peak }));
    }
}
