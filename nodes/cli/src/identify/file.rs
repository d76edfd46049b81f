//! The learned numbers as a printer file: the nominal file, its numbers and their comments replaced.

use super::learn::{Learned, Quantity};
use crate::options::significant;
use crate::report::decode::short;
use anyhow::bail;

/// Longest warning that is told `[char]`.
const WARNING_MAX: usize = 160;
/// Digits of a number in the file; intervals are rarely narrower than 0.1 %.
const DIGITS: usize = 5;
/// Digits of the ends of an interval.
const DIGITS_INTERVAL: usize = 4;
/// Blocks of a printer file that are learned.
const BLOCKS: [&str; 2] = ["hotend", "extruder"];
/// Quantities that are parameters of the estimator.
const ESTIMATOR: [&str; 3] = ["thermistor.sigma_k", "encoder.quantum_m", "width.sigma_min_m"];

/// The text of the file; `nominal` is the text of the one that it replaces, `bag` the name of the bag.
pub(super) fn text(nominal: &str, learned: &Learned, bag: &str, warned: &[String]) -> anyhow::Result<String> {
    let mut text = head(learned, bag);
    for warning in warned {
        let line = short(warning, WARNING_MAX);
        text.push_str(&format!(
            "# WARNED while the bag was recorded, so that a fault may be learned: {line}\n"
        ));
    }
    let mut block = "";
    let mut left: Vec<&Quantity> = learned.quantities.iter().filter(|it| in_block(it).is_some()).collect();
    for line in nominal.lines().skip_while(|line| line.starts_with('#')) {
        let entry = line.trim_start();
        if let Some(name) = entry.strip_suffix(':') {
            block = BLOCKS.into_iter().find(|block| *block == name).unwrap_or("");
        }
        let found = left.iter().position(|quantity| {
            in_block(quantity).is_some_and(|(of, key)| {
                of == block && entry.strip_prefix(key).is_some_and(|rest| rest.starts_with(':'))
            })
        });
        match found {
            Some(at) => text.push_str(&replaced(line, left.remove(at), bag)),
            None => text.push_str(line),
        }
        text.push('\n');
    }
    if let Some(quantity) = left.first() {
        bail!("{}: not in the printer file", quantity.name);
    }
    text.push_str(&noise(learned));
    Ok(text)
}

/// Block and key of a quantity of the printer.
fn in_block(quantity: &Quantity) -> Option<(&str, &str)> {
    quantity.name.split_once('.').filter(|(block, _)| BLOCKS.contains(block))
}

fn head(learned: &Learned, bag: &str) -> String {
    let mut head = format!(
        "# A printer as `fdm identify` learned it from the bag {bag}. Line: value # [unit] [range] what; source.\n\
         # In brackets the 95 % interval. Where the bag says little, the belief of config/identify.yaml stands: (belief).\n\
         # The heater's power is taken as given: every heat capacity and loss scales with it.\n"
    );
    let beside = |quantity: &&Quantity| in_block(quantity).is_none() && !ESTIMATOR.contains(&quantity.name);
    for quantity in learned.quantities.iter().filter(beside) {
        head.push_str(&format!("# {}: {} {}\n", quantity.name, told(quantity), quantity.unit));
    }
    if let Some(flow) = &learned.flow {
        head.push_str(&format!(
            "# Lags, compliance and linear lag are for this spool, with its material's file at {:.1} K in the nozzle: another material\n\
             # wants the shipped extruder, or a print of its own to learn from. The lags stand at {} mm/s of filament.\n",
            flow.nominal.at_k,
            flow.speeds_m_s.map(|speed| format!("{:.1}", 1e3 * speed)).join(", ")
        ));
    }
    head
}

fn told(quantity: &Quantity) -> String {
    let belief = if quantity.source == "belief" { " (belief)" } else { "" };
    let digits = |value| significant(value, DIGITS_INTERVAL);
    format!(
        "{} [{}, {}]{belief}",
        significant(quantity.value, DIGITS),
        digits(quantity.low),
        digits(quantity.high)
    )
}

/// The line with the learned number; unit, range and symbol of its comment stay, the source is the bag.
fn replaced(line: &str, quantity: &Quantity, bag: &str) -> String {
    let (entry, comment) = line.split_once('#').unwrap_or((line, ""));
    let key = entry.split(':').next().unwrap_or(entry);
    let what = comment.split(';').next().unwrap_or("").trim();
    let digits = |value| significant(value, DIGITS_INTERVAL);
    let belief = if quantity.source == "belief" { ", mostly belief" } else { "" };
    let (low, high) = (digits(quantity.low), digits(quantity.high));
    let value = significant(quantity.value, DIGITS);
    format!("{key}: {value} # {what}; bag {bag}, 95 % [{low}, {high}]{belief}")
}

/// Noise of the sensors, as parameters of the estimator alone.
fn noise(learned: &Learned) -> String {
    let mut text = String::from("state_estimator:\n  ros__parameters:\n");
    for quantity in &learned.quantities {
        if let Some((block, key)) =
            quantity.name.split_once('.').filter(|_| ESTIMATOR.contains(&quantity.name))
        {
            let (value, unit) = (significant(quantity.value, DIGITS), quantity.unit);
            let (low, high) =
                (significant(quantity.low, DIGITS_INTERVAL), significant(quantity.high, DIGITS_INTERVAL));
            text.push_str(&format!(
                "    {block}:\n      {key}: {value} # [{unit}] > 0 noise, 95 % [{low}, {high}]\n"
            ));
        }
    }
    text
}
