//! What may change while the node is active is checked, and acts at once.

use crate::frames::{Frames, Refusal};
use crate::params::{LIVE, Params};
use crate::picture::tests::jpeg;
use models::units::Seconds;

#[path = "../../runtime/tests/live/changed.rs"]
mod changed;

const SHIPPED: &str = include_str!("../../../config/camera.param.yaml");

fn parsed(text: &str) -> Option<Params> {
    changed::parsed(text)
}

/// Whether one of ten frames at 20 Hz is left out.
fn thins(frames: &mut Frames) -> bool {
    let at = |number: u8| 10.0 + 0.05 * f64::from(number);
    (0..10).any(|number| {
        let taken = frames.on_frame(Seconds(at(number) + 0.01), Seconds(at(number)), &jpeg(640, 480, number));
        taken == Err(Refusal::TooFast)
    })
}

#[test]
fn every_live_parameter_is_checked_and_acts_at_once() {
    for name in LIVE {
        assert_eq!(name, "camera.rate_max_hz", "{name} has no row here");
        assert!(parsed(&changed::changed(SHIPPED, name, "500.0")).is_none(), "{name} is out of range");
        let shipped = parsed(SHIPPED).unwrap().camera;
        let mut retuned = Frames::new(shipped.clone());
        retuned.retune(parsed(&changed::changed(SHIPPED, name, "5.0")).unwrap().camera);
        assert!(thins(&mut retuned) && !thins(&mut Frames::new(shipped)), "{name}");
    }
}
