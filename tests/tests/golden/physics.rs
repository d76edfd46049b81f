//! System 1: thermal, rheology, bead, latent quantities, quality.

use models::bead::{rectangle, stadium};
use models::extruder::{Extruder, RawExtruder};
use models::hotend::{Hotend, Inputs as HeatInputs, RawHotend, Thermal};
use models::latent::{Cooling, LaidBead, RawCooling, adhesion, fill, layer_shift_m};
use models::material::{Material, RawMaterial};
use models::melt::{Melt, melt_temperature};
use models::quality::{Observed, Quality, RawQuality, Terms, fused_confidence, softmax};
use models::units::{Kelvin, Seconds};
use serde_json::{Value, json};

use super::vector::{Handler, Inputs, Set};

pub(crate) fn handler(function: &str) -> Option<Handler> {
    Some(match function {
        "thermal_rhs" => thermal_rhs,
        "thermal_steady" => thermal_steady,
        "thermal_trajectory" => thermal_trajectory,
        "rheology" => rheology,
        "flow_from_pressure" => flow_from_pressure,
        "melt_temperature" => melt_temp,
        "q_max" => q_max,
        "bead_rect" => bead_rect,
        "bead_stadium" => bead_stadium,
        "adhesion" => bond,
        "t_bond" => bond_time,
        "porosity" => porosity,
        "layer_shift" => layer_shift,
        "softmax" => probabilities,
        "fused_confidence" => confidence,
        "quality" => quality,
        _ => return None,
    })
}

fn refused(error: impl std::fmt::Display) -> String {
    format!("refused: {error}")
}

/// The header's material of the name that the vector gives.
pub(crate) fn material(set: &Set, given: Inputs<'_>) -> Result<Material, String> {
    let name = given.text("material")?;
    let header = set.block("materials")?.block(name)?;
    Material::try_from(RawMaterial {
        name: name.into(),
        density_kg_m3: header.num("rho")?,
        heat_capacity_j_kg_k: header.num("cp")?,
        flow_index: header.num("n")?,
        consistency_pa_sn: header.num("Kref")?,
        reference_temp_k: header.num("Tref")?,
        activation_energy_j_mol: header.num("Ea")?,
        nozzle_temp_k: header.num("Tset")?,
        bed_temp_k: header.num("Tbed")?,
        min_temp_k: header.num("Tmin")?,
        max_temp_k: header.num("Tmax")?,
        glass_temp_k: header.num("Tg")?,
        adhesion_time_s: header.num("t_weld")?,
        fan: header.num("fan")?,
        lag_s: header.num("K_adv")?,
    })
    .map_err(refused)
}

/// The header's hot end.
pub(crate) fn hotend(set: &Set) -> Result<Hotend, String> {
    let header = set.block("hotend")?;
    Hotend::try_from(RawHotend {
        block_capacity_j_k: header.num("Ce")?,
        nozzle_capacity_j_k: header.num("Cn")?,
        coupling_w_k: header.num("Ken")?,
        block_loss_w_k: header.num("he")?,
        nozzle_loss_w_k: header.num("hn")?,
        block_loss_fan_w_k: header.num("he_fan")?,
        nozzle_loss_fan_w_k: header.num("hn_fan")?,
        heater_power_w: header.num("Pmax")?,
        sensor_lag_s: header.num("tau_s")?,
    })
    .map_err(refused)
}

/// Diameter of a filament with the cross section that the vectors use.
const FILAMENT_DIAMETER_M: f64 = 1.75e-3;

fn raw_extruder(set: &Set) -> Result<RawExtruder, String> {
    let header = set.block("hotend")?;
    Ok(RawExtruder {
        compliance_m_n: header.num("compliance")?,
        linear_lag_s: header.num("Klin")?,
        force_max_n: header.num("Fmax")?,
        melting_flow_m3_s: header.num("qc")?,
        nozzle_radius_m: header.num("R")?,
        nozzle_length_m: header.num("L")?,
        filament_diameter_m: FILAMENT_DIAMETER_M,
        rabinowitsch: false,
    })
}

fn melt(set: &Set, given: Inputs<'_>, extruder: RawExtruder) -> Result<Melt, String> {
    Ok(Melt::new(&material(set, given)?, &Extruder::try_from(extruder).map_err(refused)?))
}

/// Heater off and filament at ambient where the vector says nothing else.
fn heat_inputs(set: &Set, given: Inputs<'_>) -> Result<HeatInputs, String> {
    let ambient_k = given.num("Tamb_K")?;
    Ok(HeatInputs {
        heater_w: given.num("P_W").unwrap_or(0.0),
        fan: given.num("fan")?,
        ambient_k,
        filament_k: given.num("Tf_K").unwrap_or(ambient_k),
        melt_w_k: given.num("mdot_kg_s")? * material(set, given)?.heat_capacity_j_kg_k,
    })
}

fn thermal_rhs(set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let block_k = given.num("Te_K")?;
    let at = Thermal { block_k, nozzle_k: given.num("Tn_K")?, sensor_k: block_k };
    let rates = hotend(set)?.rhs(at, &heat_inputs(set, given)?);
    Ok(json!({"dTe_K_s": rates.block_k, "dTn_K_s": rates.nozzle_k}))
}

fn thermal_steady(set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let steady = hotend(set)?.steady(given.num("Tn_K")?, &heat_inputs(set, given)?);
    Ok(json!({"Te_K": steady.block_k, "P_W": steady.heater_w}))
}

/// In steps of 50 ms, the longest that the plant may take.
fn thermal_trajectory(set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let (hotend, acting) = (hotend(set)?, heat_inputs(set, given)?);
    let mut at = Thermal {
        block_k: given.num("Te0_K")?,
        nozzle_k: given.num("Tn0_K")?,
        sensor_k: given.num("Ts0_K")?,
    };
    let mut left_s = given.num("t_s")?;
    while left_s > 1e-9 {
        let dt_s = left_s.min(0.05);
        at = hotend.step(at, &acting, Seconds(dt_s));
        left_s -= dt_s;
    }
    Ok(json!({"Te_K": at.block_k, "Tn_K": at.nozzle_k, "Ts_K": at.sensor_k}))
}

fn rheology(set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let extruder = RawExtruder {
        nozzle_length_m: given.num("L_m")?,
        nozzle_radius_m: given.num("R_m")?,
        ..raw_extruder(set)?
    };
    let paper = melt(set, given, extruder)?;
    let corrected = melt(set, given, RawExtruder { rabinowitsch: true, ..extruder })?;
    let (flow, temp) = (given.num("q_m3_s")?, Kelvin(given.num("T_K")?));
    Ok(json!({
        "K_Pa_sn": paper.consistency_pa_sn(temp),
        "gamma_1_s": paper.shear_rate_1_s(flow),
        "eta_Pa_s": paper.viscosity_pa_s(flow, temp),
        "dp_Pa": paper.pressure_pa(flow, temp),
        "dp_rabinowitsch_Pa": corrected.pressure_pa(flow, temp),
        "force_N": paper.force_n(flow, temp),
    }))
}

fn flow_from_pressure(set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let flow =
        melt(set, given, raw_extruder(set)?)?.flow_m3_s(given.num("dp_Pa")?, Kelvin(given.num("T_K")?));
    Ok(json!({"q_m3_s": flow}))
}

fn melt_temp(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let (nozzle, filament) = (Kelvin(given.num("Tn_K")?), Kelvin(given.num("Tf_K")?));
    let temp = melt_temperature(nozzle, filament, given.num("q_m3_s")?, given.num("qc_m3_s")?);
    Ok(json!({"Tm_K": temp.0}))
}

fn q_max(set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let extruder = RawExtruder { force_max_n: given.num("Fmax_N")?, ..raw_extruder(set)? };
    let (nozzle, filament) = (Kelvin(given.num("Tn_K")?), Kelvin(given.num("Tf_K")?));
    Ok(json!({"q_m3_s": melt(set, given, extruder)?.flow_max_m3_s(nozzle, filament, given.num("margin")?)}))
}

fn bead_rect(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let (width, speed, height) = (given.num("w_m")?, given.num("v_m_s")?, given.num("h_m")?);
    let flow = rectangle::flow_m3_s(width, speed, height);
    let slopes = rectangle::sensitivities(flow, speed, height);
    Ok(json!({
        "q_m3_s": flow,
        "w_from_q_m": rectangle::width_m(flow, speed, height),
        "dw_dq_s_m2": slopes.to_flow_s_m2,
        "dw_dv_s": slopes.to_speed_s,
        "dw_dh": slopes.to_height,
    }))
}

fn bead_stadium(set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let (width, speed, height) = (given.num("w_m")?, given.num("v_m_s")?, given.num("h_m")?);
    let flow = stadium::flow_m3_s(width, speed, height);
    let extruder = Extruder::try_from(raw_extruder(set)?).map_err(refused)?;
    Ok(json!({
        "q_m3_s": flow,
        "w_from_q_m": stadium::width_m(flow, speed, height),
        "filament_speed_m_s": flow / extruder.filament_area_m2(),
    }))
}

fn bond(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    Ok(json!({"alpha": adhesion(given.num("t_bond_s")?, given.num("tau_s")?)}))
}

/// The vectors carry no heat transfer: model book 1.2 fixes 60 + 90 fan W/(m2 K).
fn bond_time(set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let cooling =
        Cooling::try_from(RawCooling { still_air_w_m2_k: 60.0, fan_w_m2_k: 90.0 }).map_err(refused)?;
    let bead = LaidBead {
        nozzle_k: given.num("Tn_K")?,
        below_k: given.num("Tsub_K")?,
        ambient_k: given.num("Tamb_K")?,
        height_m: given.num("h_m")?,
        width_m: given.num("w_m")?,
        fan: given.num("fan")?,
    };
    Ok(json!({"t_bond_s": cooling.bond_time_s(&material(set, given)?, &bead)}))
}

fn porosity(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let fill = fill(given.num("V_extr")?, given.num("V_layer")?);
    Ok(json!({"phi": fill.porosity, "overfill": fill.overfill}))
}

fn layer_shift(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let actual_m = [given.num("x_act_m")?, given.num("y_act_m")?];
    let wanted_m = [given.num("x_ref_m")?, given.num("y_ref_m")?];
    Ok(json!({"ds_m": layer_shift_m(actual_m, wanted_m)}))
}

/// The first class is `ok`.
fn probabilities(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let p = softmax::<5>(given.array("logits")?).ok_or("refused")?;
    Ok(json!({"p": p, "p_defect": 1.0 - p[0]}))
}

fn confidence(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let (statistic, threshold) = (given.num("a")?, given.num("tau_a")?);
    let fused = fused_confidence(statistic, threshold, given.num("p_det")?, given.num("beta")?);
    Ok(json!({"c": fused.ok_or("refused")?}))
}

fn terms(given: Inputs<'_>) -> Result<Terms, String> {
    Ok(Terms {
        features: given.num("feat")?,
        width: given.num("w")?,
        temperature: given.num("T")?,
        adhesion: given.num("alpha")?,
        porosity: given.num("phi")?,
    })
}

fn quality(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let quality = Quality::try_from(RawQuality {
        weights: terms(given.block("weights")?)?,
        tolerances: terms(given.block("tolerances")?)?,
    })
    .map_err(refused)?;
    let seen = Observed {
        feature_errors: &given.nums("e_feat")?,
        width_m: given.num("w_m")?,
        width_wanted_m: given.num("wref_m")?,
        temperature_error_k: given.num("Tn_K")? - given.num("Tref_K")?,
        adhesion: given.num("alpha")?,
        porosity: given.num("phi")?,
    };
    Ok(json!({"Q": quality.terms(&seen).total()}))
}
