use super::*;
use models::units::Seconds;

fn raw() -> RawParams {
    RawParams {
        diameter_m: 3e-3,
        drop_length_m: 3e-3,
        feed_ratio: 1.0,
        bead_width_m: 6.8e-3,
        spread_m: 1.2e-3,
        drive_lag_s: 0.3,
        wall_length_m: 0.06,
        cell_m: 2.5e-4,
        return_s: 2.0,
        drop_volume_sigma: 0.0,
        drop_place_sigma_m: 0.0,
        features_per_layer: 0,
        feature_height_m: 5e-4,
        feature_length_m: 4.5e-3,
        sensor: RawSensor { period_s: 0.5, sigma_m: 0.0, delay_s: 0.5, trail_m: 6e-3 },
    }
}

const NOMINAL: Speeds = Speeds { wire_m_s: 3.5e-3, head_m_s: 1.68e-3 };

fn layers(raw: RawParams, seed: u64, layers: u32) -> (WirePlant, Vec<HeightSample>) {
    let mut plant = WirePlant::new(Params::try_from(raw).unwrap(), seed);
    let mut samples = Vec::new();
    while plant.layer() <= layers {
        plant.step(Seconds(0.02), NOMINAL);
        samples.extend(std::iter::from_fn(|| plant.sample()));
    }
    (plant, samples)
}

fn mean(values: &[f64]) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "few cells")]
    let count = values.len() as f64;
    values.iter().sum::<f64>() / count
}

/// Wire in is wall out. 0.06 m of wall take 0.06 * 3.5/1.68 = 0.125 m of wire of 7.0686 mm2, whatever the lag that both
/// drives share: ten layers are 10 * 125 * 7.0686 / (60 * 6.8) = 21.656 mm high. A step of 0.02 s past the end of the
/// wall is 0.034 mm of 60: 0.06 %.
#[test]
fn what_is_fed_is_what_stands_there() {
    let (plant, _) = layers(raw(), 1, 10);
    let height_m = mean(plant.surface().heights_m());
    assert!((height_m - 21.656e-3).abs() < 0.013e-3, "{height_m}");
}

#[test]
fn samples_come_late_and_in_order() {
    let mut plant = WirePlant::new(Params::try_from(raw()).unwrap(), 1);
    let mut last_s = 0.0;
    let mut seen = 0;
    while plant.layer() < 2 {
        plant.step(Seconds(0.02), NOMINAL);
        while let Some(sample) = plant.sample() {
            let late_s = plant.now().0 - sample.stamp.0;
            // A step of 0.02 s rounds up.
            assert!((0.5..=0.52 + 1e-9).contains(&late_s), "{late_s}");
            assert!(sample.stamp.0 > last_s && sample.layer == 1);
            last_s = sample.stamp.0;
            seen += 1;
        }
    }
    // 60 mm at 1.68 mm/s, one each 0.5 s: 71.
    assert!((70..=73).contains(&seen), "{seen}");
}

#[test]
fn without_noise_the_sensor_tells_the_surface() {
    let (plant, samples) = layers(raw(), 1, 1);
    for sample in samples {
        let error_m = sample.height_m - plant.surface().height_m(sample.position_m);
        // Five standard deviations of a bell reach 6 mm, as far as the sensor trails.
        assert!(error_m.abs() < 5e-6, "{sample:?} {error_m}");
    }
}

#[test]
fn a_seed_makes_the_same_wall_and_another_one_another() {
    let rough = RawParams { features_per_layer: 4, drop_volume_sigma: 0.02, ..raw() };
    let heights = |seed| layers(rough, seed, 2).0.surface().heights_m().to_vec();
    assert_eq!(heights(1), heights(1));
    assert_ne!(heights(1), heights(2));
}

#[test]
fn a_drop_loses_nothing_at_the_end_of_the_wall() {
    let mut surface = Surface::flat(0.02, 2.5e-4);
    surface.add_area(0.0, 1.2e-3, 3e-6);
    surface.add_area(0.0199, 1.2e-3, 3e-6);
    // Mean height times length is the area.
    assert!((mean(surface.heights_m()) * surface.length_m() - 6e-6).abs() < 1e-15);
}

#[test]
fn a_negative_diameter_is_named_with_its_limit() {
    let error = Params::try_from(RawParams { diameter_m: -3e-3, ..raw() }).unwrap_err();
    assert_eq!(error.to_string(), "diameter_m = -0.003 m: must be in [0.0001, 0.02]");
}

/// The shipped plant is not what plan and correction believe.
#[test]
fn the_shipped_plant_loads_and_differs_from_the_model() {
    #[derive(serde::Deserialize)]
    struct File {
        #[serde(rename = "/**")]
        any: Parameters,
    }
    #[derive(serde::Deserialize)]
    struct Parameters {
        #[serde(rename = "ros__parameters")]
        all: Blocks,
    }
    #[derive(serde::Deserialize)]
    struct Blocks {
        wire_plant: Params,
    }
    let file = include_str!("../../../../config/plants/wire.yaml");
    let plant = serde_saphyr::from_str::<File>(file).unwrap().any.all.wire_plant;
    let believed = raw();
    assert!((plant.diameter_m / believed.diameter_m - 1.0).abs() > 0.005);
    assert!((plant.feed_ratio - 1.0).abs() > 0.004);
    assert!(plant.sensor.sigma_m > 0.99e-4 && plant.feature_height_m > 0.499e-3);
}
