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
