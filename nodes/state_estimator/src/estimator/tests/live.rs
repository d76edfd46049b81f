//! What may change while the node is active is checked, and acts at once.

use super::*;
use crate::live::LIVE;

#[path = "../../../../runtime/tests/live/changed.rs"]
mod changed;

fn params(text: &str) -> Option<Params> {
    changed::parsed(text)
}

/// Ten times the noise: the state that it stands behind is known worse after 3 s, and only from the change on.
#[test]
fn every_live_parameter_is_checked_and_acts_at_once() {
    for name in LIVE {
        let (value, behind) = match name {
            "process.block_k" => ("1.0", state::BLOCK),
            "process.nozzle_k" => ("2.0", state::NOZZLE),
            "process.sensor_k" => ("0.2", state::SENSOR),
            "process.flow_rel" => ("0.04", state::FLOW),
            "process.slip" => ("0.03", state::SLIP),
            "process.gain" => ("0.008", state::GAIN),
            "thermistor.sigma_k" => ("1.5", state::SENSOR),
            "nozzle_sensor.sigma_k" => ("1.5", state::NOZZLE),
            "encoder.relative" => ("0.04", state::SLIP),
            "width.sigma_min_m" => ("1.2e-4", state::GAIN),
            other => panic!("{other} has no row here"),
        };
        assert!(params(&changed::changed(SHIPPED, name, "-1.0")).is_none(), "{name} = -1 is out of range");
        let (mut shipped, mut retuned) = (Rig::new(), Rig::new());
        if name == "nozzle_sensor.sigma_k" {
            (shipped.nozzle, retuned.nozzle) = (Some(Celsius(215.0)), Some(Celsius(215.0)));
        }
        let before = [shipped.run(300), retuned.run(300)].map(|estimate| estimate.p[(behind, behind)]);
        retuned.estimator.retune(params(&changed::changed(SHIPPED, name, value)).unwrap());
        let after = [shipped.run(300), retuned.run(300)].map(|estimate| estimate.p[(behind, behind)]);
        assert!((before[0] - before[1]).abs() <= 0.0, "{name}: the same until then");
        assert!(after[1] > 1.05 * after[0], "{name}: {after:?}");
    }
}

/// Limits are not live, but whoever retunes all parameters has them all followed: channels, what is learnt, and health.
#[test]
fn limits_follow_and_what_was_seen_stays() {
    let retuned = |rig: &mut Rig, changes: &[(&str, &str)]| {
        let change = |text: String, &(name, value): &(&str, &str)| changed::changed(&text, name, value);
        rig.estimator.retune(params(&changes.iter().fold(SHIPPED.to_owned(), change)).unwrap());
    };
    let mut rig = Rig::new();
    let before = rig.run(3000);
    retuned(&mut rig, &[("thermistor.trust.age_limit_s", "0.02"), ("width.trust.gate", "4.0")]);
    rig.gain = 1.04;
    // readings each 0.1 s: the newest is 0.05 s old
    let after = rig.run(55);
    let width = Channel::Width as usize;
    assert!(!after.alive[Channel::Thermistor as usize] && after.alive[width]);
    assert_eq!(after.gated[width], before.gated[width] + 1);
    assert!(after.nis[width].is_some_and(|nis| nis < 12.0), "within the shipped gate: {:?}", after.nis);
    assert_eq!(after.measured[width], before.measured[width] + 1);

    retuned(&mut rig, &[("width.adaptation.low", "1.0"), ("width.adaptation.high", "1.0")]);
    rig.gain = 1.0;
    assert!(before.noise_scale[width] < 0.9, "{:?}", before.noise_scale);
    assert!((rig.run(3000).noise_scale[width] - 1.0).abs() < 1e-12);
    retuned(&mut rig, &[("health.gain_error", "0.01"), ("health.mismatch_s", "1.0")]);
    assert_eq!(rig.run(300).health, EstimateHealth::Mismatch);
}
