//! The estimator: events in, an estimate per tick out.

use crate::channel::{CHANNELS, Channel, Record, Window};
use crate::filter::Filter;
use crate::history::{Ring, Sample};
use crate::input::{Ages, Event, Reason, Refusals, check_status, finite, within};
use crate::params::Params;
use crate::printer_model::{PrinterModel, Setting, State, state};
use models::command::EstimateHealth;
use models::extruder::Extruder;
use models::hotend::Hotend;
use models::material::Material;
use models::melt::Melt;
use models::status::PrinterStatus;
use models::units::{Celsius, Kelvin, Seconds};
use nalgebra::SMatrix;

/// Statuses kept: 3 s at 100 Hz.
const SAMPLES: usize = 320;
/// Encoder positions kept: 1 s at 200 Hz.
const POSITIONS: usize = 200;
/// Widths kept until the next tick.
const FRAMES: usize = 8;

/// What is known of the printer at `stamp`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Time of validity.
    pub stamp: Seconds,
    /// State, indexed by [`state`].
    pub x: State,
    /// Its covariance.
    pub p: SMatrix<f64, { state::COUNT }, { state::COUNT }>,
    /// Newest normalised innovation squared of each channel; `None` before the first.
    pub nis: [Option<f64>; CHANNELS],
    /// Mean of all of them.
    pub nis_mean: [Option<f64>; CHANNELS],
    /// Newest innovation `[K]`, `[m/s]`, `[m]`.
    pub innovations: [Option<f64>; CHANNELS],
    /// Innovations taken into account in the mean.
    pub measured: [u64; CHANNELS],
    /// Innovations rejected by the gate.
    pub gated: [u64; CHANNELS],
    /// Channels whose newest sample is recent.
    pub alive: [bool; CHANNELS],
    /// States that the living sensors tell of; the others stand at what the model says, or are frozen.
    pub observed: [bool; state::COUNT],
    /// Statistics of the last twenty innovations; `None` before twenty.
    pub window: [Option<Window>; CHANNELS],
    /// Slow mean of the slicer's feed `[m/s]`: the scale of the flow.
    pub reference_feed_m_s: f64,
    /// Steps of slip, gain or temperature taken as given.
    pub steps: u64,
    /// Times the filter went back to its prior.
    pub resets: u64,
    /// Variance of each channel's noise over the configured one, as adapted from its innovations.
    pub noise_scale: [f64; CHANNELS],
    /// What the estimator says of its own work.
    pub health: EstimateHealth,
    /// Samples not used.
    pub refusals: Refusals,
}

impl Estimate {
    /// States held at what is believed of them: a slip that no encoder shows.
    #[must_use]
    pub fn held(&self) -> [bool; state::COUNT] {
        std::array::from_fn(|index| index == state::SLIP && !self.alive[Channel::Encoder as usize])
    }
}

/// A width that waits for the next tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    pub(crate) exposed_s: f64,
    pub(crate) width_m: f64,
    pub(crate) sigma_m: f64,
}

/// What came in since the last tick, and what is kept to look back.
#[derive(Debug)]
pub(crate) struct Inbox {
    pub(crate) status: Option<PrinterStatus>,
    pub(crate) samples: Ring<Sample>,
    pub(crate) positions: Ring<(f64, f64)>,
    /// With its stamp `[s]`.
    pub(crate) temperature: Option<(f64, Kelvin)>,
    pub(crate) frames: Ring<Frame>,
}

/// Unscented filter over the printer's telemetry and sensors. Knows no clock and no middleware.
#[derive(Debug)]
pub struct Estimator {
    params: Params,
    filter: Filter,
    inbox: Inbox,
    records: [Record; CHANNELS],
    refusals: Refusals,
    now_s: Option<f64>,
}

impl Estimator {
    /// An estimator that has seen nothing, for a nominal printer and a material.
    #[must_use]
    pub fn new(params: Params, (hotend, extruder): (&Hotend, &Extruder), material: &Material) -> Self {
        let setting = Setting {
            ambient: Kelvin(params.ambient_k),
            filament_area_m2: extruder.filament_area_m2(),
            substep: Seconds(params.process.substep_s),
        };
        let model = PrinterModel::new(hotend, material, setting);
        Self {
            params,
            filter: Filter::new(params, model, (Melt::new(material, extruder), *extruder)),
            inbox: Inbox {
                status: None,
                samples: Ring::new(SAMPLES),
                positions: Ring::new(POSITIONS),
                temperature: None,
                frames: Ring::new(FRAMES),
            },
            // widths that never fit tell of another printer, not of a broken filter
            records: Channel::ALL.map(|channel| {
                let (trust, resets) = match channel {
                    Channel::Thermistor => (params.thermistor.trust, true),
                    Channel::Encoder => (params.encoder.trust, true),
                    Channel::Width => (params.width.trust, false),
                };
                Record::new(trust, params.health, resets)
            }),
            refusals: Refusals::default(),
            now_s: None,
        }
    }

    /// Samples refused so far; an estimate carries them too, but there may be none.
    #[must_use]
    pub fn refusals(&self) -> &Refusals {
        &self.refusals
    }

    /// Other noises of model and sensors from now on. What is known, and how well, stays.
    pub fn retune(&mut self, params: Params) {
        self.params = params;
        self.filter.retune(params);
    }

    /// Takes one event in; a tick yields an estimate once a status and a temperature are known.
    pub fn on_event(&mut self, event: Event) -> Option<Estimate> {
        match event {
            Event::Hotend { stamp, temp } => {
                let taken = self.take_temperature(stamp, temp);
                taken.unwrap_or_else(|reason| self.refusals.hotend.count(reason));
            }
            Event::Encoder { stamp, position_m } => {
                let taken = self.take_position(stamp, position_m);
                taken.unwrap_or_else(|reason| self.refusals.encoder.count(reason));
            }
            Event::Width { exposed, width_m, sigma_m } => {
                let taken = self.take_width(exposed, width_m, sigma_m);
                taken.unwrap_or_else(|reason| self.refusals.width.count(reason));
            }
            Event::Printer(status) => {
                let taken = self.take_status(&status);
                taken.unwrap_or_else(|reason| self.refusals.printer.count(reason));
            }
            Event::Tick { now } => return self.tick(now),
        }
        None
    }

    fn ages(&self, channel: Channel, limit_s: f64) -> Ages {
        let before_s = self.records[channel as usize].seen_s;
        Ages { now_s: self.now_s, lead_s: self.params.telemetry.lead_limit_s, limit_s, before_s }
    }

    fn take_temperature(&mut self, stamp: Seconds, temp: Celsius) -> Result<(), Reason> {
        let sensor = &self.params.thermistor;
        let temp_c = within(temp.0, (sensor.low_c, sensor.high_c))?;
        let stamp_s = self.ages(Channel::Thermistor, sensor.trust.age_limit_s).check(stamp)?;
        self.records[Channel::Thermistor as usize].seen_s = Some(stamp_s);
        self.inbox.temperature = Some((stamp_s, Celsius(temp_c).into()));
        Ok(())
    }

    fn take_position(&mut self, stamp: Seconds, position_m: f64) -> Result<(), Reason> {
        let position_m = finite(position_m)?;
        let stamp_s = self.ages(Channel::Encoder, self.params.encoder.trust.age_limit_s).check(stamp)?;
        let jump = self.inbox.positions.newest().is_some_and(|&(before_s, before_m)| {
            (position_m - before_m).abs()
                > self.params.telemetry.motor_speed_max_m_s * (stamp_s - before_s)
                    + self.params.encoder.quantum_m
        });
        self.records[Channel::Encoder as usize].seen_s = Some(stamp_s);
        if jump {
            self.inbox.positions.clear();
        }
        self.inbox.positions.push((stamp_s, position_m));
        if jump { Err(Reason::OutOfRange) } else { Ok(()) }
    }

    fn take_width(&mut self, exposed: Seconds, width_m: f64, sigma_m: f64) -> Result<(), Reason> {
        let sensor = &self.params.width;
        let width_m = within(width_m, (0.0, sensor.width_max_m))?;
        let sigma_m = within(sigma_m, (0.0, sensor.width_max_m))?;
        let exposed_s = self.ages(Channel::Width, sensor.trust.age_limit_s).check(exposed)?;
        self.records[Channel::Width as usize].seen_s = Some(exposed_s);
        self.inbox.frames.push(Frame { exposed_s, width_m, sigma_m });
        Ok(())
    }

    fn take_status(&mut self, status: &PrinterStatus) -> Result<(), Reason> {
        check_status(status)?;
        let newest = self.inbox.samples.newest().copied();
        let ages = Ages {
            now_s: self.now_s,
            lead_s: self.params.telemetry.lead_limit_s,
            limit_s: self.params.telemetry.age_limit_s,
            before_s: newest.map(|sample| sample.stamp_s),
        };
        let stamp_s = ages.check(status.stamp)?;
        let jump = newest.is_some_and(|before| {
            (status.motor_position_m - before.motor_m).abs()
                > self.params.telemetry.motor_speed_max_m_s * (stamp_s - before.stamp_s)
        });
        if jump {
            self.inbox.samples.clear();
        }
        self.inbox.samples.push(Sample {
            stamp_s,
            motor_m: status.motor_position_m,
            path_speed_m_s: status.path_speed_m_s,
            height_m: status.layer_height_m,
            depositing: status.depositing,
        });
        self.inbox.status = Some(*status);
        if jump { Err(Reason::OutOfRange) } else { Ok(()) }
    }

    fn tick(&mut self, now: Seconds) -> Option<Estimate> {
        let Ok(now_s) = finite(now.0) else {
            self.refusals.tick.count(Reason::NotFinite);
            return None;
        };
        if self.now_s.is_some_and(|before_s| now_s <= before_s) {
            self.refusals.tick.count(Reason::Disordered);
            return None;
        }
        self.now_s = Some(now_s);
        let status = self.inbox.status?;
        if now_s - status.stamp.0 > self.params.telemetry.age_limit_s {
            return None;
        }
        self.filter.cycle(now_s, &status, &mut self.inbox, &mut self.records)?;
        self.estimate(now_s, &status)
    }

    fn estimate(&self, now_s: f64, status: &PrinterStatus) -> Option<Estimate> {
        let belief = self.filter.outlook(now_s, status)?;
        let records = &self.records;
        Some(Estimate {
            stamp: Seconds(now_s),
            x: belief.mean,
            p: belief.covariance,
            nis: Channel::ALL.map(|channel| records[channel as usize].nis),
            nis_mean: Channel::ALL.map(|channel| records[channel as usize].nis_mean()),
            innovations: Channel::ALL.map(|channel| records[channel as usize].innovation),
            measured: Channel::ALL.map(|channel| records[channel as usize].count),
            gated: Channel::ALL.map(|channel| records[channel as usize].gated),
            alive: Channel::ALL.map(|channel| records[channel as usize].alive(now_s)),
            observed: observed(Channel::ALL.map(|channel| records[channel as usize].alive(now_s))),
            window: Channel::ALL.map(|channel| records[channel as usize].window()),
            reference_feed_m_s: self.filter.reference_feed_m_s(),
            steps: self.filter.steps(),
            resets: self.filter.resets(),
            noise_scale: self.filter.noise_scale(),
            health: self.filter.health(now_s),
            refusals: self.refusals,
        })
    }
}

/// What a set of living channels tells of (model book 1.5): the nozzle only through the model of the joint, flow and slip
/// through the encoder, the gain through widths. Without the encoder widths tell of flow and gain as one product.
fn observed([thermistor, encoder, width]: [bool; CHANNELS]) -> [bool; state::COUNT] {
    let mut observed = [false; state::COUNT];
    observed[state::BLOCK] = thermistor;
    observed[state::SENSOR] = thermistor;
    observed[state::FLOW] = encoder;
    observed[state::SLIP] = encoder;
    observed[state::GAIN] = width;
    observed
}

#[cfg(test)]
mod tests;
