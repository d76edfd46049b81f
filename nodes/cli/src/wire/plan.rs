//! `fdm wire plan`: what a wire, a metal and a power give.

use super::material;
use crate::config::ConfigDir;
use crate::options::{in_range, positive, significant};
use crate::output::{self, Json};
use anyhow::bail;
use clap::Args;
use models::wire::Limits;
use models::wire::cycle::{Cycle, DIAMETER_RANGE_M, DROP_LENGTH_RANGE_M, Feed, RawFeed};
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

/// A planned speed that the configured machine does not reach.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Beyond {
    /// `wire` or `head`.
    pub speed: &'static str,
    /// `above` or `below`.
    pub side: &'static str,
    /// As planned.
    pub planned_mm_s: f64,
    /// The limit.
    pub limit_mm_s: f64,
    /// File of the limit.
    pub file: String,
}

/// Powers with which all speeds stay within the limits.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Fitting {
    /// Least: of the laser where its power was given, else absorbed.
    pub least_w: f64,
    /// Most.
    pub most_w: f64,
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
    /// Speeds beyond the machine's limits; empty where it can do the plan.
    pub beyond_limits: Vec<Beyond>,
    /// Powers that would fit, where this one does not; absent where none does.
    pub fitting_power: Option<Fitting>,
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
    check(args)?;
    let diameter_m = args.diameter.map_or(process.feed.diameter_m, |mm| 1e-3 * mm);
    let drop_length_m = args.drop_length.map_or(diameter_m, |mm| 1e-3 * mm);
    check_film(args, diameter_m)?;
    // Without a laser's power the absorbed one is given: all of it is absorbed.
    let (power_w, share) = match args.power {
        None => (process.feed.absorbed_w, 1.0),
        Some(power_w) => {
            let share = args.absorptivity.unwrap_or(metal.absorptivity);
            (positive("--power", power_w, "W")?, in_range("--absorptivity", share, "-", (0.001, 1.0))?)
        }
    };
    let absorbed_w = power_w * share;
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
    let file = config.file(PROCESS).display().to_string();
    let beyond_limits = beyond(&process.limits, &cycle, &file);
    let fitting_power = fitting(&process.limits, (&cycle, drop_length_m), (drain_s.unwrap_or(0.0), share))
        .filter(|_| !beyond_limits.is_empty());
    Ok(Plan { beyond_limits, fitting_power, ..figures((name, args.power), &feed, &cycle, drain_s) })
}

/// Where limits of the speeds stand.
const PROCESS: &str = "wire/process.yaml";

/// Ranges of what was typed.
fn check(args: &PlanArgs) -> anyhow::Result<()> {
    let millimetres = |(low_m, high_m): (f64, f64)| (1e3 * low_m, 1e3 * high_m);
    if let Some(mm) = args.diameter {
        in_range("--diameter", mm, "mm", millimetres(DIAMETER_RANGE_M))?;
    }
    if let Some(mm) = args.drop_length {
        in_range("--drop-length", mm, "mm", millimetres(DROP_LENGTH_RANGE_M))?;
    }
    Ok(())
}

/// A film is molten from the wire's surface inwards: no thicker than the wire's radius.
fn check_film(args: &PlanArgs, diameter_m: f64) -> anyhow::Result<()> {
    let Some(film_mm) = args.film else { return Ok(()) };
    positive("--film", film_mm, "mm")?;
    in_range("--film", film_mm, "mm", (0.0, 0.5e3 * diameter_m))?;
    if !(args.angle > 0.0 && args.angle <= 90.0) {
        bail!("--angle {} deg: must be in (0, 90] deg", args.angle);
    }
    Ok(())
}

/// Powers whose drops take as long as the limits of both speeds allow; none where no time suits both.
fn fitting(
    limits: &Limits,
    (cycle, drop_length_m): (&Cycle, f64),
    (drain_s, share): (f64, f64),
) -> Option<Fitting> {
    let shortest_s = (drop_length_m / limits.wire_high_m_s).max(cycle.pitch_m / limits.head_high_m_s);
    let longest_s = (drop_length_m / limits.wire_low_m_s).min(cycle.pitch_m / limits.head_low_m_s);
    let power_w = |period_s: f64| cycle.energy_j / (period_s - drain_s) / share;
    (drain_s < shortest_s && shortest_s <= longest_s)
        .then(|| Fitting { least_w: power_w(longest_s), most_w: power_w(shortest_s) })
}

/// Speeds of a drop that the limits do not allow.
fn beyond(limits: &Limits, cycle: &Cycle, file: &str) -> Vec<Beyond> {
    let speeds = [
        ("wire", cycle.wire_m_s, (limits.wire_low_m_s, limits.wire_high_m_s)),
        ("head", cycle.head_m_s, (limits.head_low_m_s, limits.head_high_m_s)),
    ];
    let beyond = speeds.into_iter().filter_map(|(speed, planned_m_s, (low_m_s, high_m_s))| {
        let (side, limit_m_s) = if planned_m_s > high_m_s {
            ("above", high_m_s)
        } else if planned_m_s < low_m_s {
            ("below", low_m_s)
        } else {
            return None;
        };
        let (planned_mm_s, limit_mm_s) = (1e3 * planned_m_s, 1e3 * limit_m_s);
        Some(Beyond { speed, side, planned_mm_s, limit_mm_s, file: file.to_owned() })
    });
    beyond.collect()
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
        beyond_limits: Vec::new(),
        fitting_power: None,
    }
}

fn text(plan: &Plan) -> String {
    let power = plan.power_w.map_or_else(String::new, |power_w| format!(" of {power_w:.0} W"));
    let drain = plan
        .drain_s
        .map_or_else(String::new, |drain_s| format!(", {} ms of it drainage", significant(1e3 * drain_s, 4)));
    let figures = format!(
        "wire         {} {:.3} mm, {:.3} mm a drop\n\
         power        {:.1} W absorbed{power}, losses not counted\n\
         drop         {} mm3, {} J, {} s{drain}\n\
         layer        {:.3} mm high, bead {:.3} mm2, a drop every {:.3} mm\n\
         wire speed   {:.3} mm/s\n\
         head speed   {:.3} mm/s",
        plan.material,
        plan.diameter_mm,
        plan.drop_length_mm,
        plan.absorbed_w,
        significant(plan.drop_volume_mm3, 4),
        significant(plan.energy_j, 4),
        significant(plan.period_s, 4),
        plan.layer_height_mm,
        plan.bead_section_mm2,
        plan.pitch_mm,
        plan.wire_mm_s,
        plan.head_mm_s,
    );
    let warning = |beyond: &Beyond| {
        format!(
            "\nwarning      {} speed {:.3} mm/s is {} the limit {:.3} mm/s of {}",
            beyond.speed, beyond.planned_mm_s, beyond.side, beyond.limit_mm_s, beyond.file
        )
    };
    let fitting = match plan.fitting_power {
        _ if plan.beyond_limits.is_empty() => String::new(),
        None => "\nwarning      no power keeps both speeds within these limits".to_owned(),
        Some(Fitting { least_w, most_w }) => format!(
            "\nwarning      {} W to {} W {} would fit",
            significant(least_w, 4),
            significant(most_w, 4),
            if plan.power_w.is_some() { "of laser power" } else { "absorbed" }
        ),
    };
    figures + &plan.beyond_limits.iter().map(warning).collect::<String>() + &fitting
}

#[cfg(test)]
mod tests;
