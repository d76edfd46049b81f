//! Figures of a replay for people.

use super::Figures;
use super::compare::Output;
use crate::options::significant;
use serde_json::Value;
use std::fmt::Write;

/// Fields that are told of an output; the JSON has all.
const FIELDS: usize = 12;

/// The figures as text.
pub(crate) fn page(figures: &Figures) -> String {
    let Figures { bag, namespace, clock, messages, span_s, parameters, .. } = figures;
    let mut page = format!(
        "{bag}: {messages} messages of {span_s:.1} s, printer {namespace}, clock {clock}, parameters from the {parameters}\n"
    );
    for line in &figures.other_build {
        page.push_str(&format!("another build: {line}\n"));
    }
    for set in &figures.set {
        page.push_str(&format!("set {set}\n"));
    }
    let (before, after) = match figures.baseline {
        "recorded" => ("recorded", "replayed"),
        _ => ("as recorded", "with it set"),
    };
    // Writing to a string cannot fail.
    _ = writeln!(page, "\n{:<20} {before:>12} {after:>12} {:>9} {:>10}", "output", "matched", "identical");
    for output in &figures.outputs {
        let Output { topic, before, after, matched, identical, .. } = output;
        _ = writeln!(page, "{topic:<20} {before:>12} {after:>12} {matched:>9} {identical:>10}");
    }
    for output in figures.outputs.iter().filter(|output| !output.is_identical()) {
        page.push_str(&differing(output));
    }
    if figures.identical {
        page.push_str("\nidentical, bit by bit\n");
    }
    page
}

/// What differs in an output.
fn differing(output: &Output) -> String {
    let mut text = format!("\n{}", output.topic);
    if let Some(first) = &output.first_difference {
        let (stamp_s, field) = (first.stamp_s, &first.field);
        let both = (short(&first.before), short(&first.after));
        text.push_str(&match (&first.before, &first.after) {
            (Value::Bool(before), Value::Bool(_)) if field == "a message" => {
                let which = if *before { "before" } else { "after" };
                format!(": first at {stamp_s:.3} s, a message that only the run {which} has")
            }
            _ => format!(": first at {stamp_s:.3} s, {field} {} -> {}", both.0, both.1),
        });
    }
    text.push('\n');
    let mut fields: Vec<_> = output.fields.iter().collect();
    fields.sort_by_key(|(_, field)| std::cmp::Reverse(field.differing));
    for (name, field) in fields.iter().take(FIELDS) {
        let (rms, max) = (significant(field.rms, 3), significant(field.max, 3));
        _ = writeln!(text, "  {name:<28} differs in {:>7}   RMS {rms:>10}   max {max:>10}", field.differing);
    }
    if fields.len() > FIELDS {
        _ = writeln!(text, "  and {} more fields: --json", fields.len() - FIELDS);
    }
    text
}

fn short(value: &Value) -> String {
    match value {
        Value::Number(number) => {
            number.as_f64().map_or_else(|| number.to_string(), |value| significant(value, 6))
        }
        other => crate::report::decode::short(&other.to_string(), 60),
    }
}
