//! Share of the wanted flow that leaves a sound nozzle: less while pressure builds up, more while it fades (model book 2.1).
//!
//! Where no advance is in force roads are thin after every start, and nothing is wrong with the printer. What the nominal
//! melt lays of the filament that was commanded, advance included, is held against what the plan wanted there.

use crate::layer::Nominal;
use models::extruder::StaticLaw;
use models::melt::Melt;
use models::params::{ParamError, in_range, ordered};
use models::status::PrinterStatus;
use models::units::{Kelvin, Seconds};
use serde::Deserialize;
use std::collections::VecDeque;

/// How the commanded filament is followed. Built only from a valid [`RawPressure`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawPressure")]
pub struct PressureParams(RawPressure);

/// The `pressure` block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawPressure {
    /// How long shares are kept: longer than a frame is under way `[s]`.
    pub kept_s: f64,
    /// Statuses farther apart tell nothing of the filament in between `[s]`.
    pub gap_max_s: f64,
    /// More filament between two statuses is a new count, not a move `[m]`.
    pub jump_max_m: f64,
    /// The law is exact at the fastest feed and at this share of it `[-]`.
    pub slow_rel: f64,
    /// Smallest and largest share that is believed `[-]`.
    pub share: [f64; 2],
}

impl TryFrom<RawPressure> for PressureParams {
    type Error = ParamError;

    fn try_from(raw: RawPressure) -> Result<Self, ParamError> {
        in_range("pressure.kept_s", raw.kept_s, "s", (0.1, 60.0))?;
        in_range("pressure.gap_max_s", raw.gap_max_s, "s", (0.005, 1.0))?;
        in_range("pressure.jump_max_m", raw.jump_max_m, "m", (1e-4, 1.0))?;
        in_range("pressure.slow_rel", raw.slow_rel, "-", (0.01, 0.9))?;
        in_range("pressure.share[0]", raw.share[0], "-", (0.1, 1.0))?;
        in_range("pressure.share[1]", raw.share[1], "-", (1.0, 3.0))?;
        ordered(("pressure.share[0]", raw.share[0]), ("pressure.share[1]", raw.share[1]))?;
        Ok(Self(raw))
    }
}

/// Flow of a sound nozzle. Knows no clock.
#[derive(Debug, Clone)]
pub(crate) struct NominalFlow {
    params: RawPressure,
    nominal: Nominal,
    ambient: Kelvin,
    melt: Melt,
    /// The law, with the set-point and the fastest feed `[m/s]` that it was made for.
    law: Option<(StaticLaw, Kelvin, f64)>,
    fastest_m_s: f64,
    flow_m_s: f64,
    /// Stamp `[s]` and wanted filament `[m]` of the newest status.
    before: Option<(f64, f64)>,
    /// Stamp `[s]` and share `[-]`, oldest first.
    shares: VecDeque<(f64, f64)>,
}

impl NominalFlow {
    /// A nozzle that rests.
    pub(crate) fn new(params: PressureParams, nominal: Nominal, ambient: Kelvin) -> Self {
        Self {
            params: params.0,
            melt: Melt::new(&nominal.material, &nominal.printer.extruder),
            nominal,
            ambient,
            law: None,
            fastest_m_s: 0.0,
            flow_m_s: 0.0,
            before: None,
            shares: VecDeque::new(),
        }
    }

    /// Share of the wanted flow that left the nozzle then; 1 where it is not known.
    pub(crate) fn share(&self, laid: Seconds) -> f64 {
        let after = self.shares.partition_point(|(stamp_s, _)| *stamp_s < laid.0);
        let known = after.checked_sub(1).and_then(|last| self.shares.get(last)).zip(self.shares.get(after));
        known.map_or(1.0, |(from, to)| {
            if to.0 - from.0 > self.params.gap_max_s {
                return 1.0;
            }
            let share = from.1 + (to.1 - from.1) * (laid.0 - from.0) / (to.0 - from.0);
            share.clamp(self.params.share[0], self.params.share[1])
        })
    }

    /// Follows the filament wanted since the last status.
    pub(crate) fn on_status(&mut self, status: &PrinterStatus) {
        let (stamp_s, wanted_m) = (status.stamp.0, status.wanted_position_m);
        let Some((before_s, before_m)) = self.before else {
            self.before = Some((stamp_s, wanted_m));
            return;
        };
        let (dt_s, moved_m) = (stamp_s - before_s, wanted_m - before_m);
        if dt_s.is_nan() || dt_s <= 0.0 {
            return;
        }
        self.before = Some((stamp_s, wanted_m));
        if moved_m.is_nan() || moved_m.abs() > self.params.jump_max_m || dt_s > self.params.gap_max_s {
            self.flow_m_s = 0.0;
            self.shares.clear();
            return;
        }
        let wanted_m_s = status.planned_feed_m_s * status.trims.speed * status.trims.flow;
        if status.depositing {
            self.fastest_m_s = self.fastest_m_s.max(wanted_m_s);
        }
        let Some(law) = self.law(Kelvin::from(status.hotend_target)) else { return };
        let lag = Seconds(self.nominal.material.lag_s);
        self.flow_m_s = law.flow_after(self.flow_m_s, moved_m / dt_s, Seconds(dt_s), lag);
        self.keep(stamp_s, status.depositing.then(|| self.flow_m_s.max(0.0) / wanted_m_s));
    }

    fn keep(&mut self, stamp_s: f64, share: Option<f64>) {
        let forgotten_s = stamp_s - self.params.kept_s;
        while self.shares.front().is_some_and(|(stamp_s, _)| *stamp_s < forgotten_s) {
            self.shares.pop_front();
        }
        self.shares.extend(share.filter(|share| share.is_finite()).map(|share| (stamp_s, share)));
    }

    /// The law at a set-point, made anew where it or the fastest feed has changed.
    fn law(&mut self, nozzle: Kelvin) -> Option<StaticLaw> {
        let made = self.law.filter(|(_, of, fastest_m_s)| *of == nozzle && *fastest_m_s >= self.fastest_m_s);
        if made.is_none() && self.fastest_m_s > 0.0 {
            let outlets_m_s = (self.params.slow_rel * self.fastest_m_s, self.fastest_m_s);
            let extruder = &self.nominal.printer.extruder;
            let law = StaticLaw::of_melting((&self.melt, extruder), (nozzle, self.ambient), outlets_m_s);
            self.law = law.map(|law| (law, nozzle, self.fastest_m_s));
            return law;
        }
        made.map(|(law, ..)| law)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classifier::tests::{nominal, printer_status};
    use models::status::JobPhase;

    /// Shares every 20 ms of a print with these feeds `(m/s, s)` under an advance; the first status tells the start.
    fn shares(feeds: &[(f64, f64)], advance_s: f64, change: impl Fn(&mut PrinterStatus)) -> Vec<f64> {
        let raw =
            RawPressure { kept_s: 60.0, gap_max_s: 0.3, jump_max_m: 0.05, slow_rel: 0.25, share: [0.6, 1.4] };
        let mut nozzle = NominalFlow::new(raw.try_into().unwrap(), nominal(), Kelvin(298.15));
        let (mut step, mut fed_m) = (0, 0.0);
        for &(feed_m_s, duration_s) in feeds {
            let end_s = 0.02 * f64::from(step) + duration_s;
            while 0.02 * f64::from(step) < end_s - 1e-9 {
                step += 1;
                fed_m += 0.02 * feed_m_s;
                let mut status = PrinterStatus {
                    planned_feed_m_s: feed_m_s,
                    wanted_position_m: fed_m + advance_s * feed_m_s,
                    ..printer_status(0.02 * f64::from(step), JobPhase::Printing, 0)
                };
                change(&mut status);
                nozzle.on_status(&status);
            }
        }
        (1..=step).map(|step| nozzle.share(Seconds(0.02 * f64::from(step)))).collect()
    }

    /// Model book 2.2: after a step of the feed a part of `e^(-t/K)` of it is missing, near enough.
    #[test]
    fn roads_are_thin_until_the_pressure_is_there() {
        let steps = [(1e-3, 10.0), (2e-3, 5.0)];
        let without = shares(&steps, 0.0, |_| ());
        assert!((without[498] - 1.0).abs() < 1e-3, "at rest {}", without[498]);
        assert!((0.6..0.7).contains(&without[502]) && without[540] < 0.93, "{:?}", &without[500..550]);
        assert!(without[510..].is_sorted() && without[748] > 0.99, "{:?}", &without[500..]);
        let with = shares(&steps, nominal().material.lag_s, |_| ());
        assert!(with[502] > 0.9, "an advance brings it: {:?}", &with[500..510]);
        let slower = shares(&[(2e-3, 10.0), (1e-3, 5.0)], 0.0, |_| ());
        assert!(slower[505] > 1.2, "what is compressed flows on: {:?}", &slower[500..510]);
    }

    /// A flow that the loop corrects is no pressure that is missing; what the encoder loop adds is not in the wanted filament.
    #[test]
    fn a_trim_is_wanted() {
        let trimmed = shares(&[(2e-3, 10.0)], 0.0, |status| {
            status.trims.flow = 1.2;
            status.wanted_position_m *= 1.2;
        });
        assert!((trimmed[498] - 1.0).abs() < 1e-3, "{}", trimmed[498]);
    }

    #[test]
    fn what_is_not_known_takes_nothing_off() {
        let rare = shares(&[(1e-3, 3.0), (2e-3, 0.2)], 0.0, |status| status.stamp.0 *= 20.0);
        assert!(rare.iter().all(|share| (share - 1.0).abs() < 1e-12), "slow hosts");
        for spoil in [f64::NAN, 1e3] {
            let spoiled = shares(&[(1e-3, 3.0), (2e-3, 0.1)], 0.0, |status| {
                if (status.stamp.0 - 3.0).abs() < 0.01 {
                    status.wanted_position_m += spoil;
                }
            });
            assert!(spoiled.iter().all(|share| (0.6..=1.4).contains(share)), "{spoiled:?}");
        }
    }

    #[test]
    fn a_share_that_cannot_be_is_refused_with_its_name() {
        let raw =
            RawPressure { kept_s: 60.0, gap_max_s: 0.3, jump_max_m: 0.05, slow_rel: 0.25, share: [1.1, 1.4] };
        assert!(PressureParams::try_from(raw).unwrap_err().to_string().contains("pressure.share[0]"));
    }
}
