//! Events, topics and diagnostics as tables.

use super::words::clock;
use super::{View, absent};
use crate::report::record::diagnostics::level_name;
use crate::report::record::events::Line;
use fdm_loop_msgs::DiagnosticStatus;
use maud::{Markup, html};
use runtime::topics;

/// Lines of the table of events.
pub(crate) const EVENTS_MAX: usize = 150;

/// Decisions and changes, numbered as the markers on the time axes.
pub(crate) fn events(view: &View) -> Markup {
    let lines = view.record.events.lines();
    if lines.is_empty() {
        return absent("Decisions and changes", topics::EVENTS.name());
    }
    let beyond = lines.len().saturating_sub(EVENTS_MAX) as u64 + view.record.events.beyond;
    html! {
        p.note { "Equal events share a line. The numbers stand on the time axes below, the worst " (super::MARKERS_MAX) " of them." }
        div.scroll { table.events {
            thead { tr { th { "no." } th { "time" } th { "severity" } th { "who" } th { "what" } th { "cause" } th { "before → after" } } }
            tbody { @for (index, line) in lines.iter().enumerate().take(EVENTS_MAX) { (event(index + 1, line)) } }
        } }
        @if beyond > 0 { p.note { (beyond) " more are in the bag." } }
    }
}

fn event(number: usize, line: &Line) -> Markup {
    let text = &line.text;
    let who = text.who.rsplit('/').next().unwrap_or_default();
    let first = line.times_s.first().copied().unwrap_or(0.0);
    html! {
        tr class=(line.severity.name()) {
            td { (number) }
            td.nowrap {
                (clock(first))
                @if line.count > 1 { " " br; small { (line.count) " times, last " (clock(line.last_s)) } }
            }
            td { span class=(format!("tag {}", line.severity.name())) { (line.severity.name()) } }
            td { (who) }
            td { (text.what) }
            td { (text.why) }
            td { @if !text.before.is_empty() { (text.before) " → " } (text.after) }
        }
    }
}

/// Counts of the recorder and of what was read.
pub(crate) fn recorder(view: &View) -> Markup {
    let tally = &view.record.tally;
    let counts = view.bag.counts.as_ref();
    let counted = |topic: &str| counts.and_then(|counts| counts.topics.get(topic)).copied();
    let differing = tally
        .topics
        .iter()
        .filter(|(topic, counts)| counted(topic).is_some_and(|count| count != counts.messages))
        .count();
    html! {
        @if let Some(counts) = counts {
            p { "The recorder left the bag " b { (super::super::decode::short(&counts.state, 40)) } ": " (counts.messages)
                " messages in finished files; in its last run " (counts.run.received) " received, " (counts.run.dropped)
                " dropped, " (counts.run.missed) " that did not arrive, " (counts.run.log_time_raised) " with their log time raised." }
        } @else {
            p.absent { "Counts of the recorder: there is no counts.json beside the files." }
        }
        p {
            @if tally.sums_fit > 0 { "The data of " (tally.sums_fit) " of " (view.bag.files.len()) " files fit the checksum that was written with them. " }
            @else { "No file carries a checksum of its data that fits. " }
            (tally.messages) " messages were read, " (tally.unread()) " of them could not be decoded, "
            (view.record.time.strange) " have a stamp that does not fit to the others."
            @if differing > 0 { " " b { (differing) " topics hold another number of messages than the recorder counted." } }
            @if tally.beyond > 0 { " " (tally.beyond) " messages of further topics are not listed." }
        }
        @for at in &view.record.time.jumps { p.note { "The clock of the nodes jumped at " (clock(*at)) "." } }
        details {
            summary { "Topics" }
            div.scroll { table {
                thead { tr { th { "topic" } th { "type" } th.n { "messages" } th.n { "not decoded" } th.n { "stamp does not fit" } } }
                tbody { @for (topic, counts) in &tally.topics { tr {
                    td { (topic) @if tally.foreign.contains(topic) { " " small { "(not shown)" } } }
                    td { (counts.type_name) }
                    td.n { (counts.messages) }
                    td.n { (counts.undecodable + counts.other_type) }
                    td.n { (counts.misplaced) }
                } } }
            } }
        }
    }
}

/// Last status of each component, the troubled ones first.
pub(crate) fn diagnostics(view: &View) -> Markup {
    let mut components: Vec<_> = view.record.diagnostics.components.iter().collect();
    if components.is_empty() {
        return absent("Status of the nodes", topics::DIAGNOSTICS.name());
    }
    components.sort_by_key(|(_, component)| std::cmp::Reverse((component.level, component.worst)));
    html! {
        div.scroll { table {
            thead { tr { th { "component" } th { "at the end" } th { "worst" } th.n { "not ok" } th { "values at the end" } } }
            tbody { @for (name, component) in components { tr {
                td { (name) }
                td { (level(component.level)) " " (component.message) }
                td { @if component.worst != DiagnosticStatus::OK { (level(component.worst)) " " (component.worst_message) } }
                td.n { (component.not_ok) " of " (component.reports) }
                td { @if !component.values.is_empty() { details { summary { (component.values.len()) " values" }
                    @for (key, value) in &component.values { (key) ": " (value) br; }
                } } }
            } } }
        } }
    }
}

fn level(level: u8) -> Markup {
    let name = level_name(level);
    html! { span class=(format!("tag {name}")) { (name) } }
}
