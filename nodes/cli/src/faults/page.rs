//! The figures of `fdm faults` as one page that stands by itself: reaction times beside limits and other firmware.

use super::catalogue::LimitSource;
use super::figures::{FaultFigures, Figures, TrialFigures};
use super::meaning;
use maud::{DOCTYPE, Markup, html};

/// Shortest and longest time of the axis `[s]`; it is logarithmic.
const AXIS_S: (f64, f64) = (0.01, 100.0);
/// Size of a row's drawing `[px]`.
const ROW_PX: (f64, f64) = (480.0, 22.0);
/// Room at both ends of the axis for half of a mark's label `[px]`: "0.01 s" takes some 35 px.
const MARGIN_PX: f64 = 24.0;
/// Marks of the axis `[s]`.
const MARKS_S: [f64; 5] = [0.01, 0.1, 1.0, 10.0, 100.0];

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;margin:1.5rem;max-width:75rem;color:#1b2430}\
table{border-collapse:collapse;width:100%}td,th{padding:.15rem .5rem;text-align:left;white-space:nowrap}\
tr:nth-child(even){background:#f4f6f8}.missed{color:#b3261e;font-weight:600}.wide{overflow-x:auto}\
small{color:#5b6875}";

/// The page.
#[must_use]
pub fn page(figures: &Figures) -> String {
    let trials: usize = figures.faults.iter().map(|fault| fault.trials.len()).sum();
    let runs: usize = figures.faults.iter().map(|fault| fault.runs).sum();
    html! {
        (DOCTYPE)
        html lang="en" {
            (crate::html::head("Reaction times", STYLE))
            body {
                h1 { "From fault to reaction" }
                p {
                    (figures.title()) ": " (figures.faults.len()) " faults, " (trials) " trials, "
                    (runs) " runs. Times run from injection to actuation; told: until fdm says that a process ended, "
                    "hangs or cannot write. Bar: median to worst; black line: limit (none is drawn where it counts filament or "
                    "layers: it stands beside the worst time then); "
                    span style="color:#c77700" { "K" } " and " span style="color:#6a3fa0" { "M" }
                    ": what Klipper and Marlin need by their sources or as measured, no run of this table "
                    "(peers in config/faults.yaml). False trips: " (figures.false_trips) " (sound prints: "
                    (format!("{:.1}", figures.hours)) " h, " (format!("{:.1}", figures.camera_hours))
                    " h of them with the camera)."
                }
                div class="wide" { table {
                    tr { th { "ID" } th { "fault" } th { "reaction" } th { "worst / limit" } th { (axis()) } }
                    @for fault in &figures.faults {
                        @for trial in &fault.trials { (row(fault, trial)) }
                        @if fault.trials.is_empty() { (unseen(fault, figures)) }
                    }
                } }
                @for meaning in meaning::of(figures) { p { small { (meaning) } } }
            }
        }
    }
    .into_string()
}

fn row(fault: &FaultFigures, trial: &TrialFigures) -> Markup {
    let time = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.2} s"));
    let limit = trial.limit().unwrap_or_else(|| fault.limit.clone().unwrap_or_else(|| "-".to_owned()));
    let source = trial.limit_source.map(LimitSource::text);
    html! {
        tr {
            td { (fault.id) }
            td { (fault.fault) ": " (trial.name) }
            td { (trial.action) " " small { (trial.detected) "/" (trial.runs) } }
            td class=[(!trial.within_limit).then_some("missed")] title=[source] {
                (time(trial.reaction_max_s)) " / " (limit)
                @if let Some(limit_s) = trial.told_limit_s {
                    br; small { "told " (time(trial.told_max_s)) " / " (limit_s) " s" }
                }
            }
            td { (bar(trial)) }
        }
        @if !trial.figures.is_empty() {
            @let figures = trial.figures.iter().map(|(name, figure)| format!("{name} {figure:.2}"));
            tr { td {} td colspan="4" { small { (figures.collect::<Vec<_>>().join(", ")) } } }
        }
        @for measure in &trial.measures {
            tr { td {} td colspan="4" { small { (measure.text()) } } }
        }
    }
}

fn unseen(fault: &FaultFigures, figures: &Figures) -> Markup {
    let why = match (&fault.waiting, &fault.test) {
        (Some(why), _) => format!("waiting: {why}"),
        (None, Some(test)) => format!("test: {test}"),
        (None, None) => figures.elsewhere().to_owned(),
    };
    html! { tr { td { (fault.id) } td { (fault.fault) } td { (fault.action) } td colspan="2" { small { (why) } } } }
}

fn axis() -> Markup {
    drawing(&html! {
        @for mark_s in MARKS_S {
            text x=(place(mark_s)) y="15" font-size="11" text-anchor="middle" fill="#5b6875" { (mark_s) " s" }
        }
    })
}

fn bar(trial: &TrialFigures) -> Markup {
    let (middle, worst) = (trial.reaction_p50_s.map(place), trial.reaction_max_s.map(place));
    let colour = if trial.within_limit { "#2f7d4f" } else { "#b3261e" };
    drawing(&html! {
        @for mark_s in MARKS_S {
            line x1=(place(mark_s)) x2=(place(mark_s)) y1="0" y2="22" stroke="#dde3e8" {}
        }
        @if let (Some(middle), Some(worst)) = (middle, worst) {
            rect x=(middle) y="7" width=((worst - middle).max(3.0)) height="8" fill=(colour) {}
        }
        @if let Some(limit_s) = trial.limit_s.filter(|_| trial.limit_mm.is_none()) {
            line x1=(place(limit_s)) x2=(place(limit_s)) y1="2" y2="20" stroke="#1b2430" stroke-width="2" {}
        }
        @for (letter, seconds, fill) in
            [("K", trial.peers.klipper_s, "#c77700"), ("M", trial.peers.marlin_s, "#6a3fa0")]
        {
            @if let Some(seconds) = seconds {
                text x=(place(seconds)) y="15" font-size="12" text-anchor="middle" fill=(fill) { (letter) }
            }
        }
    })
}

fn drawing(inside: &Markup) -> Markup {
    html! { svg width=(ROW_PX.0) height=(ROW_PX.1) role="img" { (inside) } }
}

/// Place of a time on the axis `[px]`.
fn place(seconds: f64) -> f64 {
    let (low, high) = (AXIS_S.0.ln(), AXIS_S.1.ln());
    let share = (seconds.clamp(AXIS_S.0, AXIS_S.1).ln() - low) / (high - low);
    MARGIN_PX + share * (ROW_PX.0 - 2.0 * MARGIN_PX)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A decade is a quarter of the axis wherever it lies.
    #[test]
    fn decades_are_equally_long_and_what_is_beyond_stays_on_the_axis() {
        let decade = place(1.0) - place(0.1);
        assert!((place(100.0) - place(10.0) - decade).abs() < 1e-9);
        assert!((place(1e9) - place(100.0)).abs() < 1e-9);
        assert!(place(0.0) >= 0.0);
    }
}
