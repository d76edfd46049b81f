//! System 4: five-axis machine of hybrid layout.

use models::hybrid::synthesis::microsteps;
use models::hybrid::{AxisError, Geometry, RawGeometry, Station, SurfacePoint};
use serde::Deserialize;
use serde_json::{Value, json};

use super::vector::{Handler, Inputs, Set};

/// The paper's hemisphere, where a vector names none.
const RADIUS_M: f64 = 0.075;

pub(crate) fn handler(function: &str) -> Option<Handler> {
    Some(match function {
        "inverse" => inverse,
        "forward_error" => forward_error,
        "linear_gain" => linear_gain,
        "delta_max" => delta_max,
        "synthesis" => synthesis,
        _ => return None,
    })
}

fn refused(error: impl std::fmt::Display) -> String {
    format!("refused: {error}")
}

/// The header's geometry; it has no limits.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct G1 {
    #[serde(rename = "L_m")]
    rod_m: f64,
    rail_xy_m: [[f64; 2]; 4],
    joint_m: [[f64; 3]; 4],
    branch: String,
    part_offset_z_m: f64,
    tip_m: [f64; 3],
    lead_m: f64,
}

fn geometry(set: &Set, given: Inputs<'_>) -> Result<Geometry, String> {
    if given.text("geometry")? != "G1" {
        return Err("another geometry".into());
    }
    let value = set.header.get("geometry_G1").ok_or("header has no `geometry_G1`")?;
    let g1: G1 = serde_json::from_value(value.clone()).map_err(|error| error.to_string())?;
    if g1.branch != "carriage above joint" {
        return Err("another branch".into());
    }
    Geometry::try_from(RawGeometry {
        provenance: "golden vectors".into(),
        rod_m: g1.rod_m,
        rails_m: g1.rail_xy_m,
        joints_m: g1.joint_m,
        part_offset_m: g1.part_offset_z_m,
        tip_m: g1.tip_m,
        lead_m: g1.lead_m,
        carriage_low_m: -1.0,
        carriage_high_m: 1.0,
        tilt_max_rad: 2.0,
        condition_max: 500.0,
        gain_max: 200.0,
    })
    .map_err(refused)
}

fn station<'a>(geometry: &'a Geometry, given: Inputs<'_>) -> Result<Station<'a>, String> {
    let radius_m = given.num("R_m").unwrap_or(RADIUS_M);
    let point = SurfacePoint::on_hemisphere(radius_m, given.num("z_m")?).map_err(refused)?;
    geometry.station(&point).map_err(refused)
}

fn inverse(set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let geometry = geometry(set, given)?;
    let station = station(&geometry, given)?;
    Ok(json!({
        "pose": station.target.pose.coordinates(),
        "q_m": station.carriages_m,
        "point_platform_m": station.target.platform_point_m.as_slice(),
        "normal_platform": station.target.platform_normal.as_slice(),
    }))
}

fn forward_error(set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let geometry = geometry(set, given)?;
    let shift =
        station(&geometry, given)?.shift(&given.array("dq_m")?, given.num("dq5_rad")?).map_err(refused)?;
    Ok(json!({
        "pose": shift.pose.coordinates(),
        "delta_m": shift.vector_m.as_slice(),
        "delta_perp_m": shift.normal_m,
    }))
}

fn linear_gain(set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let geometry = geometry(set, given)?;
    let gain = station(&geometry, given)?.gain();
    Ok(json!({"gain": gain.carriages, "sum_abs": gain.carriage_sum()}))
}

fn delta_max(set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    if given.text("q5")? != "same angle error" {
        return Err("another error of the table".into());
    }
    let geometry = geometry(set, given)?;
    let error = AxisError::of_motors(given.num("dq_deg")?.to_radians(), given.num("lead_m")?);
    let worst = station(&geometry, given)?.extremal(&error);
    Ok(json!({"delta_max_m": worst.largest_m, "failed_combinations": worst.failed}))
}

fn synthesis(set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    if given.text("error_model")? != "one microstep" {
        return Err("another model of error".into());
    }
    let geometry = geometry(set, given)?;
    let motor = (given.num("full_step_deg")?.to_radians(), geometry.lead_m);
    let found = microsteps(&[station(&geometry, given)?], motor, given.num("target_m")?, 1 << 16)
        .ok_or("no number of microsteps meets the target")?;
    Ok(json!({"microsteps": found.count, "delta_max_m": found.largest_m}))
}
