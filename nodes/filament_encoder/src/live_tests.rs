//! What may change while the node is active is checked, and acts at once.

use super::*;
use crate::params::LIVE;
use models::units::Seconds;

#[path = "../../runtime/tests/live/changed.rs"]
mod changed;

const SHIPPED: &str = include_str!("../../../config/filament_encoder.param.yaml");

fn parsed(text: &str) -> Option<Params> {
    changed::parsed(text)
}

/// Counts of a device that jumps after its first report, one after the other.
fn jumps(encoder: &mut Encoder, counts: i64, times: u32) -> Option<Sample> {
    encoder.on_counts(Seconds(1.0), Seconds(1.0), 0).unwrap();
    let at = |time: u32| Seconds(1.0 + 0.01 * f64::from(time));
    (1..=times).map(|time| encoder.on_counts(at(time), at(time), counts).ok()).last().flatten()
}

#[test]
fn every_live_parameter_is_checked_and_acts_at_once() {
    for name in LIVE {
        let (value, bad, acts): (&str, &str, fn(&mut Encoder) -> bool) = match name {
            // 100 counts of 10 um in 10 ms are 0.1 m/s
            "encoder.speed_max_m_s" => ("0.05", "2.0", |encoder| jumps(encoder, 100, 1).is_none()),
            "encoder.rebase_after" => {
                ("2", "0", |encoder| jumps(encoder, 90_000, 2).is_some_and(|sample| sample.rebased))
            }
            other => panic!("{other} has no row here"),
        };
        assert!(parsed(&changed::changed(SHIPPED, name, bad)).is_none(), "{name} = {bad} is out of range");
        let shipped = parsed(SHIPPED).unwrap().encoder;
        let mut retuned = Encoder::new(shipped);
        retuned.retune(parsed(&changed::changed(SHIPPED, name, value)).unwrap().encoder);
        assert!(acts(&mut retuned) && !acts(&mut Encoder::new(shipped)), "{name}");
    }
}
