//! Laws of the resonance and of a blow.

use super::*;

const STEP: Seconds = Seconds(1e-3);

fn structure() -> Structure {
    let mode = |frequency_hz, damping| Mode { frequency_hz, damping };
    let params =
        StructureParams { along_x: mode(48.0, 0.07), along_y: mode(37.0, 0.05), along_z: mode(95.0, 0.04) };
    Structure::new(params, STEP)
}

/// Acceleration along one axis `[m/s2]` after its speed has jumped by 10 mm/s, sampled each millisecond.
fn ringing(axis: usize) -> Vec<f64> {
    let mut structure = structure();
    let mut velocity_m_s = [0.0; 3];
    velocity_m_s[axis] = 0.01;
    (0..500).map(|_| structure.step(velocity_m_s, STEP)[axis]).collect()
}

/// Times at which the signal rises through zero, interpolated `[s]`.
fn rises_s(signal: &[f64]) -> Vec<f64> {
    let rise = |(index, pair): (usize, &[f64])| {
        (pair[0] < 0.0 && pair[1] >= 0.0)
            .then(|| (f64::from(u32::try_from(index).unwrap()) + pair[0] / (pair[0] - pair[1])) * 1e-3)
    };
    signal.windows(2).enumerate().filter_map(rise).collect()
}

#[test]
fn a_jump_of_speed_rings_at_the_damped_frequency() {
    for (axis, frequency_hz, damping) in [(0, 48.0, 0.07_f64), (1, 37.0, 0.05), (2, 95.0, 0.04)] {
        let rises_s = rises_s(&ringing(axis)[..200]);
        let periods = f64::from(u32::try_from(rises_s.len() - 1).unwrap());
        let seen_hz = periods / (rises_s[rises_s.len() - 1] - rises_s[0]);
        let damped_hz = frequency_hz * (1.0 - damping * damping).sqrt();
        // Linear interpolation of a sine sampled ten times a period errs by less than 1 % of it.
        assert!((seen_hz / damped_hz - 1.0).abs() < 0.01, "{axis}: {seen_hz} Hz, {damped_hz} Hz");
    }
}

#[test]
fn the_ringing_dies_with_the_damping_of_its_axis() {
    let energy = |signal: &[f64]| signal.iter().map(|m_s2| m_s2 * m_s2).sum::<f64>();
    for (axis, frequency_hz, damping) in [(0, 48.0, 0.07), (1, 37.0, 0.05), (2, 95.0, 0.04)] {
        let signal = ringing(axis);
        // Energy falls with exp(-2 d w t); windows of 100 ms hold whole periods but for 5 %.
        let fall = (energy(&signal[100..200]) / energy(&signal[..100])).ln();
        let wanted = -2.0 * damping * TAU * frequency_hz * 0.1;
        assert!((fall / wanted - 1.0).abs() < 0.1, "{axis}: {fall}, {wanted}");
    }
}

/// The tool ends with the commanded speed, however it got there: its acceleration integrates to the jump.
#[test]
fn the_tool_takes_up_the_commanded_speed() {
    for axis in 0..3 {
        let gained_m_s: f64 = ringing(axis).iter().sum::<f64>() * 1e-3;
        // Rectangles instead of the integral: half a step of the first acceleration, w v = 10 mm/s x 600 1/s.
        assert!((gained_m_s / 0.01 - 1.0).abs() < 0.05, "{axis}: {gained_m_s}");
    }
}

#[test]
fn a_steady_ramp_is_felt_as_it_is_commanded() {
    let mut structure = structure();
    let mut felt_m_s2 = [0.0; 3];
    for step in 1..=1000 {
        let speed_m_s = 1e-3 * f64::from(step);
        felt_m_s2 = structure.step([1.5 * speed_m_s, -0.5 * speed_m_s, 0.2 * speed_m_s], STEP);
    }
    // After 1 s even the y axis has fallen by exp(-0.05 x 2 pi x 37 x 1 s) = 9e-6.
    for (felt, wanted) in felt_m_s2.into_iter().zip([1.5, -0.5, 0.2]) {
        assert!((felt - wanted).abs() < 1e-4, "{felt}, {wanted}");
    }
}

#[test]
fn the_result_does_not_depend_on_the_step() {
    let felt_m_s2 = |steps: i32| {
        let dt = Seconds(0.02 / f64::from(steps));
        let mut structure = structure();
        let ramp = (1..=steps).map(|step| structure.step([dt.0 * f64::from(step), 0.0, 0.0], dt)[0]);
        ramp.last().unwrap()
    };
    assert!((felt_m_s2(20) - felt_m_s2(160)).abs() < 1e-9);
}

#[test]
fn a_blow_has_its_peak_in_the_middle_the_energy_of_its_window_and_no_mean() {
    for length_s in [0.010, 0.015, 0.020] {
        let peak_m_s2 = [36.0, 27.0, 0.0];
        let blow = Blow { start: Seconds(1.0), length_s, peak_m_s2, frequency_hz: 160.0 };
        assert!((blow.at(Seconds(1.0 + 0.5 * length_s))[0] - 36.0).abs() < 1e-9);
        let at = |step: u32| blow.at(Seconds(1.0 + f64::from(step) * 1e-5));
        let energy: f64 = (0..3000).map(at).map(|a| a.iter().map(|x| x * x).sum::<f64>() * 1e-5).sum();
        // Of cos^2 the 2 f part is left: below 3 % of the window's at three waves and more.
        assert!((energy / (45.0 * 45.0 * length_s / 4.0) - 1.0).abs() < 0.03, "{length_s}: {energy}");
        let gained_m_s: f64 = (0..3000).map(at).map(|a| a[0] * 1e-5).sum();
        // Against 0.6 A T of a half sine without wave.
        assert!(gained_m_s.abs() < 0.1 * 36.0 * length_s, "{length_s}: {gained_m_s}");
        assert!(!blow.over(Seconds(1.0 + 0.99 * length_s)) && blow.over(Seconds(1.0 + 1.01 * length_s)));
    }
}

#[test]
fn what_is_no_structure_is_refused() {
    let mode = |frequency_hz, damping| Mode::try_from(RawMode { frequency_hz, damping });
    assert!(mode(48.0, 0.07).is_ok());
    assert_eq!(mode(48.0, 1.0).unwrap_err().to_string(), "damping = 1 (no unit): must be in [0.001, 0.9]");
    assert!(mode(0.0, 0.07).is_err() && mode(f64::NAN, 0.07).is_err());
    let impact = RawImpact {
        frequency_hz: 160.0,
        shortest_s: 0.02,
        longest_s: 0.01,
        skip_low_m_s2: 30.0,
        skip_high_m_s2: 50.0,
    };
    assert!(ImpactParams::try_from(impact).is_err());
}
