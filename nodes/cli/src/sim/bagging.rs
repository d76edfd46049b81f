//! A bag of a print in virtual time: what would be said over DDS, with the log times of the loop's own clock.

use super::message::{Content, Message};
use super::printing::CONTROLLER_SESSION;
use anyhow::Context;
use bag_recorder::file::Stamp;
use bag_recorder::whole::WholeBag;
use bag_recorder::writer::Recorded;
use bag_recorder::{order, recorded};
use defect_classifier::convert as sight;
use fdm_loop_msgs::{ControlCommand, FilamentMotion, Header, PrintInfo, RosType, Temperature};
use models::command::{MotionTrim, Scheduled};
use models::motion::Segment;
use models::units::{Celsius, Seconds};
use mpc_controller::Coming;
use printer_sim::pace::Pace;
use printer_sim::{Simulator, convert as printer};
use runtime::topics::{self, Topic};
use runtime::wire;
use safety_supervisor::convert as safety;
use std::collections::BTreeMap;
use std::path::Path;

/// Period of the simulated truth in the bag `[s]`, as over DDS.
const TRUTH_PERIOD_S: f64 = 0.02;
/// Name under which the supervisor notes its decisions.
const SUPERVISOR: &str = "safety_supervisor";
/// Name under which the classifier notes what it sees.
const CLASSIFIER: &str = "defect_classifier";
/// Namespace of the topics.
const NAMESPACE: &str = "/printer";

/// A time as a stamp of it reads.
#[must_use]
pub fn as_stamped(time: Seconds) -> Seconds {
    Seconds(Header::at(time.0).stamp.seconds().unwrap_or(time.0))
}

/// A bag being written.
pub struct Bagging {
    bag: WholeBag,
    topics: BTreeMap<&'static str, Recorded>,
    machine: Option<defect_classifier::params::MachineParams>,
    truth: Pace,
    told: Pace,
    segments: u64,
    trims: u64,
    failed: Option<anyhow::Error>,
}

impl Bagging {
    /// Begins a bag with what is printed.
    ///
    /// # Errors
    /// A folder that cannot be made.
    pub fn create(
        path: &Path,
        info: &PrintInfo,
        machine: Option<defect_classifier::params::MachineParams>,
    ) -> anyhow::Result<Self> {
        let text = |key: &str, value: &str| (key.to_owned(), value.to_owned());
        let note = BTreeMap::from([
            text("clock", crate::replay::VIRTUAL),
            text("print_id", &info.print_id),
            text("gcode_file", &info.gcode_file),
            text("config", &info.config),
            text("config_sha256", &info.config_sha256),
            text("build", &info.build),
            text("scenario", &info.scenario),
        ]);
        let mut bagging = Self {
            bag: WholeBag::create(path, note).with_context(|| path.display().to_string())?,
            topics: BTreeMap::new(),
            machine,
            truth: Pace::new(TRUTH_PERIOD_S),
            told: Pace::new(topics::SAFETY_STATE_PERIOD.0),
            segments: 0,
            trims: 0,
            failed: None,
        };
        bagging.put(Seconds(0.0), &topics::PRINT_INFO, info);
        Ok(bagging)
    }

    /// Closes the bag, and tells how many messages it holds.
    ///
    /// # Errors
    /// The first write that failed.
    pub fn finish(self) -> anyhow::Result<u64> {
        match self.failed {
            Some(error) => Err(error),
            None => Ok(self.bag.finish()?),
        }
    }

    /// A message on its way between printer and brains; what the classifier and the estimator say is kept where they say
    /// it.
    pub fn message(&mut self, now: Seconds, message: &Message) {
        let header = || Header::at(message.stamp.0);
        let temperature =
            |temp: Celsius| Temperature { header: header(), temperature: temp.0, variance: 0.0 };
        match &message.content {
            Content::Hotend(temp) => self.put(now, &topics::HOTEND_TEMPERATURE, &temperature(*temp)),
            Content::Bed(temp) => self.put(now, &topics::BED_TEMPERATURE, &temperature(*temp)),
            Content::Nozzle(temp) => self.put(now, &topics::NOZZLE_TEMPERATURE, &temperature(*temp)),
            Content::Encoder(position_m) => {
                let read = FilamentMotion { header: header(), position_m: *position_m, speed_m_s: 0.0 };
                self.put(now, &topics::FILAMENT_MOTION, &read);
            }
            Content::Printer(status) => {
                self.put(now, &topics::PRINTER_STATE, &wire::status_to_wire(status));
            }
            Content::Imu(batch) => self.put(now, &topics::IMU_BATCH, &printer::imu((**batch).clone())),
            Content::Frame(jpeg) => {
                self.put(now, &topics::CAMERA_IMAGE, &printer::frame(message.stamp, jpeg.clone()));
            }
            Content::Command(command, health) => {
                let health = *health as u8;
                let sent = ControlCommand { health, ..wire::command_to_wire(message.stamp, command) };
                self.put(now, &topics::CONTROL_COMMAND, &sent);
            }
            Content::Permit(permit) => {
                self.put(now, &topics::SAFETY_COMMAND, &wire::permit_to_wire(message.stamp, permit));
            }
            Content::Vision(_) | Content::Estimate(_) => {}
        }
    }

    /// The stand-in's width; returns the time of exposure as its message has it.
    pub fn width(&mut self, now: Seconds, exposed: Seconds, (width_m, sigma_m): (f64, f64)) -> Seconds {
        self.put(now, &topics::BEAD_WIDTH, &printer::width(exposed, width_m, sigma_m));
        as_stamped(exposed)
    }

    /// A move; returns it as its message has it.
    pub fn motion(
        &mut self,
        now: Seconds,
        (start, path_time_s): (Seconds, f64),
        segment: &Segment,
    ) -> Option<(Seconds, Segment)> {
        self.segments += 1;
        let sent = wire::motion_to_wire(start, path_time_s, self.segments, segment);
        self.put(now, &topics::PRINTER_MOTION, &sent);
        let read = wire::motion_from_wire(&sent).ok()?;
        Some((read.start, read.segment))
    }

    /// A move that is known before it begins, with its number; returns both as its message has them.
    pub fn coming(
        &mut self,
        now: Seconds,
        (stamp, path_time_s): (Seconds, f64),
        (sequence, segment): (u64, &Segment),
    ) -> Option<Coming> {
        let sent = wire::motion_to_wire(stamp, path_time_s, sequence.saturating_add(1), segment);
        self.put(now, &topics::PRINTER_COMING, &sent);
        mpc_controller::convert::coming(&sent).ok().map(|(_, read)| read)
    }

    /// The controller's trim of a coming move; returns it as its message has it.
    pub fn wish_ahead(&mut self, now: Seconds, validity: Seconds, trim: MotionTrim) -> Option<Scheduled> {
        self.trims += 1;
        let wished = Scheduled { session: CONTROLLER_SESSION, sequence: self.trims, validity, trim };
        let sent = wire::schedule_to_wire(now, &wished);
        self.put(now, &topics::CONTROL_SCHEDULE, &sent);
        wire::schedule_from_wire(&sent).ok()
    }

    /// What the supervisor lets through of it.
    pub fn allow_ahead(&mut self, now: Seconds, allowed: &Scheduled) {
        self.put(now, &topics::SAFETY_SCHEDULE, &wire::schedule_to_wire(now, allowed));
    }

    /// A prediction; returns what the controller reads in its message.
    pub fn prediction(
        &mut self,
        now: Seconds,
        output: &advance_predictor::Output,
    ) -> Option<mpc_controller::Event> {
        let sent = advance_predictor::convert::prediction(now, output);
        self.put(now, &topics::ADVANCE_PREDICTION, &sent);
        mpc_controller::convert::prediction(&sent).ok().map(|(_, event)| event)
    }

    /// What the classifier says.
    pub fn sight(&mut self, now: Seconds, outputs: &[defect_classifier::Output], classes: &[String]) {
        use defect_classifier::Output;
        for output in outputs {
            match output {
                Output::Defects(found) => self.put(now, &topics::DEFECTS, &sight::defects(found, classes)),
                Output::Width(width) => self.put(now, &topics::BEAD_WIDTH, &sight::width(width)),
                Output::Quality(figure) => {
                    if let Some(quality) = self.machine.map(|machine| sight::quality(figure, &machine)) {
                        self.put(now, &topics::LAYER_QUALITY, &quality);
                    }
                }
                Output::Note(note) => self.put(now, &topics::EVENTS, &sight::note(note, CLASSIFIER)),
                Output::Picture { exposed, jpeg } => {
                    self.put(now, &topics::ANNOTATED, &sight::picture(*exposed, jpeg.clone()));
                }
            }
        }
    }

    /// An estimate.
    pub fn estimate(&mut self, now: Seconds, estimate: &state_estimator::Estimate) {
        self.put(now, &topics::ESTIMATE, &state_estimator::convert::estimate(estimate));
    }

    /// The supervisor's state and decisions; its permit is a [`Message`].
    pub fn safety(&mut self, now: Seconds, output: &safety_supervisor::Output) {
        for decision in &output.events {
            self.put(now, &topics::EVENTS, &safety::event(now, SUPERVISOR, decision));
        }
        if self.told.due(now) || !output.events.is_empty() {
            self.put(now, &topics::SAFETY_STATE, &safety::state(now, &output.state));
        }
    }

    /// What is really so, where it is due.
    pub fn truth(&mut self, now: Seconds, simulator: &Simulator) {
        if self.truth.due(now) {
            let (position_m, onset) = (simulator.status().motor_position_m, simulator.first_onset());
            let truth = printer::truth(simulator.truth(), position_m, onset);
            self.put(now, &topics::SIM_TRUTH, &truth);
        }
    }

    fn put<T: RosType>(&mut self, now: Seconds, topic: &Topic<T>, message: &T) {
        let log_ns = order::nanoseconds(now);
        let stamp = Stamp { log_ns, publish_ns: log_ns, sequence: 0 };
        let topics::TopicInfo { name, .. } = topic.info();
        let Recorded { channel, schema } =
            self.topics.entry(name).or_insert_with(|| recorded(format!("{NAMESPACE}/{name}"), &topic.info()));
        let written = crate::replay::encode(message)
            .context("a message cannot be encoded")
            .and_then(|payload| Ok(self.bag.put(channel, schema, stamp, &payload)?));
        if let Err(error) = written {
            self.failed.get_or_insert(error);
        }
    }
}
