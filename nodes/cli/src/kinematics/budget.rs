//! `fdm kinematics budget`: how far a layer may lie off that the machine alone explains, as two parameters.

use super::{MachineArgs, stl};
use crate::output::{self, Json};
use anyhow::bail;
use clap::Args;
use models::hybrid::published::Published;
use models::hybrid::{AxisError, CARRIAGES, Station, SurfacePoint};
use models::params::{in_range, positive};
use serde::Serialize;
use std::path::PathBuf;

/// Largest offset between two layers that wrong motors explain, for the parameters `machine` and
/// `shift.machine_error_m`.
#[derive(Debug, Args)]
pub struct BudgetArgs {
    /// Part: a closed mesh, binary or ASCII; the paper's hemisphere without it.
    #[arg(long)]
    stl: Option<PathBuf>,
    /// Length of one unit of the file `[mm]`.
    #[arg(long, default_value_t = 1.0)]
    unit: f64,
    /// Full step of the motors `[deg]`; each is wrong by the machine file's part of it.
    #[arg(long, default_value_t = 1.8)]
    step: f64,
    /// Points of the surface below this height are left out `[mm]`.
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
    /// Points that the machine refuses, or where a combination of signs loses the nominal branch.
    pub left_out: usize,
    /// Largest lateral error of a point, over all combinations of signs.
    pub lateral_mm: f64,
    /// Block `machine` of `defect_classifier`.
    pub defect_classifier: MachineBlock,
    /// `shift.machine_error_m` of `safety_supervisor`: the same number.
    pub safety_supervisor_machine_error_m: f64,
}

/// Heights of the hemisphere.
const HEIGHTS: u32 = 61;
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
    positive("step_deg", args.step, "deg")?;
    in_range("unit_mm", args.unit, "mm", (1e-6, 1e6))?;
    in_range("from_height_mm", args.from_height, "mm", (0.0, 1e4))?;
    let geometry = args.machine.geometry(&config)?;
    let angle_deg = args.step * args.machine.choices(&config)?.motor_error;
    let error = AxisError::of_motors(angle_deg.to_radians(), geometry.lead_m);
    let tables: Published = runtime::params::from_yaml(&config.file("machines/published.yaml"))?;
    let points = points(args, tables.radius_m)?;
    let laterals: Vec<f64> = points
        .iter()
        .filter_map(|point| geometry.station(point).ok())
        .filter_map(|station| lateral_m(&station, &error))
        .collect();
    let largest_m = laterals.iter().copied().fold(0.0, f64::max);
    // Of two layers either may be off, in opposite directions: an axis' error changes its sign within a step.
    let error_m = (2.0 * largest_m / GRAIN_M).ceil() * GRAIN_M;
    if laterals.is_empty() {
        bail!("--from-height {}: no point above it that the machine can work on", args.from_height);
    }
    // What the supervisor takes: a larger budget would hide any shift.
    in_range("machine_error_m", error_m, "m", (0.0, 0.01))?;
    let figures = BudgetFigures {
        machine: args.machine.machine.clone(),
        provenance: geometry.provenance.clone(),
        angle_deg,
        points: points.len(),
        left_out: points.len() - laterals.len(),
        lateral_mm: 1e3 * largest_m,
        defect_classifier: MachineBlock { error_known: true, error_m },
        safety_supervisor_machine_error_m: error_m,
    };
    if !json.is_stdout() {
        output::line(&text(&figures))?;
    }
    json.write(&figures)
}

fn points(args: &BudgetArgs, radius_m: f64) -> anyhow::Result<Vec<SurfacePoint>> {
    let lowest_m = 1e-3 * args.from_height;
    if let Some(path) = &args.stl {
        let mesh = stl::read(path, 1e-3 * args.unit)?;
        let centres = mesh.triangles().iter().map(|triangle| SurfacePoint {
            position_m: (triangle[0] + triangle[1] + triangle[2]) / 3.0,
            normal: (triangle[1] - triangle[0]).cross(&(triangle[2] - triangle[0])),
        });
        return Ok(centres.filter(|point| point.position_m.z >= lowest_m).collect());
    }
    let heights = (0..HEIGHTS).map(|index| radius_m * f64::from(index) / f64::from(HEIGHTS - 1));
    let points = heights
        .filter(|height_m| *height_m >= lowest_m)
        .map(|height_m| Ok(SurfacePoint::on_hemisphere(radius_m, height_m)?));
    points.collect()
}

/// Largest error across the extruder's axis over all signs `[m]`, where a camera at the extruder looks for an offset;
/// none where a combination has no pose on the nominal branch.
fn lateral_m(station: &Station<'_>, error: &AxisError) -> Option<f64> {
    let mut largest_m = 0.0_f64;
    for combination in 0..1_u32 << (CARRIAGES + 1) {
        let sign = |bit: usize| if combination >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let carriages_m: [f64; CARRIAGES] = std::array::from_fn(|bit| sign(bit) * error.carriage_m);
        let shift = station.shift(&carriages_m, sign(CARRIAGES) * error.table_rad).ok()?;
        largest_m = largest_m.max(shift.vector_m.x.hypot(shift.vector_m.y));
    }
    Some(largest_m)
}

fn text(figures: &BudgetFigures) -> String {
    let error_m = figures.safety_supervisor_machine_error_m;
    [
        format!("machine      {}: geometry {}", figures.machine, figures.provenance),
        format!("motors       each wrong by {:.4} degrees, worst combination of signs", figures.angle_deg),
        format!("points       {} of the surface, {} left out", figures.points, figures.left_out),
        format!("lateral      at most {:.4} mm; between two layers twice that", figures.lateral_mm),
        String::new(),
        "# defect_classifier".to_owned(),
        format!("    machine: {{error_known: true, error_m: {error_m:.6}}}"),
        "# safety_supervisor, block shift".to_owned(),
        format!("      machine_error_m: {error_m:.6}"),
    ]
    .join("\n")
}
