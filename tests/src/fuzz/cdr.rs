//! Payloads of every type that a process reads, decoded as the middleware does and turned into what a brain takes.
//!
//! What is decoded is encoded again to bytes that say the same; what a node's conversion lets through is finite, and the
//! supervisor that is told of it keeps its laws. The classifier's conversions are those of `runtime::wire` and stand
//! behind OpenCV: it is these that are called.

use super::laws::{is_finite, is_one_line};
use super::supervisor_print::Print;
use byteorder::{BigEndian, LittleEndian};
use fdm_loop_msgs::{
    AdvancePrediction, BeadWidth, CameraInfo, ChangeStateRequest, Clock, CompressedImage, ControlCommand,
    DefectReport, DescribeParametersRequest, DiagnosticArray, FilamentMotion, FilamentReport,
    GetParameterTypesRequest, GetParametersRequest, Heartbeat, Imu, ImuBatch, InjectFaultRequest,
    LayerHeight, LayerQuality, ListParametersRequest, Log, MotionSegment, MotionTrim, ParameterEvent,
    PrintEvent, PrintInfo, PrinterState, SafetyState, SetModeRequest, SetParametersAtomicallyRequest,
    SetParametersRequest, SimTruth, SimWire, StateEstimate, TFMessage, Temperature, TemperatureReport,
    TransitionEvent, TriggerRequest,
};
use models::units::Seconds;
use runtime::wire::{self, WireError};
use safety_supervisor::{Event, convert as supervisor};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Debug;
use {
    advance_predictor::convert as advance, mpc_controller::convert as controller,
    state_estimator::convert as estimator,
};

/// A type by its name, and who reads it.
type Kind = (&'static str, fn(&[u8], bool));

macro_rules! kinds {
    ($($type:ident => $then:expr,)*) => {
        [$((stringify!($type), |payload, big| decoded::<$type>(payload, big, $then)),)*]
    };
}

pub(super) const KINDS: &[Kind] = &kinds! {
    Temperature => |message| {
        sound(wire::temperature_from_wire(message));
        sound(estimator::hotend(message));
        judged(&[supervisor::hotend(message), supervisor::bed(message)]);
    },
    FilamentMotion => |message| {
        sound(wire::filament_from_wire(message));
        sound(estimator::encoder(message));
        sound(controller::encoder(message));
        judged(&[supervisor::encoder(message)]);
    },
    BeadWidth => |message| {
        sound(wire::bead_width_from_wire(message));
        sound(estimator::width(message));
        sound(controller::width(message));
    },
    LayerHeight => |message| {
        sound(wire::layer_height_from_wire(message));
        sound(controller::height(message));
    },
    ImuBatch => |message| {
        sound(wire::imu_from_wire(message));
        judged(&[supervisor::imu(message)]);
    },
    CompressedImage => |message| {
        if let Ok(frame) = wire::frame_from_wire(message) {
            assert!(frame.jpeg.len() <= wire::FRAME_BYTES_MAX);
            is_finite(&frame.exposed);
            _ = camera::picture::jpeg_header(&frame.jpeg);
        }
    },
    DefectReport => |message| {
        sound(wire::defects_from_wire(message));
        judged(&[supervisor::vision(message)]);
    },
    ControlCommand => |message| {
        sound(wire::permit_from_wire(message));
        sound(wire::control_health_from_wire(message));
        judged_both(supervisor::command(message));
    },
    MotionTrim => |message| {
        sound(wire::schedule_from_wire(message));
        if let Ok((_, scheduled)) = supervisor::scheduled(message) {
            Print::acting().scheduled(scheduled);
        }
    },
    PrinterState => |message| {
        sound(wire::status_from_wire(message));
        sound(estimator::printer(message));
        sound(controller::printer(message));
        sound(controller::wire_printer(message));
        sound(advance::printer(message));
        judged(&[supervisor::printer(message)]);
    },
    MotionSegment => |message| {
        sound(wire::motion_from_wire(message));
        sound(controller::coming(message));
        sound(advance::motion(message));
    },
    StateEstimate => |message| {
        sound(wire::estimate_from_wire(message));
        sound(controller::estimate(message));
        judged_both(supervisor::estimate(message));
    },
    AdvancePrediction => |message| sound(controller::prediction(message)),
    TemperatureReport => |message| sound(wire::stamp_from_wire(&message.header)),
    FilamentReport => |message| sound(wire::stamp_from_wire(&message.header)),
    Imu => |message| sound(wire::stamp_from_wire(&message.header)),
    CameraInfo => |message| sound(wire::stamp_from_wire(&message.header)),
    LayerQuality => |message| sound(wire::stamp_from_wire(&message.header)),
    Heartbeat => |message| sound(wire::stamp_from_wire(&message.header)),
    SafetyState => |message| sound(wire::stamp_from_wire(&message.header)),
    PrintEvent => |message| sound(wire::stamp_from_wire(&message.header)),
    PrintInfo => |message| sound(wire::stamp_from_wire(&message.header)),
    DiagnosticArray => |message| sound(wire::stamp_from_wire(&message.header)),
    SimTruth => |message| sound(wire::stamp_from_wire(&message.header)),
    SimWire => |message| sound(wire::stamp_from_wire(&message.header)),
    Clock => |message| is_finite(&message.clock.seconds()),
    Log => |_| {},
    TFMessage => |_| {},
    ParameterEvent => |_| {},
    TransitionEvent => |_| {},
    InjectFaultRequest => |message| match printer_sim::convert::fault(Seconds(100.0), message) {
        Err(error) => _ = error.to_string(),
        Ok(entry) => is_finite(&entry),
    },
    SetModeRequest => |message| _ = supervisor::set_mode(message.mode),
    TriggerRequest => |_| {},
    ChangeStateRequest => |_| {},
    GetParametersRequest => |_| {},
    GetParameterTypesRequest => |_| {},
    DescribeParametersRequest => |_| {},
    ListParametersRequest => |_| {},
    SetParametersRequest => |_| {},
    SetParametersAtomicallyRequest => |_| {},
};

/// The first byte says of what type, the second in which order its bytes are.
pub fn cdr(bytes: &[u8]) {
    let [kind, order, payload @ ..] = bytes else { return };
    let (_, read) = KINDS[usize::from(*kind) % KINDS.len()];
    read(payload, order & 1 == 1);
}

fn decoded<T: Serialize + DeserializeOwned>(payload: &[u8], big: bool, then: impl Fn(&T)) {
    let read = |bytes: &[u8], big: bool| {
        let read = if big {
            cdr_encoding::from_bytes::<T, BigEndian>(bytes)
        } else {
            cdr_encoding::from_bytes::<T, LittleEndian>(bytes)
        };
        read.map(|(message, _)| message)
    };
    let Ok(message) = read(payload, big) else { return };
    let written = cdr_encoding::to_vec::<T, LittleEndian>(&message).unwrap();
    // Alignment adds seven bytes to a field at most, of which the smallest has one.
    assert!(written.len() <= 8 * payload.len() + 8, "{} bytes out of {}", written.len(), payload.len());
    let again = read(&written, false).unwrap();
    assert_eq!(cdr_encoding::to_vec::<T, LittleEndian>(&again).unwrap(), written);
    then(&message);
}

fn sound<V: Debug>(read: Result<V, WireError>) {
    match read {
        Ok(value) => is_finite(&value),
        Err(error) => is_one_line(&error.to_string()),
    }
}

fn judged(read: &[Result<(Seconds, Event), WireError>]) {
    let events: Vec<Event> = read.iter().flatten().map(|(_, event)| event.clone()).collect();
    told(events);
}

fn judged_both(read: Result<(Seconds, [Event; 2]), WireError>) {
    if let Ok((_, events)) = read {
        told(events.to_vec());
    }
}

/// A supervisor in a print hears this between two ticks.
fn told(events: Vec<Event>) {
    if events.is_empty() {
        return;
    }
    events.iter().for_each(is_finite);
    let mut print = Print::acting();
    for event in events {
        print.event(print.now(), event);
    }
    (0..3).for_each(|_| print.step());
}
