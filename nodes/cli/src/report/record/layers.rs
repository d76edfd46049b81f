//! Layers and their roads: what was asked for, what was estimated there, what quality came of it.

use super::super::series::Series;
use super::signals::Flow;
use fdm_loop_msgs::{LayerQuality, MotionSegment, PrinterState};
use models::bead::stadium;
use std::collections::{BTreeMap, VecDeque};

/// Roads that are kept: some tens of hours of printing.
const ROADS_MAX: usize = 1_000_000;
/// Layers that are told apart.
const LAYERS_MAX: usize = 20_000;
/// States that are looked back at for an estimate.
const BACK: usize = 128;
/// An estimate belongs to a state no further away than this `[s]`.
const NEAR_S: f64 = 0.03;
/// A camera's measurement is of a place reached this long ago at most `[s]`.
const SEEN_S: f64 = 0.2;
/// Below this path speed a width from flow over speed says nothing `[m/s]`.
const SPEED_MIN_M_S: f64 = 5e-3;
/// Columns of the errors along the slicer's time: 0.1 s in 2 h.
const COLUMNS: usize = 65_536;
/// What no bed reaches `[m]`.
const BED_MAX_M: f64 = 10.0;

/// A road as planned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Road {
    pub(crate) layer: u32,
    pub(crate) role: u8,
    pub(crate) from_mm: [f32; 2],
    pub(crate) to_mm: [f32; 2],
    pub(crate) width_mm: f32,
    pub(crate) speed_mm_s: f32,
    /// Start and end along the slicer's time `[s]`.
    pub(crate) start_s: f64,
    pub(crate) end_s: f64,
}

/// What is known of a layer.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Layer {
    /// First and last deposit on the axis `[s]`.
    pub(crate) span_s: Option<(f64, f64)>,
    /// Sum of squares and number of relative width errors, estimated.
    error_sq: f64,
    errors: u64,
    pub(crate) quality: Option<LayerQuality>,
    /// Frames that were flagged in it.
    pub(crate) flagged: u64,
}

impl Layer {
    /// Root mean square of the estimated relative width error.
    pub(crate) fn width_rms(&self) -> Option<f64> {
        (self.errors > 0).then(|| (self.error_sq / self.errors as f64).sqrt())
    }
}

/// The printer at a moment.
#[derive(Debug, Clone, Copy)]
struct Moment {
    at: f64,
    path_s: f64,
    layer: u32,
    speed_m_s: f64,
    /// Width and height of the road that is laid.
    road: Option<(f64, f64)>,
}

/// All layers.
#[derive(Debug)]
pub(crate) struct Layers {
    pub(crate) layers: BTreeMap<u32, Layer>,
    pub(crate) roads: Vec<Road>,
    /// Roads that were not kept.
    pub(crate) beyond: u64,
    /// Moves whose numbers cannot be.
    pub(crate) refused: u64,
    /// Qualities whose numbers cannot be.
    pub(crate) qualities_refused: u64,
    moments: VecDeque<Moment>,
    /// Relative width error along the slicer's time `[-]`.
    pub(crate) error_rel: Series,
    /// Measured relative width errors: number, sum, sum of squares.
    pub(crate) measured_rel: (u64, f64, f64),
}

impl Default for Layers {
    fn default() -> Self {
        Self {
            layers: BTreeMap::new(),
            roads: Vec::new(),
            beyond: 0,
            refused: 0,
            qualities_refused: 0,
            moments: VecDeque::new(),
            error_rel: Series::with_columns(COLUMNS),
            measured_rel: (0, 0.0, 0.0),
        }
    }
}

impl Layers {
    fn layer(&mut self, number: u32) -> Option<&mut Layer> {
        let room = self.layers.len() < LAYERS_MAX;
        match self.layers.entry(number) {
            std::collections::btree_map::Entry::Occupied(known) => Some(known.into_mut()),
            std::collections::btree_map::Entry::Vacant(free) => room.then(|| free.insert(Layer::default())),
        }
    }

    /// Takes the state of the printer in.
    pub(crate) fn state(&mut self, at: f64, state: &PrinterState) {
        let known =
            state.depositing && state.layer_known && state.target_width_known && state.layer_height_known;
        let sane = state.target_width_m > 0.0 && state.layer_height_m > 0.0;
        let road = (known && sane).then_some((state.target_width_m, state.layer_height_m));
        let speed_m_s = state.path_speed_m_s;
        self.moments.push_back(Moment { at, path_s: state.path_time_s, layer: state.layer, speed_m_s, road });
        if self.moments.len() > BACK {
            self.moments.pop_front();
        }
        if known && let Some(layer) = self.layer(state.layer) {
            let (first, last) = layer.span_s.unwrap_or((at, at));
            layer.span_s = Some((first.min(at), last.max(at)));
        }
    }

    fn moment(&self, at: f64, near_s: f64) -> Option<Moment> {
        let distance = |moment: &&Moment| (moment.at - at).abs();
        let nearest = self.moments.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        ((nearest.at - at).abs() <= near_s).then_some(*nearest)
    }

    /// Width `[m]` by an estimate, where a road is laid: flow of melt over path speed, as a stadium.
    pub(crate) fn estimated(&mut self, at: f64, flow: Flow, filament_area_m2: f64) -> Option<f64> {
        let moment = self.moment(at, NEAR_S)?;
        let (target_m, height_m) = moment.road?;
        if moment.speed_m_s < SPEED_MIN_M_S {
            return None;
        }
        let flow_m3_s = flow.flow_m_s.max(0.0) * flow.gain * filament_area_m2;
        let width_m = stadium::width_m(flow_m3_s, moment.speed_m_s, height_m);
        let error = width_m / target_m - 1.0;
        if !error.is_finite() {
            return None;
        }
        self.error_rel.add(moment.path_s, error);
        if let Some(layer) = self.layer(moment.layer) {
            layer.error_sq += error * error;
            layer.errors += 1;
        }
        Some(width_m)
    }

    /// A measured width.
    pub(crate) fn measured(&mut self, at: f64, width_m: f64) {
        let road = self.moment(at, SEEN_S).and_then(|moment| moment.road);
        let Some(error) =
            road.map(|(target_m, _)| width_m / target_m - 1.0).filter(|error| error.is_finite())
        else {
            return;
        };
        let (count, sum, squares) = &mut self.measured_rel;
        *count += 1;
        *sum += error;
        *squares += error * error;
    }

    /// A flagged frame.
    pub(crate) fn flag(&mut self, at: f64) {
        let number = self.moment(at, SEEN_S * 10.0).map(|moment| moment.layer);
        if let Some(layer) = number.and_then(|number| self.layers.get_mut(&number)) {
            layer.flagged += 1;
        }
    }

    /// Takes the quality of a layer in: the newest counts.
    pub(crate) fn quality(&mut self, quality: &LayerQuality) {
        let terms = [
            quality.quality,
            quality.feature_term,
            quality.width_term,
            quality.temperature_term,
            quality.adhesion_term,
            quality.porosity_term,
        ];
        if terms.iter().any(|term| !term.is_finite() || *term < 0.0) {
            self.qualities_refused += 1;
            return;
        }
        if let Some(layer) = self.layer(quality.layer) {
            layer.quality = Some(quality.clone());
        }
    }

    /// Takes a move in.
    pub(crate) fn motion(&mut self, segment: &MotionSegment) {
        if segment.kind != MotionSegment::KIND_DEPOSIT || !segment.layer_known || !segment.target_width_known
        {
            return;
        }
        let place = |m: f64| (m.is_finite() && m.abs() < BED_MAX_M).then_some(m);
        let numbers = (|| {
            let [x0, y0] = [place(segment.start_m[0])?, place(segment.start_m[1])?];
            let [x1, y1] = [place(segment.end_m[0])?, place(segment.end_m[1])?];
            let duration_s = segment.accelerate_s + segment.cruise_s + segment.decelerate_s;
            let sane = segment.target_width_m > 0.0
                && segment.target_width_m < 0.1
                && segment.cruise_speed_m_s.is_finite()
                && segment.start_time_s.is_finite()
                && (0.0..1e6).contains(&duration_s);
            sane.then_some(([x0, y0], [x1, y1], duration_s))
        })();
        let Some((from_m, to_m, duration_s)) = numbers else {
            self.refused += 1;
            return;
        };
        if self.roads.len() >= ROADS_MAX {
            self.beyond += 1;
            return;
        }
        #[allow(clippy::cast_possible_truncation)] // a picture needs no more
        let mm = |m: f64| (m * 1e3) as f32;
        self.roads.push(Road {
            layer: segment.layer,
            role: segment.role,
            from_mm: from_m.map(mm),
            to_mm: to_m.map(mm),
            width_mm: mm(segment.target_width_m),
            speed_mm_s: mm(segment.cruise_speed_m_s),
            start_s: segment.start_time_s,
            end_s: segment.start_time_s + duration_s,
        });
    }
}
