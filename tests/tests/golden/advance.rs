//! System 2: pressure advance, its test line, turns.

use models::advance::width::Tally;
use models::advance::{
    Compensation, Condition, Drive, Passage, Polymer, RawDrive, RawPolymer, RawTestLine, TestLine,
    VirtualLine, WidthErrors, turn,
};
use models::motion::junction_speed_m_s;
use models::units::{Celsius, Seconds};
use serde_json::{Value, json};

use super::vector::{Handler, Inputs, Set};

/// Step of the printed line: the lags are 45 ms and more.
const STEP: Seconds = Seconds(5e-4);
/// Parts that each part of the line is sampled at.
const SAMPLES: u32 = 20_000;

pub(crate) fn handler(function: &str) -> Option<Handler> {
    Some(match function {
        "forces" => forces,
        "test_line_times" => test_line_times,
        "advance_linear" => advance_linear,
        "virtual_test_line" => virtual_test_line,
        "junction_speed" => junction_speed,
        "turn_labels" => turn_labels,
        _ => return None,
    })
}

fn refused(error: impl std::fmt::Display) -> String {
    format!("refused: {error}")
}

fn forces(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let forces = Passage {
        viscosity_pa_s: given.num("mu_Pa_s")?,
        length_m: given.num("L_m")?,
        outlet_m_s: given.num("v_out_m_s")?,
        density_kg_m3: given.num("rho_kg_m3")?,
        inlet_diameter_m: given.num("d_in_m")?,
        outlet_diameter_m: given.num("d_out_m")?,
    }
    .forces();
    Ok(json!({
        "F_friction_N": forces.friction_n,
        "F_friction_on_filament_N": forces.friction_on_filament_n,
        "F_accel_N": forces.acceleration_n,
        "ratio": forces.ratio(),
    }))
}

/// The paper's line.
fn line() -> Result<TestLine, String> {
    let raw =
        RawTestLine { low_m_s: 0.02, high_m_s: 0.08, acceleration_m_s2: 1.0, low_m: 0.03, high_m: 0.04 };
    TestLine::try_from(raw).map_err(refused)
}

fn test_line_times(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let raw = RawTestLine {
        low_m_s: given.num("v_low_m_s")?,
        high_m_s: given.num("v_high_m_s")?,
        acceleration_m_s2: given.num("acc_m_s2")?,
        low_m: given.num("s_low_m")?,
        high_m: given.num("s_high_m")?,
    };
    let line = TestLine::try_from(raw).map_err(refused)?;
    Ok(json!({"t_s": line.ends_s(), "plateau_m": line.plateau_m(), "plateau_s": line.plateau().0}))
}

/// Width errors of the paper's line under a linear lag.
fn linear_errors(lag: Compensation, line: &TestLine) -> Option<WidthErrors> {
    let knots_m_s = line.knots_m_s();
    let mut state_m_s = lag.steady(knots_m_s[0]);
    let (mut tally, mut start_s) = (Tally::default(), 0.0);
    for (part, end_s) in line.ends_s().into_iter().enumerate() {
        let speed = |index: f64| {
            knots_m_s[part] + (knots_m_s[part + 1] - knots_m_s[part]) * index / f64::from(SAMPLES)
        };
        let dt = Seconds((end_s - start_s) / f64::from(SAMPLES));
        for index in (0..SAMPLES).map(f64::from) {
            let half = Seconds(0.5 * dt.0);
            let middle_m_s = speed(index + 0.5);
            state_m_s = lag.step(state_m_s, (speed(index), middle_m_s), half);
            tally.add(lag.outlet(state_m_s, middle_m_s) / middle_m_s - 1.0, middle_m_s * dt.0);
            state_m_s = lag.step(state_m_s, (middle_m_s, speed(index + 1.0)), half);
        }
        start_s = end_s;
    }
    tally.errors()
}

fn advance_linear(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    if given.text("profile")? != "paper test line" {
        return Err("another profile".into());
    }
    let lag = Compensation { lag_s: given.num("K_s")?, advance_s: given.num("KA_s")? };
    let errors = linear_errors(lag, &line()?).ok_or("no way")?;
    Ok(json!({
        "rms": errors.rms,
        "max_under": errors.under_max,
        "max_over": errors.over_max,
        "mean_abs": errors.mean_abs,
    }))
}

fn polymer(set: &Set, name: &str) -> Result<Polymer, String> {
    let given = set.block("materials")?.block(name)?;
    Polymer::try_from(RawPolymer {
        flow_index: given.num("n")?,
        activation_j_mol: given.num("Ea")?,
        reference: Celsius(given.num("Tref")? - models::units::ZERO_CELSIUS_K),
        factor: given.num("a")?,
        range_c: given.array("T")?,
    })
    .map_err(refused)
}

fn drive(given: Inputs<'_>) -> Result<Drive, String> {
    Drive::try_from(RawDrive {
        scale_s: given.num("ca")?,
        linear_s: given.num("Klin")?,
        gap_m: given.num("hg")?,
        gap_power: given.num("m")?,
        reference_m_s: given.num("vref")?,
        reference_width_m: 4e-4,
        filament_area_m2: 0.25 * std::f64::consts::PI * 1.75e-3_f64.powi(2),
        advance_range_s: [0.0, 1.0],
    })
    .map_err(refused)
}

fn virtual_test_line(set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let at = Condition {
        temperature: Celsius(given.num("T_C")?),
        height_m: 1e-3 * given.num("h_mm")?,
        width_m: 1e-3 * given.num("Ds_mm")?,
    };
    let polymer = polymer(set, given.text("material")?)?;
    let printed = VirtualLine::new(&drive(given.block("par")?)?, &polymer, &at, &line()?, STEP);
    let best = printed.best().ok_or("no best")?;
    let none = printed.errors(0.0).ok_or("no line")?;
    Ok(json!({"KA_best_s": best.advance_s, "rms_none": none.rms, "rms_best": best.errors.rms}))
}

fn junction_speed(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let angle_rad = given.num("interior_angle_deg")?.to_radians();
    let speed_m_s = junction_speed_m_s(angle_rad, given.num("acc_m_s2")?, given.num("junction_deviation_m")?);
    Ok(json!({"v_m_s": speed_m_s}))
}

fn turn_labels(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let points_m: Vec<[f64; 2]> =
        given.pairs("points_mm")?.into_iter().map(|point| point.map(|mm| 1e-3 * mm)).collect();
    let threshold_rad = given.num("threshold_deg")?.to_radians();
    let angles_deg: Vec<f64> = turn::turn_angles_rad(&points_m).into_iter().map(f64::to_degrees).collect();
    let ways_mm: Vec<Option<f64>> =
        turn::ways_to_turn_m(&points_m, threshold_rad).into_iter().map(|way| way.map(|m| 1e3 * m)).collect();
    Ok(json!({"turn_angle_deg": angles_deg, "distance_to_next_turn_mm": ways_mm}))
}
