//! System 1: fast trims and model predictive controller.

use mpc_controller::params::{RawCost, RawLimits, RawSolver};
use mpc_controller::qp::{Lags, Outcome, Qp, Start};
use mpc_controller::trims::{Gains, trimmed};
use serde_json::{Value, json};

use super::vector::{Handler, Inputs, Set};

pub(crate) fn handler(function: &str) -> Option<Handler> {
    Some(match function {
        "trims" => trims,
        "mpc_step" => mpc_step,
        _ => return None,
    })
}

fn trims(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let gains = Gains {
        feed_1_s: given.num("Kw_1_s")?,
        features_m_s: given.num("Kphi_m_s")?,
        speed_1_s: given.num("Kv_1_s")?,
        feed_range_m_s: (given.num("Fmin")?, given.num("Fmax")?),
        speed_range_m_s: (given.num("vmin")?, given.num("vmax")?),
    };
    let now = (given.num("F_m_s")?, given.num("v_m_s")?);
    let width_error_m = given.num("w_m")? - given.num("wref_m")?;
    let (feed_m_s, speed_m_s) = trimmed(&gains, now, width_error_m, &given.nums("e_feat")?);
    Ok(json!({"F_m_s": feed_m_s, "v_m_s": speed_m_s}))
}

/// Cost of model book 1.7: the vectors carry none.
const COST: RawCost = RawCost {
    width_scale: 0.05,
    temperature_scale_k: 5.0,
    temperature_weight: 0.3,
    speed_scale: 0.20,
    feed_scale: 0.6,
    setpoint_weight_1_k2: 0.02,
    change_weight: 0.3,
    feed_change: 0.05,
    speed_change: 0.04,
    setpoint_change_k: 2.0,
};

/// Bounds and rates of model book 1.7.
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

/// Room enough: the law is checked here, not the time of a solve.
const SOLVER: RawSolver = RawSolver { guesses: 12, iterations: 200, time_limit_s: 10.0 };

fn mpc_step(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let lags = Lags {
        period_s: given.num("dt_s")?,
        horizon: usize::try_from(given.count("N")?).map_err(|error| error.to_string())?,
        flow_s: given.num("K_lag_s")?,
        thermal_s: given.num("tau_T_s")?,
    };
    let start = Start {
        flow: given.num("eu")?,
        temperature_k: given.num("eT_K")?,
        gain: given.num("b")?,
        last: given.array("u_prev")?,
        feed_cap: given.optional("f_cap")?,
        width_ratio: given.num("rw")?,
    };
    let mut problem = Qp::new(COST, LIMITS, lags, SOLVER).map_err(|error| format!("refused: {error:?}"))?;
    match problem.solve(&start) {
        (first, Outcome::Solved { .. }) => Ok(json!({"u": first})),
        (_, other) => Err(format!("not solved: {other:?}")),
    }
}
