//! Time of one answer: `K_A` by the networks, `K_A` by the physics, and a turn update of a path in short pieces.
//!
//! `cargo run --release -p advance_predictor --no-default-features --example predict_time`, in the repository's folder
#![allow(
    clippy::print_stdout,
    clippy::expect_used,
    reason = "an example prints and stops at the first failure"
)]

use advance_predictor::Params;
use advance_predictor::compensation::{Ensemble, Predictor};
use advance_predictor::network::chance::Stream;
use advance_predictor::turn::{TurnNetwork, Watcher, curves};
use models::advance::{Condition, Physics};
use models::units::Celsius;
use serde::de::DeserializeOwned;
use std::collections::HashMap;
use std::hint::black_box;
use std::time::Instant;

/// Answers that the time is taken over.
const ANSWERS: u32 = 100_000;

fn read<T: DeserializeOwned>(path: &str) -> T {
    let text = std::fs::read_to_string(path).expect(path);
    let mut tree: HashMap<String, HashMap<String, T>> = serde_saphyr::from_str(&text).expect(path);
    tree.remove("/**").and_then(|mut node| node.remove("ros__parameters")).expect("ros__parameters")
}

/// Mean time of `work` in microseconds, once per answer.
fn mean_us(mut work: impl FnMut(u32)) -> f64 {
    let start = Instant::now();
    (0..ANSWERS).for_each(&mut work);
    1e6 * start.elapsed().as_secs_f64() / f64::from(ANSWERS)
}

fn main() {
    let params: Params = read("config/advance_predictor.param.yaml");
    let mut blocks: HashMap<String, Physics> = read("config/advance/physics.yaml");
    let physics = blocks.remove("advance_physics").expect("advance_physics");
    let file = |path| std::fs::read_to_string(path).expect("a network's file");
    let ensemble = Ensemble::parse(&file(&params.models.bowden)).expect("networks");
    let turns = TurnNetwork::parse(&file(&params.models.turn)).expect("network of turns");
    let predictor = Predictor::new(physics, params.bounds, ensemble);
    for (name, low_c) in [("networks", 200.0), ("physics", 240.0)] {
        let time_us = mean_us(|index| {
            let temperature = Celsius(low_c + f64::from(index % 30));
            let at = Condition { temperature, height_m: 2e-4, width_m: 4.07e-4 };
            _ = black_box(predictor.predict("PLA", &at));
        });
        println!("K_A by the {name}: {time_us:.2} us");
    }
    let path = curves::generate(200, &mut Stream::new(1));
    for buffered in [0, 4, 8] {
        let mut watcher = Watcher::new(params.turn);
        let mut pieces = path.iter().cycle();
        let (mut hidden, mut worst_us) = (0_u32, 0.0_f64);
        let time_us = mean_us(|_| {
            let start = Instant::now();
            if watcher.known() > buffered {
                watcher.begin_next();
            }
            pieces.next().into_iter().for_each(|piece| watcher.push(*piece));
            let seen = watcher.foresee(&turns, 0.0);
            hidden += u32::from(seen.is_some_and(|seen| seen.known_m < 0.004));
            worst_us = worst_us.max(1e6 * start.elapsed().as_secs_f64());
        });
        println!(
            "turn update, {buffered} moves ahead: {time_us:.2} us mean, {worst_us:.0} us worst, {:.0} % starved",
            1e2 * f64::from(hidden) / f64::from(ANSWERS)
        );
    }
}
