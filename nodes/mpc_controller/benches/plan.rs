//! A plan of 48 moves from starts as they occur and wilder ones. `fdm bench controller` sets it beside OSQP and do-mpc.

#![expect(clippy::expect_used, reason = "a benchmark has nobody to hand an error to")]

use criterion::{Criterion, criterion_group, criterion_main};
use mpc_controller::params::{RawCost, RawLimits, RawSolver};
use mpc_controller::qp::{Lags, Qp, Start};
use std::hint::black_box;

const COST: RawCost = RawCost {
    width_scale: 0.05,
    temperature_scale_k: 5.0,
    temperature_weight: 0.3,
    speed_scale: 0.2,
    feed_scale: 0.6,
    setpoint_weight_1_k2: 0.02,
    change_weight: 0.3,
    feed_change: 0.05,
    speed_change: 0.04,
    setpoint_change_k: 2.0,
};
const LIMITS: RawLimits = RawLimits {
    feed: 0.25,
    speed_low: -0.30,
    speed_high: 0.15,
    setpoint_k: 10.0,
    feed_rate: 0.06,
    speed_rate: 0.05,
    setpoint_rate_k: 1.0,
    force_margin: 0.8,
};
const LAGS: Lags = Lags { period_s: 0.25, horizon: 16, flow_s: 0.63, thermal_s: 12.0 };
const SOLVER: RawSolver = RawSolver { iterations: 60, time_limit_s: f64::INFINITY };
const STARTS: u32 = 200;

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

fn plan(criterion: &mut Criterion) {
    let mut qp = Qp::new(COST, LIMITS, LAGS, SOLVER).expect("the problem of model book 1.7");
    let starts: Vec<Start> = (0..STARTS).map(start).collect();
    let mut next = starts.iter().cycle();
    criterion.bench_function("plan of 48 moves", |bencher| {
        bencher.iter(|| qp.solve(black_box(next.next().unwrap_or(&starts[0]))));
    });
}

criterion_group!(plans, plan);
criterion_main!(plans);
