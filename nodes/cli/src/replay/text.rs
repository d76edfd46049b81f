//! Figures of a replay for people.

use super::Figures;
use super::compare::Output;
use super::events::Alone;
use crate::options::significant;
use serde_json::Value;
use std::fmt::Write;

/// Fields that are told of an output; the JSON has all.
const FIELDS: usize = 12;
/// Digits of a value, and how many tell any two apart.
const DIGITS: usize = 6;
const DIGITS_MAX: usize = 17;

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
    if !figures.set.is_empty() {
        page.push_str(
            "open loop: what the sensors measured stays as recorded, whatever the brains say now\n",
        );
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
        let both = apart(&first.before, &first.after);
        text.push_str(&match (&first.before, &first.after) {
            (Value::Bool(before), Value::Bool(_)) if field == "a message" => {
                let which = if *before { "before" } else { "after" };
                format!(": first at {stamp_s:.3} s, a message that only the run {which} has")
            }
            _ => format!(": first at {stamp_s:.3} s, {field} {} -> {}", both.0, both.1),
        });
    } else {
        text.push_str(": round-off alone");
    }
    text.push('\n');
    let mut fields: Vec<_> = output.fields.iter().collect();
    fields.sort_by_key(|(_, field)| std::cmp::Reverse(field.differing));
    for (name, field) in fields.iter().take(FIELDS) {
        let (rms, max) = (significant(field.rms, 3), significant(field.max, 3));
        _ = writeln!(text, "  {name:<28} differs in {:>7}   RMS {rms:>10}   max {max:>10}", field.differing);
    }
    for Alone { stamp_s, before, text: said } in &output.alone {
        let which = if *before { "before" } else { "after" };
        _ = writeln!(text, "  only {which} at {stamp_s:.3} s: {said}");
    }
    if fields.len() > FIELDS {
        _ = writeln!(text, "  and {} more fields: --json", fields.len() - FIELDS);
    }
    text
}

/// Two values that differ, with as many digits as it takes to see it.
fn apart(before: &Value, after: &Value) -> (String, String) {
    let both = |digits| (short(before, digits), short(after, digits));
    (DIGITS..=DIGITS_MAX)
        .map(both)
        .find(|(before, after)| before != after)
        .unwrap_or_else(|| both(DIGITS_MAX))
}

fn short(value: &Value, digits: usize) -> String {
    match value {
        Value::Number(number) => {
            number.as_f64().map_or_else(|| number.to_string(), |value| significant(value, digits))
        }
        other => crate::report::decode::short(&other.to_string(), 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_a_parameter_set_it_is_told_that_the_loop_is_open() {
        let told = |set: &[&str]| {
            page(&Figures {
                bag: "bags/x".to_owned(),
                namespace: "/printer".to_owned(),
                clock: "virtual".to_owned(),
                messages: 1,
                span_s: 1.0,
                parameters: "bag",
                other_build: Vec::new(),
                set: set.iter().map(|set| (*set).to_owned()).collect(),
                baseline: "replayed",
                outputs: Vec::new(),
                identical: true,
            })
        };
        assert!(
            told(&["mpc_controller.control=off"])
                .contains("open loop: what the sensors measured stays as recorded")
        );
        assert!(!told(&[]).contains("open loop"));
    }

    #[test]
    fn two_values_that_differ_do_not_read_alike() {
        let told = |one: f64, other: f64| apart(&one.into(), &other.into());
        assert_eq!(told(1.0, 1.25), ("1.00000".to_owned(), "1.25000".to_owned()));
        assert_eq!(told(1.0, 1.000_000_4), ("1.0000000".to_owned(), "1.0000004".to_owned()));
        let (one, other) = told(0.1, 0.1 + f64::EPSILON / 8.0);
        assert_ne!(one, other);
        assert_eq!(apart(&true.into(), &"no".into()), ("true".to_owned(), "\"no\"".to_owned()));
    }
}
