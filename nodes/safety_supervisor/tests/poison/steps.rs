//! What happens to a poisoned print between two ticks.

use crate::common::print::Print;
use models::command::{Command, Mode, Trims};
use models::status::JobPhase;
use models::units::{Celsius, Seconds};
use proptest::prelude::*;
use safety_supervisor::{Defect, Event, Operator, PrinterReport, Stream, VisionReport};

/// What happens between two ticks.
#[derive(Debug, Clone)]
pub(crate) enum Step {
    /// Ticks on which all is well, but for what was switched off.
    Well(u32),
    /// A broken value, and which one it breaks.
    Poison {
        place: usize,
        value: f64,
        whole: u64,
    },
    Ask(Operator),
    /// A stream falls silent, or speaks again.
    Switch(usize),
    Phase(JobPhase),
    /// The clock jumps by so many ticks.
    Jump(i32),
}

/// What a broken sender, a flipped bit or an attacker writes into a field.
fn broken() -> impl Strategy<Value = f64> {
    prop_oneof![
        prop::sample::select(vec![
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::MAX,
            f64::MIN,
            f64::MIN_POSITIVE / 4.0,
            -f64::MIN_POSITIVE,
            -0.0,
            0.0,
            1e300,
            -1e9,
            4.3e9,
            1e6,
        ]),
        any::<u64>().prop_map(f64::from_bits),
        -2e3..2e3,
    ]
}

/// A step, most of them poison.
pub(crate) fn step() -> impl Strategy<Value = Step> {
    use JobPhase::{Done, Failed, Idle, Paused, Preparing, Printing};
    let asked = vec![
        Operator::Pause,
        Operator::Resume,
        Operator::Stop,
        Operator::Estop,
        Operator::Acknowledge,
        Operator::Acknowledge,
        Operator::Approve,
        Operator::SetMode(Mode::Act),
        Operator::SetMode(Mode::Advise),
        Operator::SetMode(Mode::Estop),
    ];
    let phases = vec![Idle, Preparing, Printing, Printing, Printing, Paused, Done, Failed];
    let whole = prop_oneof![0..4_u64, Just(u64::MAX), any::<u64>()];
    prop_oneof![
        8 => (1..40_u32).prop_map(Step::Well),
        24 => (0..PLACES, broken(), whole).prop_map(|(place, value, whole)| Step::Poison { place, value, whole }),
        2 => prop::sample::select(asked).prop_map(Step::Ask),
        2 => (0..5_usize).prop_map(Step::Switch),
        1 => prop::sample::select(phases).prop_map(Step::Phase),
        1 => prop::sample::select(vec![-180_000, -40, 15, 60, 700, 180_000]).prop_map(Step::Jump),
    ]
}

const PLACES: usize = 29;

/// The event that carries the broken value.
pub(crate) fn poisoned(print: &Print, place: usize, value: f64, whole: u64) -> Event {
    let now = Seconds(print.now());
    let (stamp, temp) = (Seconds(value), Celsius(value));
    let report = PrinterReport { stamp: now, ..print.report };
    let frame = VisionReport {
        usable: true,
        confidence: 0.1,
        defect: Some(Defect::Spaghetti),
        confirmed: whole.is_multiple_of(2),
        told: !whole.is_multiple_of(3),
        offset_m: None,
    };
    let command =
        Command { session: 3, sequence: print.sequence + 1, validity: Seconds(1.0), trims: print.wish };
    let trims = |change: fn(&mut Trims, f64)| {
        let mut trims = print.wish;
        change(&mut trims, value);
        Event::Command(Command { trims, ..command })
    };
    match place {
        0 => Event::Hotend { stamp, temp: Celsius(print.temp_c) },
        1 => Event::Hotend { stamp: now, temp },
        2 => Event::Bed { stamp, temp: Celsius(60.0) },
        3 => Event::Bed { stamp: now, temp },
        4 => Event::Encoder { stamp, position_m: print.encoder_m },
        5 => Event::Encoder { stamp: now, position_m: value },
        6 => Event::EstimateHeartbeat { stamp },
        7 => Event::Imu { first: stamp, period: Seconds(1e-3), samples: vec![[0.0, 0.0, 9.81]; 20] },
        8 => Event::Imu { first: now, period: Seconds(value), samples: vec![[0.0, 0.0, 9.81]; 20] },
        9 => Event::Imu { first: now, period: Seconds(1e-3), samples: vec![[0.0, value, 9.81]; 20] },
        10 => Event::Vision(VisionReport { confidence: value, ..frame }),
        11 => Event::Vision(VisionReport { offset_m: Some([value, 0.0]), ..frame }),
        12 => Event::Printer(PrinterReport { stamp, ..report }),
        13 => Event::Printer(PrinterReport { motor_position_m: value, ..report }),
        14 => Event::Printer(PrinterReport { wanted_position_m: value, ..report }),
        15 => Event::Printer(PrinterReport { hotend_duty: value, ..report }),
        16 => Event::Printer(PrinterReport { bed_duty: value, ..report }),
        17 => Event::Printer(PrinterReport { hotend_target: temp, ..report }),
        18 => Event::Printer(PrinterReport { hotend_sliced_target: temp, ..report }),
        19 => Event::Printer(PrinterReport { bed_target: temp, ..report }),
        20 => Event::Printer(PrinterReport { fan: value, path_speed_m_s: value, ..report }),
        21 => trims(|trims, value| trims.flow = value),
        22 => trims(|trims, value| trims.speed = value),
        23 => trims(|trims, value| trims.setpoint_offset_k = value),
        24 => trims(|trims, value| trims.advance_s = Some(value)),
        25 => trims(|trims, value| trims.slip = Some(value)),
        26 => Event::Command(Command { sequence: whole, session: whole % 5, ..command }),
        27 => Event::Command(Command { validity: Seconds(value), ..command }),
        _ => Event::Refused { stream: Stream::ALL[(whole % 8) as usize] },
    }
}

/// Streams that a print without poison lacks: a cold bed with the noise of its reading, a tool at rest, a sound road.
pub(crate) fn sound(print: &Print) -> [Event; 3] {
    let now = Seconds(print.now());
    let road = VisionReport {
        usable: true,
        confidence: 0.0,
        defect: None,
        confirmed: false,
        told: true,
        offset_m: Some([0.0; 2]),
    };
    [
        Event::Bed { stamp: now, temp: Celsius(25.0 + f64::from(print.tick % 7) * 0.01) },
        Event::Imu { first: now, period: Seconds(1e-3), samples: vec![[0.0, 0.0, 9.81]; 20] },
        Event::Vision(road),
    ]
}
