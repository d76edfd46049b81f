//! System 1: the filter of the state estimator.

use models::material::{Material, RawMaterial};
use models::units::{Kelvin, Seconds};
use nalgebra::{Matrix1, SMatrix, SVector, Vector1};
use serde_json::{Value, json};
use state_estimator::printer_model::{Drive, PrinterModel, Road, Setting, State, state};
use state_estimator::ukf::{Gaussian, Health, Measurement, Spread, Ukf, Update, nees, nis};

use super::physics::{hotend, material};
use super::vector::{Handler, Inputs, Set};

pub(crate) fn handler(function: &str) -> Option<Handler> {
    Some(match function {
        "nis" => innovation,
        "nees" => estimation_error,
        "ukf_cycle" => ukf_cycle,
        _ => return None,
    })
}

fn innovation(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let residual = SVector::from(given.array::<2>("r")?);
    // The covariance is symmetric: rows are columns.
    let covariance = SMatrix::from(given.matrix::<2>("S")?);
    Ok(json!({"nis": nis(&residual, &covariance).ok_or("S is not positive definite")?}))
}

fn estimation_error(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let truth = SVector::from(given.array::<3>("x_true")?);
    let estimate = Gaussian {
        mean: SVector::from(given.array::<3>("x_hat")?),
        covariance: SMatrix::from(given.matrix::<3>("P")?),
    };
    Ok(json!({"nees": nees(&truth, &estimate).ok_or("P is not positive definite")?}))
}

fn model(set: &Set, given: Inputs<'_>, substep: Seconds) -> Result<PrinterModel, String> {
    let raw = RawMaterial { lag_s: given.num("K_lag_s")?, ..(*material(set, given)?).clone() };
    let material = Material::try_from(raw).map_err(|error| format!("refused: {error}"))?;
    let setting = Setting {
        ambient: Kelvin(set.block("hotend")?.num("Tamb")?),
        filament_area_m2: set.header.get("A_F_m2").and_then(Value::as_f64).ok_or("header has no A_F_m2")?,
        substep,
    };
    Ok(PrinterModel::new(&hotend(set)?, &material, setting))
}

const STATES: usize = state::COUNT;

fn diagonal(given: Inputs<'_>, name: &str) -> Result<SMatrix<f64, STATES, STATES>, String> {
    Ok(SMatrix::from_diagonal(&State::from(given.array::<STATES>(name)?)))
}

fn ukf_cycle(set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let prior =
        Gaussian { mean: State::from(given.array::<STATES>("x0")?), covariance: diagonal(given, "P0_diag")? };
    let spread = Spread { alpha: given.num("alpha")?, beta: given.num("beta")?, kappa: given.num("kappa")? };
    let drive = Drive {
        heater_power_w: given.num("P_W")?,
        motor_speed_m_s: given.num("v_cmd_m_s")?,
        back_m_s: 0.0,
        filament_speed_m_s: None,
        fan: given.num("fan")?,
    };
    let road = Road { path_speed_m_s: given.num("v_xy_m_s")?, height_m: given.num("h_m")? };
    let dt_s = given.num("dt_s")?;
    let model = model(set, given, Seconds(dt_s / f64::from(given.count("substeps")?)))?;
    let mut filter = Ukf::new(prior, spread);
    if filter.predict(&diagonal(given, "Q_diag")?, |x| model.step(x, &drive, dt_s)) != Health::Sound {
        return Err("the prediction diverged".into());
    }
    let predicted = *filter.belief();
    let nis = [
        taken(&mut filter, given, ("y_Ts_K", "R_Ts"), |x| x[state::SENSOR])?,
        taken(&mut filter, given, ("y_enc_m_s", "R_enc"), |x| {
            model.filament_speed(x, drive.motor_speed_m_s)
        })?,
        taken(&mut filter, given, ("y_w_m", "R_w"), |x| model.width(x[state::FLOW], x[state::GAIN], road))?,
    ];
    let posterior = *filter.belief();
    Ok(json!({
        "x_pred": predicted.mean.as_slice(),
        "P_pred_diag": predicted.covariance.diagonal().as_slice(),
        "nis": nis,
        "x_post": posterior.mean.as_slice(),
        "P_post_diag": posterior.covariance.diagonal().as_slice(),
    }))
}

/// Takes one channel in, with no gate, and returns its NIS.
fn taken(
    filter: &mut Ukf<STATES>,
    given: Inputs<'_>,
    (value, variance): (&str, &str),
    mut predicted: impl FnMut(&State) -> f64,
) -> Result<f64, String> {
    let measurement = Measurement {
        value: Vector1::new(given.num(value)?),
        noise: Matrix1::new(given.num(variance)?),
        gate: f64::INFINITY,
    };
    match filter.update(&measurement, |x| Vector1::new(predicted(x))) {
        Update::Applied(innovation) => Ok(innovation.nis),
        other => Err(format!("{value} was not taken: {other:?}")),
    }
}
