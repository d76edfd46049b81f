//! P1, P2: the heater gives more or less power than it is told to.
//!
//! An own energy balance, `C dT/dt = P u - (h + h_fan fan + c_feed v_feed)(T - T_amb) + d`, read through the
//! thermistor's lag, `tau dT_s/dt = T - T_s`. An observer with a triple pole at `-w` follows the disturbance `d`
//! `[W]`, and a slow average of it, bounded, stands for ambient and errors of the constants. What goes beyond is
//! power that nobody ordered, or ordered power that never came. Two observers run: the fast one sees a dead heater
//! and a shorted switch in time, the slow one, less noisy, a weak heater.
//!
//! The balance of a heater that is being warmed up carries the error of its capacity; the bound is wider by a
//! share of the power that goes into warming, as far as order and measurement agree on its sign.

use models::units::{Celsius, Seconds};

use crate::params::{HeaterParams, ObserverParams};

/// Longest step of the balance: after a longer gap the observer starts anew `[s]`.
const GAP_MAX_S: f64 = 1.0;

/// What drives the heater's temperature, as the printer reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// Heater duty `[0, 1]`; zero while the mains relay is open.
    pub duty: f64,
    /// Part fan `[0, 1]`.
    pub fan: f64,
    /// Filament pushed since start `[m]`.
    pub motor_position_m: f64,
}

/// Which way the balance is broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeaterFault {
    /// P1: power without order.
    StuckOn,
    /// P2: order without power.
    Deficit,
}

/// Mean inputs since the last temperature.
#[derive(Debug, Clone, Copy, Default)]
struct Inputs {
    duty: f64,
    fan: f64,
    feed_m_s: f64,
}

/// Watches one heater.
#[derive(Debug, Clone)]
pub struct HeaterCheck {
    params: HeaterParams,
    fast: Observer,
    slow: Observer,
    drive: Option<Drive>,
    drive_since: Seconds,
    duty_s: f64,
    feed_from_m: Option<f64>,
    last_sample: Option<Seconds>,
    skipped: u32,
    reading_c: f64,
    moved_k: f64,
}

impl HeaterCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: HeaterParams) -> Self {
        Self {
            params,
            fast: Observer::new(params.fast),
            slow: Observer::new(params.slow),
            drive: None,
            drive_since: Seconds(0.0),
            duty_s: 0.0,
            feed_from_m: None,
            last_sample: None,
            skipped: 0,
            reading_c: f64::NAN,
            moved_k: 0.0,
        }
    }

    /// Takes what the printer says it does at `now`.
    pub fn on_drive(&mut self, now: Seconds, drive: Drive) {
        if let (Some(before), Some(sampled)) = (self.drive, self.last_sample) {
            self.duty_s += before.duty * (now.0 - self.drive_since.0.max(sampled.0)).max(0.0);
        }
        self.drive = Some(drive);
        self.drive_since = now;
    }

    /// Takes a temperature of `now`, on the clock of the printer's reports; nothing is judged before the first of
    /// those. A second sample of the same moment says nothing new.
    pub fn on_sample(&mut self, now: Seconds, temp: Celsius) {
        let Some(drive) = self.drive else { return };
        if self.last_sample.is_some_and(|last| (-GAP_MAX_S..=0.0).contains(&(now.0 - last.0))) {
            return;
        }
        let dt_s = self.last_sample.map(|last| now.0 - last.0);
        let feed_from_m = self.feed_from_m.replace(drive.motor_position_m);
        let held_s = self.last_sample.map_or(0.0, |last| (now.0 - self.drive_since.0.max(last.0)).max(0.0));
        let duty_s = std::mem::take(&mut self.duty_s) + drive.duty * held_s;
        self.last_sample = Some(now);
        let (Some(dt_s), Some(feed_from_m)) = (dt_s, feed_from_m) else {
            return self.start(temp);
        };
        if !(dt_s > 0.0 && dt_s <= GAP_MAX_S) {
            return self.start(temp);
        }
        let feed_m_s = (drive.motor_position_m - feed_from_m).max(0.0) / dt_s;
        let inputs = Inputs { duty: duty_s / dt_s, fan: drive.fan, feed_m_s };
        // A single spike is no heat; a jump that stays is taken for what it is.
        let spike = (temp.0 - self.fast.sensor_c).abs() > self.params.spike_k;
        self.skipped = if spike { self.skipped + 1 } else { 0 };
        let measured = (self.skipped == 0 || self.skipped > self.params.spike_samples).then_some(temp.0);
        self.fast.step(&self.params, inputs, measured, dt_s);
        self.slow.step(&self.params, inputs, measured, dt_s);
        let changed = self.reading_c.to_bits() != temp.0.to_bits();
        self.reading_c = temp.0;
        let rate_k_s = (self.params.balance_w(inputs, temp.0) + self.slow.usual_w) / self.params.capacity_j_k;
        self.moved_k = if changed { 0.0 } else { self.moved_k + rate_k_s * dt_s };
    }

    /// The fault in force.
    #[must_use]
    pub fn fault(&self) -> Option<HeaterFault> {
        self.fast.fault().or_else(|| self.slow.fault())
    }

    /// How far the balance says the temperature has moved since the reading last changed `[K]`.
    #[must_use]
    pub fn moved_k(&self) -> f64 {
        self.moved_k
    }

    /// Excess power over the order `[W]` as the fast observer sees it: for diagnostics.
    #[must_use]
    pub fn excess_w(&self) -> f64 {
        self.fast.disturbance_w - self.fast.usual_w
    }

    /// Forgets everything: after an acknowledge, a resume or a stop of the clock.
    pub fn reset(&mut self) {
        *self = Self::new(self.params);
    }

    fn start(&mut self, temp: Celsius) {
        self.fast.start(temp.0);
        self.slow.start(temp.0);
    }
}

/// One observer of the balance.
#[derive(Debug, Clone, Copy)]
struct Observer {
    params: ObserverParams,
    block_c: f64,
    sensor_c: f64,
    disturbance_w: f64,
    usual_w: f64,
    over: u32,
    under: u32,
}

impl Observer {
    fn new(params: ObserverParams) -> Self {
        Self { params, block_c: 0.0, sensor_c: 0.0, disturbance_w: 0.0, usual_w: 0.0, over: 0, under: 0 }
    }

    fn start(&mut self, temp_c: f64) {
        *self = Self { block_c: temp_c, sensor_c: temp_c, ..Self::new(self.params) };
    }

    fn step(&mut self, heater: &HeaterParams, inputs: Inputs, measured_c: Option<f64>, dt_s: f64) {
        let balance_w = heater.balance_w(inputs, self.block_c);
        let capacity = heater.capacity_j_k;
        self.sensor_c += (self.block_c - self.sensor_c) * (1.0 - (-dt_s / heater.sensor_lag_s).exp());
        self.block_c += (balance_w + self.disturbance_w) * dt_s / capacity;
        // Triple pole at -w of the error: gains 3w - 1/tau, 3w^2 tau, w^3 C tau.
        let pole = self.params.pole_1_s;
        let residual_k = measured_c.map_or(0.0, |measured_c| measured_c - self.sensor_c);
        self.sensor_c += (3.0 * pole - 1.0 / heater.sensor_lag_s) * residual_k * dt_s;
        self.block_c += 3.0 * pole.powi(2) * heater.sensor_lag_s * residual_k * dt_s;
        self.disturbance_w += pole.powi(3) * capacity * heater.sensor_lag_s * residual_k * dt_s;

        let adapt = dt_s / heater.usual_time_s;
        self.usual_w = (self.usual_w + (self.disturbance_w - self.usual_w) * adapt)
            .clamp(-heater.usual_max_w, heater.usual_max_w);

        let excess_w = self.disturbance_w - self.usual_w;
        let warming_w = agreement(balance_w, balance_w + self.disturbance_w);
        let slack_w = heater.capacity_error * warming_w;
        self.over = if excess_w > self.params.stuck_on_w + slack_w { self.over.saturating_add(1) } else { 0 };
        self.under =
            if excess_w < -self.params.deficit_w - slack_w { self.under.saturating_add(1) } else { 0 };
    }

    fn fault(&self) -> Option<HeaterFault> {
        if self.over >= self.params.samples {
            Some(HeaterFault::StuckOn)
        } else if self.under >= self.params.samples {
            Some(HeaterFault::Deficit)
        } else {
            None
        }
    }
}

impl HeaterParams {
    /// Ordered power less losses at this temperature `[W]`.
    fn balance_w(&self, inputs: Inputs, temp_c: f64) -> f64 {
        let loss_w_k =
            self.loss_w_k + self.fan_loss_w_k * inputs.fan + self.feed_heat_j_k_m * inputs.feed_m_s;
        self.power_w * inputs.duty - loss_w_k * (temp_c - self.ambient_c)
    }
}

/// Size of what two powers have in common; zero where they differ in sign.
fn agreement(ordered_w: f64, measured_w: f64) -> f64 {
    if ordered_w * measured_w > 0.0 { ordered_w.abs().min(measured_w.abs()) } else { 0.0 }
}
