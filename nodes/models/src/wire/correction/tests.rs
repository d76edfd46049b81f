use super::*;
use proptest::prelude::*;

const LAW: RawLaw = RawLaw {
    height_m: 2.16e-3,
    wire_m_s: 3.5e-3,
    head_m_s: 1.68e-3,
    gain: 0.635,
    split: 2.0 / 3.0,
    ratio_low: 0.2,
    ratio_high: 1.8,
};

const LIMITS: RawLimits =
    RawLimits { wire_low_m_s: 1e-3, wire_high_m_s: 4e-3, head_low_m_s: 1e-3, head_high_m_s: 3e-3 };

fn law() -> Law {
    Law::try_from(LAW).unwrap()
}

fn limits() -> Limits {
    Limits::try_from(LIMITS).unwrap()
}

/// Model book 3.3: inverting the section's law for the row "3.09" gives 3.698 mm.
#[test]
fn the_row_that_does_not_fit_reads_as_3_69() {
    let height_m = law().height_of(2.34e-3, 2.05e-3).unwrap();
    assert!((height_m - 3.698e-3).abs() < 1e-6, "{height_m}");
}

/// `kappa = (2/3) v_h0/v_w0 = 0.32`: the weighted sum of the speeds is 1.68 + 0.32 * 3.5 = 2.8 mm/s at every height.
#[test]
fn the_weighted_sum_of_the_speeds_is_constant() {
    for height_m in [0.0, 1.5e-3, 2.16e-3, 3e-3] {
        let speeds = law().correct(Mode::Both, height_m).unwrap();
        assert!((speeds.head_m_s + 0.32 * speeds.wire_m_s - 2.8e-3).abs() < 1e-15);
    }
}

/// r = 1.635 wants 4.56 mm/s of wire; the laser melts 4, so the head slows from 1.34 to 4/(1.635 * 3.5/1.68) = 1.1743.
#[test]
fn the_head_takes_over_what_the_laser_cannot_melt() {
    let speeds = law().correct_within(Mode::Both, &limits(), 0.0).unwrap();
    assert!((speeds.wire_m_s - 4e-3).abs() < 1e-15 && speeds.limited);
    assert!((speeds.head_m_s - 1.174_312e-3).abs() < 1e-9, "{speeds:?}");
    assert!((speeds.section_ratio - 1.635).abs() < 1e-12);
}

#[test]
fn in_the_mode_of_one_speed_the_limit_costs_section() {
    let speeds = law().correct_within(Mode::Wire, &limits(), 0.0).unwrap();
    assert!((speeds.section_ratio - 4.0 / 3.5).abs() < 1e-12 && speeds.limited);
    assert!((speeds.head_m_s - 1.68e-3).abs() < 1e-15);
}

#[test]
fn a_height_that_is_no_number_is_refused() {
    for height_m in [f64::NAN, f64::INFINITY] {
        let error = law().correct_within(Mode::Both, &limits(), height_m).unwrap_err();
        assert!(error.to_string().starts_with("measured_height_m = "), "{error}");
    }
}

#[test]
fn limits_must_stand_in_order() {
    let error = Limits::try_from(RawLimits { wire_low_m_s: 5e-3, ..LIMITS }).unwrap_err();
    assert_eq!(error.to_string(), "wire_low_m_s = 0.005: must be below wire_high_m_s = 0.004");
}

/// The next layer adds h0 r: the error e = h - h0 becomes (1 - g) e.
fn next_error_m(law: &Law, mode: Mode, error_m: f64) -> f64 {
    let laid = law.correct(mode, law.height_m + error_m).unwrap();
    error_m + law.height_m * (laid.section_ratio - 1.0)
}

/// |1 - g| < 1; at 0 and 2 an error stays for ever.
#[test]
fn a_loop_is_called_stable_inside_zero_to_two_alone() {
    for (gain, stable) in
        [(0.0, false), (0.01, true), (0.635, true), (1.99, true), (2.0, false), (2.5, false)]
    {
        assert_eq!(law().with_gain(gain).unwrap().is_stable(), stable, "gain {gain}");
    }
}

/// Model book 3.3: 1, .365, .133, .049.
#[test]
fn a_height_error_shrinks_by_one_less_the_gain() {
    let mut error_m = 1e-4;
    for share in [0.365, 0.133, 0.0486] {
        error_m = next_error_m(&law(), Mode::Both, error_m);
        assert!((error_m - share * 1e-4).abs() < 1e-7, "{error_m}");
    }
}

proptest! {
    #[test]
    fn stable_inside_zero_to_two(gain in 0.05..1.95_f64, start_m in -2e-4..2e-4_f64) {
        let law = law().with_gain(gain).unwrap();
        let mut error_m = start_m;
        for _ in 0..100 {
            error_m = next_error_m(&law, Mode::Both, error_m);
        }
        // |1 - g| <= 0.95: 0.95^100 = 0.0059.
        prop_assert!(error_m.abs() <= 0.006 * start_m.abs() + 1e-15);
    }

    #[test]
    fn unstable_beyond_two(gain in 2.05..3.5_f64) {
        let law = law().with_gain(gain).unwrap();
        let start_m = 1e-7;
        let mut error_m = start_m;
        for _ in 0..20 {
            error_m = next_error_m(&law, Mode::Head, error_m);
        }
        // 1.05^20 = 2.65, until the law's range holds it.
        prop_assert!(error_m.abs() > 2.6 * start_m);
    }

    #[test]
    fn every_mode_lays_the_same_section(height_m in 0.0..5e-3_f64) {
        let both = law().correct(Mode::Both, height_m).unwrap();
        for mode in [Mode::Wire, Mode::Head] {
            let one = law().correct(mode, height_m).unwrap();
            prop_assert!((one.section_ratio / both.section_ratio - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn lower_means_more_wire_and_a_slower_head(height_m in 0.1e-3..4e-3_f64) {
        let high = law().correct(Mode::Both, height_m).unwrap();
        let low = law().correct(Mode::Both, height_m - 0.05e-3).unwrap();
        prop_assert!(low.wire_m_s > high.wire_m_s && low.head_m_s < high.head_m_s);
    }

    #[test]
    fn speeds_never_leave_their_limits(height_m in -1.0..1.0_f64) {
        for mode in [Mode::Both, Mode::Wire, Mode::Head] {
            let speeds = law().correct_within(mode, &limits(), height_m).unwrap();
            prop_assert!((1e-3..=4e-3).contains(&speeds.wire_m_s), "{speeds:?}");
            prop_assert!((1e-3..=3e-3).contains(&speeds.head_m_s), "{speeds:?}");
        }
    }
}
