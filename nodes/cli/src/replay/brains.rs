//! The brains of a printer on messages as they stand in a bag: each reads and says what its node does.

mod deliver;

use super::settings::Settings;
use advance_predictor::AdvancePredictor;
use advance_predictor::convert as foresight;
use byteorder::LittleEndian;
use defect_classifier::{Classifier, convert as sight};
use fdm_loop_msgs::{RosType, StateEstimate};
use models::units::Seconds;
use mpc_controller::{Controller, convert as control};
use runtime::topics;
use runtime::wire::WireError;
use safety_supervisor::{Event as Safety, Operator, Stream, Supervisor, convert as safety};
use state_estimator::{Estimator, convert as estimating};

/// Something that a brain has said.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Said {
    /// Topic as declared.
    pub(crate) topic: &'static str,
    /// When, on the brains' clock or as it was logged `[ns]`.
    pub(crate) at_ns: u64,
    /// CDR with its encapsulation header.
    pub(crate) payload: Vec<u8>,
}

/// Whose words reach the brains behind them as they are said now; all others as the bag has them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Feeds {
    pub(crate) estimate: bool,
    pub(crate) command: bool,
    pub(crate) prediction: bool,
    pub(crate) vision: bool,
}

/// Every brain, and what they have said.
pub(crate) struct Brains<'a> {
    settings: &'a Settings,
    feeds: Feeds,
    estimator: Estimator,
    controller: Controller,
    supervisor: Supervisor,
    predictor: Option<AdvancePredictor>,
    classifier: Option<Classifier>,
    /// Trims of coming moves so far.
    trims: u64,
    pub(crate) said: Vec<Said>,
}

/// A message as a bag stores it.
pub(crate) fn encode<T: RosType>(message: &T) -> Option<Vec<u8>> {
    let body = cdr_encoding::to_vec::<T, LittleEndian>(message).ok()?;
    Some([&[0, 1, 0, 0], body.as_slice()].concat())
}

impl<'a> Brains<'a> {
    /// Brains that have seen nothing.
    pub(crate) fn new(settings: &'a Settings, feeds: Feeds) -> anyhow::Result<Self> {
        let (estimated, controlled) = (&settings.estimated, &settings.controlled);
        let sessions = settings.sessions;
        let predictor = settings.foresight.as_ref().map(|setup| {
            let (params, compensation) = (setup.params.clone(), setup.compensation.clone());
            AdvancePredictor::new(params, compensation, setup.network.clone())
        });
        let classifier = settings.sight.as_ref();
        Ok(Self {
            settings,
            feeds,
            estimator: Estimator::new(
                settings.estimator,
                (&estimated.printer.hotend, &estimated.printer.extruder),
                &estimated.material,
            ),
            controller: Controller::new(
                settings.controller,
                (&controlled.printer.hotend, &controlled.printer.extruder),
                &controlled.material,
                sessions.controller,
            )?,
            supervisor: Supervisor::new(settings.supervisor, sessions.supervisor, None),
            predictor,
            classifier: classifier
                .map(|setup| Classifier::new(setup.params.clone(), setup.models.clone()))
                .transpose()?,
            trims: 0,
            said: Vec::new(),
        })
    }

    /// A message of the bag reaches every brain that listens to it.
    pub(crate) fn hear(&mut self, now: Seconds, topic: &'static str, payload: &[u8]) {
        let stale = self.settings.supervisor.stale;
        match topic {
            name if name == topics::HOTEND_TEMPERATURE.name() => {
                let limit = self.settings.estimator.thermistor.trust.age_limit_s;
                self.give_estimator(now, payload, limit, estimating::hotend);
                self.give_supervisor(
                    now,
                    payload,
                    (Stream::Hotend, stale.hotend.oldest_stamp()),
                    one(safety::hotend),
                );
            }
            name if name == topics::BED_TEMPERATURE.name() => {
                self.give_supervisor(now, payload, (Stream::Bed, stale.bed.oldest_stamp()), one(safety::bed));
            }
            name if name == topics::NOZZLE_TEMPERATURE.name() => {
                let limit = self.settings.estimator.nozzle_sensor.trust.age_limit_s;
                self.give_estimator(now, payload, limit, estimating::nozzle);
            }
            name if name == topics::FILAMENT_MOTION.name() => {
                let limit = self.settings.estimator.encoder.trust.age_limit_s;
                self.give_estimator(now, payload, limit, estimating::encoder);
                let limit = self.settings.controller.status_age_limit_s;
                self.give_controller(now, payload, limit, control::encoder);
                self.give_supervisor(
                    now,
                    payload,
                    (Stream::Encoder, stale.encoder.oldest_stamp()),
                    one(safety::encoder),
                );
            }
            name if name == topics::BEAD_WIDTH.name() => self.hear_width(now, payload),
            name if name == topics::PRINTER_STATE.name() => self.hear_printer(now, payload),
            name if name == topics::PRINTER_MOTION.name() => self.hear_motion(now, payload),
            name if name == topics::IMU_BATCH.name() => {
                self.give_supervisor(now, payload, (Stream::Imu, stale.imu.oldest_stamp()), one(safety::imu));
            }
            name if name == topics::CAMERA_IMAGE.name() => self.see(now, payload, sight::frame),
            name if name == topics::DEFECTS.name() => {
                self.give_supervisor(
                    now,
                    payload,
                    (Stream::Vision, stale.vision.oldest_stamp()),
                    one(safety::vision),
                );
            }
            name if name == topics::ADVANCE_PREDICTION.name() => {
                let limit = self.settings.controller.advance.age_limit_s;
                self.give_controller(now, payload, limit, control::prediction);
            }
            name if name == topics::ESTIMATE.name() => self.hear_estimate(now, payload),
            name if name == topics::CONTROL_COMMAND.name() => self.hear_command(now, payload),
            name if name == topics::PRINTER_COMING.name() => self.hear_coming(now, payload),
            name if name == topics::CONTROL_SCHEDULE.name() => self.hear_schedule(now, payload),
            _ => {}
        }
    }

    /// The estimator's timer.
    pub(crate) fn estimate(&mut self, now: Seconds) {
        let Some(estimate) = self.estimator.on_event(state_estimator::Event::Tick { now }) else { return };
        let message: StateEstimate = estimating::estimate(&estimate);
        if let Some(payload) = self.say(now, &topics::ESTIMATE, &message).filter(|_| self.feeds.estimate) {
            self.hear_estimate(now, &payload);
        }
    }

    /// The controller's timer.
    pub(crate) fn plan(&mut self, now: Seconds) {
        self.control(now, mpc_controller::Event::Tick { now });
    }

    /// The supervisor's timer.
    pub(crate) fn permit(&mut self, now: Seconds) {
        self.supervise(now, Safety::Tick { now });
    }

    /// A person asks the supervisor.
    pub(crate) fn ask(&mut self, now: Seconds, request: Operator) {
        self.supervise(now, Safety::Operator(request));
    }

    fn hear_width(&mut self, now: Seconds, payload: &[u8]) {
        let limit = self.settings.estimator.width.trust.age_limit_s;
        self.give_estimator(now, payload, limit, estimating::width);
        let limit = self.settings.controller.frame_age_limit().0;
        self.give_controller(now, payload, limit, control::width);
        self.attach_anew(now);
    }

    fn hear_printer(&mut self, now: Seconds, payload: &[u8]) {
        self.see(now, payload, sight::printer);
        let limit = self.settings.estimator.telemetry.age_limit_s;
        self.give_estimator(now, payload, limit, estimating::printer);
        let limit = self.settings.controller.status_age_limit_s;
        self.give_controller(now, payload, limit, control::printer);
        self.foretell(now, payload, foresight::printer);
        let limit = self.settings.supervisor.stale.printer.oldest_stamp();
        self.give_supervisor(now, payload, (Stream::Printer, limit), one(safety::printer));
    }

    fn hear_motion(&mut self, now: Seconds, payload: &[u8]) {
        self.see(now, payload, sight::motion);
        self.foretell(now, payload, foresight::motion);
    }

    fn hear_estimate(&mut self, now: Seconds, payload: &[u8]) {
        self.see(now, payload, sight::estimate);
        let limit = self.settings.supervisor.stale.estimate.oldest_stamp();
        self.give_supervisor(now, payload, (Stream::Estimate, limit), safety::estimate);
        let limit = self.settings.controller.estimate_age_limit_s;
        self.give_controller(now, payload, limit, control::estimate);
    }

    fn hear_command(&mut self, now: Seconds, payload: &[u8]) {
        let limit = self.settings.supervisor.stale.command.oldest_stamp();
        self.give_supervisor(now, payload, (Stream::Command, limit), safety::command);
    }
}

/// Names of nodes that note events.
pub(crate) const SUPERVISOR: &str = "safety_supervisor";
/// As [`SUPERVISOR`].
pub(crate) const CLASSIFIER: &str = "defect_classifier";
/// No limit of age: these nodes take what is seconds old.
const FOREVER: Seconds = Seconds(f64::INFINITY);

/// A reader of one event as one of several.
fn one<T>(
    read: impl Fn(&T) -> Result<(Seconds, Safety), WireError>,
) -> impl Fn(&T) -> Result<(Seconds, [Safety; 1]), WireError> {
    move |message| read(message).map(|(stamp, event)| (stamp, [event]))
}
