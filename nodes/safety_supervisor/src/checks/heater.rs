//! P1, P2: the heater gives more or less power than it is told to.
//!
//! An own energy balance, `C dT/dt = P u - (h + h_fan fan + c_feed v_feed)(T - T_amb) + d`, read through the
//! thermistor's lag, `tau dT_s/dt = T - T_s`. An observer with a triple pole at `-w` follows the disturbance `d`
//! `[W]`, and a slow average of it, bounded, stands for ambient and errors of the constants. What goes beyond is
//! power that nobody ordered, or ordered power that never came. Two observers run: the fast one sees a dead heater
//! and a shorted switch in time, the slow one, less noisy, a weak heater.
//!
//! The balance of a heater that is being warmed up carries the error of its capacity; the bound is wider by a
//! share of the power that goes into warming, as far as order and measurement agree on its sign. A reading that is
//! rougher than usual makes the balance rougher, and the bound is wider by that.

use models::units::{Celsius, Seconds};

use super::drift::Balance;
use super::drive_history::DriveHistory;
use super::heater_observer::{Noise, Observer};
use super::heater_start::Start;
use super::moved::Moved;
use super::pace::Period;
use super::roughness::Roughness;
use crate::params::HeaterParams;

/// Longest step of the balance: after a longer gap the observer starts anew `[s]`. S7 pauses then.
const GAP_MAX_S: f64 = 1.5;
/// Of slow readings one may be lost `[periods]`.
const GAP_PERIODS: f64 = 2.3;
/// Step of the observers between readings that are farther apart `[s]`: with whole seconds they would swing.
const STEP_S: f64 = 0.1;
/// So many samples in a row far from the last one are a gap, or time that was set.
const ASTRAY_SAMPLES: u32 = 3;

/// How far off a reading counts for the scatter at most `[K]`.
const SCATTER_MAX_K: f64 = 2.5;
/// Standard deviations of the scatter from which a reading is a spike `[-]`.
const SPIKE_DEVIATIONS: f64 = 4.0;

/// What drives the heater's temperature, as the printer reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// Heater duty `[0, 1]`; zero while the mains relay is open.
    pub duty: f64,
    /// Part fan `[0, 1]`.
    pub fan: f64,
    /// Filament pushed since start `[m]`.
    pub motor_position_m: f64,
    /// Share of it that the drive gear has lost of late `[0, 1]`, when it pushed: it takes no heat.
    pub slip: f64,
}

/// Which way the balance is broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeaterFault {
    /// P1: power without order.
    StuckOn,
    /// P2: order without power.
    Deficit,
}

/// So many samples in a row far off: it is the balance that is off, not they. As many as it takes to begin.
const LOST_SAMPLES: u32 = 10;

/// Samples that wait for the printer's state of their moment: 1.2 s at 10 Hz.
const WAITING: usize = 12;

/// Watches one heater.
#[derive(Debug, Clone)]
pub struct HeaterCheck {
    params: HeaterParams,
    fast: Observer,
    slow: Observer,
    history: DriveHistory,
    waiting: [Option<(Seconds, Celsius)>; WAITING],
    last_sample: Option<Seconds>,
    period: Period,
    /// Samples in a row that are of no time near the last one.
    astray: u32,
    /// Samples before the balance begins; `None` while it runs.
    start: Option<Start>,
    skipped: u32,
    /// Samples since the last spike.
    quiet: u32,
    /// Of the readings that are followed.
    roughness: Roughness,
    /// Of all readings, each taken for `SCATTER_MAX_K` off at most: from it a spike tells itself apart.
    scatter: Roughness,
    /// The last reading, where it was not left out.
    measured_c: Option<f64>,
    reading_c: f64,
    moved: Moved,
}

impl HeaterCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: HeaterParams) -> Self {
        Self {
            params,
            fast: Observer::new(params.fast),
            slow: Observer::new(params.slow),
            history: DriveHistory::default(),
            waiting: [None; WAITING],
            last_sample: None,
            period: Period::USUAL,
            astray: 0,
            start: Some(Start::default()),
            skipped: 0,
            quiet: 0,
            roughness: Roughness::new(params.usual_noise_k),
            scatter: Roughness::new(params.usual_noise_k),
            measured_c: None,
            reading_c: f64::NAN,
            moved: Moved::default(),
        }
    }

    /// Takes what the printer says it does since `stamp`, and judges the samples that it covers.
    pub fn on_drive(&mut self, stamp: Seconds, drive: Drive) {
        self.history.push(stamp, drive);
        while let Some((sampled, temp)) = self.waiting[0].filter(|(sampled, _)| *sampled <= stamp) {
            self.waiting.rotate_left(1);
            self.waiting[WAITING - 1] = None;
            self.judge(sampled, temp);
        }
    }

    /// Takes a temperature of `stamp`, on the clock of the printer's reports; nothing is judged before the first of
    /// those. It waits for the state of its moment, unless too many wait already.
    pub fn on_sample(&mut self, stamp: Seconds, temp: Celsius) {
        let Some((known, _)) = self.history.newest() else { return };
        if known >= stamp && self.waiting[0].is_none() {
            return self.judge(stamp, temp);
        }
        if let Some((sampled, oldest)) = self.waiting[0].filter(|_| self.waiting[WAITING - 1].is_some()) {
            self.waiting.rotate_left(1);
            self.waiting[WAITING - 1] = None;
            self.judge(sampled, oldest);
        }
        if let Some(free) = self.waiting.iter_mut().find(|place| place.is_none()) {
            *free = Some((stamp, temp));
        }
    }

    /// One step of the balance. A second sample of the same moment says nothing new.
    fn judge(&mut self, now: Seconds, temp: Celsius) {
        let gap_max_s = self.period.gap_s(GAP_MAX_S, GAP_PERIODS);
        if self.last_sample.is_some_and(|last| (-gap_max_s..=0.0).contains(&(now.0 - last.0))) {
            return;
        }
        let near = self.last_sample.is_none_or(|last| (now - last).0.abs() <= gap_max_s);
        self.astray = if near { 0 } else { self.astray.saturating_add(1) };
        if (1..ASTRAY_SAMPLES).contains(&self.astray) {
            // A single stamp that is wrong is no gap, and no reason to begin anew.
            return;
        }
        let last = self.last_sample.replace(now);
        let means = last.and_then(|last| self.history.means(last, now));
        let (Some(last), Some(inputs)) = (last, means) else {
            return self.begin_anew(now, temp);
        };
        let dt_s = (now - last).0;
        if dt_s > gap_max_s {
            return self.begin_anew(now, temp);
        }
        self.period.on_span(dt_s);
        if let Some(start) = &mut self.start {
            if let Some(begun) = start.on_sample(now, temp, self.params.sensor_lag_s) {
                self.start = None;
                self.fast.start(begun);
                self.slow.start(begun);
            }
            return;
        }
        let off_k = (temp.0 - self.fast.sensor_c).clamp(-SCATTER_MAX_K, SCATTER_MAX_K);
        self.scatter.on_sample(now, Some(self.fast.sensor_c + off_k));
        // A single spike is no heat; a jump that stays is taken for what it is.
        let spike = (temp.0 - self.fast.sensor_c).abs() > self.spike_k(dt_s);
        self.skipped = if spike { self.skipped + 1 } else { 0 };
        self.quiet = if spike { 0 } else { self.quiet.saturating_add(1) };
        if self.skipped > LOST_SAMPLES {
            return self.begin_anew(now, temp);
        }
        let measured = (self.skipped == 0 || self.skipped > self.params.spike_samples).then_some(temp.0);
        self.roughness.on_sample(now, measured);
        self.follow(last, now, measured);
        if std::mem::replace(&mut self.reading_c, temp.0).to_bits() != temp.0.to_bits() {
            return self.moved.begin(self.slow.block_c - self.slow.sensor_c);
        }
        let rate_k_s = (self.params.balance_w(inputs, temp.0) + self.slow.usual_w) / self.params.capacity_j_k;
        self.moved.step(rate_k_s, dt_s, self.params.sensor_lag_s);
    }

    /// How far a reading is off that is a spike `[K]`: over a longer span a heater that is at fault moves it.
    fn spike_k(&self, span_s: f64) -> f64 {
        let rate_k_s = self.params.power_w / self.params.capacity_j_k;
        let beyond_noise_k = SPIKE_DEVIATIONS * self.scatter.deviation();
        self.params.spike_k.max(beyond_noise_k) + rate_k_s * (span_s - STEP_S).max(0.0)
    }

    /// Steps the observers to the reading of `now`, or past one that is left out.
    fn follow(&mut self, last: Seconds, now: Seconds, measured_c: Option<f64>) {
        let (span_s, before_c) = ((now - last).0, std::mem::replace(&mut self.measured_c, measured_c));
        let pieces = (span_s / STEP_S).round().max(1.0);
        // What is farther off than a spike counts as far.
        let noise_k = self.roughness.deviation().max(self.scatter.deviation()).min(self.params.spike_k);
        let noise = Noise { reading_k: noise_k, period_s: span_s, duty2_s: self.history.unseen_duty2_s() };
        let mut share = 0.0;
        while share < 1.0 {
            let from = Seconds(last.0 + share * span_s);
            share = (share + 1.0 / pieces).min(1.0);
            let to = Seconds(last.0 + share * span_s);
            // Between two readings it went from one to the other.
            let at_c = measured_c.and_then(|end_c| match before_c {
                Some(start_c) => Some(start_c + share * (end_c - start_c)),
                None => (share >= 1.0).then_some(end_c),
            });
            let Some(inputs) = self.history.means(from, to) else { continue };
            for observer in [&mut self.fast, &mut self.slow] {
                observer.step(&self.params, inputs, at_c, (to - from).0);
            }
        }
        for observer in [&mut self.fast, &mut self.slow] {
            observer.judge(&self.params, noise);
        }
    }

    /// Whether a fault would show: the balance runs, and an error of its beginning has died away.
    #[must_use]
    pub fn is_judging(&self) -> bool {
        self.start.is_none() && self.fast.settling_s <= 0.0
    }

    /// The fault in force. Of a `noisy` reading the fast observer means nothing, and the slow one as much as its own
    /// limit for heat without order: what is missing has to be as large.
    #[must_use]
    pub fn fault(&self, noisy: bool) -> Option<HeaterFault> {
        if noisy {
            let large = self.slow.excess_w().abs() > self.params.slow.stuck_on_w;
            return self.slow.fault().filter(|_| large);
        }
        let fast = self.fast.fault().filter(|_| self.quiet > self.params.spike_samples);
        fast.or_else(|| self.slow.fault())
    }

    /// What the slow observer says, once an error of its beginning has died away.
    #[must_use]
    pub fn balance(&self) -> Option<Balance> {
        let settled = self.start.is_none() && self.slow.settling_s <= 0.0;
        settled.then_some(Balance {
            disturbance_w: self.slow.disturbance_w,
            warming_w: self.slow.warming_w,
            unseen_w2_s: self.params.power_w.powi(2) * self.history.unseen_duty2_s(),
        })
    }

    /// Temperature of the block as the slow observer sees it.
    #[must_use]
    pub fn block(&self) -> Celsius {
        Celsius(self.slow.block_c)
    }

    /// How far the balance says the reading must have moved since it last changed `[K]`.
    #[must_use]
    pub fn moved_k(&self) -> f64 {
        self.moved.reading_k()
    }

    /// Excess power over the order `[W]` as the fast observer sees it: for diagnostics.
    #[must_use]
    pub fn excess_w(&self) -> f64 {
        self.fast.excess_w()
    }

    /// Excess power `[W]` beside its limit as of the observer that tells a fault; the fast one's without a limit where
    /// none does.
    #[must_use]
    pub fn beyond_w(&self) -> (f64, Option<f64>) {
        let told = [&self.fast, &self.slow].into_iter().find(|observer| observer.fault().is_some());
        told.map_or((self.excess_w(), None), |observer| (observer.excess_w(), observer.limit_w()))
    }

    /// Forgets everything: after an acknowledge.
    pub fn reset(&mut self) {
        *self = Self::new(self.params);
    }

    fn begin_anew(&mut self, now: Seconds, temp: Celsius) {
        let mut start = Start::default();
        // The first of several samples never begins a balance.
        _ = start.on_sample(now, temp, self.params.sensor_lag_s);
        self.start = Some(start);
        self.measured_c = None;
        self.skipped = 0;
        self.roughness = Roughness::new(self.params.usual_noise_k);
        (self.fast, self.slow) = (Observer::new(self.params.fast), Observer::new(self.params.slow));
    }
}
