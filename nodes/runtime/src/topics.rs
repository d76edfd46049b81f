//! Every topic with its type and both ends of its quality of service, and every service, declared once.
//!
//! Names are relative to the node's namespace unless they begin with `/`.

use crate::qos::{self, Qos};
use fdm_loop_msgs::{
    AdvancePrediction, BeadWidth, CameraInfo, ChangeState, Clock, CompressedImage, ControlCommand,
    DefectReport, Definition, DescribeParameters, DiagnosticArray, FilamentMotion, FilamentReport,
    GetAvailableStates, GetAvailableTransitions, GetParameterTypes, GetParameters, GetState, Heartbeat, Imu,
    ImuBatch, InjectFault, LayerHeight, LayerQuality, ListParameters, Log, MotionSegment, MotionTrim,
    ParameterEvent, PrintEvent, PrintInfo, PrinterState, RosType, SafetyState, SetMode, SetParameters,
    SetParametersAtomically, SimTruth, SimWire, StateEstimate, TFMessage, Temperature, TemperatureReport,
    TransitionEvent, Trigger,
};
use models::units::Seconds;
use std::marker::PhantomData;

/// Name, type and quality of service of a topic.
#[derive(Debug)]
pub struct Topic<T> {
    name: &'static str,
    qos: Qos,
    message: PhantomData<fn() -> T>,
}

impl<T: RosType> Topic<T> {
    /// Declares a topic.
    const fn new(name: &'static str, qos: Qos) -> Self {
        Self { name, qos, message: PhantomData }
    }

    /// Name as declared, before namespace and remapping.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// Both ends of its quality of service.
    #[must_use]
    pub const fn qos(&self) -> Qos {
        self.qos
    }

    /// The declaration without its type, as a recorder wants it.
    #[must_use]
    pub const fn info(&self) -> TopicInfo {
        TopicInfo { name: self.name, qos: self.qos, definition: T::DEFINITION }
    }
}

/// A topic without its Rust type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TopicInfo {
    /// Name as declared.
    pub name: &'static str,
    /// Both ends of its quality of service.
    pub qos: Qos,
    /// Definition of its message.
    pub definition: Definition,
}

/// Name and type of a service.
#[derive(Debug)]
pub struct Service<S> {
    name: &'static str,
    service: PhantomData<fn() -> S>,
}

impl<S> Service<S> {
    /// Declares a service.
    const fn new(name: &'static str) -> Self {
        Self { name, service: PhantomData }
    }

    /// Name as declared, before namespace and remapping.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.name
    }
}

/// Hot end temperature, checked, from the thermistor node.
pub const HOTEND_TEMPERATURE: Topic<Temperature> = Topic::new("sensors/hotend/temperature", qos::SENSOR);
/// Temperature of a second sensor in the nozzle, where fitted.
pub const NOZZLE_TEMPERATURE: Topic<Temperature> = Topic::new("sensors/nozzle/temperature", qos::SENSOR);
/// Bed temperature, checked, from the thermistor node.
pub const BED_TEMPERATURE: Topic<Temperature> = Topic::new("sensors/bed/temperature", qos::SENSOR);
/// Filament position and speed from the encoder node.
pub const FILAMENT_MOTION: Topic<FilamentMotion> = Topic::new("sensors/filament/motion", qos::SENSOR);
/// Accelerations of the tool, checked, all samples.
pub const IMU_BATCH: Topic<ImuBatch> = Topic::new("sensors/imu/batch", qos::SENSOR);
/// The same, thinned out for tools.
pub const IMU_DATA: Topic<Imu> = Topic::new("sensors/imu/data_raw", qos::SENSOR_BURSTS);
/// Frames of the camera, checked but not decoded.
pub const CAMERA_IMAGE: Topic<CompressedImage> =
    Topic::new("sensors/camera/image_raw/compressed", qos::SENSOR);
/// Calibration of the camera, one message per frame.
pub const CAMERA_INFO: Topic<CameraInfo> = Topic::new("sensors/camera/camera_info", qos::SENSOR);
/// Measured height of a layer, wire process.
pub const LAYER_HEIGHT: Topic<LayerHeight> = Topic::new("sensors/layer/height", qos::SENSOR);
/// Printer and job.
pub const PRINTER_STATE: Topic<PrinterState> = Topic::new("printer/state", qos::SENSOR);
/// Moves that begin.
pub const PRINTER_MOTION: Topic<MotionSegment> = Topic::new("printer/motion", qos::RELIABLE);
/// Moves that a host which attaches trims to them has read, before they begin.
pub const PRINTER_COMING: Topic<MotionSegment> = Topic::new("printer/coming", qos::RELIABLE);
/// Raw temperatures of the firmware.
pub const TEMPERATURE_REPORT: Topic<TemperatureReport> =
    Topic::new("printer/report/temperature", qos::REPORT);
/// Raw counts of the filament encoder.
pub const FILAMENT_REPORT: Topic<FilamentReport> = Topic::new("printer/report/filament", qos::REPORT);
/// Raw accelerations of the printer's own unit.
pub const IMU_REPORT: Topic<ImuBatch> = Topic::new("printer/report/imu", qos::REPORT);
/// Frames of the printer's own camera.
pub const CAMERA_REPORT: Topic<CompressedImage> = Topic::new("printer/report/camera/compressed", qos::REPORT);
/// What the frames show.
pub const DEFECTS: Topic<DefectReport> = Topic::new("vision/defects", qos::RELIABLE);
/// Frames with what was found in them drawn.
pub const ANNOTATED: Topic<CompressedImage> = Topic::new("vision/annotated/compressed", qos::SENSOR);
/// Quality of the layers.
pub const LAYER_QUALITY: Topic<LayerQuality> = Topic::new("quality/layer", qos::RELIABLE);
/// Measured width of the road.
pub const BEAD_WIDTH: Topic<BeadWidth> = Topic::new("vision/bead_width", qos::RELIABLE);
/// Pressure advance and the next turn.
pub const ADVANCE_PREDICTION: Topic<AdvancePrediction> = Topic::new("advance/prediction", qos::RELIABLE);
/// State estimate.
pub const ESTIMATE: Topic<StateEstimate> = Topic::new("estimate/state", qos::RELIABLE);
/// The controller's wish.
pub const CONTROL_COMMAND: Topic<ControlCommand> = Topic::new("control/command", qos::COMMAND);
/// What the controller wishes for coming moves.
pub const CONTROL_SCHEDULE: Topic<MotionTrim> = Topic::new("control/schedule", qos::SCHEDULE);
/// The supervisor's permit.
pub const SAFETY_COMMAND: Topic<ControlCommand> = Topic::new("safety/command", qos::COMMAND);
/// What the supervisor lets through for coming moves.
pub const SAFETY_SCHEDULE: Topic<MotionTrim> = Topic::new("safety/schedule", qos::SCHEDULE);
/// The supervisor's state.
pub const SAFETY_STATE: Topic<SafetyState> = Topic::new("safety/state", qos::LATCHED);
/// Decisions and changes of all nodes.
pub const EVENTS: Topic<PrintEvent> = Topic::new("events", qos::RELIABLE);
/// What is being printed.
pub const PRINT_INFO: Topic<PrintInfo> = Topic::new("print/info", qos::LATCHED);
/// Proof of work of all nodes.
pub const HEARTBEAT: Topic<Heartbeat> = Topic::new("heartbeat", qos::BEAT);
/// The supervisor's beats once more, for who witnesses that one: to hear a dozen nodes for the sake of one costs more than
/// the rest of a thermistor's work. Recorded as [`HEARTBEAT`].
pub const SAFETY_HEARTBEAT: Topic<Heartbeat> = Topic::new("safety/heartbeat", qos::BEAT);
/// What the simulated printer really does: tests and reports only.
pub const SIM_TRUTH: Topic<SimTruth> = Topic::new("sim/truth/state", qos::SENSOR);
/// What the simulated wire process really is: tests and reports only.
pub const SIM_WIRE: Topic<SimWire> = Topic::new("sim/truth/wire", qos::SENSOR);
/// Simulated time.
pub const CLOCK: Topic<Clock> = Topic::new("/clock", qos::CLOCK);
/// Places of the printer's parts that do not move in what they hang on.
pub const TF_STATIC: Topic<TFMessage> = Topic::new("/tf_static", qos::LATCHED);
/// Place of the tool.
pub const TF: Topic<TFMessage> = Topic::new("/tf", qos::STANDARD);
/// Status of all nodes.
pub const DIAGNOSTICS: Topic<DiagnosticArray> = Topic::new("/diagnostics", qos::STANDARD);
/// Parameters of all nodes, as they come and change.
pub const PARAMETER_EVENTS: Topic<ParameterEvent> = Topic::new("/parameter_events", qos::RELIABLE);
/// Changes of a node's state. Not in [`ALL`]: each node has its own.
pub const TRANSITION_EVENT: Topic<TransitionEvent> = Topic::new("~/transition_event", qos::EVENT);
/// Log lines of all nodes.
pub const ROSOUT: Topic<Log> = Topic::new("/rosout", qos::ROSOUT);

/// Period of the supervisor's tick and permit on [`SAFETY_COMMAND`]: 50 Hz.
pub const PERMIT_PERIOD: Seconds = Seconds(0.02);
/// What 99.9 % of the intervals between permits keep of that period; where they do not, the supervisor says so.
pub const PERMIT_JITTER: Seconds = Seconds(0.01);
/// Longest time between two messages on [`SAFETY_STATE`]: 2 Hz.
pub const SAFETY_STATE_PERIOD: Seconds = Seconds(0.5);

/// Every topic above but [`SAFETY_HEARTBEAT`]: what a recorder may record.
pub const ALL: &[TopicInfo] = &[
    HOTEND_TEMPERATURE.info(),
    NOZZLE_TEMPERATURE.info(),
    BED_TEMPERATURE.info(),
    FILAMENT_MOTION.info(),
    PRINTER_STATE.info(),
    PRINTER_MOTION.info(),
    PRINTER_COMING.info(),
    TEMPERATURE_REPORT.info(),
    FILAMENT_REPORT.info(),
    IMU_REPORT.info(),
    IMU_BATCH.info(),
    IMU_DATA.info(),
    CAMERA_REPORT.info(),
    CAMERA_IMAGE.info(),
    CAMERA_INFO.info(),
    LAYER_HEIGHT.info(),
    DEFECTS.info(),
    ANNOTATED.info(),
    LAYER_QUALITY.info(),
    BEAD_WIDTH.info(),
    ADVANCE_PREDICTION.info(),
    ESTIMATE.info(),
    CONTROL_COMMAND.info(),
    CONTROL_SCHEDULE.info(),
    SAFETY_COMMAND.info(),
    SAFETY_SCHEDULE.info(),
    SAFETY_STATE.info(),
    EVENTS.info(),
    PRINT_INFO.info(),
    HEARTBEAT.info(),
    SIM_TRUTH.info(),
    SIM_WIRE.info(),
    CLOCK.info(),
    TF_STATIC.info(),
    TF.info(),
    DIAGNOSTICS.info(),
    PARAMETER_EVENTS.info(),
    ROSOUT.info(),
];

/// Pause: firmware pause and park.
pub const SAFETY_PAUSE: Service<Trigger> = Service::new("safety/pause");
/// Print on after a pause.
pub const SAFETY_RESUME: Service<Trigger> = Service::new("safety/resume");
/// Stop: heaters off, motion stopped.
pub const SAFETY_STOP: Service<Trigger> = Service::new("safety/stop");
/// Emergency stop.
pub const SAFETY_ESTOP: Service<Trigger> = Service::new("safety/estop");
/// A person has seen the cause of a latched mode.
pub const SAFETY_ACKNOWLEDGE: Service<Trigger> = Service::new("safety/acknowledge");
/// Observe, advise or act.
pub const SAFETY_SET_MODE: Service<SetMode> = Service::new("safety/set_mode");
/// Approve the waiting correction in the mode advise.
pub const CONTROL_APPROVE: Service<Trigger> = Service::new("control/approve");
/// Names of a node's parameters.
pub const LIST_PARAMETERS: Service<ListParameters> = Service::new("~/list_parameters");
/// Values of a node's parameters.
pub const GET_PARAMETERS: Service<GetParameters> = Service::new("~/get_parameters");
/// Types of a node's parameters.
pub const GET_PARAMETER_TYPES: Service<GetParameterTypes> = Service::new("~/get_parameter_types");
/// Unit, range and source of a node's parameters.
pub const DESCRIBE_PARAMETERS: Service<DescribeParameters> = Service::new("~/describe_parameters");
/// Sets parameters one by one.
pub const SET_PARAMETERS: Service<SetParameters> = Service::new("~/set_parameters");
/// Sets all parameters or none.
pub const SET_PARAMETERS_ATOMICALLY: Service<SetParametersAtomically> =
    Service::new("~/set_parameters_atomically");
/// Takes a managed node to another state.
pub const CHANGE_STATE: Service<ChangeState> = Service::new("~/change_state");
/// State of a managed node.
pub const GET_STATE: Service<GetState> = Service::new("~/get_state");
/// All states of a managed node.
pub const GET_AVAILABLE_STATES: Service<GetAvailableStates> = Service::new("~/get_available_states");
/// Steps that a managed node can take now.
pub const GET_AVAILABLE_TRANSITIONS: Service<GetAvailableTransitions> =
    Service::new("~/get_available_transitions");
/// All steps of a managed node.
pub const GET_TRANSITION_GRAPH: Service<GetAvailableTransitions> = Service::new("~/get_transition_graph");
/// Records to a new file from now on.
pub const RECORDER_RECORD: Service<Trigger> = Service::new("~/record");
/// Records nothing until it is asked to.
pub const RECORDER_PAUSE: Service<Trigger> = Service::new("~/pause");
/// Records on.
pub const RECORDER_RESUME: Service<Trigger> = Service::new("~/resume");
/// Writes the last seconds to a file of their own.
pub const RECORDER_SNAPSHOT: Service<Trigger> = Service::new("~/snapshot");
/// Ends the file and begins the next.
pub const RECORDER_SPLIT: Service<Trigger> = Service::new("~/split_bagfile");
/// Inject a fault into the simulated printer.
pub const INJECT_FAULT: Service<InjectFault> = Service::new("printer_sim/inject_fault");

#[cfg(test)]
mod tests {
    use super::*;
    use crate::qos::{Durability, Reliability};
    use std::collections::BTreeSet;

    #[test]
    fn names_are_unique_and_in_snake_case() {
        let names: BTreeSet<_> = ALL.iter().map(|topic| topic.name).collect();
        assert_eq!(names.len(), ALL.len());
        for name in names {
            assert!(name.chars().all(|c| c.is_ascii_lowercase() || "_/".contains(c)), "{name}");
        }
    }

    /// DDS matches only where the offered end is at least what is requested.
    #[test]
    fn every_request_is_met_by_its_offer() {
        for TopicInfo { name, qos, .. } in ALL {
            let best_effort = qos.requested.reliability == Reliability::BestEffort;
            assert!(best_effort || qos.offered.reliability == Reliability::Reliable, "{name}");
            let volatile = qos.requested.durability == Durability::Volatile;
            assert!(volatile || qos.offered.durability == Durability::TransientLocal, "{name}");
        }
    }
}
