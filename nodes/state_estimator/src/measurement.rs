//! From raw samples to measurements: what they say, how well, and when they say nothing (model book 1.5).

use crate::estimator::{Frame, Inbox};
use crate::history::{Ring, Sample};
use crate::intervals::Interval;
use crate::melt_lag::STEP;
use crate::params::{Params, RawEncoder};
use crate::printer_model::{Drive, PrinterModel, Road, State, state};
use crate::ukf::Measurement;
use models::units::Kelvin;
use nalgebra::{Matrix1, Vector1};

/// Way back that is a stroke, no tremor of the wheel `[quanta]`.
const STROKE_QUANTA: f64 = 2.5;

/// Spread of a path speed that close reports do not show `[-]`.
const HIDDEN_SPREAD: f64 = 0.25;

/// A measurement with what is needed to predict it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Observation {
    value: f64,
    variance: f64,
    /// Part of the variance that is of a transient.
    passing: f64,
    /// Of no road whose speed changes: it tells of sensor and melt.
    is_steady: bool,
    sensor: Sensor,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Sensor {
    /// A temperature among the states; what drives the printer since the newest status, and for how long until the reading.
    Temperature { of: usize, drive: Drive, ahead_s: f64 },
    /// Mean speeds over the encoder's interval of the motor's strokes forth and back, both 0 or more: only the former slip.
    Encoder { forth_m_s: f64, back_m_s: f64 },
    /// Road at exposure, how much the flow was above today's, and how it depended on the factor of its law.
    Width { road: Road, flow_change_m_s: f64, slope_m_s: f64 },
}

impl Observation {
    /// Mean speeds of the filament and of the motor's strokes forth and back `[m/s]`.
    pub(crate) fn encoder([value, forth_m_s, back_m_s]: [f64; 3], variance: f64) -> Self {
        Self {
            value,
            variance,
            passing: 0.0,
            is_steady: true,
            sensor: Sensor::Encoder { forth_m_s, back_m_s },
        }
    }

    pub(crate) fn measurement(&self, gate: f64) -> Measurement<1> {
        Measurement { value: Vector1::new(self.value), noise: Matrix1::new(self.variance), gate }
    }

    /// Whether less was measured than predicted.
    pub(crate) fn lacks(&self, predicted: f64) -> bool {
        self.value < predicted
    }

    /// The same with more variance.
    pub(crate) fn doubted(&self, excess: f64) -> Self {
        Self { variance: self.variance + excess, ..*self }
    }

    /// Variance that a passing transient adds; 0 without one.
    pub(crate) fn passing(&self) -> f64 {
        self.passing
    }

    /// Whether the noise of the sensor is the larger part of the variance.
    pub(crate) fn is_of_noise(&self) -> bool {
        self.is_steady && self.passing < 0.5 * self.variance
    }

    /// Predicted width `[m]`, and what the factor on the melt's lag does to it, relative `[-]`; `None` of another sensor.
    pub(crate) fn lagging(&self, model: &PrinterModel, x: &State) -> Option<(f64, f64)> {
        let Sensor::Width { road, flow_change_m_s, slope_m_s } = self.sensor else { return None };
        let flow_m_s = x[state::FLOW] + flow_change_m_s;
        let width_m = |flow_m_s: f64| model.width(flow_m_s, x[state::GAIN], road);
        let lever_m = (width_m(flow_m_s + STEP * slope_m_s) - width_m(flow_m_s)) / STEP;
        Some((width_m(flow_m_s), lever_m / width_m(flow_m_s)))
    }

    pub(crate) fn predicted(&self, model: &PrinterModel, x: &State) -> Vector1<f64> {
        Vector1::new(match self.sensor {
            Sensor::Temperature { of, drive, ahead_s } if ahead_s > 0.0 => model.step(x, &drive, ahead_s)[of],
            Sensor::Temperature { of, .. } => x[of],
            Sensor::Encoder { forth_m_s, back_m_s } => model.filament_speed(x, forth_m_s) - back_m_s,
            Sensor::Width { road, flow_change_m_s, .. } => {
                model.width(x[state::FLOW] + flow_change_m_s, x[state::GAIN], road)
            }
        })
    }
}

/// A reading against the belief at `at_s`, carried on to the reading's own time: a host may tell its state a few times a
/// second, and a hot end that heats up gains a kelvin in between.
pub(crate) fn temperature(
    (of, sigma_k): (usize, f64),
    reading: (f64, Kelvin),
    (at_s, drive): (f64, Drive),
) -> Observation {
    Observation {
        value: reading.1.0,
        variance: sigma_k * sigma_k,
        passing: 0.0,
        is_steady: true,
        sensor: Sensor::Temperature { of, drive, ahead_s: reading.0 - at_s },
    }
}

/// The interval from the last used position to the newest that a status covers.
///
/// Motor and encoder are compared over the same interval by their own stamps. The encoder tells the strokes back, which do
/// not slip and which the reports of a slow host hide: what the motor went forth is the rest. The used position moves on even
/// where the interval is not looked at, so that no later one reaches back into it.
pub(crate) fn encoder(params: &Params, reference_feed_m_s: f64, inbox: &mut Inbox) -> Option<Interval> {
    let encoder = &params.encoder;
    let covered_s = inbox.samples.newest()?.stamp_s;
    let end = inbox.positions.newest_until(covered_s)?;
    let Some(start) = inbox.position_used else {
        inbox.position_used = Some(end);
        return None;
    };
    let span_s = end.0 - start.0;
    if span_s < encoder.interval_min_s {
        return None;
    }
    let interval = interval(inbox, start, end);
    inbox.position_used = Some(end);
    let least_m = encoder.speed_min_rel * reference_feed_m_s * span_s;
    interval.filter(|interval| span_s <= encoder.interval_max_s && interval.forth_m >= least_m)
}

/// What happened between two counts; `None` where the motor's way is not known.
fn interval(inbox: &Inbox, start: (f64, f64), end: (f64, f64)) -> Option<Interval> {
    let (from, to) = (inbox.samples.motor_at(start.0)?, inbox.samples.motor_at(end.0)?);
    let speeds_m_s = inbox.samples.speed_range(start.0, end.0)?;
    let back_m = inbox.positions.way_back_m(start.0, end.0);
    Some(Interval {
        from_s: start.0,
        to_s: end.0,
        passed_m: end.1 - start.1,
        forth_m: to.motor_m - from.motor_m + back_m,
        back_m,
        off_m: (from.error_m, to.error_m),
        speeds_m_s,
    })
}

/// Whether the filament strokes in an interval, or has stroked back within `strokes_s` before it; a slow host's reports may
/// hide that, the encoder does not.
///
/// Pressure advance drives the motor forth and back by several times what it feeds. Only strokes forth slip, so a slip
/// that is known to a hundredth leaves a tenth of the flow open, and the encoder tells no slip there: it tells the flow.
pub(crate) fn is_stroking(encoder: &RawEncoder, inbox: &Inbox, (from_s, to_s): (f64, f64)) -> bool {
    let since_s = from_s - encoder.strokes_s;
    let shown = inbox.samples.speed_range(since_s, to_s).is_some_and(|(slowest_m_s, _)| slowest_m_s < 0.0);
    shown || inbox.positions.way_back_m(since_s, to_s) > STROKE_QUANTA * encoder.quantum_m
}

/// Mean speed of the filament past the encoder `[m/s]`; `None` where it is not known.
pub(crate) fn filament_between(inbox: &Inbox, (from_s, to_s): (f64, f64)) -> Option<f64> {
    Some((inbox.positions.value_at(to_s)? - inbox.positions.value_at(from_s)?) / (to_s - from_s))
}

/// What the filter remembers for a late frame, and asks of it.
pub(crate) struct Past<'a> {
    pub(crate) flows: &'a Ring<(f64, f64)>,
    /// How they depend on the factor of the melt's law `[m/s]`.
    pub(crate) slopes: &'a Ring<(f64, f64)>,
    pub(crate) flow_m_s: f64,
    pub(crate) at_s: f64,
    /// How far the flow was from what was pushed shortly before `[m/s]`.
    pub(crate) imbalances: &'a Ring<(f64, f64)>,
    /// Share of a width that it may be off by for each of that `[s/m]`.
    pub(crate) off_s_m: f64,
    /// How long before an exposure the path must be steady `[s]`.
    pub(crate) steady_s: f64,
    /// Spread of the path speed up to which a width is looked at even so `[-]`, and the share of it that such a width may be off by.
    pub(crate) unsteady: (f64, f64),
    /// Rest of a dip that passes by itself `[m]`.
    pub(crate) transient_m: f64,
}

/// Width at the time of exposure, with the difference of the flow then and now from the filter's own history; its
/// variance is `scale` times the stated one.
pub(crate) fn width(
    params: &Params,
    scale: f64,
    frame: &Frame,
    samples: &Ring<Sample>,
    past: &Past<'_>,
) -> Option<Observation> {
    let sensor = &params.width;
    let smear_s = sensor.smear_m / sensor.path_speed_min_m_s;
    let from_s = frame.exposed_s - past.steady_s.max(smear_s);
    let window_s = (from_s, frame.exposed_s);
    let (most, noise) = past.unsteady;
    let steady = samples.steady_road(window_s, sensor.path_speed_spread).map(|road| (road, None));
    let unsteady = || samples.unsteady_road(window_s, most).map(|(road, spread)| (road, Some(spread)));
    let ((path_speed_m_s, height_m), spread) = steady.or_else(unsteady)?;
    if path_speed_m_s < sensor.path_speed_min_m_s {
        return None;
    }
    let then_m_s =
        if frame.exposed_s >= past.at_s { past.flow_m_s } else { past.flows.value_at(frame.exposed_s)? };
    let known_s = frame.exposed_s.min(past.at_s);
    let slope_m_s = past.slopes.value_at(known_s).unwrap_or(0.0);
    let unsteady_m = spread.map_or(0.0, |spread| noise * (spread + HIDDEN_SPREAD) * frame.width_m);
    let unbalanced_m = past.off_s_m * past.imbalances.value_at(known_s)? * frame.width_m;
    let sigma_m = frame.sigma_m.max(sensor.sigma_min_m);
    let passing = (sensor.transient_doubt * past.transient_m).powi(2);
    Some(Observation {
        value: frame.width_m,
        variance: scale * (sigma_m * sigma_m + unbalanced_m * unbalanced_m)
            + unsteady_m * unsteady_m
            + passing,
        passing,
        is_steady: spread.is_none(),
        sensor: Sensor::Width {
            road: Road { path_speed_m_s, height_m },
            flow_change_m_s: then_m_s - past.flow_m_s,
            slope_m_s,
        },
    })
}
