//! Part fan: a rotor that follows its drive, and a tachometer on it.

use models::params::{ParamError, in_range};
use models::units::Seconds;
use serde::Deserialize;

/// A fan. Built only from valid [`RawSettings`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawSettings")]
pub struct Settings(RawSettings);

/// A fan as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawSettings {
    /// Revolutions at full duty `[1/s]`; 0 without a tachometer.
    pub full_1_s: f64,
    /// Time constant of the rotor `[s]`.
    pub spin_s: f64,
}

impl TryFrom<RawSettings> for Settings {
    type Error = ParamError;
    fn try_from(raw: RawSettings) -> Result<Self, ParamError> {
        in_range("part_fan.full_1_s", raw.full_1_s, "1/s", (0.0, 2000.0))?;
        in_range("part_fan.spin_s", raw.spin_s, "s", (1e-3, 10.0))?;
        Ok(Self(raw))
    }
}

/// The rotor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartFan {
    settings: Settings,
    share: f64,
}

impl PartFan {
    /// At rest.
    #[must_use]
    pub fn new(settings: Settings) -> Self {
        Self { settings, share: 0.0 }
    }

    /// One step of `dt` at a driven share of full speed `[0, 1]`; exact for a constant share.
    pub fn step(&mut self, driven: f64, dt: Seconds) {
        self.share = driven + (self.share - driven) * (-dt.0 / self.settings.0.spin_s).exp();
    }

    /// What the tachometer shows `[1/s]`; `None` where there is none.
    #[must_use]
    pub fn speed_1_s(&self) -> Option<f64> {
        let full_1_s = self.settings.0.full_1_s;
        (full_1_s > 0.0).then_some(full_1_s * self.share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fan(full_1_s: f64) -> PartFan {
        PartFan::new(Settings::try_from(RawSettings { full_1_s, spin_s: 0.5 }).unwrap())
    }

    #[test]
    fn the_rotor_reaches_what_drives_it_and_runs_down_without() {
        let mut fan = fan(80.0);
        (0..500).for_each(|_| fan.step(1.0, Seconds(0.01)));
        assert!((fan.speed_1_s().unwrap() - 80.0 * (1.0 - (-10.0_f64).exp())).abs() < 1e-9);
        (0..50).for_each(|_| fan.step(0.0, Seconds(0.01)));
        assert!((fan.speed_1_s().unwrap() - 80.0 * (-1.0_f64).exp()).abs() < 0.01);
    }

    #[test]
    fn a_fan_without_a_tachometer_shows_nothing() {
        assert_eq!(fan(0.0).speed_1_s(), None);
    }
}
