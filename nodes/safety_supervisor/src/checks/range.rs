//! S1: thermistor open (far too cold) or short (far too hot).

use models::units::Celsius;

use crate::params::RangeParams;

/// Watches one temperature.
#[derive(Debug, Clone)]
pub struct RangeCheck {
    params: RangeParams,
    newest: Option<Celsius>,
    outside: u32,
}

impl RangeCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: RangeParams) -> Self {
        Self { params, newest: None, outside: 0 }
    }

    /// Takes a temperature.
    pub fn on_sample(&mut self, temp: Celsius) {
        self.newest = Some(temp);
        let inside = (self.params.min_c..=self.params.max_c).contains(&temp.0);
        self.outside = if inside { 0 } else { self.outside.saturating_add(1) };
    }

    /// Whether enough samples in a row were outside; a single spike is not.
    #[must_use]
    pub fn tripped(&self) -> bool {
        self.outside >= self.params.samples
    }

    /// The newest sample; `None` before the first.
    #[must_use]
    pub fn newest(&self) -> Option<Celsius> {
        self.newest
    }

    /// The end of the range `[degC]` that the newest sample lies beyond; `None` inside.
    #[must_use]
    pub fn limit_c(&self) -> Option<f64> {
        let Celsius(newest_c) = self.newest?;
        let Self { params: RangeParams { min_c, max_c, .. }, .. } = self;
        if newest_c > *max_c { Some(*max_c) } else { (newest_c < *min_c).then_some(*min_c) }
    }

    /// Whether there was a sample, and the newest was inside.
    #[must_use]
    pub fn is_well(&self) -> bool {
        self.newest.is_some() && self.is_inside()
    }

    /// Whether the newest sample was inside.
    #[must_use]
    pub fn is_inside(&self) -> bool {
        self.outside == 0
    }
}
