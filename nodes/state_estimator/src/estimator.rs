//! The estimator: events in, an estimate per tick out.

use crate::channel::{CHANNELS, Channel, Record, Window, widths_tell_slip};
use crate::filter::Filter;
use crate::history::{Ring, Sample};
use crate::input::{Event, Reason, Refusals, finite};
use crate::params::Params;
use crate::printer_model::{PrinterModel, Setting, State, state};
use models::command::EstimateHealth;
use models::extruder::Extruder;
use models::hotend::Hotend;
use models::material::Material;
use models::melt::Melt;
use models::status::PrinterStatus;
use models::units::{Kelvin, Seconds};
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
    /// Length that is held compressed over what the material file says, as learnt from widths.
    pub melt_lag: f64,
    /// What the estimator says of its own work.
    pub health: EstimateHealth,
    /// Samples not used.
    pub refusals: Refusals,
}

impl Estimate {
    /// States held at what is believed of them: a slip that neither an encoder nor widths show.
    #[must_use]
    pub fn held(&self) -> [bool; state::COUNT] {
        let told = self.alive[Channel::Encoder as usize] || widths_tell_slip(self.alive);
        std::array::from_fn(|index| index == state::SLIP && !told)
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
    /// Position up to which the encoder's speeds have been looked at; none of another count.
    pub(crate) position_used: Option<(f64, f64)>,
    /// With its stamp `[s]`.
    pub(crate) temperature: Option<(f64, Kelvin)>,
    /// With its stamp `[s]`.
    pub(crate) nozzle: Option<(f64, Kelvin)>,
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
                position_used: None,
                temperature: None,
                nozzle: None,
                frames: Ring::new(FRAMES),
            },
            // widths, or a nozzle's sensor, that never fit tell of another printer, not of a broken filter
            records: Channel::ALL.map(|channel| {
                let resets = matches!(channel, Channel::Thermistor | Channel::Encoder);
                Record::new(params.trust(channel), params.health, resets)
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

    /// Other noises of model and sensors, gates, ages and windows from now on. What is known, and how well, stays, and so does
    /// what was seen. Form, spread and prior count where the filter starts next; room and substep stay the model's own.
    pub fn retune(&mut self, params: Params) {
        self.params = params;
        self.filter.retune(params);
        for (record, channel) in self.records.iter_mut().zip(Channel::ALL) {
            record.retune(params.trust(channel), params.health);
        }
    }

    /// Takes one event in; a tick yields an estimate once a status and a temperature are known.
    pub fn on_event(&mut self, event: Event) -> Option<Estimate> {
        match event {
            Event::Hotend { stamp, temp } => {
                let taken = self.take_temperature(Channel::Thermistor, stamp, temp);
                match taken {
                    Ok(reading) => self.inbox.temperature = Some(reading),
                    Err(reason) => self.refusals.hotend.count(reason),
                }
            }
            Event::Nozzle { stamp, temp } => {
                let taken = self.take_temperature(Channel::Nozzle, stamp, temp);
                match taken {
                    Ok(reading) => self.inbox.nozzle = Some(reading),
                    Err(reason) => self.refusals.nozzle.count(reason),
                }
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
            observed: observed(Channel::ALL.map(|channel| records[channel as usize].tells(now_s))),
            window: Channel::ALL.map(|channel| records[channel as usize].window()),
            reference_feed_m_s: self.filter.reference_feed_m_s(),
            steps: self.filter.steps(),
            resets: self.filter.resets(),
            noise_scale: self.filter.noise_scale(),
            melt_lag: self.filter.melt_lag(),
            health: self.filter.health(now_s),
            refusals: self.refusals,
        })
    }
}

/// What a set of channels tells of (model book 1.5): the nozzle by its own sensor, else only through the model of the
/// joint, flow and slip through the encoder, the gain through widths. Without the encoder widths tell of all three: of flow and
/// gain as one product, of the slip by what strokes of pressure advance lose, or as what changes faster than a spool.
fn observed([thermistor, encoder, width, nozzle]: [bool; CHANNELS]) -> [bool; state::COUNT] {
    let mut observed = [false; state::COUNT];
    observed[state::BLOCK] = thermistor;
    observed[state::NOZZLE] = nozzle;
    observed[state::SENSOR] = thermistor;
    observed[state::FLOW] = encoder || width;
    observed[state::SLIP] = encoder || width;
    observed[state::GAIN] = width;
    observed
}

mod taking;

#[cfg(test)]
mod tests;
