//! What the firmware's thermometers tell.

use super::*;

/// Hot end and nozzle over 10 s of a warm printer `[degC]`, and the truth of the nozzle at the end.
fn told(fitted: bool) -> (Vec<(f64, Option<f64>)>, f64) {
    let mut params = params();
    params.simulator.sensors.nozzle_sensor = fitted;
    let mut simulator = Simulator::new(params, straight_job(30), &Scenario::default(), 1).unwrap();
    simulator.warm_up(&Preheat { hotend: Some(Celsius(226.0)), bed: Some(Celsius(60.0)) });
    run_for(&mut simulator, 10.0);
    let told = std::iter::from_fn(|| simulator.poll()).filter_map(|output| match output {
        Output::Temperatures { hotend, nozzle, .. } => Some((hotend.0, nozzle.map(|temp| temp.0))),
        _ => None,
    });
    (told.collect(), Celsius::from(models::units::Kelvin(simulator.truth().nozzle_k)).0)
}

/// A noise of 0.15 K about the nozzle, which the melt cools below its block; without it all else reads as it did.
#[test]
fn a_sensor_in_the_nozzle_reads_the_nozzle_where_one_is_fitted() {
    let (with, truth_c) = told(true);
    assert!(with.len() >= 99, "{}", with.len());
    let last: Vec<f64> = with.iter().rev().take(5).map(|(_, nozzle)| nozzle.unwrap()).collect();
    assert!(last.iter().all(|nozzle_c| (nozzle_c - truth_c).abs() < 1.5), "{last:?} of {truth_c}");
    assert!(with.last().is_some_and(|(block_c, nozzle)| nozzle.unwrap() < block_c - 2.0));
    let (without, _) = told(false);
    assert!(without.iter().all(|(_, nozzle)| nozzle.is_none()));
    assert!(with.iter().zip(&without).all(|(one, other)| one.0.to_bits() == other.0.to_bits()));
}
