//! The inertial unit of a printer at work.

use super::*;
use crate::imu::{Batch, RawSettings, Settings};

const NO_NOISE: f64 = 0.0;

/// A warm printer whose unit has this noise `[m/s2]`.
fn with_noise(sigma_m_s2: f64, job: JobSource, faults: &Scenario) -> Simulator {
    let mut params = params();
    params.simulator.imu.sigma_m_s2 = sigma_m_s2;
    let mut simulator = Simulator::new(params, job, faults, 1).unwrap();
    simulator.warm_up(&Preheat { hotend: Some(Celsius(226.0)), bed: Some(Celsius(60.0)) });
    simulator
}

fn batches(simulator: &mut Simulator, time_s: f64) -> Vec<Batch> {
    run_for(simulator, time_s);
    std::iter::from_fn(|| simulator.poll())
        .filter_map(|output| if let Output::Imu(batch) = output { Some(*batch) } else { None })
        .collect()
}

/// Time and acceleration of each sample.
fn samples(simulator: &mut Simulator, time_s: f64) -> Vec<(f64, [f64; 3])> {
    let timed = |batch: Batch| {
        let at_s =
            move |index: usize| batch.first.0 + f64::from(u32::try_from(index).unwrap()) * batch.period.0;
        batch.samples.into_iter().enumerate().map(move |(index, sample)| (at_s(index), sample))
    };
    batches(simulator, time_s).into_iter().flat_map(timed).collect()
}

/// Largest magnitude without gravity `[m/s2]` and its time.
fn peak(samples: &[(f64, [f64; 3])]) -> (f64, f64) {
    let magnitude = |[x, y, z]: [f64; 3]| (x * x + y * y + (z - 9.80665).powi(2)).sqrt();
    samples
        .iter()
        .map(|(time_s, sample)| (magnitude(*sample), *time_s))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap()
}

fn still() -> JobSource {
    job_of(&[Action::Dwell(Seconds(1e3))])
}

#[test]
fn every_sample_comes_once_and_in_its_place() {
    let mut simulator = with_noise(0.3, straight_job(30), &Scenario::default());
    let batches = batches(&mut simulator, 10.0);
    assert_eq!(batches.len(), 200);
    for (number, batch) in (0_u32..).zip(&batches) {
        assert_eq!((batch.samples.len(), batch.first_sequence), (50, u64::from(number) * 50));
        assert!((batch.first.0 - (f64::from(number) * 0.05 + 1e-3)).abs() < 1e-9);
    }
}

/// REP 145: +9.81 on z at rest; model book 1.4: 0.3 m/s2 of noise.
#[test]
fn at_rest_it_reads_gravity_upward_and_its_noise() {
    let mut simulator = with_noise(0.3, still(), &Scenario::default());
    let samples = samples(&mut simulator, 4.0);
    for axis in 0..3 {
        let count = f64::from(u32::try_from(samples.len()).unwrap());
        let mean = samples.iter().map(|(_, sample)| sample[axis]).sum::<f64>() / count;
        let spread = samples.iter().map(|(_, sample)| (sample[axis] - mean).powi(2)).sum::<f64>() / count;
        // Four standard errors: 0.3/sqrt(4000) of the mean, 0.3/sqrt(8000) of the deviation.
        let wanted = if axis == 2 { 9.80665 } else { 0.0 };
        assert!((mean - wanted).abs() < 0.019, "{axis}: {mean}");
        assert!((spread.sqrt() - 0.3).abs() < 0.014, "{axis}: {}", spread.sqrt());
    }
}

#[test]
fn a_ramp_of_the_plan_shows_along_its_path_and_its_sign() {
    let mut line = *straight_job(1)
        .steps
        .find_map(|step| if let Step::Move(s) = step { Some(Box::new(s)) } else { None })
        .unwrap();
    // 0.3 m along (3, 4)/5 with 1 s up and 1 s down at 0.15 m/s2.
    (line.end_m, line.length_m) = ([0.09, 0.12, 0.0], 0.15);
    line.profile = Trapezoid::new(0.15, (0.0, 0.0), 0.15, 0.15);
    let job = JobSource { steps: Box::new(std::iter::once(Step::Move(line))), ..straight_job(1) };
    let mut simulator = with_noise(NO_NOISE, job, &Scenario::default());
    let samples = samples(&mut simulator, 2.0);
    let mean = |from: usize, axis: usize| {
        samples[from..from + 500].iter().map(|(_, a)| a[axis]).sum::<f64>() / 500.0
    };
    for (from, sign) in [(400, 1.0), (1400, -1.0)] {
        assert!((mean(from, 0) - sign * 0.09).abs() < 1e-3, "{}", mean(from, 0));
        assert!((mean(from, 1) - sign * 0.12).abs() < 1e-3, "{}", mean(from, 1));
    }
}

/// Model book 1.12: 30-50 m/s2 within 20 ms of the skip, along the axis that skipped; then nothing more.
#[test]
fn lost_steps_show_as_one_burst_along_their_axis() {
    for seed_s in [5.0, 5.25, 5.5] {
        let skip = fault_at(seed_s, "component: motion, kind: layer_shift_y, size: 8.0e-4");
        let samples = samples(&mut with_noise(NO_NOISE, straight_job(30), &skip), 10.0);
        let (peak_m_s2, time_s) = peak(&samples);
        // Sampled each millisecond a wave of 160 Hz shows at least cos(0.5 ms x 1005 1/s) = 0.876 of its peak.
        assert!((0.87 * 30.0..=52.0).contains(&peak_m_s2), "{peak_m_s2}");
        assert!((0.0..0.02).contains(&(time_s - seed_s)), "{time_s}");
        let others = samples.iter().filter(|(t, _)| *t > 1.0 && !(seed_s..seed_s + 0.0205).contains(t));
        assert!(peak(&others.copied().collect::<Vec<_>>()).0 < 5.0);
    }
}

#[test]
fn a_knock_has_its_energy_from_peak_and_length() {
    let knock = fault_at(2.0, "component: motion, kind: knock, size: 45.0");
    let samples = samples(&mut with_noise(NO_NOISE, still(), &knock), 3.0);
    let energy: f64 =
        samples.iter().map(|(_, [x, y, z])| (x * x + y * y + (z - 9.80665).powi(2)) * 1e-3).sum();
    // A^2 T/4 of 10 to 20 ms; sums of samples for the integral: within 3 %.
    let of = |length_s: f64| 45.0 * 45.0 * length_s / 4.0;
    assert!((0.97 * of(0.010)..1.03 * of(0.020)).contains(&energy), "{energy}");
    let long = samples.iter().filter(|(_, sample)| peak(&[(0.0, *sample)]).0 > 1e-6).count();
    assert!((10..=20).contains(&long), "{long}");
}

#[test]
fn beyond_its_range_it_shows_its_range() {
    let knock = fault_at(1.0, "component: motion, kind: knock, size: 200.0");
    let mut params = params();
    params.simulator.imu.range_m_s2 = 40.0;
    let mut simulator = Simulator::new(params, still(), &knock, 1).unwrap();
    let samples = samples(&mut simulator, 2.0);
    let largest = samples.iter().flat_map(|(_, sample)| sample.map(f64::abs)).fold(0.0, f64::max);
    assert!((largest - 40.0).abs() < 1e-12, "{largest}");
}

/// A blow would stand out of the quietest and the busiest print alike.
#[test]
fn a_sound_print_of_a_real_file_stays_far_below_a_blow() {
    let mut simulator = Simulator::new(params(), cube(10), &Scenario::default(), 1).unwrap();
    simulator.warm_up(&cube(10).preheat);
    let mut highest_m_s2: f64 = 0.0;
    while simulator.phase() != JobPhase::Done {
        highest_m_s2 = highest_m_s2.max(peak(&samples(&mut simulator, 1.0)).0);
    }
    assert!((1.0..20.0).contains(&highest_m_s2), "{highest_m_s2}");
}

#[test]
fn a_printer_without_one_prints_the_same() {
    let end = |period_s: f64| {
        let mut params = params();
        params.simulator.imu.period_s = period_s;
        let mut simulator = Simulator::new(params, straight_job(5), &Scenario::default(), 1).unwrap();
        simulator.warm_up(&Preheat { hotend: Some(Celsius(226.0)), bed: Some(Celsius(60.0)) });
        let count = batches(&mut simulator, 20.0).len();
        (count > 0, simulator.truth().integrals)
    };
    let (fitted, with) = end(1e-3);
    let (none, without) = end(0.0);
    assert!(fitted && !none);
    assert_eq!(with, without);
}

#[test]
fn what_is_no_sensor_is_refused() {
    let raw = RawSettings { period_s: 1e-3, batch_period_s: 0.05, sigma_m_s2: 0.3, range_m_s2: 156.9 };
    assert!(
        Settings::try_from(raw).is_ok() && Settings::try_from(RawSettings { period_s: 0.0, ..raw }).is_ok()
    );
    for period_s in [5e-4, 1.5e-3, 0.2, -1e-3, f64::NAN] {
        assert!(Settings::try_from(RawSettings { period_s, ..raw }).is_err(), "{period_s}");
    }
    let slow = Settings::try_from(RawSettings { period_s: 0.1, ..raw }).unwrap_err();
    assert_eq!(slow.to_string(), "imu.batch_period_s = 0.05 s: must be in [0.1, 1]");
}
