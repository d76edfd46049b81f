//! `fdm kinematics budget`: how far a layer may lie off that the machine alone explains, as two parameters.

use super::{MachineArgs, PartArgs, unlikely_size};
use crate::options::in_range;
use crate::output::{self, Json};
use anyhow::bail;
use clap::Args;
use models::hybrid::published::Published;
use models::hybrid::{AxisError, Ends, Geometry, Laterals, Mesh, SurfacePoint};
use models::params;
use serde::Serialize;
use std::path::PathBuf;

/// Largest offset between two layers that wrong motors explain, for the parameters `machine` and
/// `shift.machine_error_m`; every motor is wrong by the machine file's part of a step.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct BudgetArgs {
    #[command(flatten)]
    part: PartArgs,
    /// Points of the surface below this height are left out `[mm]`; how many is said.
    #[arg(long, default_value_t = 15.0)]
    from_height: f64,
    #[command(flatten)]
    machine: MachineArgs,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// What `defect_classifier` publishes beside Q_k.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MachineBlock {
    /// A budget is known.
    pub error_known: bool,
    /// The budget `[m]`.
    pub error_m: f64,
}

/// The figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BudgetFigures {
    /// Machine.
    pub machine: String,
    /// Where its geometry comes from.
    pub provenance: String,
    /// Angle by which every motor is wrong.
    pub angle_deg: f64,
    /// Points of the surface that were looked at.
    pub points: usize,
    /// Longest edge of the pieces of the surface whose centres they are; absent for the hemisphere.
    pub edge_mm: Option<f64>,
    /// Height below which nothing was looked at.
    pub from_height_mm: f64,
    /// Points below it.
    pub below: usize,
    /// Points of the face that the part stands on.
    pub on_the_table: usize,
    /// Points above the height that the machine refuses, or where a combination of signs loses the nominal branch.
    pub left_out: usize,
    /// Share of the surface above the height that these are.
    pub left_out_share: f64,
    /// Largest lateral error of a point, over all combinations of signs.
    pub lateral_mm: f64,
    /// Where it lies: `inside`, at the height `cut`, or at the end of the machine's `reach`.
    pub largest_at: &'static str,
    /// What does not fit the machine about the part.
    pub warning: Option<String>,
    /// Block `machine` of `defect_classifier`.
    pub defect_classifier: MachineBlock,
    /// `shift.machine_error_m` of `safety_supervisor`: the same number.
    pub safety_supervisor_machine_error_m: f64,
}

/// Heights of the hemisphere, from the cut to the pole.
const HEIGHTS: u32 = 61;
/// A part's surface is looked at in pieces with no edge longer than this `[m]`.
const EDGE_M: f64 = 1e-3;
/// Most of them: on larger parts the edges are longer. Some seconds.
const MOST: usize = 20_000;
/// Fewer points than these are no surface.
const FEWEST: usize = 30;
/// The parameters are written in whole micrometres, rounded up.
const GRAIN_M: f64 = 1e-6;

/// Runs the command.
///
/// # Errors
/// A file that is no closed mesh, a value out of range, a surface without a point that the machine can work on.
pub fn run(args: &BudgetArgs) -> anyhow::Result<()> {
    let config = args.machine.config()?;
    let json = Json::new(args.json.as_deref());
    json.check()?;
    args.part.check()?;
    in_range("--from-height", args.from_height, "mm", (0.0, 1e4))?;
    let geometry = args.machine.geometry(&config)?;
    let angle_deg = args.part.step * args.machine.choices(&config)?.motor_error;
    let error = AxisError::of_motors(angle_deg.to_radians(), geometry.lead_m);
    let tables: Published = runtime::params::from_yaml(&config.file("machines/published.yaml"))?;
    let mesh = args.part.mesh()?;
    let surface = surface(args, (&geometry, mesh.as_ref(), tables.radius_m), &error)?;
    let found = &surface.found;
    let Some((largest_m, ends)) = found.largest.filter(|_| found.counted >= FEWEST) else {
        bail!(
            "--from-height {} mm: {} points above it that the machine can work on, must be {FEWEST} or more \
             ({} points lie below it, the machine refuses {})",
            args.from_height,
            found.counted,
            found.below,
            found.refused
        );
    };
    // Of two layers either may be off, in opposite directions: an axis' error changes its sign within a step.
    let error_m = (2.0 * largest_m / GRAIN_M).ceil() * GRAIN_M;
    // What the supervisor takes: a larger budget would hide any shift.
    params::in_range("machine_error_m", error_m, "m", (0.0, 0.01))?;
    let figures = BudgetFigures {
        machine: args.machine.machine.clone(),
        provenance: geometry.provenance.clone(),
        angle_deg,
        points: found.counted + found.refused,
        edge_mm: surface.edge_m.map(|edge_m| 1e3 * edge_m),
        from_height_mm: args.from_height,
        below: found.below,
        on_the_table: found.on_table,
        left_out: found.refused,
        left_out_share: found.refused_share,
        lateral_mm: 1e3 * largest_m,
        largest_at: match ends {
            Ends::Inside => "inside",
            Ends::Cut => "cut",
            Ends::Reach => "reach",
        },
        warning: mesh.as_ref().and_then(|mesh| unlikely_size(mesh, &geometry)),
        defect_classifier: MachineBlock { error_known: true, error_m },
        safety_supervisor_machine_error_m: error_m,
    };
    if !json.is_stdout() {
        output::line(&text(&figures))?;
    }
    json.write(&figures)
}

/// What was looked at.
struct Surface {
    found: Laterals,
    edge_m: Option<f64>,
}

fn surface(
    args: &BudgetArgs,
    (geometry, mesh, radius_m): (&Geometry, Option<&Mesh>, f64),
    error: &AxisError,
) -> anyhow::Result<Surface> {
    let lowest_m = 1e-3 * args.from_height;
    if let Some(mesh) = mesh {
        let sampling = mesh.sampled(EDGE_M, MOST);
        let found = geometry.laterals(&sampling, lowest_m, error);
        return Ok(Surface { found, edge_m: Some(sampling.edge_m) });
    }
    in_range("--from-height", args.from_height, "mm", (0.0, 1e3 * radius_m))?;
    // All meridians are alike: heights alone are a surface.
    let height_m = |index| lowest_m + (radius_m - lowest_m) * f64::from(index) / f64::from(HEIGHTS - 1);
    let points =
        (0..HEIGHTS).map(|index| Ok(SurfacePoint::on_hemisphere(radius_m, height_m(index).min(radius_m))?));
    let points = points.collect::<anyhow::Result<Vec<_>>>()?;
    Ok(Surface { found: geometry.laterals_of(&points, error), edge_m: None })
}

fn text(figures: &BudgetFigures) -> String {
    let error_m = figures.safety_supervisor_machine_error_m;
    let surface = figures.edge_mm.map_or_else(
        || format!("{} of one meridian, evenly over the height", figures.points),
        |edge_mm| format!("{} of the surface, one a piece with edges up to {edge_mm:.2} mm", figures.points),
    );
    let height_mm = figures.from_height_mm;
    let cut = figures.edge_mm.map_or_else(
        || format!("nothing below {height_mm} mm is looked at (--from-height)"),
        |_| {
            let all = figures.below + figures.points;
            format!(
                "{} of {all} points lie below {height_mm} mm and are left out (--from-height), {} more on the table",
                figures.below, figures.on_the_table
            )
        },
    );
    let warning = figures.warning.as_ref().map(|warning| format!("warning      {warning}"));
    let lines = [
        format!("machine      {}: geometry {}", figures.machine, figures.provenance),
        format!("motors       each wrong by {:.4} degrees, worst combination of signs", figures.angle_deg),
        format!("height cut   {cut}"),
        format!(
            "points       {surface}; the machine refuses {}, {:.1} % of that surface",
            figures.left_out,
            100.0 * figures.left_out_share
        ),
        format!("lateral      at most {:.4} mm; between two layers twice that", figures.lateral_mm),
        format!("             {}", where_it_lies(figures.largest_at)),
        String::new(),
        "# config/defect_classifier.param.yaml: replaces the lines of the block 'machine' there".to_owned(),
        "    machine:".to_owned(),
        "      error_known: true".to_owned(),
        format!("      error_m: {error_m:.6}"),
        "# config/safety_supervisor.param.yaml: replaces the line 'machine_error_m' of the block 'shift' there".to_owned(),
        format!("      machine_error_m: {error_m:.6}"),
    ];
    warning.into_iter().chain(lines).collect::<Vec<_>>().join("\n")
}

/// What decides the figure, for people.
fn where_it_lies(largest_at: &str) -> &'static str {
    match largest_at {
        "cut" => "it lies at the height cut: a lower one makes it larger",
        "reach" => {
            "it lies where the machine's reach ends: its limits decide it, above all the guard before singular poses \
             (condition_max, gain_max)"
        }
        _ => "it lies inside of the surface",
    }
}
