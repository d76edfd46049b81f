//! Which side of a piece of road shows its edge: nothing of the same layer beside it, nothing hidden.

use super::SeenEdge;
use super::params::WidthParams;
use super::stretch::{Piece, Station};
use crate::camera::Camera;
use crate::path::Road;
use crate::surroundings::{Mask, REDUCTION, lies_at};

/// A side of a piece of road whose edge can be seen.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Side {
    /// 1 for the left of the direction of travel, -1 for the right.
    pub(crate) sign: f64,
    /// The places along the piece where it can.
    pub(crate) stations: Vec<Station>,
    /// The edge of a road below lies at about the same place: it may be that one that is seen.
    pub(crate) stacked: bool,
}

impl Side {
    /// Whether enough of the piece shows.
    pub(crate) fn long_enough(&self, params: &WidthParams) -> bool {
        #[expect(clippy::cast_precision_loss, reason = "a handful of stations")]
        let length_m = self.stations.len() as f64 * params.station_m;
        length_m >= params.piece_min_m
    }

    /// The edge in the picture, from the first station to the last.
    pub(crate) fn edge(&self, edge_m: f64, (camera, tool_m): (&Camera, [f64; 2])) -> Option<SeenEdge> {
        let end = |station: &Station| {
            let point_m = [0, 1].map(|axis| station.point_m[axis] + self.sign * edge_m * station.left[axis]);
            camera.pixel(tool_m, point_m)
        };
        Some(SeenEdge { ends_px: [end(self.stations.first()?), end(self.stations.last()?)] })
    }
}

/// What the picture shows around a piece.
pub(crate) struct Scene<'a> {
    /// Camera and where the tool is.
    pub(crate) view: (&'a Camera, [f64; 2]),
    /// Roads in the picture, with the part laid.
    pub(crate) roads: &'a [(Road, f64)],
    /// Roads of the piece's layer.
    pub(crate) layer: &'a Mask,
}

/// Sides of a piece that show its edge.
pub(crate) fn sides(
    scene: &Scene<'_>,
    piece: &Piece,
    params: &WidthParams,
) -> Result<Vec<Side>, opencv::Error> {
    let levels = scene.layer.levels()?;
    let (camera, tool_m) = scene.view;
    let step_m = camera.scale_m * REDUCTION;
    let mut found = Vec::new();
    for sign in [1.0, -1.0] {
        let shows = |station: &&Station| {
            let at = |away_m: f64| {
                let point_m = [0, 1].map(|axis| station.point_m[axis] + sign * away_m * station.left[axis]);
                camera.pixel(tool_m, point_m)
            };
            let mut away_m = 0.9 * piece.width_m;
            while away_m <= params.clear_widths * piece.width_m {
                if lies_at(levels, at(away_m)) {
                    return false;
                }
                away_m += step_m;
            }
            camera.sees(at(0.0), params.margin_px)
                && camera.sees(at(params.clear_widths * piece.width_m), params.margin_px)
        };
        let stations: Vec<Station> = piece.stations.iter().filter(shows).copied().collect();
        if let Some(middle) = stations.get(stations.len() / 2) {
            let stacked = stacked(scene.roads, piece, (middle, sign), params);
            found.push(Side { sign, stations, stacked });
        }
    }
    Ok(found)
}

/// Whether a road of the layer below has an edge near ours.
fn stacked(
    roads: &[(Road, f64)],
    piece: &Piece,
    (station, sign): (&Station, f64),
    params: &WidthParams,
) -> bool {
    let below = roads.iter().filter(|(road, _)| road.layer + 1 == piece.layer);
    let edge_m = 0.5 * piece.width_m;
    below.into_iter().any(|(road, laid_m)| {
        let along = road.along();
        let away_m = [station.point_m[0] - road.from_m[0], station.point_m[1] - road.from_m[1]];
        let way_m = away_m[0] * along[0] + away_m[1] * along[1];
        // Where our outward normal, from our centre line, meets its two edges; nowhere for one across.
        let parallel = -along[1] * station.left[0] + along[0] * station.left[1];
        if parallel.abs() < 0.9 || way_m < -piece.width_m || way_m > laid_m + piece.width_m {
            return false;
        }
        let beside_m = -along[1] * away_m[0] + along[0] * away_m[1];
        let centre_m = -sign * parallel.signum() * beside_m;
        [-0.5, 0.5].iter().any(|half| {
            (centre_m + half * road.width_m - edge_m).abs() < params.stacked_widths * piece.width_m
        })
    })
}

/// Mask of all roads of a layer that were laid.
pub(crate) fn layer_mask(
    (camera, tool_m): (&Camera, [f64; 2]),
    roads: &[(Road, f64)],
    layer: u32,
) -> Result<Mask, opencv::Error> {
    let mut mask = Mask::empty(camera)?;
    for (road, laid_m) in roads.iter().filter(|(road, laid_m)| road.layer == layer && *laid_m > 0.0) {
        let (from, to) = (camera.pixel(tool_m, road.from_m), camera.pixel(tool_m, road.point_m(*laid_m)));
        mask.draw(from, to, road.width_m / camera.scale_m)?;
    }
    Ok(mask)
}
