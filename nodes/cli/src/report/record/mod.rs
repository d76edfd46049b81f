//! What a bag says, gathered in one pass and in bounded memory.

pub(crate) mod diagnostics;
pub(crate) mod ending;
pub(crate) mod events;
pub(crate) mod layers;
pub(crate) mod pictures;
pub(crate) mod print;
pub(crate) mod signals;
pub(crate) mod tally;
pub(crate) mod truth;
pub(crate) mod wall;

use super::decode::{decode, short};
use super::scan::{Raw, Visitor};
use super::timeline::Timeline;
use diagnostics::Diagnostics;
use events::Events;
use fdm_loop_msgs::{Header, RosType};
use layers::Layers;
use pictures::Pictures;
use print::Print;
use runtime::topics::{self, TopicInfo};
use signals::Signals;
use std::collections::BTreeMap;
use tally::{NAME_MAX, Tally};
use truth::Truth;
use wall::Wall;

/// Everything that the page shows.
#[derive(Debug, Default)]
pub(crate) struct Record {
    /// Namespace whose topics are shown; the first one found where none is asked for.
    pub(crate) namespace: Option<String>,
    pub(crate) time: Timeline,
    pub(crate) tally: Tally,
    pub(crate) print: Print,
    pub(crate) signals: Signals,
    pub(crate) layers: Layers,
    pub(crate) events: Events,
    pub(crate) pictures: Pictures,
    pub(crate) diagnostics: Diagnostics,
    pub(crate) truth: Truth,
    pub(crate) wall: Wall,
}

impl Visitor for Record {
    fn message(&mut self, raw: &Raw<'_>) {
        self.tally.count(raw.topic, raw.type_name);
        if let Some(known) = self.declared(raw.topic) {
            // What every graph has is no sign of a printer.
            self.tally.of_a_printer = self.tally.of_a_printer
                || !known.name.starts_with('/') && raw.type_name == known.definition.full_name();
            self.take(known.name, raw);
        }
    }

    fn note(&mut self, name: &str, values: &BTreeMap<String, String>) {
        if name == "fdm_loop" {
            self.print.note(values);
        }
    }
}

impl Record {
    /// The declaration of a topic; `None` for one that is none of this printer's.
    fn declared(&mut self, topic: &str) -> Option<TopicInfo> {
        for known in topics::ALL {
            if known.name.starts_with('/') {
                if topic == known.name {
                    return Some(*known);
                }
                continue;
            }
            // `printer/state` also ends `/x/printer/state` of another namespace: the longest namespace is not sought,
            // the first one found counts.
            let Some(namespace) = topic.strip_suffix(known.name).and_then(|front| front.strip_suffix('/'))
            else {
                continue;
            };
            self.tally.namespace(namespace);
            match &self.namespace {
                Some(ours) if ours == namespace => return Some(*known),
                Some(_) => {}
                None => {
                    self.namespace = Some(namespace.to_owned());
                    return Some(*known);
                }
            }
        }
        self.tally.foreign(topic);
        None
    }

    /// What is said of a bag without a message that a printer's graph has; `None` for any other.
    pub(crate) fn foreign(&self) -> Option<String> {
        /// Topics that are named.
        const NAMED: usize = 6;
        let tally = &self.tally;
        if tally.of_a_printer || tally.messages == 0 {
            return None;
        }
        let named = tally.topics.iter().take(NAMED);
        let mut there: Vec<String> = named
            .map(|(topic, counts)| format!("{} ({})", short(topic, NAME_MAX), counts.type_name))
            .collect();
        if tally.topics.len() > NAMED {
            there.push(format!("{} more, see `fdm bag info`", tally.topics.len() - NAMED));
        }
        Some(format!("no topic of a printer's graph is in this bag; there are {}", there.join(", ")))
    }

    /// Refuses a namespace that was asked for and has no topic.
    ///
    /// # Errors
    /// Names those that there are.
    pub(crate) fn check_namespace(&self, asked: &str) -> anyhow::Result<()> {
        let there = &self.tally.namespaces;
        if there.contains(asked) {
            return Ok(());
        }
        let names: Vec<&str> = there.iter().map(String::as_str).collect();
        let names = if names.is_empty() { "none of a printer".to_owned() } else { names.join(", ") };
        anyhow::bail!("--namespace {asked}: the bag holds nothing of it; there are {names}")
    }

    /// Takes a message of a declared topic in.
    fn take(&mut self, name: &'static str, raw: &Raw<'_>) {
        const HOTEND: &str = topics::HOTEND_TEMPERATURE.name();
        const NOZZLE: &str = topics::NOZZLE_TEMPERATURE.name();
        const BED: &str = topics::BED_TEMPERATURE.name();
        const STATE: &str = topics::PRINTER_STATE.name();
        const MOTION: &str = topics::PRINTER_MOTION.name();
        const WIDTH: &str = topics::BEAD_WIDTH.name();
        const ESTIMATE: &str = topics::ESTIMATE.name();
        const WISH: &str = topics::CONTROL_COMMAND.name();
        const PERMIT: &str = topics::SAFETY_COMMAND.name();
        const SAFETY: &str = topics::SAFETY_STATE.name();
        const EVENTS: &str = topics::EVENTS.name();
        const INFO: &str = topics::PRINT_INFO.name();
        const IMU: &str = topics::IMU_BATCH.name();
        const DEFECTS: &str = topics::DEFECTS.name();
        const QUALITY: &str = topics::LAYER_QUALITY.name();
        const ANNOTATED: &str = topics::ANNOTATED.name();
        const CAMERA: &str = topics::CAMERA_IMAGE.name();
        const TRUTH: &str = topics::SIM_TRUTH.name();
        const HEIGHT: &str = topics::LAYER_HEIGHT.name();
        const WIRE: &str = topics::SIM_WIRE.name();
        const DIAGNOSTICS: &str = topics::DIAGNOSTICS.name();
        match name {
            HOTEND => self.stamped(raw, |all, at, message| all.signals.hotend(at, &message)),
            NOZZLE => self.stamped(raw, |all, at, message| all.signals.nozzle_sensor(at, &message)),
            BED => self.stamped(raw, |all, at, message| all.signals.bed(at, &message)),
            STATE => self.stamped(raw, Self::state),
            MOTION => self.stamped(raw, |all, _, message| all.layers.motion(&message)),
            WIDTH => self.stamped(raw, Self::width),
            ESTIMATE => self.stamped(raw, Self::estimate),
            WISH => self.stamped(raw, |all, at, message| all.signals.wish.take(at, &message)),
            PERMIT => self.stamped(raw, |all, at, message| all.signals.permit.take(at, &message)),
            SAFETY => self.stamped(raw, |all, at, message| all.print.safety(at, &message)),
            EVENTS => self.stamped(raw, Self::event),
            INFO => self.stamped(raw, |all, at, message| all.print.info(at, &message)),
            IMU => self.stamped(raw, |all, at, message| all.signals.imu.take(at, &message)),
            DEFECTS => self.stamped(raw, Self::defects),
            QUALITY => self.stamped(raw, |all, _, message| all.layers.quality(&message)),
            ANNOTATED => self.stamped(raw, |all, at, message| all.pictures.annotated(at, message)),
            CAMERA => self.stamped(raw, |all, at, message| all.pictures.camera(at, message)),
            TRUTH => self.stamped(raw, Self::truth),
            HEIGHT => self.stamped(raw, |all, at, message| all.wall.measured(at, &message)),
            WIRE => self.stamped(raw, |all, at, message| all.wall.truth(at, &message)),
            DIAGNOSTICS => self.read(raw, |all, message| all.diagnostics.take(&message)),
            _ => {}
        }
    }

    /// Reads a message, or counts why it could not be read.
    fn read<T: RosType>(&mut self, raw: &Raw<'_>, then: impl FnOnce(&mut Self, T)) {
        if raw.encoding != "cdr" || raw.type_name != T::DEFINITION.full_name() {
            self.tally.other_type(raw.topic);
            return;
        }
        match decode::<T>(raw.payload) {
            Some(message) => then(self, message),
            None => self.tally.undecodable(raw.topic),
        }
    }

    /// The same for a message whose header says when it counts.
    fn stamped<T: RosType + Stamped>(&mut self, raw: &Raw<'_>, then: impl FnOnce(&mut Self, f64, T)) {
        self.read(raw, |all, message: T| match all.time.at(message.header()) {
            Some(at) => then(all, at, message),
            None => all.tally.misplaced(raw.topic),
        });
    }

    fn state(&mut self, at: f64, message: fdm_loop_msgs::PrinterState) {
        self.print.state(at, &message);
        self.signals.state(at, &message);
        self.layers.state(at, &message);
    }

    fn width(&mut self, at: f64, message: fdm_loop_msgs::BeadWidth) {
        self.signals.width(at, &message);
        self.layers.measured(at, message.width_m);
    }

    fn estimate(&mut self, at: f64, message: fdm_loop_msgs::StateEstimate) {
        let Some(read) = self.signals.estimate(at, &message) else { return };
        let area_m2 = self.print.filament_area_m2();
        if let Some(width_m) = self.layers.estimated(at, read, area_m2) {
            self.signals.width_estimated.add(at, width_m * 1e3);
        }
    }

    fn event(&mut self, at: f64, message: fdm_loop_msgs::PrintEvent) {
        if message.severity > 0 {
            self.pictures.event(at, &message);
        }
        self.print.event(at, &message);
        self.events.take(at, &message);
        if self.print.ending.done().is_none_or(|done_s| at <= done_s) {
            self.events.before_the_end = self.events.counts;
        }
    }

    fn defects(&mut self, at: f64, message: fdm_loop_msgs::DefectReport) {
        self.signals.defects(at, &message);
        if message.usable && message.confirmed && message.cause != "ok" {
            self.layers.flag(at);
        }
        self.pictures.report(at, message);
    }

    fn truth(&mut self, at: f64, message: fdm_loop_msgs::SimTruth) {
        self.truth.take(at, &message);
    }
}

/// A message with a header.
trait Stamped {
    fn header(&self) -> &Header;
}

macro_rules! stamped {
    ($($message:ident),*) => { $(
        impl Stamped for fdm_loop_msgs::$message {
            fn header(&self) -> &Header {
                &self.header
            }
        }
    )* };
}

stamped!(
    BeadWidth,
    CompressedImage,
    ControlCommand,
    DefectReport,
    ImuBatch,
    LayerHeight,
    LayerQuality,
    MotionSegment,
    PrintEvent,
    PrintInfo,
    PrinterState,
    SafetyState,
    SimTruth,
    SimWire,
    StateEstimate,
    Temperature
);
