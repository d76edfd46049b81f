//! `fdm kinematics error`: tables over height and angle beside the paper's.

use super::MachineArgs;
use crate::options::{in_range, needs, positive};
use crate::output::{self, Json};
use anyhow::Context;
use clap::Args;
use models::hybrid::error::COMBINATIONS;
use models::hybrid::published::Published;
use models::hybrid::synthesis::Choices;
use models::hybrid::{AxisError, Geometry, SurfacePoint};
use rand::{Rng, SeedableRng, rngs::StdRng};
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;

/// Errors on the paper's hemisphere when every motor is wrong by one angle, in the worst combination of signs.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct ErrorArgs {
    /// Heights on the hemisphere `[mm]`, separated by commas; without them the paper's tables are printed.
    #[arg(long, value_delimiter = ',')]
    height: Vec<f64>,
    /// Angle by which every motor is wrong `[deg]`, for these heights; that of the paper's Table 1 if not given.
    #[arg(long)]
    angle: Option<f64>,
    /// Radius of the hemisphere `[mm]` for these heights; the paper's if not given.
    #[arg(long)]
    radius: Option<f64>,
    /// Random draws per height beside the worst combination, each error uniform up to its bound; one has no deviation.
    #[arg(long, value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    monte_carlo: Option<u32>,
    /// Seed of the draws; 1 if not given.
    #[arg(long)]
    seed: Option<u64>,
    #[command(flatten)]
    machine: MachineArgs,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// One row.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ErrorRow {
    /// Number of the paper's table; absent for heights given.
    pub table: Option<u32>,
    /// Height on the hemisphere.
    pub height_mm: f64,
    /// Angle of the motors.
    pub angle_deg: f64,
    /// Whether the angle is our reading of a rounded one.
    pub read_as: bool,
    /// As printed.
    pub printed_mm: Option<f64>,
    /// Ours, exact; absent where a combination of signs has no pose.
    pub error_mm: Option<f64>,
    /// Ours over printed, less 1.
    pub residual_rel: Option<f64>,
    /// Ours to first order.
    pub linear_mm: f64,
    /// Sum of the carriages' gains.
    pub gain: f64,
    /// Condition number of the Jacobian.
    pub condition: f64,
    /// Combinations of signs without a pose on the nominal branch.
    pub failed: u32,
    /// All combinations.
    pub combinations: u32,
    /// Largest error of the combinations that have a pose: of all of them where none failed.
    pub posed_mm: f64,
    /// Standard deviation of the random draws; absent where one has no pose.
    pub random_mm: Option<f64>,
    /// Draws without a pose on the nominal branch.
    pub random_failed: Option<u32>,
    /// All draws.
    pub draws: Option<u32>,
}

/// The figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ErrorFigures {
    /// Machine.
    pub machine: String,
    /// Where its geometry comes from.
    pub provenance: String,
    /// Rows.
    pub rows: Vec<ErrorRow>,
}

/// What one row is asked for.
#[derive(Debug, Clone, Copy)]
struct Asked {
    table: Option<u32>,
    height_m: f64,
    angle_deg: f64,
    read_as: bool,
    printed_m: Option<f64>,
}

/// Runs the command.
///
/// # Errors
/// A height that the hemisphere has not, a pose that the machine refuses.
pub fn run(args: &ErrorArgs) -> anyhow::Result<()> {
    let config = args.machine.config()?;
    let json = Json::new(args.json.as_deref());
    json.check()?;
    let geometry = args.machine.geometry(&config)?;
    let tables: Published = runtime::params::from_yaml(&config.file("machines/published.yaml"))?;
    let radius_m = args.radius.map_or(tables.radius_m, |mm| 1e-3 * mm);
    let alone = [("--angle", args.angle.is_some()), ("--radius", args.radius.is_some())];
    needs("--height", !args.height.is_empty(), &alone)?;
    needs("--monte-carlo", args.monte_carlo.is_some(), &[("--seed", args.seed.is_some())])?;
    super::check_heights(&args.height, args.radius, radius_m)?;
    let angle_deg = angle_deg(args, &tables, &args.machine.choices(&config)?)?;
    let asked = if args.height.is_empty() { of_tables(&tables) } else { of_heights(args, angle_deg) };
    let rows = asked.iter().map(|asked| row(&geometry, radius_m, asked, args));
    let figures = ErrorFigures {
        machine: args.machine.machine.clone(),
        provenance: geometry.provenance.clone(),
        rows: rows.collect::<anyhow::Result<_>>()?,
    };
    if !json.is_stdout() {
        output::line(&text(&figures))?;
    }
    json.write(&figures)
}

/// Full steps between two positions in which a stepper's field holds it alike: further off it has jumped, and its angle
/// is wrong by a number of jumps, not by an error of the motor.
const STEPS_OF_A_JUMP: f64 = 4.0;

/// The angle of the heights given, within a jump of the coarsest motor `[deg]`.
fn angle_deg(args: &ErrorArgs, tables: &Published, choices: &Choices) -> anyhow::Result<f64> {
    let angle_deg = args.angle.unwrap_or(tables.table_1_angle_deg);
    let step_rad = choices.steps_rad.iter().copied().fold(0.0, f64::max);
    positive("--angle", angle_deg, "deg")?;
    in_range("--angle", angle_deg, "deg", (0.0, STEPS_OF_A_JUMP * step_rad.to_degrees()))
}

fn of_heights(args: &ErrorArgs, angle_deg: f64) -> Vec<Asked> {
    let asked =
        |mm: &f64| Asked { table: None, height_m: 1e-3 * mm, angle_deg, read_as: false, printed_m: None };
    args.height.iter().map(asked).collect()
}

/// Every printed row; a rounded angle as printed and as we read it.
fn of_tables(tables: &Published) -> Vec<Asked> {
    let mut asked: Vec<Asked> = tables
        .table_1
        .iter()
        .map(|row| Asked {
            table: Some(1),
            height_m: row.height_m,
            angle_deg: tables.table_1_angle_deg,
            read_as: false,
            printed_m: Some(row.error_m),
        })
        .collect();
    for row in &tables.table_2 {
        let printed = Asked {
            table: Some(2),
            height_m: tables.table_2_height_m,
            angle_deg: row.angle_deg,
            read_as: false,
            printed_m: Some(row.error_m),
        };
        asked.push(printed);
        asked.extend(row.read_as_deg.map(|angle_deg| Asked { angle_deg, read_as: true, ..printed }));
    }
    asked
}

fn row(geometry: &Geometry, radius_m: f64, asked: &Asked, args: &ErrorArgs) -> anyhow::Result<ErrorRow> {
    let point = SurfacePoint::on_hemisphere(radius_m, asked.height_m)?;
    let station = geometry.station(&point).with_context(|| format!("height {} mm", 1e3 * asked.height_m))?;
    let error = AxisError::of_motors(asked.angle_deg.to_radians(), geometry.lead_m);
    let worst = station.extremal(&error);
    let mut source = StdRng::seed_from_u64(args.seed.unwrap_or(1));
    let mut uniform = || source.random_range(-1.0..=1.0);
    let spread = args.monte_carlo.map(|draws| station.monte_carlo(&error, draws, &mut uniform));
    // Among the combinations left the worst may be missing: no maximum of them is the worst error.
    let worst_m = (worst.failed == 0).then_some(worst.largest_m);
    Ok(ErrorRow {
        table: asked.table,
        height_mm: 1e3 * asked.height_m,
        angle_deg: asked.angle_deg,
        read_as: asked.read_as,
        printed_mm: asked.printed_m.map(|printed_m| 1e3 * printed_m),
        error_mm: worst_m.map(|worst_m| 1e3 * worst_m),
        residual_rel: asked.printed_m.zip(worst_m).map(|(printed_m, worst_m)| worst_m / printed_m - 1.0),
        linear_mm: 1e3 * station.gain().largest_m(&error),
        gain: station.gain().carriage_sum(),
        condition: station.condition,
        failed: worst.failed,
        combinations: COMBINATIONS,
        posed_mm: 1e3 * worst.largest_m,
        random_mm: spread.filter(|spread| spread.failed == 0).map(|spread| 1e3 * spread.deviation_m),
        random_failed: spread.map(|spread| spread.failed),
        draws: args.monte_carlo,
    })
}

/// Which figures a row has not, and why; empty where it has all.
fn without_a_pose(row: &ErrorRow) -> String {
    let mut text = String::new();
    let at = format!("z = {:.1} mm, {:.5} degrees", row.height_mm, row.angle_deg);
    // Writing to a string cannot fail.
    if row.failed > 0 {
        _ = writeln!(
            text,
            "{at}: {} of {} combinations of signs have no pose, so there is no worst error; the others reach {:.4} mm",
            row.failed, row.combinations, row.posed_mm
        );
    }
    if let (Some(failed @ 1..), Some(draws)) = (row.random_failed, row.draws) {
        _ = writeln!(text, "{at}: {failed} of {draws} draws have no pose, so there is no deviation");
    }
    text
}

fn text(figures: &ErrorFigures) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    _ = writeln!(text, "Machine {}: geometry {}", figures.machine, figures.provenance);
    _ = writeln!(
        text,
        "{:>5} {:>6} {:>8}  {:>9} {:>9} {:>9}  {:>9} {:>7} {:>9} {:>6} {:>9}",
        "table",
        "z mm",
        "deg",
        "paper mm",
        "ours mm",
        "residual",
        "linear mm",
        "gain",
        "condition",
        "failed",
        "random mm"
    );
    for row in &figures.rows {
        let table = row.table.map_or_else(|| "-".to_owned(), |table| table.to_string());
        let printed = row.printed_mm.map_or_else(|| "-".to_owned(), |mm| format!("{mm:.3}"));
        let ours = row.error_mm.map_or_else(|| "none".to_owned(), |mm| format!("{mm:.4}"));
        let residual =
            row.residual_rel.map_or_else(|| "-".to_owned(), |share| format!("{:+.1} %", 100.0 * share));
        let no_random = if row.draws.is_some() { "none" } else { "-" };
        let random = row.random_mm.map_or_else(|| no_random.to_owned(), |mm| format!("{mm:.4}"));
        let note = if row.read_as { "  read for the rounded angle above" } else { "" };
        _ = writeln!(
            text,
            "{table:>5} {:>6.1} {:>8.5}  {printed:>9} {ours:>9} {residual:>9}  {:>9.4} {:>7.2} {:>9.1} {:>6} \
             {random:>9}{note}",
            row.height_mm, row.angle_deg, row.linear_mm, row.gain, row.condition, row.failed
        );
    }
    text.push_str(
        "residual: ours over the paper's, less 1; linear: ours to first order; gain: error along the normal per error \
         of the carriages, their sum; condition: of the Jacobian, large near a pose that the machine cannot hold; \
         failed: combinations of signs without a pose; random: standard deviation of draws\n",
    );
    figures.rows.iter().for_each(|row| text.push_str(&without_a_pose(row)));
    if figures.rows.iter().any(|row| row.table.is_some()) {
        text.push_str(
            "Table 1 below z = 15 mm is not met: it contradicts Table 2 (1 degree) and any smooth continuation; \
             the authors' solver may have left the assembly branch near 90 degrees of tilt (hypothesis).",
        );
    }
    text
}
