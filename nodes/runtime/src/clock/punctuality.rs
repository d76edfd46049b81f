//! Whether the ticks of a timer come at even intervals of real time: a machine with too much to do shows here first (L1).

use crate::diagnostics::Diagnostics;
use models::units::Seconds;
use std::collections::{BTreeMap, VecDeque};

/// Ticks that are looked back on: 20 s at 50 Hz.
const WINDOW: u64 = 1000;
/// Of these, so many may be off: 0.1 %.
const OFF_MAX: usize = 1;
/// Share of a new interval in the usual one: simulated time has a pace of its own.
const NEW_SHARE: f64 = 0.02;
/// Name among the alarms of the node.
const NAME: &str = "ticks";
/// Name of the counts of late ticks: `0:498 1:2`, two were later than usual by 1 ms to 2 ms.
pub const TICKS_LATE_MS: &str = "ticks_late_ms";
/// Ticks between two tellings of how late they were: 1 s at 50 Hz, as `/diagnostics` is published.
const TELL: u64 = 50;
/// Later than so many milliseconds is told as so many.
const LATE_MAX_MS: u16 = 100;

/// What is known of the intervals.
#[derive(Debug)]
pub(crate) struct Punctuality {
    diagnostics: Diagnostics,
    tolerance: Seconds,
    last: Option<Seconds>,
    usual_s: Option<f64>,
    ticks: u64,
    /// Numbers of those that were off.
    off: VecDeque<u64>,
    /// How many of all were later than the usual interval by whole milliseconds.
    late_ms: BTreeMap<u16, u64>,
}

impl Punctuality {
    /// Tells in `diagnostics` where more than 0.1 % of the intervals differ by more than `tolerance` from the usual one.
    pub(crate) fn new(diagnostics: Diagnostics, tolerance: Seconds) -> Self {
        Self {
            diagnostics,
            tolerance,
            last: None,
            usual_s: None,
            ticks: 0,
            off: VecDeque::new(),
            late_ms: BTreeMap::new(),
        }
    }

    /// A tick at `now` of real time.
    pub(crate) fn tick(&mut self, now: Seconds) {
        self.ticks += 1;
        let before = self.off.len();
        while self.off.front().is_some_and(|number| number + WINDOW <= self.ticks) {
            self.off.pop_front();
        }
        let last = self.last.replace(now);
        if let Some(interval_s) = last.map(|last| (now - last).0) {
            let usual_s = self.usual_s.unwrap_or(interval_s);
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "saturates at both ends"
            )]
            let late_ms = ((interval_s - usual_s) * 1e3) as u16;
            *self.late_ms.entry(late_ms.min(LATE_MAX_MS)).or_default() += 1;
            if (interval_s - usual_s).abs() > self.tolerance.0 {
                self.off.push_back(self.ticks);
            }
            // One long stall must not change what is usual.
            let bounded_s = interval_s.min(2.0 * usual_s);
            self.usual_s = Some(usual_s + NEW_SHARE * (bounded_s - usual_s));
        }
        if self.off.len() != before {
            self.tell();
        }
        if self.ticks.is_multiple_of(TELL) {
            let counts: Vec<String> =
                self.late_ms.iter().map(|(late_ms, ticks)| format!("{late_ms}:{ticks}")).collect();
            self.diagnostics.set(TICKS_LATE_MS, counts.join(" "));
        }
    }

    fn tell(&self) {
        let (off, tolerance_ms) = (self.off.len(), self.tolerance.0 * 1e3);
        let text =
            format!("irregular: {off} of the last {WINDOW} intervals are more than {tolerance_ms:.0} ms off");
        self.diagnostics.set("ticks_off", off);
        self.diagnostics.alarm(NAME, (off > OFF_MAX).then_some(text));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::Clock;
    use fdm_loop_msgs::DiagnosticStatus;

    fn level(diagnostics: &Diagnostics) -> (u8, String) {
        let own = diagnostics.array("/x", &Clock::simulated()).status.swap_remove(0);
        (own.level, own.message)
    }

    /// One stall is a late tick and an early one: 30 ms and 10 ms instead of 20, each 10 off; then it is forgotten.
    #[test]
    fn two_intervals_of_a_thousand_are_told_until_they_are_past() {
        let diagnostics = Diagnostics::default();
        let mut ticks = Punctuality::new(diagnostics.clone(), Seconds(0.009));
        let mut now = Seconds(100.0);
        let mut tick = |interval_s: f64| {
            now = now + Seconds(interval_s);
            ticks.tick(now);
        };
        (0..500).for_each(|_| tick(0.02));
        tick(0.03);
        assert_eq!(level(&diagnostics), (DiagnosticStatus::OK, "ok".to_owned()), "1 of 1000 is allowed");
        tick(0.01);
        let (warn, text) = level(&diagnostics);
        assert_eq!(
            (warn, text.contains("irregular: 2 of the last 1000")),
            (DiagnosticStatus::WARN, true),
            "{text}"
        );
        (0..1000).for_each(|_| tick(0.02));
        assert_eq!(level(&diagnostics), (DiagnosticStatus::OK, "ok".to_owned()));
    }

    #[test]
    fn late_ticks_are_counted_by_whole_milliseconds() {
        let diagnostics = Diagnostics::default();
        let mut ticks = Punctuality::new(diagnostics.clone(), Seconds(0.01));
        let mut now = Seconds(100.0);
        for (interval_s, times) in [(0.02, 47), (0.0236, 1), (0.0164, 1), (0.5, 1)] {
            (0..times).for_each(|_| {
                now = now + Seconds(interval_s);
                ticks.tick(now);
            });
        }
        let own = diagnostics.array("/x", &Clock::simulated()).status.swap_remove(0);
        let told =
            own.values.iter().find(|value| value.key == TICKS_LATE_MS).map(|value| value.value.as_str());
        assert_eq!(told, Some("0:47 3:1 100:1"));
    }

    /// Simulated time at a tenth of its pace: intervals of 0.2 s are as even as those of 20 ms.
    #[test]
    fn another_pace_is_not_irregular() {
        let diagnostics = Diagnostics::default();
        let mut ticks = Punctuality::new(diagnostics.clone(), Seconds(0.01));
        (0..500).for_each(|number| ticks.tick(Seconds(f64::from(number) * 0.2)));
        assert_eq!(level(&diagnostics).0, DiagnosticStatus::OK);
    }
}
