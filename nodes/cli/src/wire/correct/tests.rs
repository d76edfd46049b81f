use super::*;
use models::wire::correction::{RawLaw, RawLimits};

/// r = 1.635 wants 4.56 mm/s of wire: at a limit of 4 the head takes over; a layer of 4.5 mm asks for a section of
/// 0.31, at which only the law's own least of 0.5 holds.
#[test]
fn the_limit_that_holds_is_named() {
    let law = Law::try_from(RawLaw {
        height_m: 2.16e-3,
        wire_m_s: 3.5e-3,
        head_m_s: 1.68e-3,
        gain: 0.635,
        split: 2.0 / 3.0,
        ratio_low: 0.5,
        ratio_high: 1.8,
    })
    .unwrap();
    let limits = Limits::try_from(RawLimits {
        wire_low_m_s: 1e-3,
        wire_high_m_s: 4e-3,
        head_low_m_s: 1e-3,
        head_high_m_s: 3e-3,
    })
    .unwrap();
    let held =
        |height_m: f64| at_limits(&law, &limits, &law.correct_within(Mode::Both, &limits, height_m).unwrap());
    assert_eq!(held(0.0), ["wire at its most, 4.000 mm/s"]);
    assert_eq!(held(4.5e-3), ["section at its least, 0.500"]);
    assert!(held(2.1e-3).is_empty());
}
