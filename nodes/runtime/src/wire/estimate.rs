//! `StateEstimate`: the names of states and channels, and what a reader may rely on.

use super::{WireError, stamp_from_wire, within};
use fdm_loop_msgs::StateEstimate;
use models::command::EstimateHealth;
use models::units::{Kelvin, Seconds};

/// Names of the states in the order of the estimator.
pub const STATES: [&str; 6] = ["block_k", "nozzle_k", "sensor_k", "flow_m_s", "slip", "gain"];
/// Names of the measurement channels in the order of the estimator.
pub const CHANNELS: [&str; 4] = ["thermistor", "encoder", "width", "nozzle"];

/// What controller and supervisor read of an estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StateReading {
    /// Time of validity.
    pub stamp: Seconds,
    /// Nozzle temperature.
    pub nozzle: Kelvin,
    /// Outlet flow as filament speed `[m/s]`; noise makes it negative at rest.
    pub flow_m_s: f64,
    /// Share of the motor's feed that is lost `[-]`.
    pub slip: f64,
    /// Road section over nominal section `[-]`.
    pub gain: f64,
    /// Slow mean of the slicer's feed `[m/s]`.
    pub reference_feed_m_s: f64,
    /// The encoder speaks.
    pub encoder_alive: bool,
    /// Widths come.
    pub width_alive: bool,
    /// What the estimator says of its own work.
    pub health: EstimateHealth,
}

/// A state estimate.
///
/// # Errors
/// [`WireError`] for a value that is not finite or not possible, a state or channel that is missing, arrays of lengths
/// that do not belong together, a negative variance.
pub fn estimate_from_wire(wire: &StateEstimate) -> Result<StateReading, WireError> {
    let (states, channels) = (wire.names.len(), wire.channels.len());
    let lengths = [
        ("x", wire.x.len(), states),
        ("covariance", wire.covariance.len(), states * states),
        ("observed", wire.observed.len(), states),
        ("held", wire.held.len(), states),
        ("alive", wire.alive.len(), channels),
        ("measured", wire.measured.len(), channels),
        ("nis", wire.nis.len(), channels),
        ("nis_mean", wire.nis_mean.len(), channels),
        ("chi_square", wire.chi_square.len(), channels),
    ];
    if let Some((field, ..)) = lengths.iter().find(|(_, length, wanted)| length != wanted) {
        return Err(WireError::Missing { field });
    }
    const POSITIVE: (f64, f64) = (0.0, f64::MAX);
    let all =
        |field, values: &[f64], range| values.iter().try_for_each(|v| within(field, *v, range).map(drop));
    all("covariance", &wire.covariance, (f64::MIN, f64::MAX))?;
    for field in [("nis", &wire.nis), ("nis_mean", &wire.nis_mean), ("chi_square", &wire.chi_square)] {
        all(field.0, field.1, POSITIVE)?;
    }
    all("noise_scale", &wire.noise_scale, POSITIVE)?;
    for index in 0..states {
        within("covariance", wire.covariance[index * (states + 1)], POSITIVE)?;
    }
    state(wire, "block_k", KELVIN)?;
    state(wire, "sensor_k", KELVIN)?;
    Ok(StateReading {
        stamp: stamp_from_wire(&wire.header)?,
        nozzle: Kelvin(state(wire, "nozzle_k", KELVIN)?),
        flow_m_s: state(wire, "flow_m_s", (-1.0, 1.0))?,
        slip: state(wire, "slip", (-1.0, 1.0))?,
        gain: state(wire, "gain", (1e-3, 10.0))?,
        reference_feed_m_s: within("reference_feed_m_s", wire.reference_feed_m_s, (1e-9, 1.0))?,
        encoder_alive: channel(wire, "encoder")?,
        width_alive: channel(wire, "width")?,
        health: EstimateHealth::from_code(wire.health).ok_or(super::command::unknown(
            "health",
            wire.health,
            3.0,
        ))?,
    })
}

/// What no part of a printer leaves.
const KELVIN: (f64, f64) = (1.0, 2000.0);

fn state(wire: &StateEstimate, name: &'static str, range: (f64, f64)) -> Result<f64, WireError> {
    let index = wire.names.iter().position(|known| known == name);
    let value = index.and_then(|index| wire.x.get(index)).ok_or(WireError::Missing { field: name })?;
    within(name, *value, range)
}

fn channel(wire: &StateEstimate, name: &'static str) -> Result<bool, WireError> {
    let index = wire.channels.iter().position(|known| known == name);
    index.and_then(|index| wire.alive.get(index)).copied().ok_or(WireError::Missing { field: name })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sound() -> StateEstimate {
        let mut covariance = vec![0.0; 36];
        (0..6).for_each(|index| covariance[index * 7] = 1e-6);
        StateEstimate {
            names: STATES.map(str::to_owned).to_vec(),
            x: vec![483.0, 475.0, 483.0, 2e-3, 0.01, 1.0],
            covariance,
            observed: vec![true; 6],
            held: vec![false; 6],
            reference_feed_m_s: 2e-3,
            channels: CHANNELS.map(str::to_owned).to_vec(),
            alive: vec![true, false, true, false],
            measured: vec![true; 4],
            nis: vec![1.0; 4],
            nis_mean: vec![1.0; 4],
            gated: vec![0; 4],
            chi_square: vec![20.0; 4],
            ..StateEstimate::default()
        }
    }

    #[test]
    fn states_are_found_by_name() {
        let reading = estimate_from_wire(&sound()).unwrap();
        assert_eq!((reading.nozzle, reading.slip, reading.encoder_alive), (Kelvin(475.0), 0.01, false));
    }

    #[test]
    fn what_cannot_be_is_refused_by_name() {
        type Poison = fn(&mut StateEstimate);
        let poisons: [(&str, Poison); 9] = [
            ("nozzle_k is not finite", |wire| wire.x[1] = f64::NAN),
            ("covariance is not finite", |wire| wire.covariance[3] = f64::NAN),
            ("covariance = -1: must be in", |wire| wire.covariance[7] = -1.0),
            ("nozzle_k = -1: must be in", |wire| wire.x[1] = -1.0),
            ("slip is missing", |wire| wire.names[4] = "x".into()),
            ("alive is missing", |wire| wire.alive = vec![]),
            ("observed is missing", |wire| wire.observed.truncate(5)),
            ("held is missing", |wire| wire.held.clear()),
            ("nis = -1: must be in", |wire| wire.nis[0] = -1.0),
        ];
        for (text, poison) in poisons {
            let mut wire = sound();
            poison(&mut wire);
            let said = estimate_from_wire(&wire).unwrap_err().to_string();
            assert!(said.starts_with(text), "{said} is not {text}");
        }
    }
}
