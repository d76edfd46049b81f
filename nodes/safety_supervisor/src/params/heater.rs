//! P1, P2, P12: numbers of the energy balance of a heater.

use models::params::{ParamError, in_range};
use serde::Deserialize;

use super::thermal::count;

/// P1, P2: one observer of the balance.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawObserverParams")]
pub struct ObserverParams {
    /// Speed of the observer `[1/s]`.
    pub pole_1_s: f64,
    /// Power without order that trips `[W]`.
    pub stuck_on_w: f64,
    /// Order without power that trips `[W]`.
    pub deficit_w: f64,
    /// Share of the order without power that trips as well `[-]`: a draught is no share of it.
    pub deficit_share: f64,
    /// Least power that such a share counts from `[W]`.
    pub deficit_min_w: f64,
    /// Samples in a row until it trips `[-]`.
    pub samples: u32,
}

/// As [`ObserverParams`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawObserverParams {
    /// Speed of the observer `[1/s]`.
    pub pole_1_s: f64,
    /// Power without order that trips `[W]`.
    pub stuck_on_w: f64,
    /// Order without power that trips `[W]`.
    pub deficit_w: f64,
    /// Share of the order without power that trips as well `[-]`: a draught is no share of it.
    pub deficit_share: f64,
    /// Least power that such a share counts from `[W]`.
    pub deficit_min_w: f64,
    /// Samples in a row until it trips `[-]`.
    pub samples: u32,
}

impl TryFrom<RawObserverParams> for ObserverParams {
    type Error = ParamError;

    fn try_from(raw: RawObserverParams) -> Result<Self, ParamError> {
        Ok(Self {
            pole_1_s: in_range("pole_1_s", raw.pole_1_s, "1/s", (0.1, 3.0))?,
            stuck_on_w: in_range("stuck_on_w", raw.stuck_on_w, "W", (1.0, 200.0))?,
            deficit_w: in_range("deficit_w", raw.deficit_w, "W", (1.0, 200.0))?,
            deficit_share: in_range("deficit_share", raw.deficit_share, "-", (0.1, 1.0))?,
            deficit_min_w: in_range("deficit_min_w", raw.deficit_min_w, "W", (1.0, 200.0))?,
            samples: count("samples", raw.samples, 50)?,
        })
    }
}

/// Largest share of the heater's power that heat without order may have to have `[-]`: the rest holds a block at its target.
const STUCK_ON_SHARE: f64 = 0.6;

/// Largest share that missing heat may have to have: a weak heater gives half of what is ordered `[-]`.
const DEFICIT_SHARE: f64 = 0.5;

/// P1, P2: constants of the energy balance: the supervisor's own, not the estimator's.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawHeaterParams")]
pub struct HeaterParams {
    /// Heater power at full duty `[W]`.
    pub power_w: f64,
    /// Heat capacity of block and nozzle `[J/K]`.
    pub capacity_j_k: f64,
    /// Loss to air `[W/K]`.
    pub loss_w_k: f64,
    /// Further loss at full part fan `[W/K]`.
    pub fan_loss_w_k: f64,
    /// Heat taken along by the filament per length `[J/(K m)]`.
    pub feed_heat_j_k_m: f64,
    /// Air temperature `[degC]`.
    pub ambient_c: f64,
    /// Lag of the thermistor `[s]`.
    pub sensor_lag_s: f64,
    /// Time over which a lasting disturbance becomes usual `[s]`.
    pub usual_time_s: f64,
    /// Largest disturbance that may become usual `[W]`.
    pub usual_max_w: f64,
    /// Relative error of the capacity that is allowed for while warming up `[-]`.
    pub capacity_error: f64,
    /// Error of the sensor's lag that is allowed for while the order changes `[s]`.
    pub lag_error_s: f64,
    /// Deviation from the expected reading that counts as a spike `[K]`.
    pub spike_k: f64,
    /// Spikes in a row that are left out `[-]`.
    pub spike_samples: u32,
    /// Noise of a sound reading, one standard deviation, that the limits of the observers allow for `[K]`.
    pub usual_noise_k: f64,
    /// For a heater that is dead, loose or shorted.
    pub fast: ObserverParams,
    /// For a heater that is weak.
    pub slow: ObserverParams,
}

/// As [`HeaterParams`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawHeaterParams {
    /// Heater power at full duty `[W]`.
    pub power_w: f64,
    /// Heat capacity of block and nozzle `[J/K]`.
    pub capacity_j_k: f64,
    /// Loss to air `[W/K]`.
    pub loss_w_k: f64,
    /// Further loss at full part fan `[W/K]`.
    pub fan_loss_w_k: f64,
    /// Heat taken along by the filament per length `[J/(K m)]`.
    pub feed_heat_j_k_m: f64,
    /// Air temperature `[degC]`.
    pub ambient_c: f64,
    /// Lag of the thermistor `[s]`.
    pub sensor_lag_s: f64,
    /// Time over which a lasting disturbance becomes usual `[s]`.
    pub usual_time_s: f64,
    /// Largest disturbance that may become usual `[W]`.
    pub usual_max_w: f64,
    /// Relative error of the capacity that is allowed for while warming up `[-]`.
    pub capacity_error: f64,
    /// Error of the sensor's lag that is allowed for while the order changes `[s]`.
    pub lag_error_s: f64,
    /// Deviation from the expected reading that counts as a spike `[K]`.
    pub spike_k: f64,
    /// Spikes in a row that are left out `[-]`.
    pub spike_samples: u32,
    /// Noise of a sound reading, one standard deviation, that the limits of the observers allow for `[K]`.
    pub usual_noise_k: f64,
    /// For a heater that is dead, loose or shorted.
    pub fast: ObserverParams,
    /// For a heater that is weak.
    pub slow: ObserverParams,
}

impl TryFrom<RawHeaterParams> for HeaterParams {
    type Error = ParamError;

    fn try_from(raw: RawHeaterParams) -> Result<Self, ParamError> {
        let power_w = in_range("power_w", raw.power_w, "W", (1.0, 2000.0))?;
        // What is ordered is no excess: a limit of more than this finds no switch that conducts by itself.
        let most_w = STUCK_ON_SHARE * power_w;
        for (name, observer) in [("fast.stuck_on_w", raw.fast), ("slow.stuck_on_w", raw.slow)] {
            in_range(name, observer.stuck_on_w, "W", (0.0, most_w))?;
        }
        let most_w = DEFICIT_SHARE * power_w;
        for (name, deficit_w) in [
            ("fast.deficit_w", raw.fast.deficit_w),
            ("fast.deficit_min_w", raw.fast.deficit_min_w),
            ("slow.deficit_w", raw.slow.deficit_w),
            ("slow.deficit_min_w", raw.slow.deficit_min_w),
        ] {
            // A weak heater lacks half of what is ordered: a limit of more than that finds none.
            in_range(name, deficit_w, "W", (1.0, most_w))?;
        }
        Ok(Self {
            power_w,
            capacity_j_k: in_range("capacity_j_k", raw.capacity_j_k, "J/K", (0.1, 1e5))?,
            loss_w_k: in_range("loss_w_k", raw.loss_w_k, "W/K", (0.001, 100.0))?,
            fan_loss_w_k: in_range("fan_loss_w_k", raw.fan_loss_w_k, "W/K", (0.0, 1.0))?,
            feed_heat_j_k_m: in_range("feed_heat_j_k_m", raw.feed_heat_j_k_m, "J/(K m)", (0.0, 100.0))?,
            ambient_c: in_range("ambient_c", raw.ambient_c, "degC", (-20.0, 100.0))?,
            sensor_lag_s: in_range("sensor_lag_s", raw.sensor_lag_s, "s", (0.2, 60.0))?,
            usual_time_s: in_range("usual_time_s", raw.usual_time_s, "s", (5.0, 3600.0))?,
            usual_max_w: in_range("usual_max_w", raw.usual_max_w, "W", (0.0, 100.0))?,
            capacity_error: in_range("capacity_error", raw.capacity_error, "-", (0.0, 1.0))?,
            lag_error_s: in_range("lag_error_s", raw.lag_error_s, "s", (0.0, 60.0))?,
            spike_k: in_range("spike_k", raw.spike_k, "K", (0.3, 100.0))?,
            spike_samples: count("spike_samples", raw.spike_samples, 10)?,
            usual_noise_k: in_range("usual_noise_k", raw.usual_noise_k, "K", (0.001, 5.0))?,
            fast: raw.fast,
            slow: raw.slow,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 40 W half are ordered at a target: an excess of 25 W is never there; a weak heater lacks no 21 W.
    #[test]
    fn a_limit_that_no_heater_exceeds_is_refused() {
        let text = include_str!("../../../../config/safety_supervisor.param.yaml");
        let file: serde_json::Value = serde_saphyr::from_str(text).unwrap();
        let heater = |stuck_on_w: f64, spike_k: f64| {
            let mut heater = file["/**"]["ros__parameters"]["heater"].clone();
            heater["slow"]["stuck_on_w"] = stuck_on_w.into();
            heater["spike_k"] = spike_k.into();
            serde_json::from_value::<HeaterParams>(heater).map_err(|error| error.to_string())
        };
        assert!(heater(24.0, 0.8).is_ok());
        let told = heater(25.0, 0.8).unwrap_err();
        assert!(told.contains("slow.stuck_on_w = 25 W: must be in [0, 24]"), "{told}");
        for (observer, name) in ["fast", "slow"]
            .into_iter()
            .flat_map(|observer| ["deficit_w", "deficit_min_w"].map(|name| (observer, name)))
        {
            let with = |deficit_w: f64| {
                let mut heater = file["/**"]["ros__parameters"]["heater"].clone();
                heater[observer][name] = deficit_w.into();
                serde_json::from_value::<HeaterParams>(heater).map_err(|error| error.to_string())
            };
            assert!(with(20.0).is_ok());
            let told = with(21.0).unwrap_err();
            assert!(told.contains(&format!("{observer}.{name} = 21 W: must be in [1, 20]")), "{told}");
        }
        let told = heater(16.0, 0.1).unwrap_err();
        assert!(told.contains("spike_k = 0.1 K: must be in [0.3, 100]"), "{told}");
    }
}
