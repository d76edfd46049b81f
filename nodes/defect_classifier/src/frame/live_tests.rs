//! What may change while the node is active is checked, and acts at once.

use super::tests::{jpeg, picture};
use super::*;
use crate::camera::tests::camera;

#[path = "../../../runtime/tests/live/changed.rs"]
mod changed;

const SHIPPED: &str = include_str!("../../../../config/defect_classifier.param.yaml");

fn parsed(text: &str) -> Option<FrameChecks> {
    changed::parsed(text).map(|parameters: crate::params::Params| parameters.checks)
}

/// Bars of levels 60 and 160, eight pixels wide: mean 110, sharp.
#[test]
fn every_live_parameter_is_checked_and_acts_at_once() {
    let bars = jpeg(&picture(640, 480, |u, _| if (u / 8) % 2 == 0 { 60 } else { 160 }));
    for name in LIVE {
        // Half of the pixels are lighter than 150: as many as may be.
        let (values, bad): (&[(&str, &str)], &str) = match name {
            "checks.black_grey" => (&[("checks.black_grey", "120.0")], "300.0"),
            "checks.saturated_grey" => {
                (&[("checks.saturated_grey", "150.0"), ("checks.saturated_share", "0.4")], "0.0")
            }
            "checks.saturated_share" => {
                (&[("checks.saturated_share", "0.4"), ("checks.saturated_grey", "150.0")], "1.5")
            }
            "checks.sharpness_min" => (&[("checks.sharpness_min", "9.0")], "-1.0"),
            other => panic!("{other} has no row here"),
        };
        assert!(parsed(&changed::changed(SHIPPED, name, bad)).is_none(), "{name} = {bad} is out of range");
        let text = values
            .iter()
            .fold(SHIPPED.to_owned(), |text, (name, value)| changed::changed(&text, name, value));
        let shipped = parsed(SHIPPED).unwrap();
        let mut retuned = FrameGate::new(shipped, &camera());
        retuned.retune(parsed(&text).unwrap());
        assert!(FrameGate::new(shipped, &camera()).open(&bars).is_ok());
        assert!(retuned.open(&bars).is_err(), "{name}");
    }
}
