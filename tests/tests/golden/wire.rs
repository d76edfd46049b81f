//! System 3: metal wire, laser, drop by drop.

use models::wire::drop::{cap_lower_limit_m, cap_m3};
use models::wire::melting::Film;
use models::wire::{Feed, Law, Material, Mode, RawFeed, RawLaw, RawMaterial};
use serde_json::{Value, json};

use super::vector::{Handler, Inputs, Set};

pub(crate) fn handler(function: &str) -> Option<Handler> {
    Some(match function {
        "drop_cycle" => drop_cycle,
        "film" => film,
        "cap_lower_limit" => cap_lower_limit,
        "height_correction" => height_correction,
        "paper_table" => paper_table,
        _ => return None,
    })
}

fn refused(error: impl std::fmt::Display) -> String {
    format!("refused: {error}")
}

fn aluminium(set: &Set) -> Result<Material, String> {
    let given = set.block("aluminium")?;
    Material::try_from(RawMaterial {
        density_kg_m3: given.num("rho")?,
        heat_capacity_j_kg_k: given.num("c")?,
        fusion_j_kg: given.num("lam")?,
        melting_k: given.num("T_melt")?,
        start_k: given.num("T0")?,
        viscosity_pa_s: given.num("mu")?,
        melt_density_kg_m3: given.num("rho_liq")?,
        // The vectors give the absorbed power.
        absorptivity: 1.0,
    })
    .map_err(refused)
}

fn drop_cycle(set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    if given.text("material")? != "Al" || given.optional("film")?.is_some() {
        return Err("only aluminium without a film is known".into());
    }
    let feed = Feed::try_from(RawFeed {
        diameter_m: given.num("d_m")?,
        drop_length_m: given.num("h_wire_m")?,
        absorbed_w: given.num("P_abs_W")?,
        spacing: given.num("kc")?,
    })
    .map_err(refused)?;
    let cycle = feed.cycle(&aluminium(set)?, None).map_err(refused)?;
    Ok(json!({
        "mass_kg": cycle.mass_kg,
        "energy_J": cycle.energy_j,
        "t_total_s": cycle.period_s,
        "V_drop_m3": cycle.volume_m3,
        "R_m": cycle.radius_m,
        "V_missing_m3": cycle.missing_m3,
        "a_uncorrected_m": cycle.uncorrected_m,
        "a_m": cycle.pitch_m,
        "v_wire_m_s": cycle.wire_m_s,
        "v_head_m_s": cycle.head_m_s,
        "bead_area_m2": cycle.section_m2,
    }))
}

fn film(set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    // Inputs and header say the same of the melt; a vector that changes one of them has to be met too.
    let (density, viscosity) = (given.num("rho_kg_m3")?, given.num("mu_Pa_s")?);
    if (set.block("aluminium")?.num("rho_liq")? - density).abs() > 0.0 {
        return Err("not the melt of the header".into());
    }
    let film = Film {
        thickness_m: given.num("h_film_m")?,
        incline_rad: given.num("theta_deg")?.to_radians(),
        path_m: given.num("path_m")?,
    };
    Ok(json!({
        "v_mean_m_s": film.speed_m_s(density, viscosity).map_err(refused)?,
        "t_drain_s": film.drain_s(density, viscosity).map_err(refused)?,
    }))
}

fn cap_lower_limit(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let radius_m = given.num("R_m")?;
    let lower_m = cap_lower_limit_m(radius_m, given.num("V_m3")?).map_err(refused)?;
    Ok(json!({
        "a_m": lower_m,
        "a_over_R": lower_m / radius_m,
        "roundtrip_V_m3": cap_m3(radius_m, lower_m),
    }))
}

fn law(gain: f64, (height_m, wire_m_s, head_m_s): (f64, f64, f64)) -> Result<Law, String> {
    let split = 2.0 / 3.0;
    let raw = RawLaw { height_m, wire_m_s, head_m_s, gain, split, ratio_low: 0.2, ratio_high: 1.8 };
    Law::try_from(raw).map_err(refused)
}

fn height_correction(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    if given.text("kappa")? != "2/3*v_head0/v_wire0" {
        return Err("another kappa".into());
    }
    if (given.num("rmin")? - 0.2).abs() > 0.0 || (given.num("rmax")? - 1.8).abs() > 0.0 {
        return Err("another range".into());
    }
    let nominal = (given.num("h0_m")?, given.num("v_wire0_m_s")?, given.num("v_head0_m_s")?);
    let law = law(given.num("g")?, nominal)?;
    let corrected = law.correct(Mode::Both, given.num("h_meas_m")?).map_err(refused)?;
    Ok(json!({
        "v_wire_m_s": corrected.wire_m_s,
        "v_head_m_s": corrected.head_m_s,
        "area_ratio": corrected.section_ratio,
    }))
}

/// The law with the gain of the model book, at the heights of the table.
fn paper_table(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let law = law(0.635, (2.16e-3, 3.5e-3, 1.68e-3))?;
    let rows = given
        .nums("h_mm")?
        .iter()
        .map(|height_mm| law.correct(Mode::Both, 1e-3 * height_mm).map_err(refused))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(json!({
        "v_wire_mm_s": rows.iter().map(|row| 1e3 * row.wire_m_s).collect::<Vec<_>>(),
        "v_head_mm_s": rows.iter().map(|row| 1e3 * row.head_m_s).collect::<Vec<_>>(),
    }))
}
