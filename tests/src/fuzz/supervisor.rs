//! The supervisor's brain against anything that a shell could hand it, in any order and at any time.

use super::supervisor_print::Print;
use super::values::Values;
use models::command::{
    AdvanceLaw, Command, ControlHealth, EstimateHealth, Mode, MotionTrim, Scheduled, Trims,
};
use models::status::JobPhase;
use models::units::{Celsius, Seconds};
use safety_supervisor::{Cause, Defect, Event, Latch, Operator, PrinterReport, Stream, VisionReport, Worker};

/// Steps of a print; more of them say nothing new and take their time.
const STEPS: usize = 400;

/// The first byte says what a former run left behind, the others what happens.
pub fn supervisor(bytes: &[u8]) {
    let mut values = Values::new(bytes);
    let mut print = match values.below(8) {
        0 => Print::new(None),
        1 => Print::new(Some(Latch { estop: values.flag(), cause: Cause::HotendRange })),
        _ => Print::acting(),
    };
    for _ in 0..STEPS {
        if values.is_empty() {
            break;
        }
        take(&mut print, &mut values);
    }
    // Whatever came, time goes on.
    (0..5).for_each(|_| print.step());
}

fn take(print: &mut Print, values: &mut Values<'_>) {
    match values.below(16) {
        0 => (0..=values.below(64)).for_each(|_| print.step()),
        1 => {
            let stream = values.below(5);
            print.speaks[stream] = !print.speaks[stream];
        }
        2 => print.report = report(print, values),
        3 => print.temp_c = values.number(),
        4 => {
            print.tick =
                print.tick.saturating_add(i64::from(i16::from_le_bytes([values.byte(), values.byte()])))
        }
        5 => {
            let scheduled = scheduled(values);
            print.scheduled(scheduled);
        }
        6 => {
            let now = Seconds(values.number());
            let event = event(print, values);
            print.event(now, event);
        }
        _ => {
            let event = event(print, values);
            print.event(print.now(), event);
        }
    }
    print.step();
}

fn event(print: &mut Print, values: &mut Values<'_>) -> Event {
    let stamp = if values.flag() { print.now() } else { Seconds(values.number()) };
    match values.below(16) {
        0 => Event::Hotend { stamp, temp: Celsius(values.number()) },
        1 => Event::Bed { stamp, temp: Celsius(values.number()) },
        2 => Event::Encoder { stamp, position_m: values.number() },
        3 => Event::Printer(PrinterReport { stamp, ..report(print, values) }),
        4 | 5 => Event::Command(command(print, values)),
        6 => Event::EstimateHeartbeat { stamp },
        7 => Event::EstimateHealth(EstimateHealth::from_code(values.byte() % 4).unwrap_or_default()),
        8 => Event::ControlHealth(ControlHealth::from_code(values.byte() % 5).unwrap_or_default()),
        9 => {
            let (period, sample) = (Seconds(values.number()), [0; 3].map(|_: u8| values.number()));
            Event::Imu { first: stamp, period, samples: vec![sample; values.below(64)] }
        }
        10 => Event::Vision(vision(values)),
        11 => Event::Operator(operator(values)),
        12 if values.flag() => {
            if values.flag() {
                Event::RivalPermit
            } else {
                Event::RivalSample
            }
        }
        12 => Event::Refused { stream: values.pick(&Stream::ALL) },
        13 => Event::Beat { worker: values.pick(&Worker::ALL), work: u64::from(values.byte()) },
        14 => Event::Look,
        _ => Event::Tick { now: Seconds(values.number()) },
    }
}

/// The report of a sound printer with one thing changed.
fn report(print: &Print, values: &mut Values<'_>) -> PrinterReport {
    use JobPhase::{Done, Failed, Idle, Paused, Preparing, Printing};
    let mut report = PrinterReport { stamp: print.now(), ..print.report };
    let place = values.below(20);
    let number = |values: &mut Values<'_>| values.number();
    match place {
        0 => report.phase = values.pick(&[Idle, Preparing, Printing, Paused, Done, Failed]),
        1 => report.layer = values.flag().then(|| u32::from(values.byte())),
        2 => report.motor_position_m = number(values),
        3 => report.wanted_position_m = number(values),
        4 => report.hotend_duty = number(values),
        5 => report.bed_duty = number(values),
        6 => report.hotend_target = Celsius(number(values)),
        7 => report.hotend_sliced_target = Celsius(number(values)),
        8 => report.bed_target = Celsius(number(values)),
        9 => report.fan = number(values),
        10 => report.trims = trims(values),
        11 => report.path_speed_m_s = number(values),
        12 => report.filament_present = values.flag().then(|| values.flag()),
        13 => report.homed = values.flag(),
        14 => report.mains_on = values.flag(),
        15 => report.part_fan_speed_1_s = values.flag().then(|| number(values)),
        16 => report.stop_input = values.flag().then(|| values.flag()),
        _ => report.stamp = Seconds(number(values)),
    }
    report
}

fn trims(values: &mut Values<'_>) -> Trims {
    let mut trims = Trims { flow: 1.05, ..Trims::NEUTRAL };
    match values.below(6) {
        0 => trims.flow = values.number(),
        1 => trims.speed = values.number(),
        2 => trims.setpoint_offset_k = values.number(),
        3 => trims.advance_s = values.flag().then(|| values.number()),
        4 => trims.slip = values.flag().then(|| values.number()),
        _ => {}
    }
    trims
}

fn command(print: &mut Print, values: &mut Values<'_>) -> Command {
    let mut command = Command { trims: trims(values), ..print.wish() };
    match values.below(4) {
        0 => command.session = values.whole(),
        1 => command.sequence = values.whole(),
        2 => command.validity = Seconds(values.number()),
        _ => {}
    }
    command
}

fn scheduled(values: &mut Values<'_>) -> Scheduled {
    let session = if values.flag() { 3 } else { values.whole() };
    let advance = AdvanceLaw { linear_s: values.number(), shear: values.number(), index: values.number() };
    let (sequence, flow, speed) = (values.whole(), values.number(), values.number());
    let validity = Seconds(values.number());
    let carried_m = values.number();
    Scheduled { session, sequence, validity, trim: MotionTrim { sequence, flow, speed, advance, carried_m } }
}

fn vision(values: &mut Values<'_>) -> VisionReport {
    const DEFECTS: [Defect; 5] =
        [Defect::Under, Defect::Over, Defect::Spaghetti, Defect::Shift, Defect::Other];
    VisionReport {
        usable: values.flag(),
        confidence: values.number(),
        defect: values.flag().then(|| values.pick(&DEFECTS)),
        confirmed: values.flag(),
        told: values.flag(),
        offset_m: values.flag().then(|| [values.number(), values.number()]),
    }
}

fn operator(values: &mut Values<'_>) -> Operator {
    const ALL: [Operator; 12] = [
        Operator::Pause,
        Operator::Resume,
        Operator::Stop,
        Operator::Estop,
        Operator::Acknowledge,
        Operator::Acknowledge,
        Operator::Approve,
        Operator::SetMode(Mode::Observe),
        Operator::SetMode(Mode::Advise),
        Operator::SetMode(Mode::Act),
        Operator::SetMode(Mode::Act),
        Operator::SetMode(Mode::Estop),
    ];
    values.pick(&ALL)
}

/// A pause and its end, a latch and its acknowledgement, a silent sensor, a jump of the clock.
pub(super) fn seeds() -> Vec<Vec<u8>> {
    let ask = |operator: u8| [7, 1, 11, operator];
    let wait = [0, 63];
    let silent = |stream: u8| [1, stream];
    vec![
        [&[2][..], &wait, &ask(0), &wait, &ask(1), &wait].concat(),
        [&[2][..], &ask(3), &wait, &ask(4), &wait].concat(),
        [&[2][..], &silent(0), &wait, &wait, &wait, &silent(0), &ask(4), &wait].concat(),
        [&[1, 1][..], &wait, &ask(4), &wait, &ask(9)].concat(),
        [&[0][..], &wait, &[4, 0, 8], &wait, &ask(8), &wait, &ask(6)].concat(),
        [&[2][..], &[7, 1, 4, 0, 0, 0, 3], &[7, 1, 3, 6, 2, 10, 0], &[5, 1, 3, 10, 3, 10, 3, 60]].concat(),
    ]
}
