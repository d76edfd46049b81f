use super::*;
use crate::wire::tests::{PARAMS, law, limits};
use models::status::HostProfile;
use models::units::Celsius;

const RAW: RawLoop = RawLoop {
    control: WireLevel::Wire,
    period_s: 0.25,
    validity_s: 1.0,
    status_age_limit_s: 0.3,
    height_age_limit_s: 2.0,
};

#[test]
fn a_command_counts_until_the_next_one_comes() {
    let refused = LoopParams::try_from(RawLoop { validity_s: 0.2, ..RAW }).unwrap_err().to_string();
    assert_eq!(refused, "validity_s = 0.2 s: must be in [0.25, 5]");
}

fn control() -> WireControl {
    let profile = Params::try_from(PARAMS).unwrap();
    WireControl::new(RAW.try_into().unwrap(), profile, (law(0.635), limits()), 7).unwrap()
}

/// The machine lays `layer` (from 0) at a place.
fn laying(stamp_s: f64, layer: u32, along_m: f64) -> PrinterStatus {
    PrinterStatus {
        stamp: Seconds(stamp_s),
        phase: JobPhase::Printing,
        host: HostProfile::Native,
        progress: 0.5,
        layer: Some(layer),
        line: 0,
        position_m: [along_m, 0.0, 0.0],
        path_speed_m_s: 1.68e-3,
        planned_speed_m_s: 1.68e-3,
        planned_feed_m_s: 3.5e-3,
        motor_position_m: 0.0,
        wanted_position_m: 0.0,
        path_time_s: 0.0,
        depositing: true,
        target_width_m: None,
        layer_height_m: Some(2.16e-3),
        hotend_target: Celsius(0.0),
        hotend_sliced_target: Celsius(0.0),
        bed_target: Celsius(0.0),
        hotend_duty: 0.0,
        bed_duty: 0.0,
        fan: 0.0,
        trims: Trims::NEUTRAL,
        advance_s: 0.0,
        homed: true,
        mains_on: true,
        filament_present: None,
        part_fan_speed_1_s: None,
        stop_input: None,
    }
}

/// A height of a layer counted from 1.
fn height(layer: u32, height_m: f64) -> WireEvent {
    WireEvent::Height(Measured { stamp: Seconds(10.0), layer, position_m: 0.02, height_m })
}

fn flow(control: &mut WireControl, status: PrinterStatus) -> f64 {
    control.on_event(WireEvent::Printer(Box::new(status)));
    control.on_event(WireEvent::Tick { now: status.stamp }).unwrap().trims.flow
}

/// Layer 1 is half a millimetre low at 20 mm: layer 2 (1 as the machine counts) gets 1 + 0.635 * 0.5 / 2.16 there.
#[test]
fn what_was_measured_of_the_layer_below_moves_both_speeds() {
    let mut control = control();
    control.on_event(height(1, 1.66e-3));
    assert!((flow(&mut control, laying(60.0, 1, 0.0205)) - 1.14699).abs() < 1e-5);
    for (stamp_s, layer, along_m) in [(60.1, 0, 0.0205), (60.2, 2, 0.0205), (60.3, 1, 0.06)] {
        assert!((flow(&mut control, laying(stamp_s, layer, along_m)) - 1.0).abs() < 1e-15);
    }
    let report = control.report();
    assert_eq!((report.corrected, report.unmeasured), (1, 3));
}

#[test]
fn nothing_is_corrected_while_nothing_is_laid() {
    let mut control = control();
    control.on_event(height(1, 1.66e-3));
    let back = PrinterStatus { depositing: false, ..laying(60.0, 1, 0.0205) };
    let paused = PrinterStatus { phase: JobPhase::Paused, ..laying(60.1, 1, 0.0205) };
    for status in [back, paused] {
        assert!((flow(&mut control, status) - 1.0).abs() < 1e-15);
    }
}

/// What is 5 mm too low asks for far more than the law's range: exactly its bound, not a rounding beyond.
#[test]
fn the_flow_stays_inside_the_range_of_the_law() {
    for (error_m, bound) in [(-4.9e-3, 1.8), (4.9e-3, 0.2)] {
        let mut control = control();
        control.on_event(height(3, 6.48e-3 + error_m));
        let flow = flow(&mut control, laying(60.0, 3, 0.0205));
        assert!((flow - bound).abs() < 1e-12 && (0.2..=1.8).contains(&flow), "{flow}");
        assert_eq!(control.report().limited, 1);
    }
}

#[test]
fn without_a_fresh_state_there_is_no_command() {
    let mut control = control();
    assert_eq!(control.on_event(WireEvent::Tick { now: Seconds(1.0) }), None);
    control.on_event(WireEvent::Printer(Box::new(laying(60.0, 1, 0.02))));
    assert!(control.on_event(WireEvent::Tick { now: Seconds(60.3) }).is_some());
    assert_eq!(control.on_event(WireEvent::Tick { now: Seconds(60.31) }), None);
    assert_eq!(control.report().starved, 2);
}

#[test]
fn bad_inputs_are_refused_and_counted() {
    let mut control = control();
    for bad in [height(1, f64::NAN), height(1, 9e-3), height(0, 0.0)] {
        control.on_event(bad);
    }
    let heights = control.report().heights;
    assert_eq!((heights.not_finite, heights.out_of_range, heights.old_layer), (1, 1, 1));
    control.on_event(WireEvent::Printer(Box::new(laying(60.0, 1, 0.02))));
    control.on_event(WireEvent::Printer(Box::new(laying(59.0, 1, 0.02))));
    control.on_event(WireEvent::Printer(Box::new(laying(61.0, 1, f64::NAN))));
    assert_eq!(control.report().printer, Counted { invalid: 1, late: 1 });
}
