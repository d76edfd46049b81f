//! Watchdog over the middleware itself: a message through DDS to oneself.
//!
//! A signal that interrupts its poll (SIGSTOP and SIGCONT, suspend, a debugger) ends both event loops of RustDDS 0.15.1:
//! the process lives on deaf and mute, and publishing still answers Ok. So each process sends itself a number ten times
//! a second. On a `lo` without multicast a participant does not hear itself, but a second small one in the same process
//! hears it and sends the number back, which proves both directions:
//!
//! `participant of the node -> echo participant -> participant of the node`
//!
//! Nothing heard for [`LIMIT`] ends the process; whoever started it starts it again. The limit counts time in which this
//! watchdog itself ran: a process that was stopped or starved of the processor is not ended for that alone.
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
use rustdds::no_key::{DataWriterCdr, SimpleDataReaderCdr};
use rustdds::policy::{History, Reliability};
use rustdds::{DomainParticipant, QosPolicies, QosPolicyBuilder, TopicKind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// Time between two numbers.
const TICK: Duration = Duration::from_millis(100);
/// Most that one pass of the watchdog counts as silence: a pass that comes late was not scheduled `[s]`.
const MOST_PER_PASS_S: f64 = 0.125;
/// Ticks in which a node still announces new streams, and ticks between two acknowledgements of its own announcements,
/// then and later.
const ANNOUNCING: u64 = 200;
const ACK_AT_FIRST: u64 = 10;
const ACK: u64 = 100;
/// Silence that ends the process `[s]` (C5).
const LIMIT: Seconds = Seconds(1.0);
/// A wall clock that is set back by more deafens for longer than anybody is patient with a stream `[ns]`.
const SET_BACK_NS: i64 = 500_000_000;
/// Silence allowed before the first number came back: many participants discover each other in 5 s `[s]`.
const START_LIMIT: Seconds = Seconds(15.0);

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
    /// Starts the watchdog over the process's own participant; `on_silence` is called once, from its thread, `on_crowd`
    /// with the number of participants as often as they are too many.
    pub(crate) fn start(
        participants: Participants,
        session: u64,
        on_silence: impl FnOnce() + Send + 'static,
        on_crowd: impl Fn(usize) + Send + 'static,
    ) -> Result<Self, RuntimeError> {
        let crowd = Crowd::around([&participants.own, &participants.echo]);
        let ring = Ring::new(&participants.own, participants.echo, session)
            .map_err(|error| RuntimeError::create("self loop", &error))?;
        let acks = [&participants.own, &ring.echo].map(SelfAck::of);
        let age = SelfLoopAge::default();
        let (stop, stopped) = channel();
        let shared = age.clone();
        let thread = std::thread::Builder::new()
            .name("self_loop".to_owned())
            .spawn(move || {
                if watch((&ring, acks), (crowd, &on_crowd), &shared, &stopped) {
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

/// Sends and listens until stopped (false) or silent for too long (true).
fn watch(
    (ring, mut acks): (&Ring, [Option<SelfAck>; 2]),
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
            acks.iter_mut().flatten().for_each(SelfAck::send);
        }
        crowd.look().into_iter().for_each(on_crowd);
        let heard = ring.turn(number);
        let now = monotonic();
        if heard {
            age.heard(now);
        }
        let wall_ns = wall_ns();
        if silence.pass(now, heard) || wall_ns < newest_ns - SET_BACK_NS {
            return true;
        }
        newest_ns = newest_ns.max(wall_ns);
    }
}

/// Adds up the time without an own message, as far as the watchdog ran.
#[derive(Debug)]
struct Silence {
    last_pass: Seconds,
    silent: Seconds,
    established: bool,
}

impl Silence {
    fn new(now: Seconds) -> Self {
        Self { last_pass: now, silent: Seconds(0.0), established: false }
    }

    /// One pass of the watchdog; true where the limit is passed.
    fn pass(&mut self, now: Seconds, heard: bool) -> bool {
        let gap_s = (now - self.last_pass).0.min(MOST_PER_PASS_S);
        self.last_pass = now;
        if heard {
            self.established = true;
            self.silent = Seconds(0.0);
            return false;
        }
        self.silent = self.silent + Seconds(gap_s);
        self.silent > if self.established { LIMIT } else { START_LIMIT }
    }
}

/// The four ends of the loop.
struct Ring {
    out: DataWriterCdr<u64>,
    echo_in: SimpleDataReaderCdr<u64>,
    echo_out: DataWriterCdr<u64>,
    back: SimpleDataReaderCdr<u64>,
    // Kept to the end: the echo lives as long as its participant.
    echo: DomainParticipant,
}

impl Ring {
    /// Creates both topics, named after the session, so that no other process listens. They carry no ROS prefix and
    /// do not show in `ros2 topic list`.
    fn new(
        own: &DomainParticipant,
        echo: DomainParticipant,
        session: u64,
    ) -> rustdds::dds::CreateResult<Self> {
        let qos = QosPolicyBuilder::new()
            .reliability(Reliability::BestEffort)
            .history(History::KeepLast { depth: 1 })
            .build();
        let there = format!("fdm_loop_self_{session:016x}_there");
        let back = format!("fdm_loop_self_{session:016x}_back");
        Ok(Self {
            out: writer(own, &there, &qos)?,
            echo_in: reader(&echo, &there, &qos)?,
            echo_out: writer(&echo, &back, &qos)?,
            back: reader(own, &back, &qos)?,
            echo,
        })
    }

    /// Sends a number, passes on what the echo heard, and says whether one came back. A failed write shows as silence.
    fn turn(&self, number: u64) -> bool {
        _ = self.out.write(number, None);
        if let Some(heard) = newest(&self.echo_in) {
            _ = self.echo_out.write(heard, None);
        }
        newest(&self.back).is_some()
    }
}

/// The newest number that is here.
fn newest(reader: &SimpleDataReaderCdr<u64>) -> Option<u64> {
    reader.drain_read_notifications();
    let mut newest = None;
    while let Ok(Some(sample)) = reader.try_take_one() {
        newest = Some(sample.into_value());
    }
    newest
}

/// Type name of both topics.
const TYPE: &str = "fdm_loop::SelfLoop";

fn writer(
    participant: &DomainParticipant,
    name: &str,
    qos: &QosPolicies,
) -> rustdds::dds::CreateResult<DataWriterCdr<u64>> {
    let topic = participant.create_topic(name.to_owned(), TYPE.to_owned(), qos, TopicKind::NoKey)?;
    participant.create_publisher(qos)?.create_datawriter_no_key_cdr(&topic, Some(qos.clone()))
}

fn reader(
    participant: &DomainParticipant,
    name: &str,
    qos: &QosPolicies,
) -> rustdds::dds::CreateResult<SimpleDataReaderCdr<u64>> {
    let topic = participant.create_topic(name.to_owned(), TYPE.to_owned(), qos, TopicKind::NoKey)?;
    participant.create_subscriber(qos)?.create_simple_datareader_no_key(&topic, Some(qos.clone()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Passes every 0.1 s from 0 on, none heard, until the limit is passed; yields the time.
    fn ends_after(silence: &mut Silence, from: f64) -> f64 {
        (1..1000).map(|i| from + 0.1 * f64::from(i)).find(|now| silence.pass(Seconds(*now), false)).unwrap()
    }

    /// C5: dead event loops are noticed within 1 s (and one pass).
    #[test]
    fn silence_ends_the_process_after_its_limit() {
        let mut silence = Silence::new(Seconds(0.0));
        assert!(!silence.pass(Seconds(0.1), true));
        let ended = ends_after(&mut silence, 0.1);
        assert!((1.1..=1.25).contains(&ended), "{ended}");
    }

    /// A process that was stopped for 5 s is judged by what follows, not by the stop.
    #[test]
    fn a_pass_that_was_not_scheduled_counts_little() {
        let mut silence = Silence::new(Seconds(0.0));
        silence.pass(Seconds(0.1), true);
        assert!(!silence.pass(Seconds(5.1), false));
        assert!(!silence.pass(Seconds(5.2), true));
    }

    #[test]
    fn discovery_has_more_time() {
        let ended = ends_after(&mut Silence::new(Seconds(0.0)), 0.0);
        assert!((15.0..=15.25).contains(&ended), "{ended}");
    }
}
