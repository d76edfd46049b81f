//! P1 where its balance sees nothing: beyond the range of S1, and without the printer's orders.

mod common;

use common::print::Print;
use common::{Heater, params};
use models::command::Mode;
use models::units::{Celsius, Seconds};
use safety_supervisor::{Cause, Event, Operator, PrinterReport, Supervisor};

/// Runs for `span_s` or until ESTOP, with 95 % of the printer's state lost where `is_lost`: the block's highest temperature
/// `[degC]`, and mode and cause at the end.
fn run(
    heater: &mut Heater,
    supervisor: &mut Supervisor,
    span_s: f64,
    is_lost: bool,
) -> (f64, Mode, Option<Cause>) {
    let (from_s, mut highest_c) = (heater.now_s, heater.block_c);
    let (mut mode, mut cause) = (Mode::Init, None);
    while heater.now_s - from_s < span_s && mode != Mode::Estop {
        for event in heater.step() {
            if is_lost && matches!(event, Event::Printer(_)) && heater.now_s % 1.0 > 0.05 {
                continue;
            }
            if let Some(output) = supervisor.on_event(Seconds(heater.now_s), event) {
                (mode, cause) = (output.permit.mode, output.state.cause);
            }
        }
        if mode >= Mode::SafeOff {
            heater.target_c = 0.0;
        }
        highest_c = highest_c.max(heater.block_c);
    }
    (highest_c, mode, cause)
}

/// Heaters off does not reach a switch that conducts by itself: what warms on is cut off the mains.
#[test]
fn p1_a_heater_that_warms_behind_a_latch_is_cut_off_the_mains() {
    for seed in 0..20 {
        let mut heater = Heater::settled(seed, 210.0, 0.0, 0.0);
        let mut supervisor = Supervisor::new(params(), 1, None);
        assert_eq!(run(&mut heater, &mut supervisor, 60.0, false).2, None);
        heater.stuck_on = true;
        let (highest_c, mode, _) = run(&mut heater, &mut supervisor, 120.0, true);
        assert_eq!(mode, Mode::Estop, "seed {seed}: {highest_c}");
        assert!(highest_c < 350.0, "seed {seed}: {highest_c}");
    }
}

/// A heater that obeys is left to cool, at the end of a heat-up at full power too.
#[test]
fn what_cools_behind_a_latch_stays_there() {
    for seed in 0..20_u32 {
        let mut heater = Heater::new(seed.into());
        let mut supervisor = Supervisor::new(params(), 1, None);
        heater.target_c = 240.0;
        run(&mut heater, &mut supervisor, 60.0 + f64::from(seed), false);
        for _ in 0..3 {
            heater.spike_k = 400.0;
            run(&mut heater, &mut supervisor, 0.1, false);
        }
        let (_, mode, cause) = run(&mut heater, &mut supervisor, 200.0, false);
        assert_eq!(mode, Mode::SafeOff, "seed {seed}: {cause:?}");
    }
}

/// P12: warm as a bed is it must not become warmer behind a stop, and beyond its range it is not seen to cool.
#[test]
fn p12_a_bed_that_warms_behind_a_latch_is_cut_off_the_mains() {
    let stuck = Some((62.0, Cause::BedStuckOn)); // 15 K at 0.3 K/s, 6 s, and two medians
    let unseen = Some((8.6, Cause::HeatUnseen));
    for (from_c, rate_k_s, cut) in [(120.0, 0.3, stuck), (120.0, -0.1, None), (145.0, 0.0, unseen)] {
        let mut print = Print::acting();
        print.ask(Operator::Stop);
        print.report.bed_duty = 0.0;
        let from_s = print.now();
        while print.now() - from_s < 90.0 && print.mode() != Mode::Estop {
            let bed_c = from_c + rate_k_s * (print.now() - from_s);
            print.event(Event::Bed { stamp: Seconds(print.now()), temp: Celsius(bed_c) });
            print.run(0.1);
        }
        let cause = print.output.state.cause;
        let Some((within_s, expected)) = cut else {
            assert_eq!(print.mode(), Mode::SafeOff, "{rate_k_s} K/s: {cause:?}");
            continue;
        };
        assert_eq!((print.mode(), cause), (Mode::Estop, Some(expected)), "{rate_k_s} K/s");
        assert!(print.now() - from_s < within_s, "{rate_k_s} K/s");
    }
}

/// P13: the stop contact counts from the first reports on, while streams are still awaited.
#[test]
fn p13_the_stop_contact_counts_before_the_start_is_over() {
    let (mut heater, mut supervisor) = (Heater::new(1), Supervisor::new(params(), 1, None));
    let mut stopped_s = None;
    while heater.now_s < 1.0 && stopped_s.is_none() {
        for event in heater.step() {
            let event = match event {
                Event::Printer(report) => Event::Printer(PrinterReport { stop_input: Some(true), ..report }),
                Event::Hotend { .. } => continue,
                event => event,
            };
            if let Some(output) = supervisor.on_event(Seconds(heater.now_s), event)
                && output.permit.mode == Mode::Estop
            {
                stopped_s = Some(heater.now_s);
                assert_eq!(output.state.cause, Some(Cause::StopInput));
            }
        }
    }
    assert!(stopped_s.is_some_and(|stopped_s| stopped_s <= 0.25), "{stopped_s:?}");
}

/// One reading in ten is stamped a second and more off, late or early: the others are judged.
#[test]
fn p1_stray_stamps_do_not_hide_a_heater_that_heats() {
    for seed in 0..20 {
        let mut heater = Heater::settled(seed, 210.0, 0.0, 0.0);
        let mut supervisor = Supervisor::new(params(), 1, None);
        let mut stopped_s = None;
        while heater.now_s < 120.0 && stopped_s.is_none() {
            heater.stuck_on = heater.now_s >= 60.0;
            for event in heater.step() {
                let event = stamped_astray(&mut heater, event);
                let output = supervisor.on_event(Seconds(heater.now_s), event);
                if output.is_some_and(|output| output.permit.mode >= Mode::SafeOff) {
                    stopped_s = Some(heater.now_s - 60.0);
                }
            }
        }
        assert!(stopped_s.is_some_and(|s| (0.0..=8.0).contains(&s)), "seed {seed}: {stopped_s:?}");
    }
}

/// One temperature in ten as if it had been read 1.4 s later or earlier.
fn stamped_astray(heater: &mut Heater, event: Event) -> Event {
    match event {
        Event::Hotend { stamp, temp } if heater.random.uniform() < 0.1 => {
            let off_s = if heater.random.uniform() < 0.5 { 1.4 } else { -1.4 };
            Event::Hotend { stamp: Seconds(stamp.0 + off_s), temp }
        }
        event => event,
    }
}

/// S7: whatever the parameters require, a bed that is heated, or is about to be, has to be measured.
#[test]
fn s7_a_bed_that_heats_unmeasured_is_switched_off() {
    for (duty, target_c) in [(0.5, 0.0), (0.0, 60.0)] {
        let mut print = Print::acting();
        (print.report.bed_duty, print.report.bed_target) = (duty, Celsius(target_c));
        assert!(print.until(Mode::SafeOff) <= 3.1, "{duty}, {target_c} degC");
        assert_eq!(print.output.state.cause, Some(Cause::StaleBed));
    }
}
