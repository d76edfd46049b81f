use super::*;
use crate::frame::tests::{jpeg, picture};
use crate::path::tests::road;
use models::command::Trims;
use models::status::HostProfile;
use models::units::{Celsius, Kelvin};
use serde::de::DeserializeOwned;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

mod shares;

fn config(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config").join(file)
}

#[derive(serde::Deserialize)]
struct RosFile<T> {
    #[serde(rename = "ros__parameters")]
    parameters: T,
}

fn load<T: DeserializeOwned>(file: &str) -> T {
    let text = std::fs::read_to_string(config(file)).unwrap();
    let mut nodes: HashMap<String, RosFile<T>> = serde_saphyr::from_str(&text).unwrap();
    nodes.remove("/**").unwrap().parameters
}

#[derive(serde::Deserialize)]
struct Blocks {
    printer: Option<models::printer::Printer>,
    material: Option<models::material::Material>,
    quality: Option<models::quality::Quality>,
}

/// Ender 3 and PLA of the shipped files.
pub(crate) fn nominal() -> Nominal {
    Nominal {
        quality: load::<Blocks>("quality.yaml").quality.unwrap(),
        printer: load::<Blocks>("printers/ender3.yaml").printer.unwrap(),
        material: load::<Blocks>("materials/pla.yaml").material.unwrap(),
    }
}

/// The classifier of the shipped files.
fn classifier() -> Classifier {
    let params: Params = load("defect_classifier.param.yaml");
    let text = |file: &str| std::fs::read_to_string(config(file)).unwrap();
    let models = Models {
        network: Network::parse(&text("models/toolhead.json")).unwrap(),
        edge: EdgeModel::parse(&text("models/road_edge.json")).unwrap(),
        nominal: nominal(),
    };
    Classifier::new(params, models).unwrap()
}

fn status(stamp_s: f64, phase: JobPhase, layer: u32) -> Event {
    Event::Printer(Box::new(printer_status(stamp_s, phase, layer)))
}

pub(crate) fn printer_status(stamp_s: f64, phase: JobPhase, layer: u32) -> PrinterStatus {
    PrinterStatus {
        stamp: Seconds(stamp_s),
        phase,
        host: HostProfile::Native,
        progress: 0.1,
        layer: Some(layer),
        line: 1,
        position_m: [0.11, 0.1, 2e-4],
        path_speed_m_s: 0.05,
        planned_speed_m_s: 0.05,
        planned_feed_m_s: 1.6e-3,
        motor_position_m: 0.0,
        wanted_position_m: 0.0,
        path_time_s: stamp_s,
        depositing: true,
        target_width_m: Some(4.5e-4),
        layer_height_m: Some(2e-4),
        hotend_target: Celsius(215.0),
        hotend_sliced_target: Celsius(215.0),
        bed_target: Celsius(60.0),
        hotend_duty: 0.4,
        bed_duty: 0.3,
        fan: 1.0,
        trims: Trims::NEUTRAL,
        advance_s: 0.0,
        homed: true,
        mains_on: true,
        filament_present: None,
        part_fan_speed_1_s: None,
        stop_input: None,
    }
}

/// A print that stands at (0.11, 0.1) at 10 s, a short road behind it.
fn printing() -> Classifier {
    let mut brain = classifier();
    brain.on_event(status(9.0, JobPhase::Printing, 0));
    let segment = Box::new(road(0, [0.1, 0.1], [0.11, 0.1]));
    brain.on_event(Event::Motion { start: Seconds(9.1), path_s: 9.1, segment });
    for step in 1..=50_u32 {
        brain.on_event(status(9.0 + 0.02 * f64::from(step), JobPhase::Printing, 0));
    }
    brain
}

fn frame(exposed_s: f64, jpeg: Vec<u8>) -> Event {
    Event::Frame { exposed: Seconds(exposed_s), jpeg }
}

fn bars() -> Vec<u8> {
    jpeg(&picture(640, 480, |u, v| if (u / 40 + v / 40) % 2 == 0 { 60 } else { 160 }))
}

fn report(outputs: &[Output]) -> &Defects {
    let mut reports = outputs.iter().filter_map(|output| match output {
        Output::Defects(defects) => Some(defects.as_ref()),
        _ => None,
    });
    reports.next().unwrap()
}

#[test]
fn a_sound_frame_is_judged_and_drawn() {
    let outputs = printing().on_event(frame(9.95, bars()));
    let judged = report(&outputs).judged.as_ref().unwrap();
    assert!((judged.probabilities.iter().sum::<f64>() - 1.0).abs() < 1e-9);
    assert!(outputs.iter().any(|output| matches!(output, Output::Picture { .. })));
}

/// S8, S9: what cannot be judged is unknown with its reason; the change is noted once.
#[test]
fn frames_that_cannot_be_judged_are_unknown_and_noted_once() {
    let mut brain = printing();
    let black = |level: u8| jpeg(&picture(640, 480, |_, _| level));
    let first = brain.on_event(frame(9.9, black(1)));
    assert!(matches!(report(&first).judged, Err(Unusable::Black { .. })));
    assert_eq!(first.iter().filter(|output| matches!(output, Output::Note(_))).count(), 1);
    let second = brain.on_event(frame(9.92, black(2)));
    assert!(matches!(report(&second).judged, Err(Unusable::Black { .. })));
    assert!(second.iter().all(|output| !matches!(output, Output::Note(_))));
    let back = brain.on_event(frame(9.95, bars()));
    assert!(report(&back).judged.is_ok());
    assert!(matches!(report(&brain.on_event(frame(9.97, bars()))).judged, Err(Unusable::Frozen)));
    assert!(matches!(report(&brain.on_event(frame(9.98, vec![1, 2, 3]))).judged, Err(Unusable::NotJpeg)));
    assert_eq!((brain.counts().judged, brain.counts().unusable), (1, 4));
}

#[test]
fn a_frame_without_a_place_is_unknown() {
    let outputs = printing().on_event(frame(30.0, bars()));
    assert!(matches!(report(&outputs).judged, Err(Unusable::NoPlace)));
}

#[test]
fn outside_of_printing_nothing_is_said() {
    let mut brain = printing();
    brain.on_event(status(10.1, JobPhase::Paused, 0));
    assert_eq!(brain.on_event(frame(10.05, bars())), []);
    assert_eq!(brain.counts().idle, 1);
}

#[test]
fn a_layer_has_a_figure_each_second_and_one_when_it_is_done() {
    let mut brain = printing();
    brain.on_event(frame(9.95, bars()));
    let estimate = EstimateReading {
        stamp: Seconds(10.0),
        nozzle: Kelvin(475.0),
        chi_square: vec![20.0, 18.0, 21.0],
        window: 20,
    };
    brain.on_event(Event::Estimate(estimate));
    let figures: Vec<_> = (1..=100_u32)
        .flat_map(|step| brain.on_event(status(10.0 + 0.02 * f64::from(step), JobPhase::Printing, step / 80)))
        .filter_map(|output| if let Output::Quality(figure) = output { Some(figure) } else { None })
        .collect();
    let told: Vec<(u32, bool)> = figures.iter().map(|figure| (figure.layer, figure.complete)).collect();
    assert_eq!(told, [(0, false), (0, true)]);
    let terms = figures[1].terms;
    assert!(terms.total() > 0.0 && terms.temperature > 0.0 && terms.adhesion > 0.0 && figures[1].frames == 1);
}

/// Killed in the second layer it took the roads laid since for the whole part, and paused sound prints.
#[test]
fn who_joins_a_print_under_way_does_not_judge_its_old_part_until_the_next() {
    let told = |outputs: &[Output]| {
        outputs.iter().any(|output| matches!(output, Output::Note(note) if note.what == "old_part"))
    };
    let late = |brain: &mut Classifier, stamp_s: f64, layer: u32| {
        told(&brain.on_event(status(stamp_s, JobPhase::Printing, layer)))
    };
    let mut brain = classifier();
    assert!(late(&mut brain, 9.0, 1) && !late(&mut brain, 9.1, 1));
    assert!(brain.joined_late);
    brain.on_event(status(9.2, JobPhase::Paused, 1));
    brain.on_event(status(9.3, JobPhase::Printing, 1));
    assert!(brain.joined_late, "a pause makes nothing known");
    brain.on_event(status(9.4, JobPhase::Done, 1));
    brain.on_event(status(9.5, JobPhase::Printing, 0));
    assert!(!brain.joined_late);
    assert!(!late(&mut classifier(), 9.0, 0), "the first roads are laid over");
    assert!(late(&mut classifier(), 16.0, 0));
}
