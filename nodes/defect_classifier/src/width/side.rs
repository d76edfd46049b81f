//! Which side of a piece of road shows its edge: nothing as high beside it, nothing hidden.

use super::SeenEdge;
use super::ground::{Ground, floor_m};
use super::params::WidthParams;
use super::stretch::{Piece, Station};
use crate::camera::Camera;
use crate::path::Road;
use crate::surroundings::{REDUCTION, lies_at};

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
    /// What lies around the piece.
    pub(crate) ground: &'a Ground,
}

/// Sides of a piece that show its edge.
pub(crate) fn sides(
    scene: &Scene<'_>,
    piece: &Piece,
    params: &WidthParams,
) -> Result<Vec<Side>, opencv::Error> {
    let (beside, open) = (scene.ground.beside.levels()?, scene.ground.open.levels()?);
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
                if lies_at(beside, at(away_m)) || lies_at(open, at(away_m)) {
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

/// Whether a road below has an edge near ours.
fn stacked(
    roads: &[(Road, f64)],
    piece: &Piece,
    (station, sign): (&Station, f64),
    params: &WidthParams,
) -> bool {
    let floor_m = floor_m(piece, params);
    let below = roads.iter().filter(|(road, _)| road.top_m <= floor_m);
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

#[cfg(test)]
mod tests {
    use super::super::params::tests::params;
    use super::*;
    use crate::camera::tests::camera;
    use crate::path::PathHistory;
    use crate::path::tests::{params as history, road};
    use crate::surroundings::in_view;
    use models::motion::Role;
    use models::units::Seconds;

    const TOOL_M: [f64; 2] = [0.1, 0.1];

    /// Sides, left then right, on which the edge of a road along bed x is free, with a second road `beside_m` to its
    /// left that lies `lower_m` lower.
    fn free(beside_m: f64, lower_m: f64) -> Vec<f64> {
        free_beside(beside_m, lower_m, Role::Solid)
    }

    fn free_beside(beside_m: f64, lower_m: f64, role: Role) -> Vec<f64> {
        let mut path = PathHistory::new(history());
        let mut other = road(1, [0.09, 0.104 + beside_m], [0.11, 0.104 + beside_m]);
        other.role = role;
        (other.start_m[2], other.end_m[2]) = (other.start_m[2] - lower_m, other.end_m[2] - lower_m);
        path.on_move(Seconds(1.0), &other);
        path.on_move(Seconds(2.0), &road(1, [0.09, 0.104], [0.11, 0.104]));
        let camera = camera();
        let view = (&camera, TOOL_M);
        let stations =
            (0..20).map(|k| Station { point_m: [0.1 + 1e-4 * f64::from(k), 0.104], left: [0.0, 1.0] });
        let piece = Piece {
            stations: stations.collect(),
            width_m: 4.5e-4,
            height_m: 2e-4,
            top_m: 4e-4,
            laid: Seconds(3.0),
        };
        let roads = in_view(&path, Seconds(9.0), view);
        let ground = Ground::of(&piece, &roads, view, &params()).unwrap();
        let sides = sides(&Scene { view, roads: &roads, ground: &ground }, &piece, &params()).unwrap();
        sides.iter().filter(|side| !side.stacked).map(|side| side.sign).collect()
    }

    #[test]
    fn a_road_beside_hides_the_edge_whatever_layer_it_is_of() {
        for lower_m in [-1e-4, 0.0, 2.7e-5, 1.3e-4] {
            assert_eq!(free(4.5e-4, lower_m), [-1.0], "{lower_m}");
        }
    }

    #[test]
    fn a_road_below_hides_an_edge_only_where_its_own_lies() {
        assert_eq!(free(4.5e-4, 2e-4), [-1.0]);
        assert_eq!(free(2.3e-4, 2e-4), [1.0, -1.0]);
    }

    /// The top skin over strands read 80 um too narrow, and the loop laid a fifth too much.
    #[test]
    fn an_edge_over_strands_is_not_measured() {
        for role in [Role::Bridge, Role::Infill, Role::Support] {
            assert_eq!(free_beside(2.3e-4, 2e-4, role), [0.0; 0], "{role:?}");
            assert_eq!(free_beside(5e-3, 2e-4, role), [1.0, -1.0], "{role:?}");
        }
    }
}
