//! Watchdog over the middleware itself: a message through DDS to oneself.
//!
//! A signal that interrupts its poll (SIGSTOP and SIGCONT, suspend, a debugger) ends both event loops of RustDDS 0.15.1:
//! the process lives on deaf and mute, and publishing still answers Ok. So each process sends itself a number four times
//! a second. Where `lo` carries multicast its participant hears it. Elsewhere it does not, but a second small one in the
//! same process hears it and sends the number back, which proves both directions:
//!
//! `participant of the node -> (echo participant ->) participant of the node`
//!
//! The second one is made only where it is needed: each participant of a domain talks to each other one.
//!
//! Nothing heard for a second ends the process; whoever started it starts it again. The limit counts time in which this
//! watchdog itself ran: a process that was stopped or starved of the processor is not ended for that alone.
//!
//! An endpoint that is never made hangs the node as well: that is seen sooner than the silence (`making`).
//!
//! A wall clock that is set back deafens a participant of RustDDS 0.15.1 for as long (T3): readers that ask for best
//! effort look for samples up to the present by that clock, and the newest lie beyond. That is seen at once.

use crate::clock::monotonic;
use crate::crowd::Crowd;
use crate::error::RuntimeError;
use crate::participants::Participants;
use crate::self_ack::SelfAck;
use crate::subscription::wall_ns;
use models::units::Seconds;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

mod making;
mod ring;
mod silence;
use making::Patience;
pub(crate) use making::{Begun, Making};
use ring::Ring;
use silence::Silence;

/// Time between two numbers. Where `lo` carries multicast each of them wakes every process of the domain.
const TICK: Duration = Duration::from_millis(250);
/// Ticks in which a node still announces new streams, and ticks between two acknowledgements of its own announcements,
/// then and later.
const ANNOUNCING: u64 = 80;
const ACK_AT_FIRST: u64 = 4;
const ACK: u64 = 40;
/// A participant that should hear itself and has not for so long gets an echo.
const ALONE_LIMIT: Seconds = Seconds(5.0);
/// A wall clock that is set back by more deafens for longer than anybody is patient with a stream `[ns]`.
const SET_BACK_NS: i64 = 500_000_000;
/// Age of the newest own message that came back; clones share it.
#[derive(Debug, Clone, Default)]
pub struct SelfLoopAge(Arc<AtomicU64>);

impl SelfLoopAge {
    /// Age in real time; `None` before the first came back.
    #[must_use]
    pub fn age(&self) -> Option<Seconds> {
        let heard = f64::from_bits(self.0.load(Ordering::Relaxed));
        (heard > 0.0).then(|| monotonic() - Seconds(heard))
    }

    /// A number came back now.
    fn heard(&self, now: Seconds) {
        self.0.store(now.0.to_bits(), Ordering::Relaxed);
    }
}

/// The running watchdog; dropping it ends its thread.
#[derive(Debug)]
pub(crate) struct SelfLoop {
    age: SelfLoopAge,
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl SelfLoop {
    /// Starts the watchdog over the process's own participant and the endpoints that it makes; `on_silence` is called once,
    /// from its thread, `on_crowd` with the number of participants as often as they are too many.
    pub(crate) fn start(
        participants: Participants,
        making: Making,
        session: u64,
        on_silence: impl FnOnce() + Send + 'static,
        on_crowd: impl Fn(usize) + Send + 'static,
    ) -> Result<Self, RuntimeError> {
        let members = || std::iter::once(&participants.own).chain(&participants.echo);
        let crowd = Crowd::around(members());
        let acks = members().filter_map(SelfAck::of).collect();
        let ring = Ring::new(participants, session)?;
        let age = SelfLoopAge::default();
        let (stop, stopped) = channel();
        let shared = age.clone();
        let patience = Patience::new(making, monotonic());
        let thread = std::thread::Builder::new()
            .name("self_loop".to_owned())
            .spawn(move || {
                if watch((ring, acks, patience), (crowd, &on_crowd), &shared, &stopped) {
                    on_silence();
                }
            })
            .map_err(|source| RuntimeError::System { what: "cannot start the self loop", source })?;
        Ok(Self { age, stop: Some(stop), thread: Some(thread) })
    }

    /// Age of the newest own message that came back.
    pub(crate) fn age(&self) -> SelfLoopAge {
        self.age.clone()
    }
}

impl Drop for SelfLoop {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            _ = thread.join();
        }
    }
}

/// Sends and listens until stopped (false), or silent or busy with an endpoint for too long (true).
fn watch(
    (mut ring, mut acks, mut patience): (Ring, Vec<SelfAck>, Patience),
    (mut crowd, on_crowd): (Crowd, &impl Fn(usize)),
    age: &SelfLoopAge,
    stopped: &Receiver<()>,
) -> bool {
    let mut silence = Silence::new(monotonic());
    let mut newest_ns = wall_ns();
    let mut number = 0_u64;
    loop {
        match stopped.recv_timeout(TICK) {
            Err(RecvTimeoutError::Timeout) => {}
            Ok(()) | Err(RecvTimeoutError::Disconnected) => return false,
        }
        number += 1;
        if number.is_multiple_of(if number < ANNOUNCING { ACK_AT_FIRST } else { ACK }) {
            acks.iter_mut().for_each(SelfAck::send);
        }
        crowd.look().into_iter().for_each(on_crowd);
        let heard = ring.turn(number);
        let now = monotonic();
        if heard {
            age.heard(now);
        }
        if patience.pass(now) {
            tracing::error!("the middleware makes an endpoint and does not come to an end");
            return true;
        }
        let wall_ns = wall_ns();
        if silence.pass(now, heard) || wall_ns < newest_ns - SET_BACK_NS {
            return true;
        }
        if ring.is_alone() && silence.is_unbroken(ALONE_LIMIT) {
            ring = match ring.with_echo() {
                Ok(ring) => ring,
                Err(error) => {
                    tracing::error!("no watch over the middleware: {error}");
                    return true;
                }
            };
        }
        newest_ns = newest_ns.max(wall_ns);
    }
}
