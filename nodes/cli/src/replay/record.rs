//! A bag in memory: the messages that brains hear and say, in their order.

use super::brains::{CLASSIFIER, SUPERVISOR};
use super::recorded::Recorded;
use super::settings::Sessions;
use crate::report::bag::Bag;
use crate::report::decode::decode;
use crate::report::scan::{Raw, Visitor, scan_what_is_there};
use anyhow::{Context, bail};
use bag_recorder::file::NOTE;
use fdm_loop_msgs::{ControlCommand, PrintEvent, PrintInfo};
use runtime::topics;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Encoding that is read.
const CDR: &str = "cdr";
/// Log time that falls by more than this means that time itself jumped back `[ns]`.
const JUMP_NS: u64 = 1_000_000_000;
/// Longest silence within a record `[ns]`: beyond it a time is wrong, and timers would be due for years.
const GAP_NS: u64 = 24 * 3600 * 1_000_000_000;
/// Nanoseconds of an hour.
const HOUR_NS: f64 = 3.6e12;

/// Topics that are read of a bag; frames are many times as long as all others together.
const HEARD: [&str; 19] = [
    topics::HOTEND_TEMPERATURE.name(),
    topics::BED_TEMPERATURE.name(),
    topics::NOZZLE_TEMPERATURE.name(),
    topics::FILAMENT_MOTION.name(),
    topics::IMU_BATCH.name(),
    topics::PRINTER_STATE.name(),
    topics::PRINTER_MOTION.name(),
    topics::BEAD_WIDTH.name(),
    topics::DEFECTS.name(),
    topics::LAYER_QUALITY.name(),
    topics::ADVANCE_PREDICTION.name(),
    topics::ESTIMATE.name(),
    topics::CONTROL_COMMAND.name(),
    topics::SAFETY_COMMAND.name(),
    topics::PRINTER_COMING.name(),
    topics::CONTROL_SCHEDULE.name(),
    topics::SAFETY_SCHEDULE.name(),
    topics::EVENTS.name(),
    topics::CAMERA_IMAGE.name(),
];

/// A message of a bag.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Kept {
    pub(crate) log_ns: u64,
    /// Topic as declared.
    pub(crate) topic: &'static str,
    pub(crate) payload: Vec<u8>,
}

/// What is read of a bag.
#[derive(Debug, Default)]
pub(crate) struct Record {
    pub(crate) namespace: Option<String>,
    /// The messages; a new part begins where time jumped back.
    pub(crate) parts: Vec<Vec<Kept>>,
    /// Newest `fdm_loop` record.
    pub(crate) note: BTreeMap<String, String>,
    /// What was printed, as it was told.
    info: Option<PrintInfo>,
    frames: bool,
    newest_ns: u64,
    /// A message whose time cannot be.
    odd: Option<String>,
    /// Messages of any topic.
    pub(crate) messages: u64,
    /// Namespaces other than the chosen one.
    others: BTreeSet<String>,
}

impl Record {
    /// Reads a bag; frames only where they are asked for.
    pub(crate) fn read(path: &Path, namespace: Option<&str>, frames: bool) -> anyhow::Result<Self> {
        let mut record = Self { namespace: namespace.map(str::to_owned), frames, ..Self::default() };
        for file in Bag::find(path)?.files {
            scan_what_is_there(&file, &mut record)?;
        }
        if let Some(odd) = &record.odd {
            bail!("{}: {odd}", path.display());
        }
        record.check_begin().with_context(|| path.display().to_string())?;
        if record.parts.is_empty() {
            let of = namespace.map_or_else(String::new, |namespace| format!(" of namespace {namespace}"));
            let others = crate::report::bag::there_are(&record.others);
            bail!("{}: nothing{of} that a brain hears{others}", path.display());
        }
        Ok(record)
    }

    /// Parameters that were in force.
    pub(crate) fn parameters(&self) -> Recorded {
        let noted = self.note.get("config").map(String::as_str);
        let told = self.info.as_ref().map(|info| info.config.as_str());
        let of = |text: Option<&str>| text.map(Recorded::parse).filter(|recorded| !recorded.is_empty());
        of(told).or_else(|| of(noted)).unwrap_or_default()
    }

    /// Refuses a record whose timers would be due for years before its first message: those of virtual time begin at 0.
    fn check_begin(&self) -> anyhow::Result<()> {
        let late = |part: &&Vec<Kept>| part.first().is_some_and(|first| first.log_ns > GAP_NS);
        let Some(first) = self.parts.iter().find(late).and_then(|part| part.first()) else { return Ok(()) };
        if !self.is_virtual() {
            return Ok(());
        }
        bail!(
            "log time of {}: {} after the print's begin; at most {}",
            first.topic,
            hours(first.log_ns),
            hours(GAP_NS)
        )
    }

    /// Whether the log times are those of the brains' own clock, to the step.
    pub(crate) fn is_virtual(&self) -> bool {
        self.note.get("clock").is_some_and(|clock| clock == VIRTUAL)
    }

    /// Every message of a topic.
    pub(crate) fn of(&self, topic: &'static str) -> impl Iterator<Item = &Kept> {
        self.parts.iter().flatten().filter(move |kept| kept.topic == topic)
    }

    /// Whether there is a message of a topic.
    pub(crate) fn has(&self, topic: &'static str) -> bool {
        self.of(topic).next().is_some()
    }

    /// Ids of the runs that were recorded.
    pub(crate) fn sessions(&self) -> Sessions {
        let first = |topic| {
            let commands = self.of(topic).find_map(|kept| decode::<ControlCommand>(&kept.payload));
            commands.map_or(1, |command| command.session_id)
        };
        Sessions {
            controller: first(topics::CONTROL_COMMAND.name()),
            supervisor: first(topics::SAFETY_COMMAND.name()),
        }
    }

    /// Length of the record `[s]`.
    pub(crate) fn span_s(&self) -> f64 {
        let span = |part: &Vec<Kept>| Some(part.last()?.log_ns.saturating_sub(part.first()?.log_ns));
        #[allow(clippy::cast_precision_loss, reason = "a length of time for people")]
        let sum_s = self.parts.iter().filter_map(span).sum::<u64>() as f64 * 1e-9;
        sum_s
    }

    /// Log time of the last message `[ns]`.
    pub(crate) fn end_ns(&self) -> Option<u64> {
        Some(self.parts.last()?.last()?.log_ns)
    }

    /// Name of a topic as declared, where it is one of the chosen printer's.
    fn declared(&mut self, resolved: &str) -> Option<&'static str> {
        let (name, namespace) = HEARD.iter().find_map(|name| {
            let namespace = resolved.strip_suffix(name)?.strip_suffix('/')?;
            Some((*name, namespace))
        })?;
        let chosen = self.namespace.get_or_insert_with(|| namespace.to_owned());
        if *chosen == namespace {
            return Some(name);
        }
        _ = self.others.insert(namespace.to_owned());
        None
    }
}

/// A length of time for people.
fn hours(ns: u64) -> String {
    #[allow(clippy::cast_precision_loss, reason = "a length of time for people")]
    let hours = ns as f64 / HOUR_NS;
    format!("{hours:.0} h")
}

/// What the record of a print in virtual time says of its clock.
pub(crate) const VIRTUAL: &str = "virtual";

/// Whether a brain that is replayed has noted this.
fn is_brains(event: &PrintEvent) -> bool {
    [SUPERVISOR, CLASSIFIER].iter().any(|node| event.who.ends_with(node))
}

impl Visitor for Record {
    fn message(&mut self, raw: &Raw<'_>) {
        self.messages += 1;
        if raw.encoding != CDR {
            return;
        }
        if raw.topic.ends_with(topics::PRINT_INFO.name()) && self.info.is_none() {
            self.info = decode(raw.payload);
        }
        let Some(topic) = self.declared(raw.topic) else { return };
        if topic == topics::CAMERA_IMAGE.name() && !self.frames {
            return;
        }
        if topic == topics::EVENTS.name() && !decode(raw.payload).is_some_and(|event| is_brains(&event)) {
            return;
        }
        if self.parts.is_empty() || self.newest_ns.saturating_sub(raw.log_ns) > JUMP_NS {
            self.parts.push(Vec::new());
        }
        let gap_ns = raw.log_ns.saturating_sub(self.newest_ns);
        if self.newest_ns > 0 && gap_ns > GAP_NS {
            let (message, gap, most) = (self.messages, hours(gap_ns), hours(GAP_NS));
            let text = || {
                format!("log time of message {message} ({topic}): {gap} after the one before; at most {most}")
            };
            self.odd.get_or_insert_with(text);
            return;
        }
        self.newest_ns = raw.log_ns;
        let kept = Kept { log_ns: raw.log_ns, topic, payload: raw.payload.to_vec() };
        if let Some(part) = self.parts.last_mut() {
            part.push(kept);
        }
    }

    fn note(&mut self, name: &str, values: &BTreeMap<String, String>) {
        if name == NOTE {
            self.note.extend(values.clone());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Timers of virtual time begin at 0, however late the first message is: minutes are no mistake, years are.
    #[test]
    fn a_begin_that_cannot_be_is_named() {
        let virtual_note = BTreeMap::from([("clock".to_owned(), VIRTUAL.to_owned())]);
        let begins = |log_ns, note| {
            let kept = Kept { log_ns, topic: topics::ESTIMATE.name(), payload: Vec::new() };
            let record = Record { parts: vec![vec![kept]], note, ..Record::default() };
            record.check_begin().map_err(|error| error.to_string())
        };
        assert_eq!(begins(GAP_NS, virtual_note.clone()), Ok(()));
        assert_eq!(begins(1 << 60, BTreeMap::new()), Ok(()), "the times of a machine");
        let said = begins(GAP_NS * 100, virtual_note).unwrap_err();
        assert_eq!(said, "log time of estimate/state: 2400 h after the print's begin; at most 24 h");
    }

    /// One wrong stamp of a log, and timers would be due for a century.
    #[test]
    fn a_time_that_cannot_be_is_named() {
        let topic = format!("/printer/{}", topics::HOTEND_TEMPERATURE.name());
        let hear = |record: &mut Record, log_ns| {
            let (type_name, offered_qos) = ("sensor_msgs/msg/Temperature", "");
            let encoding = CDR;
            record.message(&Raw { topic: &topic, type_name, encoding, offered_qos, log_ns, payload: &[] });
        };
        let mut record = Record::default();
        for log_ns in [5, GAP_NS + 5, 1 << 62, GAP_NS + 6] {
            hear(&mut record, log_ns);
        }
        assert!(record.odd.as_ref().is_some_and(|odd| odd.contains("message 3 (")), "{:?}", record.odd);
        assert_eq!(record.parts.iter().map(Vec::len).collect::<Vec<_>>(), [3]);
    }
}
