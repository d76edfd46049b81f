//! The committed networks against the figures of the issue, on lines made anew.

use super::assess::{Figures, assess};
use super::data::{DataParams, Use};
use super::measured::Measured;
use super::training::{Material, train};
use super::*;
use crate::network::training::FitParams;
use models::advance::published::Published;
use models::units::Celsius;
use std::collections::BTreeMap;
use std::sync::OnceLock;

#[derive(Deserialize)]
struct Settings {
    seed: u64,
    measured_weight: f64,
    data: DataParams,
    fit: FitParams,
    #[serde(flatten)]
    _others: BTreeMap<String, serde_json::Value>,
}

pub(crate) fn text(file: &str) -> String {
    let path = format!("{}/../../config/{file}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn settings() -> Settings {
    serde_saphyr::from_str(&text("models/advance_training.yaml")).unwrap()
}

fn block<T: serde::de::DeserializeOwned>(file: &str, name: &str) -> T {
    let mut tree: BTreeMap<String, BTreeMap<String, BTreeMap<String, T>>> =
        serde_saphyr::from_str(&text(file)).unwrap();
    tree.remove("/**").unwrap().remove("ros__parameters").unwrap().remove(name).unwrap()
}

pub(crate) fn physics() -> Physics {
    block("advance/physics.yaml", "advance_physics")
}

pub(crate) fn params() -> crate::params::Params {
    let mut tree: BTreeMap<String, BTreeMap<String, crate::params::Params>> =
        serde_saphyr::from_str(&text("advance_predictor.param.yaml")).unwrap();
    tree.remove("/**").unwrap().remove("ros__parameters").unwrap()
}

pub(crate) fn shipped(drive: DriveKind) -> Predictor {
    let ensemble = Ensemble::parse(&text(&format!("models/advance_{}.json", drive.name())), drive).unwrap();
    Predictor::new(physics(), params().bounds, ensemble)
}

fn figures(drive: DriveKind) -> &'static Figures {
    static FIGURES: [OnceLock<Figures>; 2] = [OnceLock::new(), OnceLock::new()];
    FIGURES[usize::from(drive == DriveKind::Direct)].get_or_init(|| {
        let (settings, physics) = (settings(), physics());
        let published: Published = block("advance/published.yaml", "advance_published");
        let set = settings.data.generate(drive, &physics, &published, settings.seed);
        assess(shipped(drive).ensemble(), &physics, (&settings.data, &set), &published)
    })
}

fn at(temperature_c: f64, height_mm: f64, width_mm: f64) -> Condition {
    Condition { temperature: Celsius(temperature_c), height_m: 1e-3 * height_mm, width_m: 1e-3 * width_mm }
}

/// The paper: within 0.015 s, mean 0.007 s; and anywhere between the lines of the grid too.
#[test]
fn bowden_is_within_15_ms_on_conditions_held_out() {
    for errors in [figures(DriveKind::Bowden).held_out, figures(DriveKind::Bowden).anywhere] {
        assert!(errors.count >= 200, "{errors:?}");
        assert!(errors.within_15_ms >= 0.95 && errors.mean_abs_s <= 0.007, "{errors:?}");
    }
}

#[test]
fn direct_is_within_ten_percent_on_conditions_held_out() {
    for errors in [figures(DriveKind::Direct).held_out, figures(DriveKind::Direct).anywhere] {
        assert!(errors.count >= 200 && errors.within_10_percent >= 0.95, "{errors:?}");
    }
}

#[test]
fn the_interval_holds_what_it_says() {
    for drive in DriveKind::ALL {
        for errors in [figures(drive).held_out, figures(drive).anywhere] {
            assert!((0.90..=0.98).contains(&errors.covered), "{drive:?}: {errors:?}");
        }
    }
}

/// 0.03 s, for Bowden at layers from 0.2 mm on 0.02 s; none of the seven was trained with.
#[test]
fn printed_points_are_met() {
    for drive in DriveKind::ALL {
        let points = &figures(drive).published;
        assert_eq!(points.len(), if drive == DriveKind::Bowden { 4 } else { 3 });
        for point in points {
            let strict = drive == DriveKind::Bowden && point.height_mm > 0.15;
            assert!(point.error_s.abs() <= if strict { 0.02 } else { 0.03 }, "{drive:?} {point:?}");
        }
    }
}

#[test]
fn trends_are_monotone_and_polymers_in_order() {
    for drive in DriveKind::ALL {
        let trends = figures(drive).trends;
        assert!(trends.pairs > 1000 && trends.ordered > 10, "{trends:?}");
        let broken = trends.temperature_broken + trends.height_broken + trends.width_broken;
        assert_eq!((broken, trends.order_broken), (0, 0), "{drive:?} {trends:?}");
    }
}

/// At most 1.3 times the best width error; for Bowden at most 0.03 of the uncompensated. With a direct drive the best
/// constant itself leaves 0.05 of it, for the lag is not linear: there the law over the feed stays within 0.03.
#[test]
fn widths_are_nearly_the_best() {
    for drive in DriveKind::ALL {
        let widths = figures(drive).widths;
        assert_eq!(widths.count, 12);
        assert!(widths.foretold <= 1.3 * widths.best, "{drive:?} {widths:?}");
        assert!(drive == DriveKind::Direct || widths.foretold <= 0.03 * widths.none, "{widths:?}");
        assert!(widths.foretold_law <= 0.03 * widths.none, "{drive:?} {widths:?}");
    }
}

/// Model book 2.4: ABS at 212 degC lies outside of the data. The virtual line needs 0.687 s there; the physics say so.
#[test]
fn outside_of_the_hull_the_physics_answer_and_say_so() {
    let predictor = shipped(DriveKind::Bowden);
    let outside = predictor.predict("ABS", &at(212.0, 0.35, 0.4)).unwrap();
    assert_eq!(outside.source, Source::Physics);
    let best = physics().best(DriveKind::Bowden, "ABS", &at(212.0, 0.35, 0.4), models::units::Seconds(1e-3));
    assert!((outside.advance.0 / best.unwrap().advance_s - 1.0).abs() < 0.02, "{outside:?}");
    assert_eq!(predictor.predict("ABS", &at(240.0, 0.35, 0.4)).unwrap().source, Source::Network);
    assert_eq!(predictor.predict("WOOD", &at(240.0, 0.2, 0.4)), Err(Unanswered::Polymer));
    for odd in
        [at(f64::NAN, 0.2, 0.4), at(215.0, f64::INFINITY, 0.4), at(215.0, 0.2, -0.4), at(20.0, 0.2, 0.4)]
    {
        let refused = predictor.predict("PLA", &odd);
        assert!(matches!(refused, Err(Unanswered::Bounds { .. })), "{odd:?}: {refused:?}");
    }
    let error = predictor.predict("PLA", &at(215.0, 0.2, 200.0)).unwrap_err().to_string();
    assert_eq!(error, "line width is 0.2 m, must be in [0.00015, 0.002] m");
}

/// A person whose printer needs 0.05 s more shifts the answer there, by a few lines.
#[test]
fn measured_lines_move_the_networks() {
    let (settings, physics) = (settings(), physics());
    let published: Published = block("advance/published.yaml", "advance_published");
    let mut set = settings.data.generate(DriveKind::Bowden, &physics, &published, settings.seed);
    set.lines.retain(|line| line.polymer == "PLA" && line.purpose == Use::Train);
    let own = [(215.0, 0.68), (210.0, 0.70), (220.0, 0.66)];
    let measured = own.map(|(temperature_c, advance_s)| Measured {
        drive: DriveKind::Bowden,
        polymer: "PLA".to_owned(),
        at: at(temperature_c, 0.2, 0.4),
        advance_s,
    });
    let foretold = |measured: &[Measured]| {
        let weight = settings.measured_weight;
        let material = Material {
            physics: &physics,
            data: &settings.data,
            set: &set,
            measured,
            measured_weight: weight,
        };
        let text = train(&material, &settings.fit, 1).unwrap();
        let ensemble = Ensemble::parse(&text, DriveKind::Bowden).unwrap();
        ensemble.predict("PLA", &at(215.0, 0.2, 0.4)).unwrap().advance.0
    };
    let shift_s = foretold(&measured) - foretold(&[]);
    assert!((0.02..0.08).contains(&shift_s), "{shift_s}");
}

/// Any number of any unit, whether a probe's inputs wake it or not; another layout of the same is none.
#[test]
fn a_damaged_file_is_refused() {
    let whole: serde_json::Value = serde_json::from_str(&text("models/advance_bowden.json")).unwrap();
    let refused = |value: &serde_json::Value| {
        Ensemble::parse(&value.to_string(), DriveKind::Bowden).unwrap_err().to_string()
    };
    for layer in 0..3 {
        let units = whole["members"][6][layer]["bias"].as_array().unwrap().len();
        for unit in 0..units {
            let mut value = whole.clone();
            let weight = &mut value["members"][6][layer]["weights"][unit][0];
            *weight = serde_json::json!(weight.as_f64().unwrap() + 1e-6);
            let error = refused(&value);
            assert!(error.starts_with("network file: sha256 is '"), "{layer} {unit}: {error}");
        }
    }
    let mut value = whole.clone();
    value["polymers"][0]["hull"]["height_m"] = serde_json::json!([4e-4, 1e-4]);
    assert!(
        refused(&value).contains("hull of ABS: height_m is [0.0004, 0.0001], must be"),
        "{}",
        refused(&value)
    );
    assert!(Ensemble::parse(&whole.to_string(), DriveKind::Bowden).is_ok());
}

/// A Bowden's `K_A` is ten times a direct drive's.
#[test]
fn networks_of_the_other_drive_are_refused() {
    let error = Ensemble::parse(&text("models/advance_bowden.json"), DriveKind::Direct).unwrap_err();
    assert_eq!(error.to_string(), "network file: drive is bowden, must be direct");
}

#[test]
fn reversed_bounds_are_refused() {
    let raw = RawBounds { height_m: [1e-3, 5e-5], ..*params().bounds };
    let error = Bounds::try_from(raw).unwrap_err().to_string();
    assert_eq!(error, "bounds.height_m[0] = 0.001: must be below bounds.height_m[1] = 0.00005");
}
