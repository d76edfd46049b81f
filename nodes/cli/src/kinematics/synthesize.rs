//! `fdm kinematics synthesize`: motors, microsteps, leads and encoders for a wanted accuracy.

use super::MachineArgs;
use crate::options::{positive, significant};
use crate::output::{self, Json};
use anyhow::Context;
use clap::Args;
use models::hybrid::published::Published;
use models::hybrid::synthesis::carriage_error_m;
use models::hybrid::{Station, SurfacePoint};
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;

/// Chooses drives so that the worst error stays within a target at all heights given.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct SynthesizeArgs {
    /// Largest error along the normal that is allowed `[mm]`.
    #[arg(long)]
    target: f64,
    /// Heights on the hemisphere that must keep it `[mm]`; 0 is the worst.
    #[arg(long, value_delimiter = ',', default_value = "0")]
    height: Vec<f64>,
    /// Radius of the hemisphere `[mm]`; the paper's if not given.
    #[arg(long)]
    radius: Option<f64>,
    #[command(flatten)]
    machine: MachineArgs,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// One motor with one lead.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DesignRow {
    /// Full step.
    pub step_deg: f64,
    /// Travel per turn.
    pub lead_mm: f64,
    /// Fewest microsteps that meet the target: with the motors' own error, or with an encoder where one is needed; absent
    /// where the driver's most do not.
    pub microsteps: Option<u32>,
    /// Worst error of one of them.
    pub microstep_error_mm: Option<f64>,
    /// Worst error of the motors' own.
    pub motor_error_mm: Option<f64>,
    /// Worst error of both together, which is what is judged; absent where an encoder is needed.
    pub sum_error_mm: Option<f64>,
    /// Whether no microstep keeps the target together with the motors' own error.
    pub encoder_needed: bool,
}

/// The figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SynthesisFigures {
    /// Machine.
    pub machine: String,
    /// Where its geometry comes from.
    pub provenance: String,
    /// Target.
    pub target_mm: f64,
    /// A motor's own error in parts of a full step.
    pub motor_error_share: f64,
    /// Error of a carriage that keeps the target, first order: what a scale on it has to resolve.
    pub carriage_error_mm: Option<f64>,
    /// Whether some motor with some lead keeps the target, with an encoder or without.
    pub reachable: bool,
    /// Every motor with every lead.
    pub designs: Vec<DesignRow>,
}

/// Runs the command.
///
/// # Errors
/// A target not above 0, a height that the machine refuses.
pub fn run(args: &SynthesizeArgs) -> anyhow::Result<()> {
    let config = args.machine.config()?;
    let json = Json::new(args.json.as_deref());
    json.check()?;
    let geometry = args.machine.geometry(&config)?;
    let choices = args.machine.choices(&config)?;
    let tables: Published = runtime::params::from_yaml(&config.file("machines/published.yaml"))?;
    let radius_m = args.radius.map_or(tables.radius_m, |mm| 1e-3 * mm);
    super::check_heights(&args.height, args.radius, radius_m)?;
    positive("--target", args.target, "mm")?;
    let stations = args
        .height
        .iter()
        .map(|mm| {
            let point = SurfacePoint::on_hemisphere(radius_m, 1e-3 * mm)?;
            geometry.station(&point).with_context(|| format!("height {mm} mm"))
        })
        .collect::<anyhow::Result<Vec<Station<'_>>>>()?;
    let target_m = 1e-3 * args.target;
    let designs = choices.designs(&stations, target_m)?.into_iter().map(|design| DesignRow {
        step_deg: design.step_rad.to_degrees(),
        lead_mm: 1e3 * design.lead_m,
        microsteps: design.microsteps.map(|found| found.count),
        microstep_error_mm: design.microsteps.map(|found| 1e3 * found.largest_m),
        motor_error_mm: design.motor_m.map(|error_m| 1e3 * error_m),
        sum_error_mm: design.sum_m.map(|error_m| 1e3 * error_m),
        encoder_needed: design.encoder,
    });
    let designs: Vec<DesignRow> = designs.collect();
    let figures = SynthesisFigures {
        machine: args.machine.machine.clone(),
        provenance: geometry.provenance.clone(),
        target_mm: args.target,
        motor_error_share: choices.motor_error,
        carriage_error_mm: carriage_error_m(&stations, target_m).map(|error_m| 1e3 * error_m),
        reachable: designs.iter().any(|row| row.microsteps.is_some()),
        designs,
    };
    if !json.is_stdout() {
        output::line(&text(&figures))?;
    }
    json.write(&figures)
}

fn text(figures: &SynthesisFigures) -> String {
    let mut text = String::new();
    let cell = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |mm| significant(mm, 4));
    // Writing to a string cannot fail.
    _ = writeln!(text, "Machine {}: geometry {}", figures.machine, figures.provenance);
    _ = writeln!(
        text,
        "Target {} mm: each carriage within {} mm (first order); a motor itself is wrong by {:.0} % of a full step",
        significant(figures.target_mm, 4),
        cell(figures.carriage_error_mm),
        100.0 * figures.motor_error_share
    );
    _ = writeln!(
        text,
        "{:>6} {:>8} {:>11} {:>13} {:>10} {:>9}  encoder",
        "deg", "lead mm", "microsteps", "microstep mm", "motor mm", "sum mm"
    );
    for row in &figures.designs {
        let microsteps = row.microsteps.map_or_else(|| "none".to_owned(), |count| count.to_string());
        _ = writeln!(
            text,
            "{:>6.2} {:>8.2} {microsteps:>11} {:>13} {:>10} {:>9}  {}",
            row.step_deg,
            row.lead_mm,
            cell(row.microstep_error_mm),
            cell(row.motor_error_mm),
            cell(row.sum_error_mm),
            encoder(row, figures.target_mm)
        );
    }
    if !figures.reachable {
        _ = writeln!(
            text,
            "Not reachable: no motor and lead of the machine's file keeps {} mm, not even with an encoder",
            significant(figures.target_mm, 4)
        );
    }
    text.push_str(
        "microstep, motor: worst error of one microstep and of the motors' own; sum: of both together, which must stay \
         within the target; with an encoder the microstep alone must",
    );
    text
}

/// What a row says of its encoder.
fn encoder(row: &DesignRow, target_mm: f64) -> &'static str {
    match (row.encoder_needed, row.microsteps, row.motor_error_mm) {
        (false, ..) => "not needed",
        (true, None, _) => "not reachable: the finest microstep alone exceeds the target",
        (true, _, Some(motor_mm)) if motor_mm <= target_mm => {
            "needed: motor and microstep exceed the target together"
        }
        (true, ..) => "needed: the motors alone exceed the target",
    }
}
