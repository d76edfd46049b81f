//! The node's one clock: monotonic in operation, `/clock` under `use_sim_time`.
//!
//! Monotonic time counts from the host's start, so all processes of a host share it and their stamps compare.

use crate::diagnostics::Diagnostics;
use crate::publisher::Publisher;
use crate::shutdown;
use fdm_loop_msgs::{Clock as ClockMessage, Time};
use models::units::Seconds;
use rustix::time::{ClockId, clock_gettime};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use tokio::sync::watch;

mod punctuality;

use punctuality::Punctuality;
pub use punctuality::TICKS_LATE_MS;

/// Past readings of `/clock` that are kept to date a message by its age: 256 readings 5 ms apart reach back 1.3 s,
/// longer than any validity.
const HISTORY: usize = 256;
/// Least distance of two readings in the history `[s]` of monotonic time.
const HISTORY_STEP_S: f64 = 0.005;

/// Seconds of the monotonic clock since the host's start.
pub(crate) fn monotonic() -> Seconds {
    let now = clock_gettime(ClockId::Monotonic);
    #[allow(clippy::cast_precision_loss)] // 2^53 s are 285 million years
    Seconds(now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9)
}

/// The node's clock; clones show the same time.
#[derive(Debug, Clone)]
pub struct Clock {
    simulated: Option<Arc<Simulated>>,
    /// What a node that makes the time has told the others last.
    announced: Arc<Mutex<Option<Seconds>>>,
}

/// Time as `/clock` told it.
#[derive(Debug)]
struct Simulated {
    now: watch::Sender<Seconds>,
    jumps_back: AtomicU64,
    history: Mutex<VecDeque<Reading>>,
}

/// One reading of `/clock`.
#[derive(Debug, Clone, Copy)]
struct Reading {
    monotonic: Seconds,
    simulated: Seconds,
}

impl Clock {
    /// A monotonic clock.
    pub(crate) fn monotonic() -> Self {
        Self { simulated: None, announced: Arc::default() }
    }

    /// A clock that stands at zero until told otherwise.
    pub(crate) fn simulated() -> Self {
        let (now, _) = watch::channel(Seconds(0.0));
        let simulated = Simulated { now, jumps_back: AtomicU64::new(0), history: Mutex::default() };
        Self { simulated: Some(Arc::new(simulated)), announced: Arc::default() }
    }

    /// Time now `[s]`. A simulated clock stands at zero until its first reading.
    #[must_use]
    pub fn now(&self) -> Seconds {
        self.simulated.as_ref().map_or_else(monotonic, |simulated| *simulated.now.borrow())
    }

    /// Time for the stamp of what this node says of itself. A node that makes `/clock` runs by the host's clock and stamps
    /// by the one that it makes, as all others do.
    #[must_use]
    pub(crate) fn stamp(&self) -> Seconds {
        let announced = *self.announced.lock().unwrap_or_else(PoisonError::into_inner);
        announced.unwrap_or_else(|| self.now())
    }

    /// Notes the time that this node tells on `/clock`, for its stamps.
    pub(crate) fn announce(&self, now: Seconds) {
        *self.announced.lock().unwrap_or_else(PoisonError::into_inner) = Some(now);
    }

    /// Whether time comes from `/clock`.
    #[must_use]
    pub fn is_simulated(&self) -> bool {
        self.simulated.is_some()
    }

    /// How often simulated time jumped back: a filter that sees another count than before starts anew.
    #[must_use]
    pub fn jumps_back(&self) -> u64 {
        self.simulated.as_ref().map_or(0, |simulated| simulated.jumps_back.load(Ordering::Relaxed))
    }

    /// Time on this clock `age` of real time ago: what waited in a queue while the process stood still is dated to
    /// its arrival, not to the end of the wait.
    #[must_use]
    pub fn at_age(&self, age: Seconds) -> Seconds {
        let Some(simulated) = &self.simulated else { return monotonic() - age };
        if age.0 < HISTORY_STEP_S {
            return self.now();
        }
        let then = monotonic() - age;
        let history = simulated.history.lock().unwrap_or_else(PoisonError::into_inner);
        let reading = history.iter().rev().find(|reading| reading.monotonic <= then).or(history.front());
        reading.map_or_else(|| self.now(), |reading| reading.simulated)
    }

    /// Takes a reading of `/clock` in; true where time jumped back.
    pub(crate) fn set(&self, time: Seconds) -> bool {
        let Some(simulated) = &self.simulated else { return false };
        let back = time < *simulated.now.borrow();
        let mut history = simulated.history.lock().unwrap_or_else(PoisonError::into_inner);
        if back {
            history.clear();
            simulated.jumps_back.fetch_add(1, Ordering::Relaxed);
        }
        let monotonic = monotonic();
        if history.back().is_none_or(|last| (monotonic - last.monotonic).0 >= HISTORY_STEP_S) {
            if history.len() == HISTORY {
                history.pop_front();
            }
            history.push_back(Reading { monotonic, simulated: time });
        }
        drop(history);
        simulated.now.send_replace(time);
        back
    }

    /// A timer on this clock, first due one period from now.
    pub(crate) fn timer(&self, period: Seconds) -> Timer {
        let readings = self.simulated.as_ref().map(|simulated| simulated.now.subscribe());
        Timer {
            clock: self.clone(),
            readings,
            period,
            due: self.now() + period,
            jumps: self.jumps_back(),
            punctuality: None,
        }
    }
}

/// The owner of `/clock`.
#[derive(Debug)]
pub struct ClockDriver {
    clock: Clock,
    publisher: Publisher<ClockMessage>,
}

impl ClockDriver {
    pub(crate) fn new(clock: Clock, publisher: Publisher<ClockMessage>) -> Self {
        // As the clocks that it drives: they stand at zero until their first reading.
        clock.announce(Seconds(0.0));
        Self { clock, publisher }
    }

    /// Tells everyone the simulated time, this node first; false where the message was dropped.
    pub fn set(&self, now: Seconds) -> bool {
        self.clock.set(now);
        self.clock.announce(now);
        self.publisher.send(ClockMessage { clock: Time::from_seconds(now.0) })
    }
}

/// Ticks on the node's clock.
#[derive(Debug)]
pub struct Timer {
    clock: Clock,
    readings: Option<watch::Receiver<Seconds>>,
    period: Seconds,
    due: Seconds,
    jumps: u64,
    punctuality: Option<Punctuality>,
}

/// Longest sleep between two looks at the clock `[s]`.
const LONGEST_SLEEP_S: f64 = 3600.0;

impl Timer {
    /// Tells in `/diagnostics` where more than 0.1 % of its ticks come at intervals that are further than `tolerance` of
    /// real time from the usual one.
    #[must_use]
    pub fn tell_irregular(self, diagnostics: Diagnostics, tolerance: Seconds) -> Self {
        Self { punctuality: Some(Punctuality::new(diagnostics, tolerance)), ..self }
    }

    /// Puts the next tick off to `after` from now: the work of a tick was done for another reason.
    pub fn put_off(&mut self, after: Seconds) {
        self.due = self.clock.now() + after;
    }

    /// Waits for the next tick and yields the time now. Ticks that were missed are not made up for, and after a
    /// jump back of simulated time the next tick is one period after the jump. Cancelling loses no tick. In a process
    /// that was stopped and goes on no tick comes any more.
    pub async fn next(&mut self) -> Seconds {
        loop {
            shutdown::unless_continued().await;
            let now = self.clock.now();
            if self.clock.jumps_back() != self.jumps {
                self.jumps = self.clock.jumps_back();
                self.due = now + self.period;
            }
            let late = now - self.due;
            if late.0 >= 0.0 {
                let periods = (late.0 / self.period.0).floor() + 1.0;
                self.due = self.due + Seconds(self.period.0 * periods);
                if let Some(punctuality) = &mut self.punctuality {
                    punctuality.tick(monotonic());
                }
                return now;
            }
            match &mut self.readings {
                // The clock holds the sender, so waiting cannot fail while `self` lives.
                Some(readings) => _ = readings.changed().await,
                None => {
                    let wait_s = (-late.0).min(LONGEST_SLEEP_S);
                    tokio::time::sleep(std::time::Duration::from_secs_f64(wait_s)).await;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
