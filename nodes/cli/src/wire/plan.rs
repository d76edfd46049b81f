//! `fdm wire plan`: what a wire, a metal and a power give.

use super::material;
use crate::config::ConfigDir;
use crate::output::{self, Json};
use clap::Args;
use models::params::{in_range, positive};
use models::wire::cycle::{Cycle, Feed, RawFeed};
use models::wire::melting::Film;
use serde::Serialize;
use std::path::PathBuf;

/// Plans the speeds; losses are in no equation, so the absorbed power is the least that is needed.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct PlanArgs {
    /// Metal of config/wire/materials.yaml.
    #[arg(long)]
    material: Option<String>,
    /// Diameter of the wire `[mm]`.
    #[arg(long)]
    diameter: Option<f64>,
    /// Length of wire that makes one drop `[mm]`; the diameter if not given.
    #[arg(long)]
    drop_length: Option<f64>,
    /// Power of the laser `[W]`; the absorbed power of config/wire/process.yaml if not given.
    #[arg(long)]
    power: Option<f64>,
    /// Share of the power that the wire takes up `[-]`; the metal's if not given.
    #[arg(long, requires = "power")]
    absorptivity: Option<f64>,
    /// Thickness of the molten film `[mm]`; without it drainage is left out.
    #[arg(long)]
    film: Option<f64>,
    /// Inclination of the wire against the horizontal `[deg]`, for the film.
    #[arg(long, default_value_t = 90.0, requires = "film")]
    angle: f64,
    /// Folder with the parameter files.
    #[arg(long)]
    config: Option<PathBuf>,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// The figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plan {
    /// Metal.
    pub material: String,
    /// Diameter of the wire.
    pub diameter_mm: f64,
    /// Length of wire per drop.
    pub drop_length_mm: f64,
    /// Power of the laser; absent where the absorbed one was taken.
    pub power_w: Option<f64>,
    /// Power that the wire takes up.
    pub absorbed_w: f64,
    /// Energy per drop.
    pub energy_j: f64,
    /// Time per drop.
    pub period_s: f64,
    /// Part of it for drainage.
    pub drain_s: Option<f64>,
    /// Volume of a drop.
    pub drop_volume_mm3: f64,
    /// Radius of a drop and height of a layer.
    pub layer_height_mm: f64,
    /// Way of the head per drop.
    pub pitch_mm: f64,
    /// Cross section of the bead.
    pub bead_section_mm2: f64,
    /// Speed of the wire.
    pub wire_mm_s: f64,
    /// Speed of the head.
    pub head_mm_s: f64,
}

/// Runs the command.
///
/// # Errors
/// One line with the value and its limit.
pub fn run(args: &PlanArgs) -> anyhow::Result<()> {
    let config = ConfigDir::find(args.config.as_deref())?;
    let json = Json::new(args.json.as_deref());
    json.check()?;
    let plan = plan(args, &config)?;
    if !json.is_stdout() {
        output::line(&text(&plan))?;
    }
    json.write(&plan)
}

fn plan(args: &PlanArgs, config: &ConfigDir) -> anyhow::Result<Plan> {
    let process = super::nominal(config)?;
    let name = args.material.clone().unwrap_or(process.material);
    let metal = material(config, &name)?;
    let diameter_m = args.diameter.map_or(process.feed.diameter_m, |mm| 1e-3 * mm);
    let drop_length_m = args.drop_length.map_or(diameter_m, |mm| 1e-3 * mm);
    let absorbed_w = match args.power {
        None => process.feed.absorbed_w,
        Some(power_w) => {
            let share = args.absorptivity.unwrap_or(metal.absorptivity);
            positive("power_w", power_w, "W")? * in_range("absorptivity", share, "-", (0.001, 1.0))?
        }
    };
    let feed =
        Feed::try_from(RawFeed { diameter_m, drop_length_m, absorbed_w, spacing: process.feed.spacing })?;
    let film = args.film.map(|mm| Film {
        thickness_m: 1e-3 * mm,
        incline_rad: args.angle.to_radians(),
        path_m: drop_length_m,
    });
    let drain = |film: &Film| film.drain_s(metal.melt_density_kg_m3, metal.viscosity_pa_s);
    let drain_s = film.as_ref().map(drain).transpose()?;
    let cycle = feed.cycle(&metal, film.as_ref())?;
    Ok(figures((name, args.power), &feed, &cycle, drain_s))
}

fn figures((name, power_w): (String, Option<f64>), feed: &Feed, cycle: &Cycle, drain_s: Option<f64>) -> Plan {
    Plan {
        material: name,
        diameter_mm: 1e3 * feed.diameter_m,
        drop_length_mm: 1e3 * feed.drop_length_m,
        power_w,
        absorbed_w: feed.absorbed_w,
        energy_j: cycle.energy_j,
        period_s: cycle.period_s,
        drain_s,
        drop_volume_mm3: 1e9 * cycle.volume_m3,
        layer_height_mm: 1e3 * cycle.radius_m,
        pitch_mm: 1e3 * cycle.pitch_m,
        bead_section_mm2: 1e6 * cycle.section_m2,
        wire_mm_s: 1e3 * cycle.wire_m_s,
        head_mm_s: 1e3 * cycle.head_m_s,
    }
}

fn text(plan: &Plan) -> String {
    let power = plan.power_w.map_or_else(String::new, |power_w| format!(" of {power_w:.0} W"));
    let drain =
        plan.drain_s.map_or_else(String::new, |drain_s| format!(", {:.3} ms of it drainage", 1e3 * drain_s));
    format!(
        "wire         {} {:.3} mm, {:.3} mm a drop\n\
         power        {:.1} W absorbed{power}, losses not counted\n\
         drop         {:.3} mm3, {:.3} J, {:.4} s{drain}\n\
         layer        {:.3} mm high, bead {:.3} mm2, a drop every {:.3} mm\n\
         wire speed   {:.3} mm/s\n\
         head speed   {:.3} mm/s",
        plan.material,
        plan.diameter_mm,
        plan.drop_length_mm,
        plan.absorbed_w,
        plan.drop_volume_mm3,
        plan.energy_j,
        plan.period_s,
        plan.layer_height_mm,
        plan.bead_section_mm2,
        plan.pitch_mm,
        plan.wire_mm_s,
        plan.head_mm_s,
    )
}
