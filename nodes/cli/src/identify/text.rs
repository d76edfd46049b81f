//! What people read.

use super::Figures;
use super::learn::Quantity;
use super::trial;
use crate::options::significant;
use std::path::{Path, PathBuf};

/// Below this the zeros of a plain number are more than its digits.
const SMALL: f64 = 1e-3;

fn digits(value: f64) -> String {
    if value.is_nan() {
        "-".to_owned()
    } else if value.abs() > 0.0 && value.abs() < SMALL {
        format!("{value:.3e}")
    } else {
        significant(value, 4)
    }
}

/// Where the printer file is, and how it is used; `with_extruder` where it has a learned one.
pub(super) fn written(out: &Path, config: &Path, with_extruder: bool) -> String {
    // Without the slash at the end.
    let config: PathBuf = config.components().collect();
    let (out, config) = (out.display(), config.display());
    let mut text = format!(
        "\nwritten to {out}. It takes the place of printers/ender3.yaml in a copy of the configuration:\n  \
         cp -r {config} my_config && cp {out} my_config/printers/ender3.yaml\n  \
         fdm sim FILE.gcode --config my_config\n\
         Its section state_estimator, the noise of the sensors, counts there too. What belongs to material and room (melt heat,\n\
         flow index, lags) stands in its comments for you to read: nothing else reads it there."
    );
    if with_extruder {
        text.push_str(&format!(
            "\nWARNING: its compliance and linear lag are of this spool: how stiff the melt was and how much the tube gives nothing\n\
             tells apart. Print another material with the block extruder of {config}/printers/ender3.yaml, or learn it for itself."
        ));
    }
    text
}

/// What was learned from a bag.
pub(super) fn page(figures: &Figures) -> String {
    let mut page = format!(
        "{}: {} readings of the hot end, {} widths\n\n{:<32} {:>9} {:>12} {:>12} {:>12} {:>12}\n",
        figures.bag, figures.readings, figures.widths, "", "unit", "learned", "95 % from", "to", "file says"
    );
    for quantity in &figures.quantities {
        let Quantity { name, unit, value, low, high, before, source, .. } = quantity;
        let [value, low, high, before] = [*value, *low, *high, *before].map(digits);
        let belief = if *source == "belief" { "  mostly belief" } else { "" };
        page.push_str(&format!(
            "{name:<32} {unit:>9} {value:>12} {low:>12} {high:>12} {before:>12}{belief}\n"
        ));
    }
    page.push_str("\nHeat capacities, losses and coupling scale with the heater's power, which is taken as the file says.\n\
         Not every interval holds 95 of 100 printers: fdm identify --trial 1..20 shows which do, on simulated ones.");
    if !figures.warned.is_empty() {
        let warned = figures.warned.join("\n  ");
        page.push_str(&format!(
            "\nWARNING: what was learned may be a fault's, of which this was said meanwhile: mend it and print anew.\n  {warned}"
        ));
    }
    page
}

/// Simulated printers: truth beside what was learned.
pub(super) fn trial(figures: &trial::Figures) -> String {
    let mut page = String::new();
    for run in &figures.runs {
        page.push_str(&format!(
            "seed {}\n{:<32} {:>12} {:>12} {:>12} {:>12} {:>9}\n",
            run.seed, "", "truth", "learned", "95 % from", "to", "error %"
        ));
        for Quantity { name, value, low, high, truth, .. } in &run.quantities {
            let truth = truth.unwrap_or(f64::NAN);
            let slack = 1e-9 * truth.abs();
            let inside = (low - slack..=high + slack).contains(&truth);
            let verdict = match (inside, (value / truth - 1.0).abs() <= trial::NEAR) {
                (true, _) => "",
                (false, true) => "outside, within 5 %",
                (false, false) => "OUTSIDE",
            };
            let error = format!("{:.2}", 100.0 * (value / truth - 1.0));
            let [truth, value, low, high] = [truth, *value, *low, *high].map(digits);
            let line =
                format!("{name:<32} {truth:>12} {value:>12} {low:>12} {high:>12} {error:>9}  {verdict}");
            page.push_str(line.trim_end());
            page.push('\n');
        }
        page.push('\n');
    }
    page.push_str(&format!(
        "{:<32} {:>8} {:>8} {:>8} {:>8} {:>10} {:>14}\n",
        "", "printers", "inside", "within 5%", "either", "RMS err %", "half width %"
    ));
    for verdict in &figures.verdicts {
        let trial::Verdict { name, runs, inside, near, either, error_rms_rel, half_width_rel } = verdict;
        let (error, half) = (100.0 * error_rms_rel, 100.0 * half_width_rel);
        page.push_str(&format!(
            "{name:<32} {runs:>8} {inside:>8} {near:>9} {either:>8} {error:>10.2} {half:>14.2}\n"
        ));
    }
    page.push_str(COLUMNS);
    for trial::Stopped { seed, why } in &figures.stopped {
        page.push_str(&format!("\nNOT FINISHED, and not counted: seed {seed}, {why}"));
    }
    page
}

/// What the columns of the last table count.
const COLUMNS: &str = "\ninside: printers whose truth lies in the stated 95 % interval, about 95 of 100 where the interval is true; \
    within 5%: those\nwhose learned value is no more than 5 % off the truth; either: one or the other; half width: of the interval, \
    against the truth.";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_numbers_are_told_with_an_exponent() {
        let told = [9.888e-6, -0.000_5, 0.001, 0.15, 0.0, f64::NAN].map(digits);
        assert_eq!(told, ["9.888e-6", "-5.000e-4", "0.001000", "0.1500", "0", "-"]);
    }

    #[test]
    fn a_trial_says_what_its_columns_count() {
        let none = trial::Figures {
            gcode: String::new(),
            material: String::new(),
            verdicts: Vec::new(),
            runs: Vec::new(),
            stopped: vec![trial::Stopped { seed: 36, why: "P2 at 174 s: safeoff".to_owned() }],
        };
        let page = super::trial(&none);
        for column in [
            "inside: ",
            "within 5%: ",
            "either: ",
            "about 95 of 100",
            "counted: seed 36, P2 at 174 s: safeoff",
        ] {
            assert!(page.contains(column), "{column} in {page}");
        }
    }

    #[test]
    fn what_was_warned_of_is_told_and_nothing_where_nobody_warned() {
        let told = |warned: &[&str]| {
            page(&Figures {
                bag: "cold".to_owned(),
                readings: 1,
                widths: 0,
                refused: 0,
                warned: warned.iter().map(|&why| why.to_owned()).collect(),
                lags_at_k: None,
                quantities: Vec::new(),
            })
        };
        assert!(!told(&[]).contains("WARNING"));
        let told = told(&["P4: fan", "P2: heater"]);
        assert!(told.contains("WARNING") && told.ends_with("\n  P4: fan\n  P2: heater"), "{told}");
    }

    #[test]
    fn what_can_be_done_with_the_file_is_told() {
        let told = written(Path::new("mine.yaml"), Path::new("config/"), true);
        assert!(told.contains("WARNING: its compliance and linear lag are of this spool"), "{told}");
        let told = written(Path::new("mine.yaml"), Path::new("config/"), false);
        assert!(!told.contains("WARNING"), "nothing of it was learned: {told}");
        assert!(
            told.contains("cp -r config my_config && cp mine.yaml my_config/printers/ender3.yaml"),
            "{told}"
        );
    }
}
