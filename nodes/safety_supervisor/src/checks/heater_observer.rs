//! One observer of a heater's balance: a triple pole at `-w` that follows the disturbance, and what it calls a fault.
//!
//! White noise of `sigma` `[K]` in readings `dt` apart makes the disturbance noisy by
//! `C tau sigma sqrt(dt w^5 (3 + 1/(w tau)^2) / 16)` `[W]`: the limits are wider by a multiple of what noise beyond
//! the usual adds. So does an order that is not known between two states of the printer, of power density `S`
//! `[W^2 s]`: `sqrt(3 w S / 16)`.

use super::drive_history::Means;
use super::heater::HeaterFault;
use super::heater_start::Begun;
use super::pace::{COUNTED_PERIOD_S, SLOW_SAMPLES};
use crate::params::{HeaterParams, ObserverParams};

/// What blurs a balance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Noise {
    /// Standard deviation of a reading `[K]`.
    pub(super) reading_k: f64,
    /// Time since the reading before `[s]`.
    pub(super) period_s: f64,
    /// Density of what is not known of the duty `[s]`.
    pub(super) duty2_s: f64,
}

/// One observer of the balance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Observer {
    params: ObserverParams,
    pub(super) block_c: f64,
    pub(super) sensor_c: f64,
    pub(super) disturbance_w: f64,
    pub(super) usual_w: f64,
    /// Ordered power less losses `[W]`, smoothed.
    balance_w: f64,
    /// Power that warms the block `[W]`, smoothed.
    pub(super) warming_w: f64,
    /// Ordered power behind one, two and three lags of the observer `[W]`.
    ordered_w: [f64; 3],
    /// Time until what it says counts: an error of the beginning has died away `[s]`.
    pub(super) settling_s: f64,
    over: u32,
    under: u32,
    /// Readings in a row that are a fault, as they come just now.
    needed: u32,
    /// How much heat without order, and how much missing, counts just now `[W]`.
    limits_w: (f64, f64),
}

/// Time constants of an observer until an error of its beginning counts for nothing: `e^-5 (1 + 5 + 25/2) = 12 %`.
const SETTLED: f64 = 5.0;

/// Share of the least power that counts as missing from which learning slows down, and by how much `[-]`.
const DOUBT: f64 = 0.6;
const IN_DOUBT: f64 = 4.0;

/// Standard deviations of the disturbance by which noise beyond the usual widens the limits `[-]`.
const NOISE_DEVIATIONS: f64 = 4.0;

impl Observer {
    pub(super) fn new(params: ObserverParams) -> Self {
        let settling_s = SETTLED / params.pole_1_s;
        Self {
            params,
            block_c: 0.0,
            sensor_c: 0.0,
            disturbance_w: 0.0,
            usual_w: 0.0,
            balance_w: 0.0,
            warming_w: 0.0,
            ordered_w: [0.0; 3],
            settling_s,
            over: 0,
            under: 0,
            needed: params.samples,
            limits_w: (params.stuck_on_w, params.deficit_w),
        }
    }

    pub(super) fn start(&mut self, begun: Begun) {
        *self = Self { block_c: begun.block_c, sensor_c: begun.sensor_c, ..Self::new(self.params) };
    }

    /// Follows the block for `dt_s` to a reading `[degC]`, or past one that is left out.
    pub(super) fn step(&mut self, heater: &HeaterParams, inputs: Means, measured_c: Option<f64>, dt_s: f64) {
        let balance_w = heater.balance_w(inputs, self.block_c);
        let capacity = heater.capacity_j_k;
        self.sensor_c += (self.block_c - self.sensor_c) * (1.0 - (-dt_s / heater.sensor_lag_s).exp());
        self.block_c += (balance_w + self.disturbance_w) * dt_s / capacity;
        // Triple pole at -w of the error: gains 3w - 1/tau, 3w^2 tau, w^3 C tau.
        let pole = self.params.pole_1_s;
        // No fault of a heater moves a reading faster: what is further off is noise that came several times in a row.
        let residual_k = measured_c
            .map_or(0.0, |measured_c| (measured_c - self.sensor_c).clamp(-heater.spike_k, heater.spike_k));
        self.sensor_c += (3.0 * pole - 1.0 / heater.sensor_lag_s) * residual_k * dt_s;
        self.block_c += 3.0 * pole.powi(2) * heater.sensor_lag_s * residual_k * dt_s;
        self.disturbance_w += pole.powi(3) * capacity * heater.sensor_lag_s * residual_k * dt_s;

        // What may be a weak heater is learnt so slowly that it stays one.
        let doubt = self.excess_w().abs() > DOUBT * self.params.deficit_min_w;
        let adapt = dt_s / (heater.usual_time_s * if doubt { IN_DOUBT } else { 1.0 });
        self.usual_w = (self.usual_w + (self.disturbance_w - self.usual_w) * adapt)
            .clamp(-heater.usual_max_w, heater.usual_max_w);

        // The disturbance is known through three lags; so is the order, or a firmware that chops it would hide it.
        let kept = (-pole * dt_s).exp();
        let mut passed_w = heater.power_w * inputs.duty;
        for lagged_w in &mut self.ordered_w {
            *lagged_w = passed_w + (*lagged_w - passed_w) * kept;
            passed_w = *lagged_w;
        }
        let smooth = |was_w: f64, is_w: f64| is_w + (was_w - is_w) * kept;
        self.balance_w = smooth(self.balance_w, balance_w);
        self.warming_w = smooth(self.warming_w, balance_w + self.disturbance_w);
        self.settling_s -= dt_s;
    }

    /// Counts a reading with so much noise.
    pub(super) fn judge(&mut self, heater: &HeaterParams, noise: Noise) {
        if self.settling_s > 0.0 {
            return;
        }
        // Slower readings agree for as long, and are as many as tell them from noise.
        let as_long = (f64::from(self.params.samples) * COUNTED_PERIOD_S / noise.period_s).ceil();
        let fewer = self.params.samples.min(SLOW_SAMPLES);
        self.needed =
            (fewer..=self.params.samples).find(|n| f64::from(*n) >= as_long).unwrap_or(self.params.samples);
        let warming_slack_w = heater.capacity_error * agreement(self.balance_w, self.warming_w);
        // An order that is seen `e` later or sooner than it should be is power that is off by `e` times its change, as seen:
        // too much while it rises, too little while it falls.
        let change_w_s = self.params.pole_1_s * (self.ordered_w[1] - self.ordered_w[2]);
        self.count(warming_slack_w + self.noise_slack_w(heater, noise), heater.lag_error_s * change_w_s);
    }

    /// By how much noise beyond the usual widens the limits `[W]`.
    fn noise_slack_w(&self, heater: &HeaterParams, noise: Noise) -> f64 {
        let (pole, lag_s) = (self.params.pole_1_s, heater.sensor_lag_s);
        let shape = (noise.period_s * pole.powi(5) * (3.0 + (pole * lag_s).powi(-2)) / 16.0).sqrt();
        let of_reading_w = |noise_k: f64| heater.capacity_j_k * lag_s * shape * noise_k;
        let usual_w = of_reading_w(heater.usual_noise_k);
        let of_order_w = heater.power_w * (3.0 * pole * noise.duty2_s / 16.0).sqrt();
        let whole_w = of_reading_w(noise.reading_k.max(heater.usual_noise_k)).hypot(of_order_w);
        NOISE_DEVIATIONS * (whole_w - usual_w)
    }

    /// Counts the samples in a row that are beyond a limit; both are wider by `slack_w`, one of them by what an error of the lag
    /// makes of an order that changes.
    fn count(&mut self, slack_w: f64, of_lag_w: f64) {
        let excess_w = self.excess_w();
        let over_w = self.params.stuck_on_w + slack_w + of_lag_w.max(0.0);
        self.over = if excess_w > over_w { self.over.saturating_add(1) } else { 0 };
        // No more can be missing than was ordered: an observer that starts while the block cools, its reading ahead of
        // it by the lag, sees a deficit of a heater that is off.
        let ordered_w = self.ordered_w[2];
        let missing_w = (-excess_w).min(ordered_w);
        let share_w = (self.params.deficit_share * ordered_w).max(self.params.deficit_min_w);
        let short_w = self.params.deficit_w.min(share_w) + slack_w + (-of_lag_w).max(0.0);
        self.limits_w = (over_w, short_w);
        self.under = if missing_w > short_w { self.under.saturating_add(1) } else { 0 };
    }

    pub(super) fn excess_w(&self) -> f64 {
        self.disturbance_w - self.usual_w
    }

    /// Limit of the excess `[W]` that the fault in force is beyond, below zero for what is missing.
    pub(super) fn limit_w(&self) -> Option<f64> {
        let (over_w, short_w) = self.limits_w;
        self.fault().map(|fault| if fault == HeaterFault::StuckOn { over_w } else { -short_w })
    }

    pub(super) fn fault(&self) -> Option<HeaterFault> {
        if self.over >= self.needed {
            Some(HeaterFault::StuckOn)
        } else if self.under >= self.needed {
            Some(HeaterFault::Deficit)
        } else {
            None
        }
    }
}

impl HeaterParams {
    /// Ordered power less losses at this temperature `[W]`.
    pub(super) fn balance_w(&self, inputs: Means, temp_c: f64) -> f64 {
        let loss_w_k =
            self.loss_w_k + self.fan_loss_w_k * inputs.fan + self.feed_heat_j_k_m * inputs.feed_m_s;
        self.power_w * inputs.duty - loss_w_k * (temp_c - self.ambient_c)
    }
}

/// Size of what two powers have in common; zero where they differ in sign.
fn agreement(ordered_w: f64, measured_w: f64) -> f64 {
    if ordered_w * measured_w > 0.0 { ordered_w.abs().min(measured_w.abs()) } else { 0.0 }
}
