//! `fdm kinematics map`: the error over a part.

use super::{MachineArgs, picture, stl};
use crate::output::{self, Json};
use crate::process::Picture;
use clap::Args;
use models::hybrid::published::Published;
use models::hybrid::{AxisError, Cell, ErrorMap, Geometry, Mesh, Refused, SurfacePoint};
use models::params::{in_range, positive};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

/// Maps the worst error; without an STL file over height and angle on the paper's hemisphere.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct MapArgs {
    /// Part: a closed mesh, binary or ASCII; it is placed on the middle of the table.
    #[arg(long)]
    stl: Option<PathBuf>,
    /// Length of one unit of the file `[mm]`.
    #[arg(long, default_value_t = 1.0)]
    unit: f64,
    /// Full step of the motors `[deg]`.
    #[arg(long, default_value_t = 1.8)]
    step: f64,
    /// Microsteps per full step; every motor is wrong by one of them.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=65536))]
    microsteps: u32,
    /// Draw into a file that ends in .svg or .html.
    #[arg(long)]
    picture: Option<PathBuf>,
    #[command(flatten)]
    machine: MachineArgs,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// The figures of a part.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PartFigures {
    /// Machine.
    pub machine: String,
    /// Where its geometry comes from.
    pub provenance: String,
    /// Angle by which every motor is wrong.
    pub angle_deg: f64,
    /// Triangles of the part.
    pub triangles: usize,
    /// Its volume.
    pub volume_mm3: f64,
    /// Its surface.
    pub area_mm2: f64,
    /// Share of the surface that the machine can work on.
    pub workable_share: f64,
    /// Mean of the worst error over that share.
    pub mean_mm: f64,
    /// Error that 95 % of that share stay below.
    pub p95_mm: f64,
    /// Largest error.
    pub largest_mm: Option<f64>,
    /// Where it is, in the part's frame.
    pub largest_at_mm: Option<[f64; 3]>,
    /// Cells with combinations of signs that have no pose on the nominal branch; their error is a lower bound.
    pub left_branch: usize,
    /// Triangles that the machine refuses, by reason.
    pub refused: BTreeMap<&'static str, usize>,
    /// One refusal of each reason, with value and limit.
    pub refused_examples: BTreeMap<&'static str, String>,
    /// Time of the map itself on one core.
    pub wall_time_s: f64,
}

/// One height and angle on the hemisphere.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spot {
    /// Height.
    pub height_mm: f64,
    /// Angle by which every motor is wrong.
    pub angle_deg: f64,
    /// Worst error; absent where a combination has no pose on the nominal branch.
    pub error_mm: Option<f64>,
}

/// The figures of the hemisphere.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HemisphereFigures {
    /// Machine.
    pub machine: String,
    /// Where its geometry comes from.
    pub provenance: String,
    /// Radius.
    pub radius_mm: f64,
    /// Rows of one angle each, heights rising.
    pub spots: Vec<Spot>,
}

/// Runs the command.
///
/// # Errors
/// A file that is no closed mesh; a value out of range.
pub fn run(args: &MapArgs) -> anyhow::Result<()> {
    let config = args.machine.config()?;
    Json::new(args.json.as_deref()).check()?;
    let geometry = args.machine.geometry(&config)?;
    let picture = args.picture.as_deref().map(Picture::new).transpose()?;
    positive("step_deg", args.step, "deg")?;
    in_range("unit_mm", args.unit, "mm", (1e-6, 1e6))?;
    if let Some(path) = &args.stl {
        return part(args, &geometry, &stl::read(path, 1e-3 * args.unit)?, picture.as_ref());
    }
    let tables: Published = runtime::params::from_yaml(&config.file("machines/published.yaml"))?;
    hemisphere(args, &geometry, tables.radius_m, picture.as_ref())
}

fn part(args: &MapArgs, geometry: &Geometry, mesh: &Mesh, picture: Option<&Picture>) -> anyhow::Result<()> {
    let angle_deg = args.step / f64::from(args.microsteps);
    let error = AxisError::of_motors(angle_deg.to_radians(), geometry.lead_m);
    let started = Instant::now();
    let map = geometry.error_map(mesh, &error);
    let wall_time_s = started.elapsed().as_secs_f64();
    let figures = figures(args, geometry, (mesh, &map), (angle_deg, wall_time_s));
    if let Some(picture) = picture {
        picture::part(picture, mesh, &map)?;
    }
    let json = Json::new(args.json.as_deref());
    if !json.is_stdout() {
        output::line(&text(&figures))?;
    }
    json.write(&figures)
}

fn figures(
    args: &MapArgs,
    geometry: &Geometry,
    (mesh, map): (&Mesh, &ErrorMap),
    (angle_deg, wall_time_s): (f64, f64),
) -> PartFigures {
    let summary = map.summary();
    let (mut refused, mut examples) = (BTreeMap::new(), BTreeMap::new());
    for reason in map.cells.iter().filter_map(|cell| cell.outcome.err()) {
        *refused.entry(kind(&reason)).or_insert(0) += 1;
        examples.entry(kind(&reason)).or_insert_with(|| reason.to_string());
    }
    let left = |cell: &&Cell| cell.outcome.is_ok_and(|at| at.extremal.failed > 0);
    PartFigures {
        machine: args.machine.machine.clone(),
        provenance: geometry.provenance.clone(),
        angle_deg,
        triangles: map.cells.len(),
        volume_mm3: 1e9 * mesh.volume_m3(),
        area_mm2: 1e6 * summary.area_m2,
        workable_share: summary.workable,
        mean_mm: 1e3 * summary.mean_m,
        p95_mm: 1e3 * summary.most_m,
        largest_mm: summary.largest.map(|(error_m, _)| 1e3 * error_m),
        largest_at_mm: summary.largest.map(|(_, cell)| (1e3 * map.cells[cell].centre_m).into()),
        left_branch: map.cells.iter().filter(left).count(),
        refused,
        refused_examples: examples,
        wall_time_s,
    }
}

/// Name of a reason.
fn kind(reason: &Refused) -> &'static str {
    match reason {
        Refused::NotAPoint { .. } => "not_a_point",
        Refused::Tilt { .. } => "tilt",
        Refused::Unreachable { .. } => "unreachable",
        Refused::Travel { .. } => "travel",
        Refused::Singular { .. } => "singular",
        _ => "other",
    }
}

fn text(figures: &PartFigures) -> String {
    let mut lines = vec![
        format!("machine      {}: geometry {}", figures.machine, figures.provenance),
        format!(
            "part         {} triangles, {:.0} mm3, {:.0} mm2",
            figures.triangles, figures.volume_mm3, figures.area_mm2
        ),
        format!("motors       each wrong by {:.5} degrees, worst combination of signs", figures.angle_deg),
        format!("workable     {:.1} % of the surface", 100.0 * figures.workable_share),
        format!("error        mean {:.4} mm, 95 % below {:.4} mm", figures.mean_mm, figures.p95_mm),
    ];
    if let (Some(error_mm), Some([x, y, z])) = (figures.largest_mm, figures.largest_at_mm) {
        lines.push(format!("largest      {error_mm:.4} mm at ({x:.1}, {y:.1}, {z:.1}) mm"));
    }
    if figures.left_branch > 0 {
        lines.push(format!("branch       {} cells lose their pose in some combination", figures.left_branch));
    }
    for (kind, count) in &figures.refused {
        let example = figures.refused_examples.get(kind).map_or("", String::as_str);
        lines.push(format!("refused      {count} triangles: {kind}; one has {example}"));
    }
    lines.push(format!("wall time    {:.3} s on one core", figures.wall_time_s));
    lines.join("\n")
}

/// Heights of the hemisphere's map.
const HEIGHTS: u32 = 31;
/// Angles: a full step, halved again and again.
const HALVINGS: u32 = 9;

fn hemisphere(
    args: &MapArgs,
    geometry: &Geometry,
    radius_m: f64,
    picture: Option<&Picture>,
) -> anyhow::Result<()> {
    let mut spots = Vec::new();
    for halving in 0..HALVINGS {
        let angle_deg = args.step / f64::from(1_u32 << halving);
        let error = AxisError::of_motors(angle_deg.to_radians(), geometry.lead_m);
        for index in 0..HEIGHTS {
            let height_m = radius_m * f64::from(index) / f64::from(HEIGHTS - 1);
            let worst = geometry.station(&SurfacePoint::on_hemisphere(radius_m, height_m)?)?.extremal(&error);
            let error_mm = (worst.failed == 0).then_some(1e3 * worst.largest_m);
            spots.push(Spot { height_mm: 1e3 * height_m, angle_deg, error_mm });
        }
    }
    let figures = HemisphereFigures {
        machine: args.machine.machine.clone(),
        provenance: geometry.provenance.clone(),
        radius_mm: 1e3 * radius_m,
        spots,
    };
    if let Some(picture) = picture {
        picture::hemisphere(picture, &figures.spots)?;
    }
    let json = Json::new(args.json.as_deref());
    if !json.is_stdout() {
        output::line(&hemisphere_text(&figures))?;
    }
    json.write(&figures)
}

fn hemisphere_text(figures: &HemisphereFigures) -> String {
    let mut lines = vec![
        format!("machine      {}: geometry {}", figures.machine, figures.provenance),
        format!(
            "hemisphere   radius {:.1} mm; worst error [mm] over height and motor angle",
            figures.radius_mm
        ),
    ];
    let width = HEIGHTS as usize;
    let shown = || (0..width).step_by(5);
    let head: Vec<String> = shown().map(|index| format!("{:>9.1}", figures.spots[index].height_mm)).collect();
    lines.push(format!("{:>12} {}", "deg \\ z mm", head.join(" ")));
    for row in figures.spots.chunks(width) {
        let cells: Vec<String> = shown()
            .map(|index| row[index].error_mm.map_or_else(|| format!("{:>9}", "-"), |mm| format!("{mm:>9.4}")))
            .collect();
        lines.push(format!("{:>12.5} {}", row[0].angle_deg, cells.join(" ")));
    }
    lines.join("\n")
}
