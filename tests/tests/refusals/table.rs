//! One entry per topic: a sound message, and what makes it a bad one.

use fdm_loop_msgs::{
    AdvancePrediction, BeadWidth, CompressedImage, ControlCommand, DefectReport, FilamentMotion,
    FilamentReport, Header, Heartbeat, ImuBatch, MotionSegment, MotionTrim, PrinterState, RosType,
    StateEstimate, Temperature, TemperatureReport,
};
use runtime::topics::{self, Topic};
use runtime::{Node, wire};

/// What is sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Sound,
    NotFinite,
    OutOfRange,
    Stale,
    Malformed,
}

impl Kind {
    pub(crate) const BAD: [Self; 4] = [Self::NotFinite, Self::OutOfRange, Self::Stale, Self::Malformed];
    /// Bad messages of topics that carry numbers.
    pub(crate) const NUMBERS: &[Self] = &[Self::NotFinite, Self::OutOfRange, Self::Stale];
    /// Bad messages of topics that carry frames: there is no float in them.
    const FRAMES: &[Self] = &[Self::Malformed, Self::OutOfRange, Self::Stale];

    /// Ending of the counter that must rise.
    pub(crate) fn reason(self) -> &'static str {
        match self {
            Self::Sound => "",
            Self::NotFinite => "not_finite",
            Self::OutOfRange => "out_of_range",
            Self::Stale => "stale",
            Self::Malformed => "malformed",
        }
    }
}

/// Age of a stale message `[s]`: beyond every limit of `config/`.
const OLD_S: f64 = 30.0;

/// A topic and its messages.
pub(crate) struct Entry {
    pub(crate) topic: &'static str,
    /// Bad messages that its type can hold.
    pub(crate) bad: &'static [Kind],
    /// Sends a message of a kind at a time.
    pub(crate) send: Box<dyn Fn(Kind, f64)>,
}

/// A message of a topic.
struct Sample<T> {
    sound: T,
    header: fn(&mut T) -> &mut Header,
    /// Sets one field.
    set: fn(&mut T, f64),
    out_of_range: f64,
}

fn entry<T: RosType + Clone>(node: &mut Node, topic: &Topic<T>, sample: Sample<T>) -> Entry {
    let publisher = node.publish_on(topic).unwrap();
    let send = move |kind, now_s: f64| {
        let mut message = sample.sound.clone();
        match kind {
            Kind::NotFinite => (sample.set)(&mut message, f64::NAN),
            Kind::OutOfRange => (sample.set)(&mut message, sample.out_of_range),
            Kind::Sound | Kind::Stale | Kind::Malformed => {}
        }
        let stamp_s = if kind == Kind::Stale { now_s - OLD_S } else { now_s };
        let header = (sample.header)(&mut message);
        header.stamp = Header::at(stamp_s).stamp;
        publisher.send(message);
    };
    Entry { topic: topic.name(), bad: Kind::NUMBERS, send: Box::new(send) }
}

/// The least JPEG of a size, as far as its header goes.
fn jpeg(width_px: u16, height_px: u16) -> Vec<u8> {
    let mut bytes = vec![0xff, 0xd8, 0xff, 0xc0, 0, 11, 8];
    bytes.extend(height_px.to_be_bytes());
    bytes.extend(width_px.to_be_bytes());
    bytes.extend([1, 1, 0x11, 0, 0xff, 0xda, 0, 8, 1, 1, 0, 0, 63, 0, 0x55, 0xff, 0xd9]);
    bytes
}

/// Frames of the size that `config/camera.param.yaml` names; of 100 megapixels where out of range.
fn frames(node: &mut Node, topic: &Topic<CompressedImage>) -> Entry {
    let publisher = node.publish_on(topic).unwrap();
    let send = move |kind, now_s: f64| {
        let data = match kind {
            Kind::OutOfRange => jpeg(10_000, 10_000),
            Kind::Malformed => b"\xff\xd8\xff no JPEG".to_vec(),
            Kind::Sound | Kind::Stale | Kind::NotFinite => jpeg(640, 480),
        };
        let stamp_s = if kind == Kind::Stale { now_s - OLD_S } else { now_s };
        publisher.send(CompressedImage { header: Header::at(stamp_s), format: "jpeg".into(), data });
    };
    Entry { topic: topic.name(), bad: Kind::FRAMES, send: Box::new(send) }
}

/// 50 samples at rest, as `config/imu.param.yaml` expects them.
fn accelerations() -> Sample<ImuBatch> {
    Sample {
        sound: ImuBatch {
            period_s: 1e-3,
            header: Header { frame_id: "imu".into(), ..Header::default() },
            range_m_s2: 156.9,
            x_m_s2: vec![0.0; 50],
            y_m_s2: vec![0.0; 50],
            z_m_s2: vec![9.81; 50],
            ..ImuBatch::default()
        },
        header: |message| &mut message.header,
        set: |message, value| message.x_m_s2[7] = value,
        out_of_range: 157.0,
    }
}

fn defects() -> Sample<DefectReport> {
    Sample {
        sound: DefectReport {
            usable: true,
            classes: vec!["ok".into(), "shift".into()],
            probabilities: vec![0.9, 0.1],
            confidence: 0.1,
            ..DefectReport::default()
        },
        header: |message| &mut message.header,
        set: |message, value| message.confidence = value,
        out_of_range: 1.5,
    }
}

/// A trim of a coming move: it counts beside commands of its publisher only, so a sound one is a stranger's.
fn schedule() -> Sample<MotionTrim> {
    Sample {
        sound: MotionTrim {
            validity_s: 1.0,
            segment: 1,
            flow_factor: 1.0,
            speed_factor: 1.0,
            advance_index: 0.4,
            ..MotionTrim::default()
        },
        header: |message| &mut message.header,
        set: |message, value| message.flow_factor = value,
        out_of_range: 11.0,
    }
}

fn coming() -> Sample<MotionSegment> {
    Sample {
        sound: MotionSegment { sequence: 1, ..MotionSegment::default() },
        header: |message| &mut message.header,
        set: |message, value| message.length_m = value,
        out_of_range: 101.0,
    }
}

fn temperature() -> Sample<Temperature> {
    Sample {
        sound: Temperature { temperature: 210.0, ..Temperature::default() },
        header: |message| &mut message.header,
        set: |message, value| message.temperature = value,
        out_of_range: 5000.0,
    }
}

fn estimate() -> StateEstimate {
    let mut covariance = vec![0.0; 36];
    (0..6).for_each(|index| covariance[index * 7] = 1e-6);
    StateEstimate {
        names: wire::STATES.map(str::to_owned).to_vec(),
        x: vec![483.0, 475.0, 483.0, 2e-3, 0.01, 1.0],
        covariance,
        observed: vec![true; 6],
        held: vec![false; 6],
        reference_feed_m_s: 2e-3,
        channels: wire::CHANNELS.map(str::to_owned).to_vec(),
        alive: vec![true; 4],
        measured: vec![true; 4],
        nis: vec![1.0; 4],
        nis_mean: vec![1.0; 4],
        gated: vec![0; 4],
        chi_square: vec![20.0; 4],
        ..StateEstimate::default()
    }
}

fn printer() -> Sample<PrinterState> {
    Sample {
        sound: PrinterState {
            flow_factor: 1.0,
            speed_factor: 1.0,
            homed: true,
            mains_on: true,
            ..PrinterState::default()
        },
        header: |message| &mut message.header,
        set: |message, value| message.hotend_duty = value,
        out_of_range: 1.5,
    }
}

fn prediction() -> Sample<AdvancePrediction> {
    Sample {
        sound: AdvancePrediction {
            advance_known: true,
            advance_s: 0.5,
            advance_index: 0.5,
            ..AdvancePrediction::default()
        },
        header: |message| &mut message.header,
        set: |message, value| message.advance_s = value,
        out_of_range: 100.0,
    }
}

/// A command, or a permit, of the slicer's own values.
fn command() -> Sample<ControlCommand> {
    Sample {
        sound: ControlCommand {
            validity_s: 0.25,
            flow_factor: 1.0,
            speed_factor: 1.0,
            ..ControlCommand::default()
        },
        header: |message: &mut ControlCommand| &mut message.header,
        set: |message: &mut ControlCommand, value| message.flow_factor = value,
        out_of_range: 11.0,
    }
}

/// Every topic that a node of the control path subscribes.
pub(crate) fn all(node: &mut Node) -> Vec<Entry> {
    let report = Sample {
        sound: TemperatureReport { hotend_degc: 210.0, bed_degc: 60.0, ..TemperatureReport::default() },
        header: |message: &mut TemperatureReport| &mut message.header,
        set: |message: &mut TemperatureReport, value| message.hotend_degc = value,
        out_of_range: 5000.0,
    };
    let counts = Sample {
        sound: FilamentReport { counts: 0, quantum_m: 1e-5, ..FilamentReport::default() },
        header: |message: &mut FilamentReport| &mut message.header,
        set: |message: &mut FilamentReport, value| message.quantum_m = value,
        out_of_range: 1.0,
    };
    let motion = Sample {
        sound: FilamentMotion::default(),
        header: |message: &mut FilamentMotion| &mut message.header,
        set: |message: &mut FilamentMotion, value| message.position_m = value,
        out_of_range: 1e9,
    };
    let width = Sample {
        sound: BeadWidth { width_m: 4.5e-4, sigma_m: 1e-5, ..BeadWidth::default() },
        header: |message: &mut BeadWidth| &mut message.header,
        set: |message: &mut BeadWidth, value| message.width_m = value,
        out_of_range: 1.0,
    };
    let permits = Entry { bad: &[], ..entry(node, &topics::SAFETY_COMMAND, command()) };
    // Nobody acts on a number in a beat.
    let beat = Sample {
        sound: Heartbeat { node: "/peer".to_owned(), ..Heartbeat::default() },
        header: |message: &mut Heartbeat| &mut message.header,
        set: |_, _| (),
        out_of_range: 0.0,
    };
    let beats = Entry { bad: &[], ..entry(node, &topics::HEARTBEAT, beat) };
    let state = Sample {
        sound: estimate(),
        header: |message: &mut StateEstimate| &mut message.header,
        set: |message: &mut StateEstimate, value| message.x[1] = value,
        out_of_range: -1.0,
    };
    vec![
        entry(node, &topics::ADVANCE_PREDICTION, prediction()),
        entry(node, &topics::TEMPERATURE_REPORT, report),
        entry(node, &topics::FILAMENT_REPORT, counts),
        entry(node, &topics::HOTEND_TEMPERATURE, temperature()),
        entry(node, &topics::BED_TEMPERATURE, temperature()),
        entry(node, &topics::NOZZLE_TEMPERATURE, temperature()),
        entry(node, &topics::FILAMENT_MOTION, motion),
        entry(node, &topics::PRINTER_STATE, printer()),
        entry(node, &topics::BEAD_WIDTH, width),
        entry(node, &topics::CONTROL_COMMAND, command()),
        permits,
        beats,
        entry(node, &topics::CONTROL_SCHEDULE, schedule()),
        entry(node, &topics::PRINTER_COMING, coming()),
        entry(node, &topics::ESTIMATE, state),
        entry(node, &topics::IMU_REPORT, accelerations()),
        entry(node, &topics::IMU_BATCH, accelerations()),
        entry(node, &topics::DEFECTS, defects()),
        frames(node, &topics::CAMERA_REPORT),
    ]
}
