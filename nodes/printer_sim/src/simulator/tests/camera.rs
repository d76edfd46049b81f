//! The camera of a printer at work.

use super::*;
use crate::camera::{Camera, Moment, Rig, Shot};
use std::sync::{Arc, Mutex};

/// A rig that can be looked at beside the simulation.
#[derive(Clone)]
struct Shared(Arc<Mutex<Rig>>);

impl Camera for Shared {
    fn observe(&mut self, moment: &Moment) {
        self.0.lock().unwrap().observe(moment);
    }

    fn ready(&mut self, now: Seconds) -> Option<Shot> {
        self.0.lock().unwrap().ready(now)
    }
}

/// A printer with a camera on the first layer of a cube, once it has deposited for a while under these faults: the
/// printer, its camera, where the tool went and how many frames came.
fn photographed(faults: &Scenario) -> (Simulator, Shared, Vec<[f64; 3]>, u64) {
    let mut params = params();
    params.camera.enabled = true;
    let camera = Shared(Arc::new(Mutex::new(Rig::new(&params.camera, 1))));
    let mut simulator = Simulator::new(params, cube(1), faults, 1).unwrap();
    simulator.fit(Box::new(camera.clone()));
    simulator.warm_up(&Preheat { hotend: Some(Celsius(226.0)), bed: Some(Celsius(60.0)) });
    let (mut path, mut frames, mut shifted) = (Vec::new(), 0, 0);
    for _ in 0..60_000 {
        simulator.step(Seconds(1e-3));
        let truth = simulator.truth();
        // A start behind a travel lays too little for a moment: pressure has to build.
        if truth.depositing && truth.width_m > 3e-4 {
            path.push(simulator.tool_m());
        }
        while let Some(output) = simulator.poll() {
            if let Output::Frame { exposed, sequence, .. } = output {
                // twice a second, a fifth of the period sooner or later
                let off_s = (exposed.0 - 0.5 * (frames + 1) as f64).abs();
                assert!(off_s < 0.5 * 0.2 + 2e-3 && sequence == frames, "{off_s}");
                shifted += u64::from(off_s > 0.02);
                frames += 1;
            }
        }
    }
    // four of five lie more than a fifth of that off the beat
    assert!(shifted * 3 > frames * 2, "{shifted} of {frames}");
    (simulator, camera, path, frames)
}

#[test]
fn without_a_camera_there_is_no_frame_and_with_one_there_are_two_a_second() {
    let mut params = params();
    params.camera.enabled = false;
    let mut dark = Simulator::new(params, cube(1), &Scenario::default(), 1).unwrap();
    for _ in 0..2_000 {
        dark.step(Seconds(1e-3));
        while let Some(output) = dark.poll() {
            assert!(!matches!(output, Output::Frame { .. }));
        }
    }
    // 60 s at 2 fps; the last one was exposed at 59.93 s.
    assert_eq!(photographed(&Scenario::default()).3, 120);
}

#[test]
fn roads_lie_where_the_tool_really_was() {
    let skip = fault_at(40.0, "component: motion, kind: layer_shift_x, size: 1.5e-3");
    let (simulator, camera, path, _) = photographed(&skip);
    assert!(path.len() > 10_000 && simulator.truth().layer_shift_m[0] > 1e-3);
    let rig = camera.0.lock().unwrap();
    let field = rig.deposit();
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
    let (simulator, camera, path, _) = photographed(&off);
    assert!(path.is_empty(), "nothing lands");
    let truth = simulator.truth();
    let rig = camera.0.lock().unwrap();
    let field = rig.deposit();
    assert!(truth.detached && truth.outlet_m > 1e-2 && field.bytes() > 1_000_000);
}
