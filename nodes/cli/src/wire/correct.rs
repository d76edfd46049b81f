//! `fdm wire correct`: the correction law beside the paper's tables.

use super::{ModeName, material};
use crate::config::ConfigDir;
use crate::options::{in_range, needs};
use crate::output::{self, Json};
use crate::process::block;
use clap::Args;
use models::wire::correction::{Corrected, GAIN_RANGE};
use models::wire::published::{Published, Row};
use models::wire::{Law, Limits, Mode};
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;

/// Corrects the speeds for measured heights; the paper's tables stand beside ours with residuals.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct CorrectArgs {
    /// Measured heights of a layer `[mm]`, separated by commas.
    #[arg(long, value_delimiter = ',')]
    height: Vec<f64>,
    /// Which speeds are moved for these heights; both if not given, as in the tables.
    #[arg(long, value_enum)]
    mode: Option<ModeName>,
    /// Gain in place of the configured one `[-]`, for these heights.
    #[arg(long)]
    gain: Option<f64>,
    /// Folder with the parameter files.
    #[arg(long)]
    config: Option<PathBuf>,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// A printed row beside ours.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Compared {
    /// Number of the paper's table.
    pub table: u32,
    /// Height that ours is computed for.
    pub height_mm: f64,
    /// Height as printed.
    pub printed_height_mm: f64,
    /// Whether the height is our reading of a misprint.
    pub hypothesis: bool,
    /// Wire as printed.
    pub printed_wire_mm_s: f64,
    /// Head as printed.
    pub printed_head_mm_s: f64,
    /// Wire, ours.
    pub wire_mm_s: f64,
    /// Head, ours.
    pub head_mm_s: f64,
    /// Ours less printed.
    pub wire_residual_mm_s: f64,
    /// Ours less printed.
    pub head_residual_mm_s: f64,
}

/// Speeds for one measured height, within the limits.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ForHeight {
    /// Measured height.
    pub height_mm: f64,
    /// Wire.
    pub wire_mm_s: f64,
    /// Head.
    pub head_mm_s: f64,
    /// Section laid relative to the planned one.
    pub section_ratio: f64,
    /// Power that the wire then takes.
    pub absorbed_w: f64,
    /// Whether a limit took something away.
    pub limited: bool,
    /// Which limits hold, with their values.
    pub at_limits: Vec<String>,
}

/// The figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// Gain of the heights.
    pub gain: f64,
    /// Whether height errors fade from layer to layer with it: above 0 and below 2.
    pub stable: bool,
    /// Heights given.
    pub heights: Vec<ForHeight>,
    /// Tables 1 and 2.
    pub published: Vec<Compared>,
}

/// Runs the command.
///
/// # Errors
/// One line with the value and its limit.
pub fn run(args: &CorrectArgs) -> anyhow::Result<()> {
    let config = ConfigDir::find(args.config.as_deref())?;
    let json = Json::new(args.json.as_deref());
    json.check()?;
    let alone = [("--mode", args.mode.is_some()), ("--gain", args.gain.is_some())];
    needs("--height", !args.height.is_empty(), &alone)?;
    let mode = args.mode.unwrap_or(ModeName::Both).into();
    let process = super::nominal(&config)?;
    if let Some(gain) = args.gain {
        in_range("--gain", gain, "-", GAIN_RANGE)?;
    }
    let law = args.gain.map_or(Ok(process.law), |gain| process.law.with_gain(gain))?;
    let metal = material(&config, &process.material)?;
    let controller: mpc_controller::wire::RawParams =
        block(&config, "wire/controller.yaml", "wire_controller")?;
    let highest_mm = 1e3 * (law.height_m + controller.error_max_m);
    let lowest_mm = 1e3 * (law.height_m - controller.error_max_m).max(0.0);
    let heights = args.height.iter().map(|height_mm| {
        // What the controller does not believe it does not correct either.
        in_range("--height", *height_mm, "mm", (lowest_mm, highest_mm))?;
        let speeds = law.correct_within(mode, &process.limits, 1e-3 * height_mm)?;
        Ok(ForHeight {
            height_mm: *height_mm,
            wire_mm_s: 1e3 * speeds.wire_m_s,
            head_mm_s: 1e3 * speeds.head_m_s,
            section_ratio: speeds.section_ratio,
            absorbed_w: process.feed.power_w(&metal, speeds.wire_m_s),
            limited: speeds.limited,
            at_limits: at_limits(&law, &process.limits, &speeds),
        })
    });
    let heights = heights.collect::<anyhow::Result<Vec<_>>>()?;
    let tables: Published = runtime::params::from_yaml(&config.file("wire/published.yaml"))?;
    let figures = Figures {
        gain: law.gain,
        stable: law.is_stable(),
        heights,
        published: compare(&process.law, &tables)?,
    };
    if !json.is_stdout() {
        output::line(&text(&figures))?;
    }
    json.write(&figures)
}

/// The limits that hold: of the section of the law's, of the speeds the machine's.
fn at_limits(law: &Law, limits: &Limits, speeds: &Corrected) -> Vec<String> {
    if !speeds.limited {
        return Vec::new();
    }
    let bounds = [
        ("section", speeds.section_ratio, (law.ratio_low, law.ratio_high), ""),
        ("wire", 1e3 * speeds.wire_m_s, (1e3 * limits.wire_low_m_s, 1e3 * limits.wire_high_m_s), " mm/s"),
        ("head", 1e3 * speeds.head_m_s, (1e3 * limits.head_low_m_s, 1e3 * limits.head_high_m_s), " mm/s"),
    ];
    // Up to the rounding of a division and its inverse.
    let at = |value: f64, bound: f64| (value / bound - 1.0).abs() < 1e-9;
    let mut held = Vec::new();
    for (name, value, (low, high), unit) in bounds {
        if at(value, low) {
            held.push(format!("{name} at its least, {low:.3}{unit}"));
        } else if at(value, high) {
            held.push(format!("{name} at its most, {high:.3}{unit}"));
        }
    }
    held
}

/// Every row at its printed height, and at the one that we read instead.
fn compare(law: &Law, tables: &Published) -> anyhow::Result<Vec<Compared>> {
    let mut rows = Vec::new();
    for row in &tables.rows {
        rows.push(compared(law, row, row.height_m)?);
        if let Some(height_m) = row.read_as_m {
            rows.push(compared(law, row, height_m)?);
        }
    }
    Ok(rows)
}

fn compared(law: &Law, row: &Row, height_m: f64) -> anyhow::Result<Compared> {
    let ours = law.correct(Mode::Both, height_m)?;
    Ok(Compared {
        table: row.table,
        height_mm: 1e3 * height_m,
        printed_height_mm: 1e3 * row.height_m,
        hypothesis: (height_m - row.height_m).abs() > 0.0,
        printed_wire_mm_s: 1e3 * row.wire_m_s,
        printed_head_mm_s: 1e3 * row.head_m_s,
        wire_mm_s: 1e3 * ours.wire_m_s,
        head_mm_s: 1e3 * ours.head_m_s,
        wire_residual_mm_s: 1e3 * (ours.wire_m_s - row.wire_m_s),
        head_residual_mm_s: 1e3 * (ours.head_m_s - row.head_m_s),
    })
}

fn text(figures: &Figures) -> String {
    if figures.heights.is_empty() { tables_text(figures) } else { heights_text(figures) }
}

fn heights_text(figures: &Figures) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    _ = writeln!(text, "gain {:.3}{}", figures.gain, super::unstable(figures.gain, figures.stable));
    _ = writeln!(
        text,
        "{:>9} {:>10} {:>10} {:>9} {:>10}",
        "height mm", "wire mm/s", "head mm/s", "section", "absorbed W"
    );
    for row in &figures.heights {
        let limited = match row.at_limits.as_slice() {
            [] if row.limited => "  at a limit".to_owned(),
            [] => String::new(),
            held => format!("  {}", held.join("; ")),
        };
        _ = writeln!(
            text,
            "{:>9.3} {:>10.3} {:>10.3} {:>9.3} {:>10.1}{limited}",
            row.height_mm, row.wire_mm_s, row.head_mm_s, row.section_ratio, row.absorbed_w
        );
    }
    text.push_str(
        "section: cross section laid over the planned one; absorbed: power that the wire then takes up",
    );
    text
}

fn tables_text(figures: &Figures) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    _ = writeln!(text, "Tables of the paper (it gives no formula), ours and residuals in mm/s:");
    _ = writeln!(
        text,
        "{:>5} {:>9}  {:>7} {:>7} {:>8}  {:>7} {:>7} {:>8}",
        "table", "height mm", "wire", "ours", "residual", "head", "ours", "residual"
    );
    for row in &figures.published {
        let note = if row.hypothesis {
            format!("  hypothesis: {:.2} is a misprint of {:.2}", row.printed_height_mm, row.height_mm)
        } else {
            String::new()
        };
        _ = writeln!(
            text,
            "{:>5} {:>9.2}  {:>7.2} {:>7.3} {:>+8.3}  {:>7.2} {:>7.3} {:>+8.3}{note}",
            row.table,
            row.height_mm,
            row.printed_wire_mm_s,
            row.wire_mm_s,
            row.wire_residual_mm_s,
            row.printed_head_mm_s,
            row.head_mm_s,
            row.head_residual_mm_s,
        );
    }
    _ = writeln!(text, "residual: ours minus the paper's; wire, head: their speeds");
    for row in figures.published.iter().filter(|row| row.hypothesis) {
        _ = writeln!(
            text,
            "{:.2} mm is taken for a misprint: it does not fit the speeds of its own row, {:.2} mm does \
             (config/wire/published.yaml)",
            row.printed_height_mm, row.height_mm
        );
    }
    text
}

#[cfg(test)]
mod tests;
