//! What the catalogue has to hold: the limits that are asked for, and what its sound prints are of.

use super::{catalogue, root};
use cli::faults::catalogue::LimitSource;

/// Every file that is printed and every material stands among the sound prints, with and without control.
#[test]
fn sound_prints_are_of_every_file_and_material() {
    let sound = catalogue().sound;
    let mut files = std::collections::BTreeSet::new();
    for entry in std::fs::read_dir(root().join("tests/data/gcode")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        // One is a torture of the parser, one a sequence for identification: no prints.
        if name.ends_with(".gcode") && !["quirks_handmade.gcode", "identify.gcode"].contains(&name.as_str()) {
            files.insert(name);
        }
    }
    for file in files {
        let of_file = || sound.iter().filter(|print| print.file.ends_with(&format!("/{file}")));
        for control in ["mpc", "off"] {
            assert!(of_file().any(|print| print.control == control), "{file}: not with control {control}");
        }
    }
    for material in ["PETG", "ABS"] {
        assert!(sound.iter().any(|print| print.material.as_deref() == Some(material)), "{material}");
    }
    assert!(sound.iter().any(|print| print.camera), "none with the camera");
}

/// What the design and its issue ask for `[s]`, by ID and trial.
const ASKED: &[(&str, &str, f64)] = &[
    ("S1", "hot end open", 0.5),
    ("S1", "hot end short", 0.5),
    ("S1", "open while heating", 0.5),
    ("P1", "at target", 5.0),
    ("P1", "idle", 5.0),
    ("P1", "printing with the fan on", 8.0),
    ("P2", "loose (x 0.2)", 8.0),
    ("P2", "weak (x 0.5)", 15.0),
    ("P2", "dead", 5.0),
    ("P2", "loose while heating", 8.0),
    ("P2", "dead while heating", 5.0),
    ("P3", "printing", 4.0),
    ("P4", "stands still", 10.0),
    ("P5", "a fifth lost, seen by the camera", 20.0),
    ("P5", "a fifth lost over sparse infill, seen by the camera", 20.0),
    ("P5", "total", 10.0),
    // "1 layer or 30 s": beside the layers, the later counts.
    ("P8", "back along y", 30.0),
    ("P8", "a bracket along y", 30.0),
    ("P8", "a hollow box", 30.0),
    ("P8", "flagged", 0.1),
    ("P8", "knock", 0.1),
    ("P9", "part off the bed", 60.0),
    ("P12", "dead", 30.0),
    ("P12", "stuck on", 30.0),
    ("P12", "thermistor stuck", 30.0),
    ("P12", "thermistor fell out", 30.0),
    ("P13", "emergency stop", 0.25),
    ("P13", "stop button", 0.25),
    ("P13", "stop", 0.25),
    ("P13", "pause", 0.25),
    ("S2", "stuck at target", 10.0),
    ("S2", "stuck while cooling", 10.0),
    ("S2", "stuck while heating", 3.0),
    ("S3", "upwards", 90.0),
    ("S3", "downwards", 90.0),
    ("S4", "noise x 10", 6.0),
    ("S4", "three spikes in ten", 6.0),
    ("S4", "a plug open half of the time", 6.0),
    ("S4", "a plug open most of the time", 6.0),
    ("S5", "not a number", 1.0),
    ("S5", "infinite encoder", 1.0),
    ("S5", "absurd printer state", 1.0),
    ("S6", "an hour ahead", 1.0),
    ("S6", "an hour behind", 1.0),
    ("S6", "stamp zero", 1.0),
    ("S10", "a step of 25 K", 2.0),
    ("S10", "a step of -25 K", 2.0),
    ("C2", "slicer's values", 0.25),
    // 5 s of the policy's delay, 0.5 s, and the 0.25 s in which a permit holds.
    ("C2", "policy pause", 5.75),
    ("C2", "policy heaters off", 5.75),
    ("C4", "permits 5 s late", 0.25),
    ("C7", "sensors and commands", 0.5),
    ("C8", "commands", 0.5),
    ("C13", "degraded", 1.0),
    ("K4", "second", 60.0),
    ("K5", "the set-point", 30.0),
    ("K7", "gains five times too high, pictures twice as late as told, and no error left to pass", 20.0),
    ("K8", "filament of 2.0 mm", 60.0),
];

/// What the design and its issue ask for in numbers: nothing in the catalogue may be laxer.
#[test]
fn limits_of_the_catalogue_are_those_that_are_asked_for() {
    let catalogue = catalogue();
    for &(id, name, limit_s) in ASKED {
        let fault = catalogue.faults.iter().find(|fault| fault.id == id).unwrap();
        let trial =
            fault.trials.iter().find(|trial| trial.name == name).unwrap_or_else(|| panic!("{id} {name}"));
        assert_eq!(trial.limit_s, Some(limit_s), "{id} {name}");
        assert_eq!(trial.source.or(fault.source), Some(LimitSource::Catalogue), "{id} {name}");
    }
    let trial = |id: &str| catalogue.faults.iter().find(|fault| fault.id == id).unwrap().trials[0].clone();
    for id in ["P6", "P7"] {
        assert_eq!((trial(id).limit_mm, trial(id).limit_s), (Some(7.0), Some(1.0)), "{id}");
    }
    let shift = catalogue.faults.iter().find(|fault| fault.id == "P8").unwrap();
    assert!(shift.trials.iter().any(|trial| trial.limit_layers == Some(1)), "one layer");
    for trial in &catalogue.faults.iter().find(|fault| fault.id == "P1").unwrap().trials {
        // A heater behind a thermistor that fails as well has a bound of its own.
        let held = trial.overshoot_max_k == Some(15.0) || trial.job == "idle";
        let faults = trial.entries().unwrap().len() + trial.relay.len();
        let bed = trial.name.starts_with("a bed");
        let bounded = bed || trial.overshoot_max_k.is_some_and(|most_k| most_k <= 60.0);
        let both = faults > 1 && bounded && trial.source == Some(LimitSource::Own);
        assert!(held || both, "{}", trial.name);
    }
    for (id, told_s) in [("C1", 0.5), ("C4", 0.5), ("T1", 1.0)] {
        let fault = catalogue.faults.iter().find(|fault| fault.id == id).unwrap();
        assert!(fault.process.iter().all(|trial| trial.told_s == Some(told_s)), "{id}");
        assert_eq!(fault.source, Some(LimitSource::Catalogue), "{id}");
    }
}

/// None is said to be the design's that it does not ask for; those of filament stand above.
#[test]
fn no_other_limit_is_said_to_be_the_designs() {
    let catalogue = catalogue();
    for fault in &catalogue.faults {
        for trial in fault.trials.iter().filter(|trial| trial.limit_s.is_some() && trial.limit_mm.is_none()) {
            let listed = ASKED.iter().any(|(id, name, _)| *id == fault.id && *name == trial.name);
            let of_design = trial.source.or(fault.source) == Some(LimitSource::Catalogue);
            assert_eq!(listed, of_design, "{} {}", fault.id, trial.name);
        }
    }
}
