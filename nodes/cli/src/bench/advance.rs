//! One answer of the advance predictor: `K_A` of a condition, and an update of the foresight of turns.

use super::peers::quantile;
use super::{AdvanceArgs, Benchmark};
use crate::advance::{Setup, turns};
use crate::config::ConfigDir;
use crate::job::BYTES_MAX;
use advance_predictor::compensation::Predictor;
use advance_predictor::turn::assess::starved;
use advance_predictor::turn::{Piece, TurnNetwork, TurnParams, Watcher};
use anyhow::{Context, bail};
use models::advance::{Condition, DriveKind};
use models::units::Celsius;
use std::hint::black_box;
use std::time::Instant;

/// Answers of a round: one alone is shorter than the clock's reading.
const ANSWERS: u32 = 200;
const ROUNDS: u32 = 500;
/// Longest mean time of an answer `[us]`.
const ANSWER_US: f64 = 5.0;
/// Longest mean time of an update of the foresight `[us]`.
const UPDATE_US: f64 = 20.0;
/// Moves known behind the current one: none, and the buffers of small firmware.
const BUFFERS: [u32; 4] = [0, 4, 8, 16];

pub(super) fn run(args: &AdvanceArgs) -> anyhow::Result<Vec<Benchmark>> {
    let config = ConfigDir::find(args.config.as_deref())?;
    let setup = Setup::load(&config)?;
    let predictor = setup.predictor(&config, DriveKind::Bowden)?;
    let path = config.file("models/turn.json");
    let text = runtime::input::text(&path).with_context(|| path.display().to_string())?;
    let network = TurnNetwork::parse(&text).with_context(|| path.display().to_string())?;
    let bytes =
        runtime::input::bytes(&args.gcode, BYTES_MAX).with_context(|| args.gcode.display().to_string())?;
    let mut all = Vec::new();
    for (name, low_c) in [("networks", 200.0), ("physical model, outside of their data", 240.0)] {
        let times_us = answers_us(&predictor, low_c);
        let [median_us, late_us] = [0.5, 0.99].map(|share| quantile(&times_us, share));
        all.push(Benchmark::new(format!("K_A by the {name}: median"), "us", median_us).target(ANSWER_US));
        all.push(Benchmark::new(format!("K_A by the {name}: p99 of {ANSWERS}"), "us", late_us));
    }
    for buffered in BUFFERS {
        let path = turns::planned(&bytes, &config.motion()?, buffered);
        if path.pieces.is_empty() {
            bail!("{}: no move in a layer", args.gcode.display());
        }
        let times_us = updates(&path.pieces, buffered, (&network, setup.params.turn));
        let name = format!("turn update, {buffered} moves ahead");
        #[allow(clippy::cast_precision_loss, reason = "a count of updates")]
        let count = times_us.len() as f64;
        let mean_us = times_us.iter().sum::<f64>() / count;
        all.push(Benchmark::new(format!("{name}: mean"), "us", mean_us).target(UPDATE_US));
        all.push(Benchmark::new(format!("{name}: p99"), "us", quantile(&times_us, 0.99)));
        #[allow(clippy::cast_precision_loss, reason = "counts of moments")]
        let (moments, starved) = {
            let (moments, starved) = starved(&path, &setup.params.turn);
            (moments as f64, starved as f64)
        };
        // As `fdm advance train --judge` counts them.
        all.push(Benchmark::new(format!("{name}: starved"), "%", 1e2 * starved / moments));
    }
    Ok(all)
}

/// Mean times of an answer, round by round `[us]`.
fn answers_us(predictor: &Predictor, low_c: f64) -> Vec<f64> {
    let round = |_| {
        let begin = Instant::now();
        for answer in 0..ANSWERS {
            let temperature = Celsius(low_c + f64::from(answer % 30));
            let at = Condition { temperature, height_m: 2e-4, width_m: 4.07e-4 };
            _ = black_box(predictor.predict("PLA", black_box(&at)));
        }
        1e6 * begin.elapsed().as_secs_f64() / f64::from(ANSWERS)
    };
    (0..ROUNDS).map(round).collect()
}

/// Follows a whole path: its memory fills as in a print. Times of the updates `[us]`.
fn updates(pieces: &[Piece], buffered: u32, (network, params): (&TurnNetwork, TurnParams)) -> Vec<f64> {
    let mut watcher = Watcher::new(params);
    let mut times_us = Vec::with_capacity(pieces.len());
    for piece in pieces {
        let begin = Instant::now();
        if watcher.known() > buffered as usize {
            watcher.begin_next();
        }
        watcher.push(*piece);
        _ = black_box(watcher.foresee(network, 0.0));
        times_us.push(1e6 * begin.elapsed().as_secs_f64());
    }
    times_us
}
