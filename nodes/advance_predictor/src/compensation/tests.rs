//! The committed networks against the figures of the issue, on lines made anew.

use super::assess::{Figures, Judges, assess};
use super::data::DataParams;
use super::file::{RawEnsemble, RawPolymerHull};
use super::measured::Prior;
use super::*;
use crate::network::training::FitParams;
use models::advance::published::Published;
use models::units::Celsius;
use std::collections::BTreeMap;
use std::sync::OnceLock;

#[derive(Deserialize)]
pub(super) struct Settings {
    pub(super) seed: u64,
    pub(super) measured_weight: f64,
    pub(super) measured_prior: Prior,
    pub(super) data: DataParams,
    pub(super) fit: FitParams,
    #[serde(flatten)]
    _others: BTreeMap<String, serde_json::Value>,
}

pub(crate) fn text(file: &str) -> String {
    let path = format!("{}/../../config/{file}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

pub(super) fn settings() -> Settings {
    serde_saphyr::from_str(&text("models/advance_training.yaml")).unwrap()
}

pub(super) fn block<T: serde::de::DeserializeOwned>(file: &str, name: &str) -> T {
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
    Predictor::new(physics(), params().bounds, ensemble).unwrap()
}

fn figures(drive: DriveKind) -> &'static Figures {
    static FIGURES: [OnceLock<Figures>; 2] = [OnceLock::new(), OnceLock::new()];
    FIGURES[usize::from(drive == DriveKind::Direct)].get_or_init(|| {
        let (settings, physics) = (settings(), physics());
        let published: Published = block("advance/published.yaml", "advance_published");
        let set = settings.data.generate(drive, &physics, &published, settings.seed);
        let judges = Judges { data: &settings.data, set: &set, left_out: 0, measured: &[] };
        assess(shipped(drive).ensemble(), &physics, judges, &published)
    })
}

pub(super) fn at(temperature_c: f64, height_mm: f64, width_mm: f64) -> Condition {
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

/// Networks that own lines had a part in, here with three quarters of the range: outside the physical model is scaled by
/// what they answer over it where the hull is nearest, so that both meet at the edge; without own lines it stays as it is.
#[test]
fn own_lines_scale_the_physics_outside_of_the_hull() {
    let raw: RawEnsemble = serde_json::from_str(&text("models/advance_bowden.json")).unwrap();
    let of = |measured| {
        let raw = RawEnsemble { measured, range_s: [0.3, 1.2], ..raw.clone() };
        Predictor::new(physics(), params().bounds, raw.check().unwrap()).unwrap()
    };
    let (own, virtuals) = (of(Some(4)), of(None));
    let physics_s = |at| physics().secant_s(DriveKind::Bowden, "ABS", &at).unwrap();
    for (outside, nearest) in [
        (at(212.0, 0.35, 0.4), at(230.0, 0.35, 0.4)),
        (at(240.0, 0.6, 0.8), at(240.0, 0.4, 0.6)),
        (at(270.0, 0.09, 0.45), at(260.0, 0.1, 0.45)),
    ] {
        let edge = own.predict("ABS", &nearest).unwrap();
        let found = own.predict("ABS", &outside).unwrap();
        let expected_s = edge.advance.0 / physics_s(nearest) * physics_s(outside);
        assert_eq!((edge.source, found.source), (Source::Network, Source::Physics));
        assert!((found.advance.0 / expected_s - 1.0).abs() < 1e-9, "{found:?} {expected_s}");
        assert!((expected_s / physics_s(outside) - 1.0).abs() > 0.05, "else nothing is scaled: {expected_s}");
        assert!((found.half_width.0 / found.advance.0 - params().bounds.physics_doubt).abs() < 1e-12);
        let unscaled_s = virtuals.predict("ABS", &outside).unwrap().advance.0;
        assert!((unscaled_s - physics_s(outside)).abs() < 1e-15, "{unscaled_s}");
    }
}

/// ABS at 160 degC in a layer of 0.05 mm: the exponential goes on to 97 s, which no drive needs; none is answered, and 1.5 s,
/// the range's end, is no answer either.
#[test]
fn a_lag_that_no_drive_has_is_not_answered() {
    let cold = shipped(DriveKind::Bowden).predict("ABS", &at(160.0, 0.05, 0.15)).unwrap_err();
    assert!(matches!(cold, Unanswered::Range { advance_s, low_s: 0.3, high_s: 1.5, .. } if advance_s > 50.0));
    assert!(cold.to_string().ends_with("outside of 0.3 to 1.5 s of a bowden drive"), "{cold}");
    // What the physical model answers lies inside of the drive's range, wherever it is asked.
    for drive in DriveKind::ALL {
        let (predictor, [low_s, high_s]) = (shipped(drive), physics().drive(drive).advance_range_s);
        let mut refused = 0;
        for (temperature, height) in (16..32).flat_map(|ten| [0.05, 0.2, 0.8].map(|mm| (10 * ten, mm))) {
            match predictor.predict("PETG", &at(f64::from(temperature), height, 1.0)) {
                Ok(answer) => assert!((low_s..=high_s).contains(&answer.advance.0), "{answer:?}"),
                Err(error) => refused += i32::from(matches!(error, Unanswered::Range { .. })),
            }
        }
        assert!(refused > 0, "{drive:?}");
    }
}

/// Each quantity by its own name, its value and the data's range.
#[test]
fn what_lies_outside_of_the_hull_is_named() {
    let predictor = shipped(DriveKind::Bowden);
    let outside = |temperature, height, width| -> Vec<_> {
        let found = predictor.ensemble().hull("PLA").unwrap().outside(&at(temperature, height, width));
        found.into_iter().map(|one| (one.field, one.value, one.unit)).collect()
    };
    assert_eq!(outside(215.0, 0.2, 0.4), []);
    assert_eq!(outside(240.0, 0.2, 0.4), [("temperature", 240.0, "degC")]);
    assert_eq!(outside(215.0, 0.5, 0.8), [("layer height", 0.5, "mm"), ("line width", 0.8, "mm")]);
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

/// A file whose checksum is right, since it was sealed so: what it says cannot be.
#[test]
fn networks_that_say_what_cannot_be_are_refused() {
    let raw: RawEnsemble = serde_json::from_str(&text("models/advance_bowden.json")).unwrap();
    let refused = |raw: RawEnsemble| raw.check().unwrap_err().to_string();
    let twice = || RawPolymerHull { name: "ABS".to_owned(), ..raw.polymers[1].clone() };
    let polymers = vec![raw.polymers[0].clone(), twice(), raw.polymers[2].clone()];
    let error = refused(RawEnsemble { polymers, ..raw.clone() });
    assert_eq!(error, "network file: polymers[1].name is ABS, must be there once");
    for (floor_s, factor) in [(1.3, 1.0), (0.003, 401.0)] {
        let error = refused(RawEnsemble { floor_s, factor, ..raw.clone() });
        assert!(error.starts_with("network file: floor_s, factor is "), "{error}");
    }
    let wide = RawEnsemble { range_s: [0.3, 1.6], ..raw.clone() }.check().unwrap();
    let error = Predictor::new(physics(), params().bounds, wide).unwrap_err().to_string();
    assert!(error.starts_with("network file: range_s is [0.3, 1.6], must be within [0.3, 1.5]"), "{error}");
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
