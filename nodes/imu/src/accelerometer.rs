//! The unit: order, age and period of batches, range, saturation, gaps; unit, axis and rate by [`crate::window`].

use models::units::Seconds;

use crate::params::UnitParams;
use crate::thin::{Thinned, Thinner};
use crate::window::{Figures, Verdict, Window};

/// A batch as its driver gives it: nothing in it is known to be sound.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// Frame of the samples.
    pub frame: String,
    /// Time of the first sample.
    pub first: Seconds,
    /// Number of the first sample since the device's start.
    pub first_sequence: u64,
    /// Time between two samples.
    pub period: Seconds,
    /// Largest magnitude that an axis can show `[m/s2]`.
    pub range_m_s2: f64,
    /// Accelerations x, y, z, gravity's reaction included `[m/s2]`.
    pub samples: Vec<[f64; 3]>,
}

/// A checked batch.
#[derive(Debug, Clone, PartialEq)]
pub struct Checked {
    /// The batch, unchanged.
    pub report: Report,
    /// Samples with an axis at its range: marked, not refused.
    pub saturated: u64,
    /// Samples that are missing before this batch.
    pub lost: u64,
    /// The device started anew: how much is missing is unknown.
    pub restarted: bool,
    /// The batch for tools.
    pub thinned: Vec<Thinned>,
}

/// Why a batch was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Refusal {
    /// A sample, stamp, period or range is NaN or infinite.
    NotFinite,
    /// No sample.
    Empty,
    /// Another frame than the configured one.
    Frame,
    /// A sample beyond the range, or another range than the configured one.
    OutOfRange,
    /// A period that is not the configured rate's.
    Period,
    /// A first sample not after that of the last batch.
    Order,
    /// A newest sample ahead of the clock.
    Future,
    /// A newest sample too far behind the clock.
    Stale,
    /// The unit has not yet shown that unit, axis and rate are right.
    Unproven,
    /// It has shown that they are not; [`Accelerometer::verdict`] says which and what to do.
    Untrue,
}

/// Refused batches by reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs, reason = "as the variants of Refusal")]
pub struct Refusals {
    pub not_finite: u64,
    pub empty: u64,
    pub frame: u64,
    pub out_of_range: u64,
    pub period: u64,
    pub order: u64,
    pub future: u64,
    pub stale: u64,
    pub unproven: u64,
    pub untrue: u64,
}

impl Refusals {
    /// All of them.
    #[must_use]
    pub fn total(&self) -> u64 {
        let Self { not_finite, empty, frame, out_of_range, period, order, future, stale, unproven, untrue } =
            self;
        not_finite + empty + frame + out_of_range + period + order + future + stale + unproven + untrue
    }

    fn count(&mut self, refusal: Refusal) {
        let counter = match refusal {
            Refusal::NotFinite => &mut self.not_finite,
            Refusal::Empty => &mut self.empty,
            Refusal::Frame => &mut self.frame,
            Refusal::OutOfRange => &mut self.out_of_range,
            Refusal::Period => &mut self.period,
            Refusal::Order => &mut self.order,
            Refusal::Future => &mut self.future,
            Refusal::Stale => &mut self.stale,
            Refusal::Unproven => &mut self.unproven,
            Refusal::Untrue => &mut self.untrue,
        };
        *counter = counter.saturating_add(1);
    }
}

/// Samples so far, besides what was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Totals {
    /// With an axis at its range.
    pub saturated: u64,
    /// Missing by the step of the sequence.
    pub lost: u64,
    /// New starts of the device.
    pub restarts: u64,
}

/// Newest batch that was in order, whether it passed or not.
#[derive(Debug, Clone, Copy)]
struct Last {
    first: Seconds,
    next_sequence: u64,
}

/// Turns reports into checked batches.
#[derive(Debug, Clone)]
pub struct Accelerometer {
    params: UnitParams,
    last: Option<Last>,
    window: Window,
    thinner: Thinner,
    refusals: Refusals,
    totals: Totals,
}

/// A stated range counts as the configured one within this share: 16 g as 156.8 or 156.9064 m/s2.
const RANGE_TOLERANCE: f64 = 0.01;

impl Accelerometer {
    /// A unit that has shown nothing yet.
    #[must_use]
    pub fn new(params: UnitParams) -> Self {
        Self {
            last: None,
            window: Window::new(params.clone()),
            thinner: Thinner::new(params.rate_hz, params.output_hz, params.sigma_m_s2),
            refusals: Refusals::default(),
            totals: Totals::default(),
            params,
        }
    }

    /// Another noise and other tolerances from now on; rates, range and ages stay. What was seen and counted stays, and so
    /// does the verdict of the last window until the next.
    pub fn retune(&mut self, params: UnitParams) {
        self.thinner.retune(params.sigma_m_s2);
        self.window.retune(params.clone());
        self.params = params;
    }

    /// Takes a report received at `now`.
    ///
    /// # Errors
    /// The [`Refusal`], which is counted.
    pub fn on_report(&mut self, now: Seconds, report: Report) -> Result<Checked, Refusal> {
        let taken = self.judge(now, report);
        if let Err(refusal) = taken {
            self.refusals.count(refusal);
        }
        taken
    }

    /// Refused batches so far.
    #[must_use]
    pub fn refusals(&self) -> Refusals {
        self.refusals
    }

    /// Samples so far that were marked, missing, or lost with a new start.
    #[must_use]
    pub fn totals(&self) -> Totals {
        self.totals
    }

    /// What the last window has shown, with what to do.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        self.window.verdict()
    }

    /// Figures of the last window.
    #[must_use]
    pub fn figures(&self) -> Option<Figures> {
        self.window.figures()
    }

    fn judge(&mut self, now: Seconds, report: Report) -> Result<Checked, Refusal> {
        self.objection(now, &report).map_or(Ok(()), Err)?;
        let (lost, restarted) = self.follow(&report);
        // A batch in another unit is beyond the range too: the window sees it, or nobody could say so.
        self.window.add(report.first, report.first_sequence, &report.samples);
        let limit = self.params.range_m_s2.min(report.range_m_s2);
        if report.samples.iter().flatten().any(|value| value.abs() > limit) {
            self.thinner.restart();
            return Err(Refusal::OutOfRange);
        }
        match self.window.verdict() {
            Verdict::Sound => Ok(self.pass(report, lost, restarted)),
            Verdict::Unproven => Err(Refusal::Unproven),
            Verdict::Unit { .. } | Verdict::Axes { .. } | Verdict::Rate { .. } => Err(Refusal::Untrue),
        }
    }

    /// What can be said of a report by itself and the clock.
    fn objection(&self, now: Seconds, report: &Report) -> Option<Refusal> {
        let scalars = [now.0, report.first.0, report.period.0, report.range_m_s2];
        if !scalars.iter().chain(report.samples.iter().flatten()).all(|value| value.is_finite()) {
            return Some(Refusal::NotFinite);
        }
        if report.samples.is_empty() {
            return Some(Refusal::Empty);
        }
        if *report.frame != *self.params.frame {
            return Some(Refusal::Frame);
        }
        let near = |value: f64, wanted: f64, share: f64| (value / wanted - 1.0).abs() <= share;
        if !near(report.range_m_s2, self.params.range_m_s2, RANGE_TOLERANCE) {
            return Some(Refusal::OutOfRange);
        }
        if !near(report.period.0 * self.params.rate_hz, 1.0, self.params.rate_tolerance) {
            return Some(Refusal::Period);
        }
        #[allow(clippy::cast_precision_loss, reason = "samples of a batch")]
        let newest_s = report.first.0 + (report.samples.len() - 1) as f64 * report.period.0;
        let age_s = now.0 - newest_s;
        if age_s < -self.params.stamp_future_max_s {
            return Some(Refusal::Future);
        }
        if age_s > self.params.stamp_age_max_s {
            return Some(Refusal::Stale);
        }
        // A stamp far behind the last one is a clock that was set back, not a late report.
        let late = |last: Seconds| {
            report.first <= last
                && (last - report.first).0 <= self.params.window_s + self.params.stamp_age_max_s
        };
        self.last.is_some_and(|last| late(last.first)).then_some(Refusal::Order)
    }

    /// Samples missing before the report, and whether the device started anew.
    fn follow(&mut self, report: &Report) -> (u64, bool) {
        let next_sequence = report.first_sequence.saturating_add(report.samples.len() as u64);
        let before = self.last.replace(Last { first: report.first, next_sequence });
        let Some(before) = before else { return (0, false) };
        let restarted = report.first_sequence < before.next_sequence || report.first < before.first;
        let lost = if restarted { 0 } else { report.first_sequence - before.next_sequence };
        self.totals.lost = self.totals.lost.saturating_add(lost);
        if restarted {
            self.totals.restarts = self.totals.restarts.saturating_add(1);
            self.window.restart();
        }
        if restarted || lost > 0 {
            self.thinner.restart();
        }
        (lost, restarted)
    }

    fn pass(&mut self, report: Report, lost: u64, restarted: bool) -> Checked {
        let limit = report.range_m_s2;
        let at_range = |sample: &&[f64; 3]| sample.iter().any(|value| value.abs() >= limit);
        let saturated = report.samples.iter().filter(at_range).count() as u64;
        self.totals.saturated = self.totals.saturated.saturating_add(saturated);
        let mut thinned = Vec::new();
        let mut stamp = report.first;
        for sample in &report.samples {
            thinned.extend(self.thinner.add(stamp, report.period, *sample));
            stamp = stamp + report.period;
        }
        Checked { report, saturated, lost, restarted, thinned }
    }
}

#[cfg(test)]
mod tests;
