//! The camera of a printer at work.

use super::*;

/// A printer with a camera on the first layer of a cube, once it has deposited for a while under these faults.
fn photographed(enabled: bool, faults: &Scenario) -> (Simulator, Vec<[f64; 3]>, u64) {
    let mut params = params();
    params.camera.enabled = enabled;
    let mut simulator = Simulator::new(params, cube(1), faults, 1).unwrap();
    simulator.warm_up(&Preheat { hotend: Some(Celsius(226.0)), bed: Some(Celsius(60.0)) });
    let (mut path, mut frames) = (Vec::new(), 0);
    for _ in 0..60_000 {
        simulator.step(Seconds(1e-3));
        let truth = simulator.truth();
        // A start behind a travel lays too little for a moment: pressure has to build.
        if truth.depositing && truth.width_m > 3e-4 {
            path.push(simulator.tool_m());
        }
        while let Some(output) = simulator.poll() {
            if let Output::Frame { exposed, sequence, .. } = output {
                assert!((exposed.0 - 0.5 * (frames + 1) as f64).abs() < 1e-9 && sequence == frames);
                frames += 1;
            }
        }
    }
    (simulator, path, frames)
}

#[test]
fn without_a_camera_there_is_no_frame_and_with_one_there_are_two_a_second() {
    let (dark, _, frames) = photographed(false, &Scenario::default());
    assert!(dark.camera().is_none() && frames == 0);
    // 60 s at 2 fps; the last one is still on its way.
    assert_eq!(photographed(true, &Scenario::default()).2, 119);
}

#[test]
fn roads_lie_where_the_tool_really_was() {
    let skip = fault_at(40.0, "component: motion, kind: layer_shift_x, size: 1.5e-3");
    let (simulator, path, _) = photographed(true, &skip);
    assert!(path.len() > 10_000 && simulator.truth().layer_shift_m[0] > 1e-3);
    let field = simulator.camera().unwrap().deposit();
    // What is shown ends up to a piece of 0.4 mm behind the nozzle: 10 ms at 40 mm/s, 100 ms at 4 mm/s.
    for tool_m in &path[..path.len() - 500] {
        let height_m = field.height_m([tool_m[0], tool_m[1]]);
        assert!(height_m > 0.7 * tool_m[2], "{tool_m:?}: {height_m}");
    }
    assert_eq!(field.refused(), 0);
}

#[test]
fn on_a_part_that_came_off_a_tangle_grows_instead_of_roads() {
    let off = fault_at(0.0, "component: part, kind: detached, size: 0.0");
    let (simulator, path, _) = photographed(true, &off);
    assert!(path.is_empty(), "nothing lands");
    let truth = simulator.truth();
    let field = simulator.camera().unwrap().deposit();
    assert!(truth.detached && truth.outlet_m > 1e-2 && field.bytes() > 1_000_000);
}
