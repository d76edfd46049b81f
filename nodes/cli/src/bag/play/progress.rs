//! How far a play has come: it can be left at any message, and goes on there.

use super::deck::Deck;
use super::reel::Reel;
use models::units::Seconds;
use runtime::qos::Durability;
use std::collections::BTreeMap;
use std::time::Duration;
use tokio::time::{Instant, sleep, sleep_until};

/// Simulated time between two readings of /clock `[ns]`.
const CLOCK_NS: u64 = 10_000_000;
/// Who is later than this may have been stopped and continued: that is told within [`HESITATION`].
const STALLED: Duration = Duration::from_millis(200);
/// Wait of a play that is suddenly late, once until it is on time again.
const HESITATION: Duration = Duration::from_millis(150);

/// A play of a reel.
pub(super) struct Progress<'a> {
    reel: &'a Reel,
    /// Time of the bag over wall time.
    rate: f64,
    /// Times that it is still played, this one included.
    passes: u32,
    /// The next message.
    next: usize,
    /// Stretch that is played, and the next reading of its clock.
    clock: Option<(usize, u64)>,
    /// A moment, and the time into the play at which it was `[ns]`.
    origin: (Instant, u64),
    /// It was on time when it was due last.
    on_time: bool,
    /// When its first message was due.
    pub(super) began: Option<Instant>,
    /// How late the latest message was.
    pub(super) late_max: Duration,
}

impl<'a> Progress<'a> {
    pub(super) fn new(reel: &'a Reel, rate: f64, times: u32) -> Self {
        Self {
            reel,
            rate,
            passes: times,
            next: 0,
            clock: None,
            origin: (Instant::now(), 0),
            on_time: true,
            began: None,
            late_max: Duration::ZERO,
        }
    }

    /// Time into the play of the next message.
    #[allow(clippy::cast_precision_loss, reason = "a time of a bag")]
    pub(super) fn place(&self) -> Seconds {
        Seconds(self.reel.frames.get(self.next).map_or(0, |frame| frame.at_ns) as f64 * 1e-9)
    }

    /// Plays from here to the end, after a wait for subscribers. Cancelling it loses nothing and repeats nothing.
    pub(super) async fn go(&mut self, deck: &mut Deck, wait: Duration) {
        sleep(wait).await;
        self.latched(deck);
        self.begin();
        while self.passes > 0 {
            while let Some(frame) = self.reel.frames.get(self.next) {
                self.drive(deck).await;
                self.reach(frame.at_ns).await;
                self.late_max = self.late_max.max(self.moment(frame.at_ns).elapsed());
                deck.publishers[frame.channel].send(&frame.payload);
                self.next += 1;
            }
            (self.next, self.clock) = (0, None);
            self.passes -= 1;
            self.begin();
        }
    }

    /// The newest word of each latched topic before this place: those who join a new participant hear it too.
    fn latched(&self, deck: &Deck) {
        let frames = &self.reel.frames[..self.next];
        let is_latched =
            |channel: usize| self.reel.channels[channel].offered.durability == Durability::TransientLocal;
        let newest: BTreeMap<usize, _> =
            frames.iter().map(|frame| (frame.channel, frame)).filter(|(of, _)| is_latched(*of)).collect();
        for (channel, frame) in newest {
            deck.publishers[channel].send(&frame.payload);
        }
    }

    /// The next message is due now.
    fn begin(&mut self) {
        let at_ns = self.reel.frames.get(self.next).map_or(0, |frame| frame.at_ns);
        (self.origin, self.on_time) = ((Instant::now(), at_ns), true);
        self.began.get_or_insert(self.origin.0);
    }

    /// Tells the readings of /clock up to the next message.
    async fn drive(&mut self, deck: &mut Deck) {
        let (Some(driver), Some(frame)) = (&mut deck.driver, self.reel.frames.get(self.next)) else { return };
        let newest = self.clock.filter(|(stretch, _)| *stretch == frame.stretch);
        let mut clock_ns = newest.map_or(frame.log_ns, |(_, clock_ns)| clock_ns);
        while clock_ns <= frame.log_ns {
            self.reach(frame.at_ns.saturating_sub(frame.log_ns - clock_ns)).await;
            driver.set(seconds(clock_ns));
            clock_ns = clock_ns.saturating_add(CLOCK_NS);
            self.clock = Some((frame.stretch, clock_ns));
            // What is waited for may lie in the past for long: who wants to end the play is heard all the same.
            tokio::task::consume_budget().await;
        }
    }

    /// The moment of a time into the play.
    fn moment(&self, at_ns: u64) -> Instant {
        let (begin, from_ns) = self.origin;
        begin + Duration::from_nanos(at_ns.saturating_sub(from_ns)).div_f64(self.rate)
    }

    /// Waits for a time into the play.
    async fn reach(&mut self, at_ns: u64) {
        let moment = self.moment(at_ns);
        if moment > Instant::now() {
            self.on_time = true;
            sleep_until(moment).await;
        }
        if self.on_time && moment.elapsed() > STALLED {
            self.on_time = false;
            sleep(HESITATION).await;
        }
    }
}

#[allow(clippy::cast_precision_loss, reason = "a time of a bag")]
fn seconds(ns: u64) -> Seconds {
    Seconds(ns as f64 * 1e-9)
}
