//! What may change while the node is active is checked, and acts at once.

use crate::accelerometer::{Accelerometer, Report};
use crate::params::{LIVE, Params};
use crate::window::{GRAVITY_M_S2, Verdict};
use models::units::Seconds;

#[path = "../../runtime/tests/live/changed.rs"]
mod changed;

const SHIPPED: &str = include_str!("../../../config/imu.param.yaml");

fn parsed(text: &str) -> Option<Params> {
    changed::parsed(text)
}

/// 2 s of samples at a rate that the device states; the variance that tools were told last.
fn shown(unit: &mut Accelerometer, sample: [f64; 3], rate_hz: f64) -> Option<f64> {
    let mut variance = None;
    for index in 0..40_u32 {
        let report = Report {
            frame: "imu".into(),
            first: Seconds(10.0 + f64::from(index) * 50.0 / rate_hz),
            first_sequence: u64::from(index) * 50,
            period: Seconds(1.0 / rate_hz),
            range_m_s2: 156.9064,
            samples: vec![sample; 50],
        };
        let now = report.first + Seconds(0.05);
        if let Ok(checked) = unit.on_report(now, report) {
            variance = checked.thinned.last().map(|thinned| thinned.variance_m2_s4).or(variance);
        }
    }
    variance
}

const REST: [f64; 3] = [0.0, 0.0, GRAVITY_M_S2];

#[test]
fn every_live_parameter_is_checked_and_acts_at_once() {
    for name in LIVE {
        let (value, bad, acts): (&str, &str, fn(&mut Accelerometer) -> bool) = match name {
            // forty samples of 0.6 m/s2 to a mean: 0.009; shipped are 0.3 m/s2: 0.00225
            "unit.sigma_m_s2" => {
                ("0.6", "0.0", |unit| shown(unit, REST, 1000.0).is_some_and(|got| got > 0.008))
            }
            "unit.rate_tolerance" => ("0.02", "0.6", |unit| shown(unit, REST, 1050.0).is_none()),
            // a tenth more than gravity
            "unit.gravity_tolerance" => {
                ("0.05", "0.6", |unit| shown(unit, REST.map(|a| 1.1 * a), 1000.0).is_none())
            }
            // atan(2/9.81) = 11.5 deg
            "unit.tilt_max_deg" => ("5.0", "60.0", |unit| {
                _ = shown(unit, [2.0, 0.0, GRAVITY_M_S2], 1000.0);
                matches!(unit.verdict(), Verdict::Axes { .. })
            }),
            other => panic!("{other} has no row here"),
        };
        assert!(parsed(&changed::changed(SHIPPED, name, bad)).is_none(), "{name} = {bad} is out of range");
        let shipped = parsed(SHIPPED).unwrap().unit;
        let mut retuned = Accelerometer::new(shipped.clone());
        retuned.retune(parsed(&changed::changed(SHIPPED, name, value)).unwrap().unit);
        assert!(acts(&mut retuned) && !acts(&mut Accelerometer::new(shipped)), "{name}");
    }
}
