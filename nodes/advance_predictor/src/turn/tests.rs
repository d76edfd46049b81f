//! Laws of the foresight.

use super::assess::{assess, starved};
use super::curves::generate;
use super::samples::Track;
use super::training::{Path, Training, train};
use super::*;
use crate::compensation::tests::{params, text};
use crate::network::chance::Stream;
use std::collections::BTreeMap;

pub(super) fn piece(from_mm: [f64; 2], to_mm: [f64; 2]) -> Piece {
    let way = [0, 1].map(|axis| 1e-3 * (to_mm[axis] - from_mm[axis]));
    let length_m = way[0].hypot(way[1]);
    Piece {
        end_m: to_mm.map(|mm| 1e-3 * mm),
        direction: way.map(|part| part / length_m),
        length_m,
        speed_m_s: 0.02,
        duration_s: length_m / 0.02,
        along_m_s2: 0.0,
        deposit: true,
        layer: None,
        fill: false,
    }
}

pub(super) fn pieces(points_mm: &[[f64; 2]]) -> Vec<Piece> {
    points_mm.windows(2).map(|pair| piece(pair[0], pair[1])).collect()
}

fn network() -> TurnNetwork {
    TurnNetwork::parse(&text("models/turn.json")).unwrap()
}

/// 6 mm straight on, then left: the buffer says so from 4 mm before it on, and when, and never earlier.
#[test]
fn a_turn_that_the_buffer_shows_is_certain() {
    let path = pieces(&[[0.0, 0.0], [6.0, 0.0], [6.0, 6.0]]);
    let mut watcher = Watcher::new(params().turn);
    path.iter().for_each(|piece| watcher.push(*piece));
    for (gone_mm, expected) in [(0.0, 0.0), (1.9, 0.0), (2.1, 1.0), (5.9, 1.0)] {
        let seen = watcher.foresee(&network(), 1e-3 * gone_mm).unwrap();
        assert!((seen.probability - expected).abs() < 1e-12, "{gone_mm}: {seen:?}");
        assert_eq!(seen.basis, Basis::Buffer);
        assert!((seen.lead.0 - (6.0 - gone_mm) / 20.0).abs() < 1e-9, "{gone_mm}: {seen:?}");
    }
    assert!(watcher.foresee(&network(), f64::NAN).is_none());
    assert!(Watcher::new(params().turn).foresee(&network(), 0.0).is_none());
}

/// A road that fills 20 mm and meets the wall there turns; the first time, without any memory of it. Without the wall, and
/// as far from it as the horizon and more, it goes on.
#[test]
fn a_road_that_fills_turns_at_the_wall() {
    let expected = |wall_mm: Option<f64>| {
        let mut watcher = Watcher::new(params().turn);
        let square = [[0.0, -9.0], [0.0, 9.0]].map(|point| [point[0] - 1.0, point[1]]);
        let right = wall_mm.map(|x_mm| [[x_mm, -9.0], [x_mm, 9.0]]);
        let fill: Vec<[f64; 2]> = (0..=40).map(|step| [0.5 * f64::from(step), 0.0]).collect();
        let path = pieces(&square).into_iter().chain(right.into_iter().flat_map(|side| pieces(&side)));
        let roads = pieces(&fill).into_iter().map(|piece| Piece { fill: true, ..piece });
        path.chain(roads).for_each(|piece| {
            if watcher.known() > 4 {
                watcher.begin_next();
            }
            watcher.push(piece);
        });
        // 2 mm of the horizon of 4 mm are hidden.
        watcher.foresee(&network(), 5e-4).unwrap().probability >= network().threshold()
    };
    assert!(expected(Some(20.3)) && expected(Some(21.2)));
    assert!(!expected(None) && !expected(Some(26.0)));
}

/// A spline that comes back in a hairpin, the first time it is laid: foreseen where four moves behind the current one do not
/// show it yet. One that bends as far in a wide bow goes on.
#[test]
fn a_hairpin_of_a_spline_is_foreseen() {
    let alarms = |ends: [[f64; 2]; 4]| {
        let points = [ends[0]].into_iter().chain(splines::chopped(ends, 0.01)).collect::<Vec<_>>();
        let (path, params) = (pieces(&points), params().turn);
        let mut starved = vec![];
        Track::new(&path, &params).run(4, &params, |watcher, moment| {
            if watcher.by_buffer(moment.gone_m).is_none() && moment.piece > 0 {
                let seen = watcher.foresee(&network(), moment.gone_m).unwrap();
                starved.push((seen.probability >= network().threshold(), moment.turns));
            }
        });
        starved
    };
    let hairpin = alarms([[0.0, 0.0], [4.0, 0.5], [-3.0, 2.0], [1.0, 0.8]]);
    let coming = hairpin.iter().filter(|(_, turns)| *turns).count();
    let foreseen = hairpin.iter().filter(|(alarm, turns)| *alarm && *turns).count();
    assert!(coming >= 5 && foreseen + 1 >= coming, "{foreseen} of {coming}: {hairpin:?}");
    let bow = alarms([[0.0, 0.0], [8.0, 0.0], [8.0, 8.0], [0.0, 8.0]]);
    let foreseen = bow.iter().filter(|(alarm, _)| *alarm).count();
    assert!(bow.len() >= 5 && foreseen == 0, "{foreseen} of {}", bow.len());
}

/// Labels of the golden path of the model book: turns of 90 and 36 degrees are turns, 5.8 degrees is none.
#[test]
fn labels_are_by_hindsight() {
    let points = [[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [20.0, 10.0], [21.0, 19.9], [30.0, 30.0]];
    let path = pieces(&points);
    let params = params().turn;
    let track = Track::new(&path, &params);
    assert_eq!(track.turns().collect::<Vec<_>>(), [1, 3]);
    track.run(0, &params, |_, moment| {
        let end_m = 1e-3 * [10.0, 20.0, 30.0, 39.950_376_877, f64::INFINITY][moment.piece];
        let at_m = path[..moment.piece].iter().map(|piece| piece.length_m).sum::<f64>() + moment.gone_m;
        let to_turn_m = if moment.piece == 0 {
            1e-3 * 20.0 - at_m
        } else if moment.piece == 2 {
            1e-3 * 39.950_376_877 - at_m
        } else {
            end_m - at_m
        };
        assert_eq!(moment.turns, to_turn_m <= 0.004 + 1e-12, "{moment:?}");
    });
}

/// What is remembered is bounded: a path of any length keeps the newest points alone, and goes on being foreseen.
#[test]
fn the_memory_is_bounded() {
    let raw = RawTurnParams { memory_points: 100, ..*params().turn };
    let small = TurnParams::try_from(raw).unwrap();
    let (mut watcher, network) = (Watcher::new(small), network());
    for (place, piece) in generate(2, &mut Stream::new(1)).into_iter().enumerate() {
        if watcher.known() > 4 {
            watcher.begin_next();
        }
        watcher.push(piece);
        let seen = watcher.foresee(&network, 0.0).unwrap();
        assert!((0.0..=1.0).contains(&seen.probability) && seen.lead.0 >= 0.0, "{seen:?}");
        assert_eq!(watcher.remembered(), (place + 1).min(100));
    }
    assert_eq!(watcher.remembered(), 100);
}

/// A square of 40 pieces of 1 mm, 80 pieces elsewhere, then its first side again: 121 pieces later 1000 points know it,
/// and of 100 those are gone.
#[test]
fn the_memory_forgets_the_oldest() {
    let along = |corners: &[[f64; 2]]| -> Vec<[f64; 2]> {
        let side = |pair: &[[f64; 2]]| {
            let (from, to) = (pair[0], pair[1]);
            (0..10)
                .map(move |step| {
                    [0, 1].map(|axis| from[axis] + 0.1 * f64::from(step) * (to[axis] - from[axis]))
                })
                .collect::<Vec<_>>()
        };
        corners.windows(2).flat_map(side).collect()
    };
    let square = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0], [0.0, 0.0]];
    let elsewhere = square.map(|corner| [corner[0] + 50.0, corner[1]]);
    let mut points = along(&square);
    points.extend(along(&elsewhere));
    points.extend(along(&elsewhere));
    points.extend(along(&square[..2]));
    let matched = |memory_points: u32| {
        let raw = RawTurnParams { memory_points, ..*params().turn };
        let mut watcher = Watcher::new(TurnParams::try_from(raw).unwrap());
        for piece in pieces(&points) {
            if watcher.known() > 0 {
                watcher.begin_next();
            }
            watcher.push(piece);
        }
        watcher.inputs(0.0).1.matched
    };
    assert!(matched(1000) > 0.0);
    assert!(matched(100).abs() < f64::EPSILON);
}

/// Two pieces of 10.5 mm in a line, looked at each millimetre: a horizon of 4 mm ends behind a piece from 7 mm on, at 4 of
/// its 11 moments; with the other one known only behind that. The judge counts the same.
#[test]
fn a_starved_moment_is_one_at_which_the_buffer_ends_too_early() {
    let path = |buffered| Path { buffered, pieces: pieces(&[[0.0, 0.0], [10.5, 0.0], [21.0, 0.0]]) };
    let params = params().turn;
    assert_eq!(starved(&path(0), &params), (22, 8));
    assert_eq!(starved(&path(1), &params), (22, 4));
    let made = Path { buffered: 4, pieces: generate(2, &mut Stream::new(1)) };
    let judged = assess(&network(), &made, &params);
    assert_eq!(starved(&made, &params), (judged.moments, judged.starved));
    assert!(judged.starved > 0 && judged.starved < judged.moments);
}

/// On made-up outlines and splines of another seed the predictor beats the buffer and both extrapolations.
#[test]
fn the_predictor_beats_its_baselines_on_paths_it_has_not_seen() {
    #[derive(serde::Deserialize)]
    struct Settings {
        turn: Training,
        #[serde(flatten)]
        _others: BTreeMap<String, serde_json::Value>,
    }
    let settings: Settings = serde_saphyr::from_str(&text("models/advance_training.yaml")).unwrap();
    let params = params().turn;
    let made = settings.turn.made(1);
    let paths: Vec<&Path> = made.iter().collect();
    let trained = train(&paths, &params, (&settings.turn, 1)).unwrap();
    assert_eq!(trained, train(&paths, &params, (&settings.turn, 1)).unwrap());
    let network = TurnNetwork::parse(&trained).unwrap();
    for unseen in [generate(20, &mut Stream::new(2)), splines::generate(20, &mut Stream::new(2))] {
        let all = assess(&network, &Path { buffered: 8, pieces: unseen }, &params).all;
        for baseline in [all.buffer_only, all.curvature_line, all.curvature_mean] {
            assert!(all.predictor.f1 > baseline.f1, "{all:?}");
        }
    }
}

/// Any number of any unit, whether the probe's inputs wake it or not.
#[test]
fn a_damaged_file_is_refused() {
    let whole: serde_json::Value = serde_json::from_str(&text("models/turn.json")).unwrap();
    for layer in 0..2 {
        for unit in 0..whole["layers"][layer]["bias"].as_array().unwrap().len() {
            let mut value = whole.clone();
            let weight = &mut value["layers"][layer]["weights"][unit][0];
            *weight = serde_json::json!(weight.as_f64().unwrap() + 1e-6);
            let error = TurnNetwork::parse(&value.to_string()).unwrap_err().to_string();
            assert!(error.starts_with("network file: sha256 is '"), "{layer} {unit}: {error}");
        }
    }
    assert!(TurnNetwork::parse(&whole.to_string()).is_ok());
}
