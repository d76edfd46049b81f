//! `fdm kinematics map`: the error over a part.

mod hemisphere;

pub use hemisphere::{HemisphereFigures, Spot};

use super::{MachineArgs, PartArgs, picture, unlikely_size};
use crate::options::{needs, significant};
use crate::output::{self, Json};
use crate::process::Picture;
use anyhow::bail;
use clap::Args;
use models::hybrid::published::Published;
use models::hybrid::{AxisError, Cell, ErrorMap, Geometry, Mesh, Refused};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

/// Maps the worst error; without an STL file over height and angle on the paper's hemisphere.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct MapArgs {
    #[command(flatten)]
    part: PartArgs,
    /// Microsteps per full step for a part: every motor is wrong by one of them; 16 if not given. The hemisphere is
    /// mapped over them.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=65536))]
    microsteps: Option<u32>,
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
    /// Pieces of them that the figures of the error are of: their centres were looked at.
    pub points: usize,
    /// Longest edge of a piece of a divided triangle.
    pub edge_mm: f64,
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
    /// Share of the surface that lies on the table.
    pub on_the_table_share: f64,
    /// Largest error, at the end of the machine's reach too.
    pub largest_mm: Option<f64>,
    /// Whether it lies there: the machine's limits then decide it.
    pub largest_at_edge: bool,
    /// Where it is, in the part's frame.
    pub largest_at_mm: Option<[f64; 3]>,
    /// Cells with combinations of signs that have no pose on the nominal branch; their error is a lower bound.
    pub left_branch: usize,
    /// Triangles that the machine refuses, by reason.
    pub refused: BTreeMap<&'static str, usize>,
    /// One refusal of each reason, with value and limit.
    pub refused_examples: BTreeMap<&'static str, String>,
    /// What does not fit the machine about the part.
    pub warning: Option<String>,
    /// Time of the map itself on one core.
    pub wall_time_s: f64,
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
    args.part.check()?;
    needs("--stl", args.part.stl.is_some(), &[("--microsteps", args.microsteps.is_some())])?;
    if let Some(mesh) = args.part.mesh()? {
        return part(args, &geometry, &mesh, picture.as_ref());
    }
    let tables: Published = runtime::params::from_yaml(&config.file("machines/published.yaml"))?;
    hemisphere::run(args, &geometry, tables.radius_m, picture.as_ref())
}

fn part(args: &MapArgs, geometry: &Geometry, mesh: &Mesh, picture: Option<&Picture>) -> anyhow::Result<()> {
    let angle_deg = args.part.step / f64::from(args.microsteps.unwrap_or(MICROSTEPS));
    let error = AxisError::of_motors(angle_deg.to_radians(), geometry.lead_m);
    let started = Instant::now();
    let map = geometry.error_map(mesh, &error);
    let sampling = mesh.sampled(EDGE_M, MOST);
    let pieces = geometry.error_map_of(&sampling, &map, &error);
    let wall_time_s = started.elapsed().as_secs_f64();
    let maps = Maps { mesh, map: &map, pieces: &pieces, edge_m: sampling.edge_m };
    let figures = figures(args, geometry, &maps, (angle_deg, wall_time_s));
    if figures.largest_mm.is_none() {
        bail!("{}", nowhere(&figures));
    }
    if let Some(picture) = picture {
        picture::part(picture, mesh, &map)?;
    }
    let json = Json::new(args.json.as_deref());
    if !json.is_stdout() {
        output::line(&text(&figures))?;
    }
    json.write(&figures)
}

/// Microsteps of usual drivers.
const MICROSTEPS: u32 = 16;
/// A part's surface is looked at in pieces with no edge longer than this `[m]`.
const EDGE_M: f64 = 2e-3;
/// Most of them: on larger parts the edges are longer.
const MOST: usize = 10_000;

/// A part, the errors of its triangles, and those of even pieces.
struct Maps<'a> {
    mesh: &'a Mesh,
    map: &'a ErrorMap,
    pieces: &'a ErrorMap,
    edge_m: f64,
}

/// Why there is no error to map.
fn nowhere(figures: &PartFigures) -> String {
    let reasons = figures.refused.iter().map(|(kind, count)| {
        let example = figures.refused_examples.get(kind).map_or("", String::as_str);
        format!("{count} triangles {kind}, one has {example}")
    });
    let reasons: Vec<String> = reasons.chain(figures.warning.clone()).collect();
    format!("the machine {} can work on no point of the part: {}", figures.machine, reasons.join("; "))
}

fn figures(
    args: &MapArgs,
    geometry: &Geometry,
    maps: &Maps<'_>,
    (angle_deg, wall_time_s): (f64, f64),
) -> PartFigures {
    let (map, pieces) = (maps.map, maps.pieces);
    let summary = pieces.summary();
    let (mut refused, mut examples) = (BTreeMap::new(), BTreeMap::new());
    let mut table_m2 = 0.0;
    for (cell, triangle) in map.cells.iter().zip(maps.mesh.triangles()) {
        let Some(reason) = cell.outcome.err() else { continue };
        let on_the_table = models::hybrid::sampling::on_the_table(triangle);
        table_m2 += if on_the_table { cell.area_m2 } else { 0.0 };
        let kind = if on_the_table { ON_THE_TABLE } else { kind(&reason) };
        *refused.entry(kind).or_insert(0) += 1;
        examples.entry(kind).or_insert_with(|| reason.to_string());
    }
    let inside = summary.largest.map(|(error_m, cell)| (error_m, pieces.cells[cell].centre_m));
    let at_edge = pieces.edge.filter(|(edge_m, _)| inside.is_none_or(|(error_m, _)| *edge_m > error_m));
    let largest = at_edge.or(inside);
    let left = |cell: &&Cell| cell.outcome.is_ok_and(|at| at.extremal.failed > 0);
    PartFigures {
        machine: args.machine.machine.clone(),
        provenance: geometry.provenance.clone(),
        angle_deg,
        triangles: map.cells.len(),
        points: pieces.cells.len(),
        edge_mm: 1e3 * maps.edge_m,
        volume_mm3: 1e9 * maps.mesh.volume_m3(),
        area_mm2: 1e6 * summary.area_m2,
        workable_share: summary.workable,
        mean_mm: 1e3 * summary.mean_m,
        p95_mm: 1e3 * summary.most_m,
        on_the_table_share: table_m2 / summary.area_m2,
        largest_mm: largest.map(|(error_m, _)| 1e3 * error_m),
        largest_at_edge: at_edge.is_some(),
        largest_at_mm: largest.map(|(_, at_m)| (1e3 * at_m).into()),
        left_branch: pieces.cells.iter().filter(left).count(),
        refused,
        refused_examples: examples,
        warning: unlikely_size(maps.mesh, geometry),
        wall_time_s,
    }
}

/// The face that the part stands on: no nozzle gets there, and none has to.
const ON_THE_TABLE: &str = "on_the_table";

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
            "part         {} triangles, {} mm3, {} mm2",
            figures.triangles,
            significant(figures.volume_mm3, 4),
            significant(figures.area_mm2, 4)
        ),
        format!(
            "points       {}, one a piece of the surface with edges up to {} mm",
            figures.points,
            significant(figures.edge_mm, 3)
        ),
        format!("motors       each wrong by {:.5} degrees, worst combination of signs", figures.angle_deg),
        format!(
            "workable     {:.1} % of the surface; {:.1} % more lies on the table",
            100.0 * figures.workable_share,
            100.0 * figures.on_the_table_share
        ),
        format!(
            "error        mean {} mm, 95 % below {} mm",
            significant(figures.mean_mm, 4),
            significant(figures.p95_mm, 4)
        ),
    ];
    if let (Some(error_mm), Some([x, y, z])) = (figures.largest_mm, figures.largest_at_mm) {
        let [x, y, z] = [x, y, z].map(|at_mm| significant(at_mm, 3));
        let edge = if figures.largest_at_edge {
            ", where the machine's reach ends: its limits decide it, above all the guard before singular poses"
        } else {
            ""
        };
        lines.push(format!("largest      {} mm at ({x}, {y}, {z}) mm{edge}", significant(error_mm, 4)));
    }
    if figures.left_branch > 0 {
        lines.push(format!("branch       {} cells lose their pose in some combination", figures.left_branch));
    }
    for (kind, count) in &figures.refused {
        if *kind == ON_THE_TABLE {
            lines.push(format!("not needed   {count} triangles: they lie on the table"));
            continue;
        }
        let example = figures.refused_examples.get(kind).map_or("", String::as_str);
        lines.push(format!("refused      {count} triangles: {kind}; one has {example}"));
    }
    lines.extend(figures.warning.iter().map(|warning| format!("warning      {warning}")));
    lines.push(format!("wall time    {:.3} s on one core", figures.wall_time_s));
    lines.join("\n")
}
