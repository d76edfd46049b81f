//! The step allocates nothing: the supervisor goes on where another process has taken all memory.

mod common;

use allocation_counter::measure;
use common::print::{Print, SOUND};
use models::command::Mode;
use models::units::{Celsius, Seconds};
use safety_supervisor::{Event, Operator, What};

/// A tick of a print that hears every sensor, frame and command. Only what the supervisor does is counted.
fn allocations_of_a_tick(print: &mut Print) -> u64 {
    print.step();
    let now = Seconds(print.now() + 0.01);
    let command = print.command();
    let events = [
        Event::Hotend { stamp: now, temp: Celsius(print.temp_c) },
        // The last digits differ, as of a sound sensor.
        Event::Bed { stamp: now, temp: Celsius(60.0 + f64::from(print.tick % 7) * 0.01) },
        Event::Imu { first: now, period: Seconds(4e-4), samples: vec![[0.0, 0.0, 9.81]; 50] },
        Event::Vision(SOUND),
        command,
        Event::Tick { now },
    ];
    events.into_iter().map(|event| measure(|| drop(print.supervisor.on_event(now, event))).count_total).sum()
}

#[test]
fn a_step_of_a_sound_print_allocates_nothing() {
    let mut print = Print::acting();
    let allocations: Vec<u64> = (0..3000).map(|_| allocations_of_a_tick(&mut print)).collect();
    assert_eq!(print.mode(), Mode::Act, "{:?}", print.output.state.cause);
    let first = allocations.iter().position(|count| *count > 0);
    assert_eq!(first, None, "tick {first:?}: {:?}", first.map(|tick| allocations[tick]));
}

/// The list of decisions is the only thing that grows: the count counts.
#[test]
fn a_decision_is_what_allocates() {
    let mut print = Print::acting();
    let now = Seconds(print.now());
    let mut decided = None;
    let counted = measure(|| decided = print.supervisor.on_event(now, Event::Operator(Operator::Pause)));
    assert_eq!(decided.unwrap().events.last().unwrap().what, What::Granted(Operator::Pause));
    assert!((1..=2).contains(&counted.count_total), "{counted:?}");
}
