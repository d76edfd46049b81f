//! One thermistor: range, finite, order and age of the stamp, rate, quantum.

use models::units::{Celsius, Seconds};

use crate::params::ChannelParams;

/// A checked temperature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Time of measurement.
    pub stamp: Seconds,
    /// Temperature.
    pub temp: Celsius,
    /// Variance: noise and, uniform over a step, the quantum: `sigma^2 + q^2/12` `[K^2]`.
    pub variance_k2: f64,
    /// Changed faster than any heater or loss can make it.
    pub fast: bool,
}

/// Why a report was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Refusal {
    /// Temperature or stamp is NaN or infinite.
    NotFinite,
    /// A temperature that no table gives.
    OutOfRange,
    /// A stamp not after the last one.
    Order,
    /// A stamp ahead of the clock.
    Future,
    /// A stamp too far behind the clock.
    Stale,
}

/// Refused reports by reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Refusals {
    /// See [`Refusal::NotFinite`].
    pub not_finite: u64,
    /// See [`Refusal::OutOfRange`].
    pub out_of_range: u64,
    /// See [`Refusal::Order`].
    pub order: u64,
    /// See [`Refusal::Future`].
    pub future: u64,
    /// See [`Refusal::Stale`].
    pub stale: u64,
}

impl Refusals {
    /// All of them.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.not_finite + self.out_of_range + self.order + self.future + self.stale
    }

    fn count(&mut self, refusal: Refusal) {
        let counter = match refusal {
            Refusal::NotFinite => &mut self.not_finite,
            Refusal::OutOfRange => &mut self.out_of_range,
            Refusal::Order => &mut self.order,
            Refusal::Future => &mut self.future,
            Refusal::Stale => &mut self.stale,
        };
        *counter = counter.saturating_add(1);
    }
}

/// Turns reports of one thermistor into samples.
#[derive(Debug, Clone)]
pub struct Channel {
    params: ChannelParams,
    last: Option<(Seconds, Celsius)>,
    refusals: Refusals,
    fast: u64,
}

impl Channel {
    /// A channel without history.
    #[must_use]
    pub fn new(params: ChannelParams) -> Self {
        Self { params, last: None, refusals: Refusals::default(), fast: 0 }
    }

    /// Other limits and noise from now on; what was seen stays.
    pub fn retune(&mut self, params: ChannelParams) {
        self.params = params;
    }

    /// Takes a report received at `now`.
    ///
    /// # Errors
    /// The [`Refusal`], which is counted.
    pub fn on_report(&mut self, now: Seconds, stamp: Seconds, temp: Celsius) -> Result<Sample, Refusal> {
        if let Some(refusal) = self.objection(now, stamp, temp) {
            self.refusals.count(refusal);
            return Err(refusal);
        }
        let fast = self.last.is_some_and(|(then, before)| {
            (temp.0 - before.0).abs() > self.params.rate_max_k_s * (stamp.0 - then.0)
        });
        self.fast = self.fast.saturating_add(u64::from(fast));
        self.last = Some((stamp, temp));
        let variance_k2 = self.params.sigma_k.powi(2) + self.params.quantum_k.powi(2) / 12.0;
        Ok(Sample { stamp, temp, variance_k2, fast })
    }

    /// Refused reports so far.
    #[must_use]
    pub fn refusals(&self) -> Refusals {
        self.refusals
    }

    /// Samples so far that changed faster than credible.
    #[must_use]
    pub fn fast(&self) -> u64 {
        self.fast
    }

    fn objection(&self, now: Seconds, stamp: Seconds, temp: Celsius) -> Option<Refusal> {
        if !(now.0.is_finite() && stamp.0.is_finite() && temp.0.is_finite()) {
            return Some(Refusal::NotFinite);
        }
        if !(self.params.min_c..=self.params.max_c).contains(&temp.0) {
            return Some(Refusal::OutOfRange);
        }
        let age_s = now.0 - stamp.0;
        if age_s < -self.params.stamp_future_max_s {
            return Some(Refusal::Future);
        }
        if age_s > self.params.stamp_age_max_s {
            return Some(Refusal::Stale);
        }
        // A stamp far behind the last one is a clock that was set back, not a late report.
        let late = |last: Seconds| stamp.0 <= last.0 && last.0 - stamp.0 <= self.params.stamp_age_max_s;
        self.last.is_some_and(|(last, _)| late(last)).then_some(Refusal::Order)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::params::Params;

    #[derive(serde::Deserialize)]
    struct File {
        #[serde(rename = "ros__parameters")]
        parameters: Params,
    }

    fn channel() -> Channel {
        let text = include_str!("../../../config/thermistor.param.yaml");
        let file: std::collections::BTreeMap<String, File> = serde_saphyr::from_str(text).unwrap();
        Channel::new(file.into_values().next().unwrap().parameters.hotend)
    }

    fn report(channel: &mut Channel, now_s: f64, stamp_s: f64, temp_c: f64) -> Result<Sample, Refusal> {
        channel.on_report(Seconds(now_s), Seconds(stamp_s), Celsius(temp_c))
    }

    #[test]
    fn broken_circuits_pass_and_are_marked() {
        let mut channel = channel();
        assert!(!report(&mut channel, 0.1, 0.1, 210.0).unwrap().fast);
        assert!(report(&mut channel, 0.2, 0.2, -14.0).unwrap().fast);
        assert!(report(&mut channel, 0.3, 0.3, 450.0).unwrap().fast);
        assert_eq!((channel.fast(), channel.refusals().total()), (2, 0));
    }

    #[test]
    fn each_kind_of_bad_report_is_refused_and_counted() {
        let mut channel = channel();
        report(&mut channel, 5.0, 5.0, 20.0).unwrap();
        for (now_s, stamp_s, temp_c, refusal) in [
            (5.1, 5.1, f64::NAN, Refusal::NotFinite),
            (5.1, f64::INFINITY, 20.0, Refusal::NotFinite),
            (5.1, 5.1, 1e4, Refusal::OutOfRange),
            (5.1, 5.0, 20.0, Refusal::Order),
            (5.1, 4.9, 20.0, Refusal::Order),
            (5.1, 3605.0, 20.0, Refusal::Future),
            (5.1, 0.0, 20.0, Refusal::Stale),
        ] {
            assert_eq!(report(&mut channel, now_s, stamp_s, temp_c), Err(refusal));
        }
        let expected = Refusals { not_finite: 2, out_of_range: 1, order: 2, future: 1, stale: 1 };
        assert_eq!(channel.refusals(), expected);
        assert!(report(&mut channel, 5.2, 5.2, 20.0).is_ok());
    }

    proptest! {
        #[test]
        fn any_bits_give_a_finite_sample_in_range_or_a_counted_refusal(
            reports in proptest::collection::vec((any::<u64>(), any::<u64>(), 0.0..0.2f64), 1..50)
        ) {
            let (mut channel, mut now_s) = (channel(), 0.0);
            let mut refused = 0;
            for (stamp, temp, step_s) in reports {
                now_s += step_s;
                let good_stamp = stamp % 2 == 0;
                let stamp_s = if good_stamp { now_s } else { f64::from_bits(stamp) };
                match report(&mut channel, now_s, stamp_s, f64::from_bits(temp)) {
                    Ok(sample) => prop_assert!((-60.0..=600.0).contains(&sample.temp.0)),
                    Err(_) => refused += 1,
                }
            }
            prop_assert_eq!(channel.refusals().total(), refused);
        }
    }
}
