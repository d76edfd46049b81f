//! Time of a solve over varying starts: mean and worst.
//!
//! `cargo run --release -p mpc_controller --no-default-features --example solve_time`

use mpc_controller::params::{RawCost, RawLimits, RawSolver};
use mpc_controller::qp::{Lags, Outcome, Qp, Start};
use std::io::Write;
use std::time::Instant;

const SOLVES: u32 = 5_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let cost = RawCost {
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
    let limits = RawLimits {
        feed: 0.25,
        speed_low: -0.30,
        speed_high: 0.15,
        setpoint_k: 10.0,
        feed_rate: 0.06,
        speed_rate: 0.05,
        setpoint_rate_k: 1.0,
        force_margin: 0.8,
    };
    let lags = Lags { period_s: 0.25, horizon: 16, flow_s: 0.63, thermal_s: 12.0 };
    let mut qp = Qp::new(cost, limits, lags, RawSolver { iterations: 60, time_limit_s: 1.0 })?;
    let (mut total_s, mut worst_s, mut solved) = (0.0, 0.0_f64, 0);
    let mut last = [0.0; 3];
    for step in 0..SOLVES {
        let phase = f64::from(step) * 0.1;
        let start = Start {
            flow: 0.1 * phase.sin(),
            temperature_k: 5.0 * (0.7 * phase).sin(),
            gain: 0.2 * (0.3 * phase).cos(),
            last,
            feed_cap: Some(0.2),
            width_ratio: 1.09 + 0.01 * (0.01 * phase).sin(),
        };
        let begun = Instant::now();
        let (got, outcome) = qp.solve(&start);
        let took_s = begun.elapsed().as_secs_f64();
        total_s += took_s;
        worst_s = worst_s.max(took_s);
        solved += i32::from(matches!(outcome, Outcome::Solved { .. }));
        last = got;
    }
    let mean_us = total_s / f64::from(SOLVES) * 1e6;
    writeln!(
        std::io::stdout(),
        "solve {mean_us:.0} us mean, {:.0} us worst, {solved} of {SOLVES} solved",
        worst_s * 1e6
    )?;
    Ok(())
}
