use super::*;
use models::wire::correction::RawLimits;

/// 5.4 mm/s is the fastest wire: what the plan of a thin wire gives is named with side and limit.
#[test]
fn a_speed_beyond_the_machine_is_named() {
    let raw =
        RawLimits { wire_low_m_s: 0.5e-3, wire_high_m_s: 5.4e-3, head_low_m_s: 0.5e-3, head_high_m_s: 10e-3 };
    let limits = Limits::try_from(raw).unwrap();
    let feed = |diameter_m| {
        let raw = RawFeed { diameter_m, drop_length_m: diameter_m, absorbed_w: 64.9, spacing: 2.0 / 3.0 };
        Feed::try_from(raw).unwrap()
    };
    let config =
        ConfigDir::find(Some(std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config"))))
            .unwrap();
    let metal = material(&config, "aluminium").unwrap();
    let of = |diameter_m| beyond(&limits, &feed(diameter_m).cycle(&metal, None).unwrap(), "file");
    assert!(of(3e-3).is_empty());
    let thin = of(0.8e-3);
    assert!(thin.iter().any(|one| one.speed == "wire" && one.side == "above" && one.planned_mm_s > 49.0));
    assert!(of(0.02).iter().all(|one| one.side == "below"), "{:?}", of(0.02));
}

/// 65 W melt the 3 mm wire at 3.5 mm/s of at most 5.4 mm/s, which 100.1 W give; the slowest head of 0.5 mm/s takes 19.3 W.
#[test]
fn the_power_that_fits_keeps_both_speeds() {
    let plan = |power: f64| {
        let args = PlanArgs {
            material: None,
            diameter: None,
            drop_length: None,
            power: Some(power),
            absorptivity: Some(0.1),
            film: None,
            angle: 90.0,
            config: Some(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config").into()),
            json: None,
        };
        let config = ConfigDir::find(args.config.as_deref()).unwrap();
        super::plan(&args, &config).unwrap()
    };
    let too_much = plan(1e6);
    let Fitting { least_w, most_w } = too_much.fitting_power.unwrap();
    assert!((most_w / 1001.0 - 1.0).abs() < 0.01 && (least_w / 193.0 - 1.0).abs() < 0.01, "{too_much:?}");
    assert!(text(&too_much).contains("of laser power would fit"), "{}", text(&too_much));
    for fits in [least_w * 1.001, most_w * 0.999] {
        assert!(plan(fits).beyond_limits.is_empty() && plan(fits).fitting_power.is_none());
    }
}
