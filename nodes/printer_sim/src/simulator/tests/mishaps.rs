//! Faults of motion, part and melt: what they do to the truth and what they leave alone.

use super::*;

fn same<const N: usize>(a_m: [f64; N], b_m: [f64; N]) -> bool {
    a_m.iter().zip(b_m).all(|(a_m, b_m)| (a_m - b_m).abs() < 1e-12)
}

const SKIP: &str = "component: motion, kind: layer_shift_x, size: 8.0e-4";

#[test]
fn lost_steps_put_the_tool_off_while_the_firmware_believes_in_its_position() {
    let mut simulator = warm(straight_job(30), &fault_at(5.0, SKIP));
    run_for(&mut simulator, 4.999);
    assert!(same(simulator.tool_m(), simulator.status().position_m));
    run_for(&mut simulator, 0.01);
    let (tool_m, believed_m) = (simulator.tool_m(), simulator.status().position_m);
    assert!(same(tool_m, [believed_m[0] + 8e-4, believed_m[1], believed_m[2]]), "{tool_m:?}");
    assert!(same(simulator.truth().layer_shift_m, [8e-4, 0.0]));
}

/// P8: a pause never corrects a shift.
#[test]
fn a_pause_and_a_resume_leave_the_shift() {
    let mut simulator = warm(straight_job(30), &fault_at(3.0, SKIP));
    run_for(&mut simulator, 4.0);
    let (mode, validity) = (Mode::Act, Seconds(0.25));
    for (first, request) in [(1, Request::Pause), (6, Request::Run)] {
        for sequence in first..first + 5 {
            let permit = Permit { session: 1, sequence, validity, mode, request, trims: Trims::NEUTRAL };
            simulator.on_permit(permit).unwrap();
            run_for(&mut simulator, 0.2);
        }
        assert_eq!(simulator.phase() == JobPhase::Paused, request == Request::Pause);
        assert!(same(simulator.truth().layer_shift_m, [8e-4, 0.0]));
    }
}

/// End stops are the only reference: homing x gives x back, and nothing else.
#[test]
fn homing_an_axis_ends_its_shift() {
    let two = scenario(
        "description: t\nfaults:\n  - {component: motion, kind: layer_shift_x, size: 8.0e-4, onset: {time_s: 0.01}}\n  \
         - {component: motion, kind: layer_shift_y, size: -1.6e-3, onset: {time_s: 0.01}}",
    );
    let job = job_of(&[Action::Dwell(Seconds(1.0)), Action::Home([true, false, false])]);
    let mut simulator = warm(job, &two);
    run_for(&mut simulator, 0.5);
    assert!(same(simulator.truth().layer_shift_m, [8e-4, -1.6e-3]));
    run_for(&mut simulator, 1.0);
    assert!(same(simulator.truth().layer_shift_m, [0.0, -1.6e-3]));
}

#[test]
fn a_knock_leaves_position_and_print_alone() {
    let end = |faults: &Scenario| {
        let mut simulator = warm(straight_job(5), faults);
        run_to_end(&mut simulator);
        (simulator.tool_m(), simulator.truth().integrals, simulator.truth().layer_shift_m)
    };
    let knocked = end(&fault_at(3.0, "component: motion, kind: knock, size: 45.0"));
    assert_eq!(knocked, end(&Scenario::default()));
}

#[test]
fn nothing_lands_on_a_part_that_came_off_and_the_firmware_does_not_know() {
    let mut simulator = warm(straight_job(30), &fault_at(5.0, "component: part, kind: detached"));
    run_for(&mut simulator, 4.9);
    let before = *simulator.truth();
    assert!(before.depositing && before.width_m > 4e-4 && !before.detached);
    run_for(&mut simulator, 1.0);
    let after = *simulator.truth();
    assert!(!after.depositing && after.width_m <= 0.0 && after.detached);
    assert!(simulator.status().depositing);
    // The extruder goes on: 1 s of u = 0.09 mm2 x 50 mm/s / 2.405 mm2.
    assert!((after.outlet_m - before.outlet_m) / 1.8e-3 > 0.9, "{}", after.outlet_m - before.outlet_m);
}

#[test]
fn a_missing_road_has_no_width_to_measure() {
    let mut simulator = warm(straight_job(10), &fault_at(3.0, "component: part, kind: detached"));
    run_for(&mut simulator, 8.0);
    let mut exposures = Vec::new();
    while let Some(output) = simulator.poll() {
        if let Output::Width { exposed, .. } = output {
            exposures.push(exposed.0);
        }
    }
    assert!(!exposures.is_empty() && exposures.iter().all(|exposed_s| *exposed_s < 3.0), "{exposures:?}");
}

/// A fifth of half a second, sooner or later, where nothing is left out; on the beat without.
#[test]
fn widths_are_exposed_off_the_beat_by_no_more_than_their_dither() {
    let off_s = |width_dither: f64| {
        let mut params = params();
        params.simulator.sensors.width_dither = width_dither;
        let mut simulator = Simulator::new(params, straight_job(10), &Scenario::default(), 1).unwrap();
        simulator.warm_up(&Preheat { hotend: Some(Celsius(226.0)), bed: Some(Celsius(60.0)) });
        run_for(&mut simulator, 8.0);
        std::iter::from_fn(|| simulator.poll())
            .filter_map(
                |output| if let Output::Width { exposed, .. } = output { Some(exposed.0) } else { None },
            )
            .map(|exposed_s| (exposed_s / 0.5 - (exposed_s / 0.5).round()).abs() * 0.5)
            .fold(0.0, f64::max)
    };
    assert!((0.05..0.102).contains(&off_s(0.2)), "{}", off_s(0.2));
    assert!(off_s(0.0) < 2e-3);
}

#[test]
fn a_printer_without_the_stand_in_gives_no_widths() {
    let mut params = params();
    params.simulator.sensors.width_period_s = 0.0;
    let mut simulator = Simulator::new(params, straight_job(5), &Scenario::default(), 1).unwrap();
    simulator.warm_up(&Preheat { hotend: Some(Celsius(226.0)), bed: Some(Celsius(60.0)) });
    run_for(&mut simulator, 4.0);
    let shown = std::iter::from_fn(|| simulator.poll()).filter(|o| matches!(o, Output::Width { .. }));
    assert_eq!(shown.count(), 0);
}

/// Under-extrusion that no sensor of the filament sees: 20 % of the melt escapes beside the nozzle.
#[test]
fn a_leak_thins_the_road_by_its_share_and_leaves_the_encoder_alone() {
    let end = |faults: &Scenario| {
        let mut simulator = warm(straight_job(20), faults);
        run_for(&mut simulator, 18.0);
        *simulator.truth()
    };
    let sound = end(&Scenario::default());
    let leaking = end(&fault_at(5.0, "component: extruder, kind: leak, size: 0.2"));
    // The slip's creep falls with the force, so the gear passes a little more: (F/40 N)^2 of 2 %.
    assert!((leaking.delivered_m / sound.delivered_m - 1.0).abs() < 2e-3);
    let area_m2 = |width_m: f64| stadium::area_m2(width_m, HEIGHT_M);
    let kept = area_m2(leaking.width_m) / area_m2(sound.width_m);
    assert!((kept - 0.8).abs() < 5e-3, "{kept}");
    // The nozzle passes 80 %, and the melt is a power law: F falls with (0.8)^n, n about 0.43.
    let force = leaking.force_n / sound.force_n;
    assert!((force - 0.8_f64.powf(0.43)).abs() < 0.02, "{force}");
    assert!((leaking.gain / sound.gain - 0.8).abs() < 1e-9);
}

/// Filament is conserved with a leak too: what passed the gear is in the road, beside the nozzle, or compressed.
#[test]
fn a_leak_loses_no_filament_from_the_account() {
    let mut simulator = warm(straight_job(20), &fault_at(5.0, "component: extruder, kind: leak, size: 0.5"));
    run_to_end(&mut simulator);
    let stored_m = simulator.truth().delivered_m - simulator.truth().outlet_m;
    assert!((0.5e-3..2.2e-3).contains(&stored_m), "{stored_m}");
}

/// Twenty readings of the bed, sounder than its block moves, from the onset of ten times the noise on `[degC]`.
fn noisy_bed_c(run: u64, seed: Option<u64>) -> Vec<f64> {
    let Scenario { faults, .. } = fault_at(2.0, "component: bed_thermistor, kind: noise, size: 10");
    let faults = faults.into_iter().map(|entry| seed.map_or(Ok(entry), |seed| entry.seeded(seed)).unwrap());
    let scenario = Scenario { faults: faults.collect(), ..Scenario::default() };
    let mut simulator = Simulator::new(params(), straight_job(30), &scenario, run).unwrap();
    simulator.warm_up(&Preheat { hotend: Some(Celsius(226.0)), bed: Some(Celsius(60.0)) });
    run_for(&mut simulator, 4.5);
    let readings = std::iter::from_fn(|| simulator.poll()).filter_map(|output| match output {
        Output::Temperatures { stamp, bed, .. } if stamp.0 > 2.05 => Some(bed.0),
        _ => None,
    });
    readings.take(20).collect()
}

/// Noise of 10 x 0.15 K: of twenty readings with other noise one is off by 1 K but for a chance of 10^-9. The bed itself
/// moves by less than 0.2 K.
#[test]
fn a_seed_of_its_own_brings_the_same_noise_in_every_run() {
    let farthest_k = |a: &[f64], b: &[f64]| {
        assert_eq!((a.len(), b.len()), (20, 20));
        a.iter().zip(b).map(|(a_c, b_c)| (a_c - b_c).abs()).fold(0.0, f64::max)
    };
    let seeded = noisy_bed_c(1, Some(7));
    assert!(farthest_k(&seeded, &noisy_bed_c(2, Some(7))) < 0.2, "another run");
    assert!(farthest_k(&seeded, &noisy_bed_c(1, Some(8))) > 1.0, "another seed");
    assert!(farthest_k(&seeded, &noisy_bed_c(1, None)) > 1.0, "the run's own");
    assert!(farthest_k(&noisy_bed_c(1, None), &noisy_bed_c(2, None)) > 1.0, "the run's own, another run");
}
