//! The last status of each component, and the worst one before.

use super::super::decode::short;
use fdm_loop_msgs::{DiagnosticArray, DiagnosticStatus};
use std::collections::BTreeMap;

/// Components that are kept.
const COMPONENTS_MAX: usize = 100;
/// Values of a component that are kept.
const VALUES_MAX: usize = 60;
/// Longest text.
const TEXT_MAX: usize = 160;

/// What is known of a component.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Component {
    pub(crate) level: u8,
    pub(crate) message: String,
    pub(crate) values: Vec<(String, String)>,
    /// Worst level of all reports.
    pub(crate) worst: u8,
    /// Message of the worst report.
    pub(crate) worst_message: String,
    /// Reports at another level than ok.
    pub(crate) not_ok: u64,
    pub(crate) reports: u64,
}

/// All components by name.
#[derive(Debug, Default)]
pub(crate) struct Diagnostics {
    pub(crate) components: BTreeMap<String, Component>,
}

impl Diagnostics {
    /// Takes a report in.
    pub(crate) fn take(&mut self, array: &DiagnosticArray) {
        for status in &array.status {
            let name = short(&status.name, TEXT_MAX);
            if self.components.len() >= COMPONENTS_MAX && !self.components.contains_key(&name) {
                continue;
            }
            self.components.entry(name).or_default().take(status);
        }
    }
}

impl Component {
    fn take(&mut self, status: &DiagnosticStatus) {
        self.reports += 1;
        self.level = status.level;
        self.message = short(&status.message, TEXT_MAX);
        if status.level != DiagnosticStatus::OK {
            self.not_ok += 1;
        }
        if status.level > self.worst {
            self.worst = status.level;
            self.worst_message.clone_from(&self.message);
        }
        let pair =
            |value: &fdm_loop_msgs::KeyValue| (short(&value.key, TEXT_MAX), short(&value.value, TEXT_MAX));
        self.values = status.values.iter().take(VALUES_MAX).map(pair).collect();
    }
}

/// Name of a level.
pub(crate) fn level_name(level: u8) -> &'static str {
    match level {
        DiagnosticStatus::OK => "ok",
        DiagnosticStatus::WARN => "warn",
        DiagnosticStatus::ERROR => "error",
        DiagnosticStatus::STALE => "stale",
        _ => "unknown",
    }
}
