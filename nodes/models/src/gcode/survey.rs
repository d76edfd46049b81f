//! A file in figures: what `fdm gcode` prints.

use super::{Header, Warning};
use crate::motion::{Action, Job, MotionParams, Step};
use serde::Serialize;
use std::collections::BTreeSet;
use std::io::BufRead;

/// Figures of one file; the field names are published.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Survey {
    /// Layers begun.
    pub layers: u32,
    /// Moves of tool or filament as planned: an arc counts one per chord.
    pub moves: u64,
    /// Arcs and splines in the file.
    pub arcs: u64,
    /// Net filament of the E words `[mm]`: retractions subtracted, firmware retractions included.
    pub filament_mm: f64,
    /// Planned time of moves and dwells, without heating and homing `[s]`.
    pub print_time_s: f64,
    /// Tools selected, or 1 where none is.
    pub tools: u32,
    /// Slicer and flavour.
    pub dialect: String,
    /// What is odd, by line; the first ones.
    pub warnings: Vec<Warning>,
    /// All warnings, kept or not.
    pub warnings_total: u64,
    /// What keeps the file from being printed.
    pub errors: Vec<Warning>,
    /// Lines of the file.
    pub lines: u64,
    /// Time as the slicer states it `[s]`.
    pub stated_time_s: Option<f64>,
    /// Filament as the slicer states it `[mm]`.
    pub stated_filament_mm: Option<f64>,
    /// Tool way of travel moves `[m]`.
    pub travel_m: f64,
    /// Tool way of laid roads `[m]`.
    pub deposit_m: f64,
}

/// Reads and plans a stream to its end; memory does not grow with its length.
pub fn survey<R: BufRead>(source: R, header: &Header, params: &MotionParams) -> Survey {
    const PER_MM: f64 = 1e3;
    let mut job = Job::new(source, header, params);
    let mut tools = BTreeSet::new();
    for step in &mut job {
        if let Step::Action(Action::Tool(tool), _) = step {
            tools.insert(tool);
        }
    }
    let totals = *job.totals();
    let mut errors = Vec::new();
    if let Some(failure) = job.failure() {
        errors.push(failure.clone());
    }
    if totals.moves == 0 {
        errors.push(Warning { line: totals.lines, reason: "no move in the file".into() });
    }
    Survey {
        layers: totals.layers,
        moves: totals.moves,
        arcs: totals.arcs,
        filament_mm: totals.filament_m * PER_MM,
        print_time_s: totals.time.0,
        tools: u32::try_from(tools.len().max(1)).unwrap_or(u32::MAX),
        dialect: header.dialect(),
        warnings: job.oddities().kept().to_vec(),
        warnings_total: job.oddities().total(),
        errors,
        lines: totals.lines,
        stated_time_s: header.stated_time.map(|time| time.0),
        stated_filament_mm: header.stated_filament_m.map(|filament_m| filament_m * PER_MM),
        travel_m: totals.travel_m,
        deposit_m: totals.deposit_m,
    }
}
