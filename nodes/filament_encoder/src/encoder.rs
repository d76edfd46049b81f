//! The encoder: order and age of the stamp, credible step, quantum; a device that started anew goes on where it was.

use models::units::Seconds;

use crate::params::EncoderParams;

/// A checked position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Time of measurement.
    pub stamp: Seconds,
    /// Filament since start `[m]`, forward positive.
    pub position_m: f64,
    /// Mean speed since the last sample `[m/s]`; `None` for the first and after a new start of the device.
    pub speed_m_s: Option<f64>,
    /// Variance of the position, uniform over a count: `q^2/12` `[m^2]`.
    pub variance_m2: f64,
    /// The device started anew: the way in between is unknown.
    pub rebased: bool,
}

/// Why a report was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Refusal {
    /// The stamp is NaN or infinite.
    NotFinite,
    /// A step faster than any filament moves.
    Step,
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
    /// See [`Refusal::Step`].
    pub step: u64,
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
        self.not_finite + self.step + self.order + self.future + self.stale
    }

    fn count(&mut self, refusal: Refusal) {
        let counter = match refusal {
            Refusal::NotFinite => &mut self.not_finite,
            Refusal::Step => &mut self.step,
            Refusal::Order => &mut self.order,
            Refusal::Future => &mut self.future,
            Refusal::Stale => &mut self.stale,
        };
        *counter = counter.saturating_add(1);
    }
}

/// Newest accepted report.
#[derive(Debug, Clone, Copy)]
struct Last {
    stamp: Seconds,
    counts: i64,
    position: i128,
}

/// Turns counts into positions.
#[derive(Debug, Clone)]
pub struct Encoder {
    params: EncoderParams,
    last: Option<Last>,
    steps_refused: f64,
    refusals: Refusals,
    rebases: u64,
}

impl Encoder {
    /// An encoder at position zero.
    #[must_use]
    pub fn new(params: EncoderParams) -> Self {
        Self { params, last: None, steps_refused: 0.0, refusals: Refusals::default(), rebases: 0 }
    }

    /// Other limits from now on; what was seen and counted stays.
    pub fn retune(&mut self, params: EncoderParams) {
        self.params = params;
    }

    /// Takes counts received at `now`. The first report is position zero.
    ///
    /// # Errors
    /// The [`Refusal`], which is counted.
    pub fn on_counts(&mut self, now: Seconds, stamp: Seconds, counts: i64) -> Result<Sample, Refusal> {
        if let Some(refusal) = self.objection(now, stamp) {
            return Err(self.refuse(refusal));
        }
        let Some(last) = self.last else {
            return Ok(self.accept(Last { stamp, counts, position: 0 }, None, false));
        };
        let step = i128::from(counts) - i128::from(last.counts);
        let dt_s = stamp.0 - last.stamp.0;
        let speed_m_s = step as f64 * self.params.quantum_m / dt_s;
        // One count either way is the quantum, at any speed.
        if dt_s > 0.0 && (speed_m_s.abs() <= self.params.speed_max_m_s || step.abs() <= 1) {
            return Ok(self.accept(
                Last { stamp, counts, position: last.position + step },
                Some(speed_m_s),
                false,
            ));
        }
        self.steps_refused += 1.0;
        if self.steps_refused < self.params.rebase_after {
            return Err(self.refuse(Refusal::Step));
        }
        self.rebases = self.rebases.saturating_add(1);
        Ok(self.accept(Last { stamp, counts, ..last }, None, true))
    }

    /// Refused reports so far.
    #[must_use]
    pub fn refusals(&self) -> Refusals {
        self.refusals
    }

    /// New starts of the device so far.
    #[must_use]
    pub fn rebases(&self) -> u64 {
        self.rebases
    }

    fn refuse(&mut self, refusal: Refusal) -> Refusal {
        self.refusals.count(refusal);
        refusal
    }

    fn accept(&mut self, last: Last, speed_m_s: Option<f64>, rebased: bool) -> Sample {
        self.steps_refused = 0.0;
        self.last = Some(last);
        Sample {
            stamp: last.stamp,
            position_m: last.position as f64 * self.params.quantum_m,
            speed_m_s,
            variance_m2: self.params.quantum_m.powi(2) / 12.0,
            rebased,
        }
    }

    fn objection(&self, now: Seconds, stamp: Seconds) -> Option<Refusal> {
        if !(now.0.is_finite() && stamp.0.is_finite()) {
            return Some(Refusal::NotFinite);
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
        self.last.is_some_and(|last| late(last.stamp)).then_some(Refusal::Order)
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

    fn encoder() -> Encoder {
        let text = include_str!("../../../config/filament_encoder.param.yaml");
        let file: std::collections::BTreeMap<String, File> = serde_saphyr::from_str(text).unwrap();
        Encoder::new(file.into_values().next().unwrap().parameters.encoder)
    }

    fn report(encoder: &mut Encoder, now_s: f64, counts: i64) -> Result<Sample, Refusal> {
        encoder.on_counts(Seconds(now_s), Seconds(now_s), counts)
    }

    #[test]
    fn counts_become_positions_and_speeds() {
        let mut encoder = encoder();
        assert!(report(&mut encoder, 1.0, 500).unwrap().position_m.abs() < 1e-15);
        let sample = report(&mut encoder, 1.01, 510).unwrap();
        // 10 counts of 10 um in 10 ms
        assert!((sample.position_m - 1e-4).abs() < 1e-12);
        assert!((sample.speed_m_s.unwrap() - 0.01).abs() < 1e-9);
    }

    #[test]
    fn a_jump_is_refused_and_a_device_that_started_anew_goes_on_where_it_was() {
        let mut encoder = encoder();
        report(&mut encoder, 1.00, 90_000).unwrap();
        let before = report(&mut encoder, 1.01, 90_010).unwrap();
        for tick in 0..4 {
            assert_eq!(report(&mut encoder, 1.02 + 0.01 * f64::from(tick), 0), Err(Refusal::Step));
        }
        let after = report(&mut encoder, 1.06, 0).unwrap();
        assert!(after.rebased && (after.position_m - before.position_m).abs() < 1e-12);
        assert_eq!((encoder.rebases(), encoder.refusals().step), (1, 4));
    }

    #[test]
    fn bad_stamps_are_refused_and_counted() {
        let mut encoder = encoder();
        report(&mut encoder, 5.0, 0).unwrap();
        for (stamp_s, refusal) in [
            (f64::NAN, Refusal::NotFinite),
            (5.0, Refusal::Order),
            (4.99, Refusal::Order),
            (9.0, Refusal::Future),
            (1.0, Refusal::Stale),
        ] {
            assert_eq!(encoder.on_counts(Seconds(5.1), Seconds(stamp_s), 1), Err(refusal));
        }
        assert_eq!(encoder.refusals().total(), 5);
    }

    proptest! {
        #[test]
        fn any_counts_give_finite_positions_whose_steps_are_credible(
            reports in proptest::collection::vec((any::<i64>(), 0.001..0.1f64, -200i64..200, any::<bool>()), 1..80)
        ) {
            let (mut encoder, mut now_s, mut counts) = (encoder(), 0.0, 0i64);
            let mut previous: Option<Sample> = None;
            for (wild, step_s, step, jump) in reports {
                now_s += step_s;
                counts = counts.saturating_add(step);
                let Ok(sample) = report(&mut encoder, now_s, if jump { wild } else { counts }) else { continue };
                prop_assert!(sample.position_m.is_finite());
                if let Some(before) = previous {
                    let way_m = (sample.position_m - before.position_m).abs();
                    // rounding of positions of up to 1e14 m
                    prop_assert!(way_m <= 0.25 * (sample.stamp.0 - before.stamp.0) + 1.1e-5);
                }
                previous = Some(sample);
            }
        }
    }
}
