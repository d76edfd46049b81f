//! Two prints on the same axes: open against closed, before against after.

use super::View;
use super::chart::Plot;
use super::ink::Ink;
use super::trace::Trace;
use super::words::{clock, percent};
use crate::report::bag::Bag;
use crate::report::record::Record;
use crate::report::series::Series;
use maud::{Markup, html};

/// The other print.
pub(crate) struct Other<'a> {
    pub(crate) bag: &'a Bag,
    pub(crate) record: &'a Record,
}

/// A figure of the other print and of this one, and how it is written.
type Row<'a> = (&'a str, [Option<f64>; 2], &'a dyn Fn(f64) -> String);

/// Letters of a bag's name in a legend.
const NAME_MAX: usize = 40;

/// Which signal of a record is drawn, and how.
type Of = for<'r> fn(&'r Record) -> &'r Series;

/// Title, unit, signal, what the axis shows at least.
const TRUE: [(&str, &str, Of, (f64, f64)); 5] = [
    ("Width error", "%", |record| &record.truth.width_error_percent, (-5.0, 5.0)),
    ("Flow out of the nozzle, as nominal filament", "mm/s", |record| &record.truth.flow_mm_s, (0.0, 2.0)),
    ("Filament delivered less commanded, over roads", "mm", |record| &record.truth.ahead_mm, (-0.5, 0.5)),
    ("Slip in the drive gear", "%", |record| &record.truth.slip_percent, (0.0, 5.0)),
    (
        "Nozzle less what counts as right, while roads are laid",
        "K",
        |record| &record.truth.nozzle_error_k,
        (-2.0, 2.0),
    ),
];
/// What is known of a print that was not simulated.
const SEEN: [(&str, &str, Of, (f64, f64)); 4] = [
    ("Width, measured", "mm", |record| &record.signals.width_measured, (0.4, 0.5)),
    ("Slip in the drive gear, estimated", "%", |record| &record.signals.slip_percent.value, (0.0, 5.0)),
    (
        "Section of the road over the nominal one, estimated",
        "%",
        |record| &record.signals.gain_percent.value,
        (95.0, 105.0),
    ),
    (
        "Hot end less set-point, while roads are laid",
        "K",
        |record| &record.signals.hotend_error_k,
        (-2.0, 2.0),
    ),
];
/// Corrections that were permitted.
const TRIMS: [(&str, &str, Of, (f64, f64)); 5] = [
    ("Trim of the flow", "%", |record| &record.signals.permit.flow_percent, (98.0, 102.0)),
    ("Trim of the speed", "%", |record| &record.signals.permit.speed_percent, (98.0, 102.0)),
    ("Trim of the set-point", "K", |record| &record.signals.permit.offset_k, (-1.0, 1.0)),
    ("Slip made up for", "%", |record| &record.signals.permit.slip_percent, (-1.0, 1.0)),
    ("Pressure advance", "s", |record| &record.signals.permit.advance_s, (0.0, 0.1)),
];

/// The section: figures side by side, then the plots.
pub(crate) fn section(view: &View, other: &Other) -> Markup {
    let simulated = view.record.truth.last.is_some() && other.record.truth.last.is_some();
    let (own, others) = names(&view.bag.name, &other.bag.name);
    let span_s = view.span_s.max(other.record.time.newest_s);
    let plot = |(title, unit, of, shows): &(&'static str, &'static str, Of, (f64, f64))| {
        let traces = vec![
            Trace::line(&others, Ink::Measured, of(other.record)),
            Trace::line(&own, Ink::Estimated, of(view.record)),
        ];
        let span_s = span_s.max(1.0);
        let onset_s = view.record.truth.onset_s;
        Plot { span_s, onset_s, shows: Some(*shows), ..view.plot(title, unit, traces) }.draw()
    };
    html! {
        @if simulated {
            p { "Both printers were simulated: these are their true figures and signals, which no node of the loop was told." }
            (figures(view, other, (&own, &others)))
            @for signal in &TRUE { (plot(signal)) }
        } @else {
            p { "What both prints show of themselves." }
            @for signal in &SEEN { (plot(signal)) }
        }
        @for signal in &TRIMS { (plot(signal)) }
        p.note { "Each print from its own first message on; the numbered marks are this print's events, one \
            without a number is the onset of its first fault. Trims are those that the \
            supervisor permitted; a print without corrections has none." }
    }
}

/// Names in the legends: as the bags are called, told apart where they are called the same, and by their ends where those differ.
fn names(own: &str, other: &str) -> (String, String) {
    let end = |name: &str| {
        let cut = name.chars().count().saturating_sub(NAME_MAX);
        let kept: String = name.chars().skip(cut).collect();
        if cut > 0 { format!("…{kept}") } else { kept }
    };
    let by_end = end(own) != end(other);
    let short = |name: &str| {
        if by_end {
            crate::report::decode::short(&end(name), NAME_MAX + 1)
        } else {
            crate::report::decode::short(name, NAME_MAX)
        }
    };
    if own == other {
        return (format!("{}, this", short(own)), format!("{}, the other", short(other)));
    }
    (short(own), short(other))
}

/// Feed, width and quality of both, and how many times smaller this print's are.
fn figures(view: &View, other: &Other, (own, others): (&str, &str)) -> Markup {
    let (mine, theirs) = (&view.record.truth, &other.record.truth);
    let share = |value: f64| percent(value, 3);
    let plain = |value: f64| format!("{value:.3}");
    let rows: [Row; 3] = [
        ("Feed error", [theirs.feed_error_rel(), mine.feed_error_rel()], &share),
        ("Width error, RMS", [theirs.width_rms_rel(), mine.width_rms_rel()], &share),
        ("Mean Q", [theirs.quality_mean(), mine.quality_mean()], &plain),
    ];
    let shown = |value: Option<f64>, how: &dyn Fn(f64) -> String| value.map_or("-".to_owned(), how);
    let onset = |onset: Option<f64>| onset.map_or("none".to_owned(), clock);
    html! {
        div.scroll { table {
            thead { tr { th { } th.n { (others) } th.n { (own) } th.n { "times smaller" } } }
            tbody {
                @for (name, [before, after], how) in rows { tr {
                    td { (name) }
                    td.n { (shown(before, how)) }
                    td.n { (shown(after, how)) }
                    td.n { (times_smaller(before, after).map_or("-".to_owned(), |times| format!("{times:.1}"))) }
                } }
                tr { td { "First fault" } td.n { (onset(theirs.onset_s)) } td.n { (onset(mine.onset_s)) } td.n { "-" } }
            }
        } }
    }
}

fn times_smaller(before: Option<f64>, after: Option<f64>) -> Option<f64> {
    let times = before? / after.filter(|after| *after > 0.0)?;
    times.is_finite().then_some(times)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bags_of_one_name_are_told_apart() {
        assert_eq!(names("a", "b"), ("a".to_owned(), "b".to_owned()));
        assert_eq!(names("a", "a"), ("a, this".to_owned(), "a, the other".to_owned()));
        let (off, mpc) = names(&format!("{}-off", "a".repeat(40)), &format!("{}-mpc", "a".repeat(40)));
        assert!(off.starts_with("…aaa") && off.ends_with("a-off") && mpc.ends_with("a-mpc"), "{off} {mpc}");
        let tail = "z".repeat(40);
        let (first, second) = names(&format!("one{tail}"), &format!("two{tail}"));
        assert!(first.starts_with("onez") && second.starts_with("twoz") && first.ends_with('…'), "{first}");
        assert_eq!(times_smaller(Some(6.0), Some(2.0)), Some(3.0));
        assert_eq!(times_smaller(Some(6.0), Some(0.0)), None);
    }
}
