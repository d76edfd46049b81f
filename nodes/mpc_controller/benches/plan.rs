//! A plan of 48 moves from starts as they occur and wilder ones. `fdm bench controller` sets it beside OSQP and do-mpc.

#![expect(clippy::expect_used, reason = "a benchmark has nobody to hand an error to")]

use criterion::{Criterion, criterion_group, criterion_main};
use mpc_controller::Params;
use mpc_controller::params::RawSolver;
use mpc_controller::qp::{Lags, Qp, Start};
use serde::Deserialize;
use std::hint::black_box;

const SHIPPED: &str = include_str!("../../../config/mpc_controller.param.yaml");
/// Filament to outlet, of PLA `[s]`.
const FLOW_LAG_S: f64 = 0.63;
const STARTS: u32 = 200;

#[derive(Deserialize)]
struct File {
    #[serde(rename = "/**")]
    node: Node,
}

#[derive(Deserialize)]
struct Node {
    #[serde(rename = "ros__parameters")]
    parameters: Params,
}

fn problem_with(guesses: u32) -> Qp {
    let file: File = serde_saphyr::from_str(SHIPPED).expect("the shipped parameters");
    let params = file.node.parameters.in_virtual_time();
    let lags = Lags {
        period_s: params.period_s,
        horizon: usize::try_from(params.model.horizon).expect("a horizon"),
        flow_s: FLOW_LAG_S,
        thermal_s: params.model.thermal_lag_s,
    };
    Qp::new(params.cost, params.limits, lags, RawSolver { guesses, ..params.solver })
        .expect("the problem of model book 1.7")
}

/// Sines of rates that have no common period: every start is another one.
fn start(index: u32) -> Start {
    let wave = |rate: f64, range: f64| range * (rate * f64::from(index)).sin();
    Start {
        flow: wave(1.1, 0.1),
        temperature_k: wave(0.7, 5.0),
        gain: wave(1.9, 0.06),
        last: [wave(2.3, 0.08), wave(0.5, 0.08), wave(1.3, 3.0)],
        feed_cap: None,
        width_ratio: 1.09,
    }
}

/// The same with another shape of the road than the one before.
fn on_road(start: Start, index: u32) -> Start {
    Start { width_ratio: 1.09 + 0.01 * f64::from(index % 2), ..start }
}

fn plan(criterion: &mut Criterion) {
    let mut qp = problem_with(12);
    let starts: Vec<Start> = (0..STARTS).map(start).collect();
    let mut next = starts.iter().cycle();
    criterion.bench_function("plan of 48 moves", |bencher| {
        bencher.iter(|| qp.solve(black_box(next.next().unwrap_or(&starts[0]))));
    });
    let roads: Vec<Start> =
        starts.iter().zip(0..STARTS).map(|(start, index)| on_road(*start, index)).collect();
    let mut next = roads.iter().cycle();
    criterion.bench_function("plan of 48 moves, each on another road", |bencher| {
        bencher.iter(|| qp.solve(black_box(next.next().unwrap_or(&roads[0]))));
    });
    let mut qp = problem_with(0);
    let mut next = starts.iter().cycle();
    criterion.bench_function("plan of 48 moves by the interior point", |bencher| {
        bencher.iter(|| qp.solve(black_box(next.next().unwrap_or(&starts[0]))));
    });
}

criterion_group!(plans, plan);
criterion_main!(plans);
