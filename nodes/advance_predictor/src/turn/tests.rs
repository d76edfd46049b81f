//! Laws of the foresight.

use super::assess::assess;
use super::curves::generate;
use super::samples::Track;
use super::training::{Path, Training, train};
use super::*;
use crate::compensation::tests::{params, text};
use crate::network::chance::Stream;
use std::collections::BTreeMap;

fn piece(from_mm: [f64; 2], to_mm: [f64; 2]) -> Piece {
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
        fill: false,
    }
}

fn pieces(points_mm: &[[f64; 2]]) -> Vec<Piece> {
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
fn the_memory_is_bounded_and_forgets_the_oldest() {
    let raw = RawTurnParams { memory_points: 100, ..*params().turn };
    let small = TurnParams::try_from(raw).unwrap();
    let mut watcher = Watcher::new(small);
    for piece in generate(2, &mut Stream::new(1)) {
        if watcher.known() > 4 {
            watcher.begin_next();
        }
        watcher.push(piece);
        let seen = watcher.foresee(&network(), 0.0).unwrap();
        assert!((0.0..=1.0).contains(&seen.probability) && seen.lead.0 >= 0.0, "{seen:?}");
        assert!(watcher.remembered() <= 100);
    }
}

/// On made-up curves of another seed the predictor beats the buffer and both extrapolations.
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
    let unseen = Path { buffered: 8, pieces: generate(20, &mut Stream::new(2)) };
    let figures = assess(&TurnNetwork::parse(&trained).unwrap(), &unseen, &params);
    let all = figures.all;
    for baseline in [all.buffer_only, all.curvature_line, all.curvature_mean] {
        assert!(all.predictor.f1 > baseline.f1, "{all:?}");
    }
}

#[test]
fn a_damaged_file_is_refused() {
    let mut value: serde_json::Value = serde_json::from_str(&text("models/turn.json")).unwrap();
    let bias = &mut value["layers"][1]["bias"][0];
    *bias = serde_json::json!(bias.as_f64().unwrap() + 1e-3);
    let error = TurnNetwork::parse(&value.to_string()).unwrap_err().to_string();
    assert!(error.starts_with("network file: probe is"), "{error}");
}
