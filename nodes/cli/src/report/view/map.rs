//! Layers seen from above: each road as wide as it was asked for, coloured by what is known of it.

use crate::report::record::layers::{Layers, Road};
use fdm_loop_msgs::MotionSegment;
use std::fmt::Write;

/// Pieces of one layer that are drawn.
const PIECES_MAX: usize = 6000;
/// A long road is coloured in pieces of this length `[mm]`.
const PIECE_MM: f32 = 2.0;
/// A piece shorter than an estimate's period takes the nearest one within this time `[s]`.
const NEAR_S: f64 = 0.06;
/// Upper ends of the classes of the relative width error; the last class has none.
pub(crate) const ERRORS: [f64; 6] = [-0.15, -0.07, -0.03, 0.03, 0.07, 0.15];
/// Classes of the speed where no error is known.
const SPEEDS: usize = 7;

/// How the roads are coloured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Colouring {
    /// By the estimated width.
    Error,
    /// By the planned speed, up to this one `[mm/s]`.
    Speed(f32),
}

/// A layer as SVG.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Map {
    pub(crate) drawing: String,
    pub(crate) colouring: Colouring,
    pub(crate) roads: usize,
    /// Roads that were not drawn.
    pub(crate) left_out: usize,
    /// Width and height of what is shown `[mm]`.
    pub(crate) size_mm: [f32; 2],
}

/// Draws a layer; `None` where no road of it is known.
pub(crate) fn draw(layers: &Layers, number: u32) -> Option<Map> {
    let mut roads: Vec<&Road> =
        layers.roads.iter().filter(|road| road.layer == number && is_object(road.role)).collect();
    if roads.is_empty() {
        roads = layers.roads.iter().filter(|road| road.layer == number).collect();
    }
    let error = |road: &Road, share: (f32, f32)| {
        let length_s = road.end_s - road.start_s;
        let at = |share: f32| road.start_s + length_s * f64::from(share);
        let (from, to) = (at(share.0), at(share.1));
        let near = || layers.error_rel.mean_between((from - NEAR_S).max(0.0), to + NEAR_S);
        layers.error_rel.mean_between(from, to).or_else(near)
    };
    let fastest = roads.iter().map(|road| road.speed_mm_s).fold(1.0_f32, f32::max);
    let known = roads.iter().filter(|road| error(road, (0.0, 1.0)).is_some()).count();
    let colouring = if known * 2 > roads.len() { Colouring::Error } else { Colouring::Speed(fastest) };
    let mut paths = Paths::default();
    let mut drawn = 0;
    for road in &roads {
        if paths.pieces >= PIECES_MAX {
            break;
        }
        drawn += 1;
        for share in pieces(road) {
            let class = match colouring {
                Colouring::Speed(fastest) => Some(speed_class(road.speed_mm_s, fastest)),
                Colouring::Error => error(road, share).map(error_class),
            };
            paths.add(road, share, class);
        }
    }
    let (low, high) = extent(&roads)?;
    let size_mm = [high[0] - low[0], high[1] - low[1]];
    Some(Map {
        drawing: paths.svg(low, size_mm, roads.first()?.width_mm),
        colouring,
        roads: drawn,
        left_out: roads.len() - drawn,
        size_mm,
    })
}

/// Parts of a road from 0 to 1.
fn pieces(road: &Road) -> impl Iterator<Item = (f32, f32)> + use<> {
    let [dx, dy] = [road.to_mm[0] - road.from_mm[0], road.to_mm[1] - road.from_mm[1]];
    let count = (dx.hypot(dy) / PIECE_MM).ceil().clamp(1.0, 100.0);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // in [1, 100]
    let count_whole = count as u16;
    (0..count_whole).map(move |part| (f32::from(part) / count, f32::from(part + 1) / count))
}

fn is_object(role: u8) -> bool {
    !matches!(role, MotionSegment::ROLE_CUSTOM | MotionSegment::ROLE_SKIRT | MotionSegment::ROLE_TOWER)
}

/// Class of a relative width error.
fn error_class(error: f64) -> usize {
    ERRORS.iter().position(|end| error < *end).unwrap_or(ERRORS.len())
}

fn speed_class(speed_mm_s: f32, fastest_mm_s: f32) -> usize {
    let share = (speed_mm_s / fastest_mm_s).clamp(0.0, 0.999);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
    // below SPEEDS
    let class = (share * SPEEDS as f32) as usize;
    class
}

fn extent(roads: &[&Road]) -> Option<([f32; 2], [f32; 2])> {
    let ends = || roads.iter().flat_map(|road| [road.from_mm, road.to_mm]);
    let edge = |axis: usize, pick: fn(f32, f32) -> f32| ends().map(|end| end[axis]).reduce(pick);
    let room = roads.iter().map(|road| road.width_mm).fold(0.4, f32::max);
    let low = [edge(0, f32::min)? - room, edge(1, f32::min)? - room];
    let high = [edge(0, f32::max)? + room, edge(1, f32::max)? + room];
    Some((low, high))
}

/// Path data by class; the last one holds what is not known.
#[derive(Default)]
struct Paths {
    data: [String; ERRORS.len() + 2],
    last: [Option<[f32; 2]>; ERRORS.len() + 2],
    pieces: usize,
}

impl Paths {
    fn add(&mut self, road: &Road, share: (f32, f32), class: Option<usize>) {
        let at =
            |share: f32, axis: usize| road.from_mm[axis] + (road.to_mm[axis] - road.from_mm[axis]) * share;
        let (from, to) = ([at(share.0, 0), at(share.0, 1)], [at(share.1, 0), at(share.1, 1)]);
        let class = class.unwrap_or(ERRORS.len() + 1).min(ERRORS.len() + 1);
        let near = |last: [f32; 2]| (last[0] - from[0]).abs() + (last[1] - from[1]).abs() < 0.01;
        // y points up on the bed and down in a drawing. Writing to a string cannot fail.
        if !self.last[class].is_some_and(near) {
            _ = write!(self.data[class], "M{:.2} {:.2}", from[0], -from[1]);
        }
        _ = write!(self.data[class], "L{:.2} {:.2}", to[0], -to[1]);
        self.last[class] = Some(to);
        self.pieces += 1;
    }

    fn svg(&self, low: [f32; 2], size_mm: [f32; 2], width_mm: f32) -> String {
        let mut text = format!(
            "<svg viewBox=\"{:.2} {:.2} {:.2} {:.2}\" stroke-width=\"{:.2}\" fill=\"none\" stroke-linecap=\"round\" \
             stroke-linejoin=\"round\">",
            low[0],
            -(low[1] + size_mm[1]),
            size_mm[0],
            size_mm[1],
            width_mm * 0.92
        );
        for (class, data) in self.data.iter().enumerate().filter(|(_, data)| !data.is_empty()) {
            _ = write!(text, "<path class=\"c{class}\" d=\"{data}\"/>");
        }
        text.push_str("</svg>");
        text
    }
}
