//! Frames: header, size, order and age of the stamp, repetition, rate.

use std::hash::{DefaultHasher, Hash, Hasher};

use models::units::Seconds;

use crate::params::CameraParams;
use crate::picture::{Header, jpeg_header};

/// Largest frame that is passed `[byte]`: faults.md S9.
pub const BYTES_MAX: usize = 4 << 20;

/// A frame that may be passed on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Accepted {
    /// What its header says.
    pub header: Header,
    /// Frames that are missing before it, by the configured rate.
    pub dropped: u64,
    /// The same bytes as the frame before: a sensor's noise never repeats, the camera stands still. Such a frame is
    /// passed on and counted, so that the classifier can say within two frames that it sees nothing (S8).
    pub frozen: bool,
}

/// Why a frame was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Refusal {
    /// The stamp is NaN or infinite.
    NotFinite,
    /// Longer than [`BYTES_MAX`], or beyond the bounds of a picture by its header.
    TooLarge,
    /// No JPEG that a decoder may be given.
    Corrupt,
    /// Another size than the configured one.
    Size,
    /// A stamp not after the last one.
    Order,
    /// A stamp ahead of the clock.
    Future,
    /// A stamp too far behind the clock.
    Stale,
    /// Sooner after the last one than the highest rate allows.
    TooFast,
}

/// Refused frames by reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs, reason = "as the variants of Refusal")]
pub struct Refusals {
    pub not_finite: u64,
    pub too_large: u64,
    pub corrupt: u64,
    pub size: u64,
    pub order: u64,
    pub future: u64,
    pub stale: u64,
    pub too_fast: u64,
}

impl Refusals {
    /// All of them.
    #[must_use]
    pub fn total(&self) -> u64 {
        let Self { not_finite, too_large, corrupt, size, order, future, stale, too_fast } = self;
        not_finite + too_large + corrupt + size + order + future + stale + too_fast
    }

    fn count(&mut self, refusal: Refusal) {
        let counter = match refusal {
            Refusal::NotFinite => &mut self.not_finite,
            Refusal::TooLarge => &mut self.too_large,
            Refusal::Corrupt => &mut self.corrupt,
            Refusal::Size => &mut self.size,
            Refusal::Order => &mut self.order,
            Refusal::Future => &mut self.future,
            Refusal::Stale => &mut self.stale,
            Refusal::TooFast => &mut self.too_fast,
        };
        *counter = counter.saturating_add(1);
    }
}

/// Newest frame that was in order.
#[derive(Debug, Clone, Copy)]
struct Last {
    exposed: Seconds,
    hash: u64,
    /// Frames that may come at once, at the highest rate.
    credit: f64,
    /// The frame before it had the same bytes.
    frozen: bool,
}

/// Most frames that may come at once: jitter of a stream at the highest rate.
const CREDIT_MAX: f64 = 2.0;

/// Judges frames.
#[derive(Debug, Clone)]
pub struct Frames {
    params: CameraParams,
    last: Option<Last>,
    accepted: Option<(Seconds, u64)>,
    interval_s: Option<f64>,
    dropped: u64,
    frozen: u64,
    seen: Option<Header>,
    refusals: Refusals,
}

impl Frames {
    /// Nothing seen yet.
    #[must_use]
    pub fn new(params: CameraParams) -> Self {
        let refusals = Refusals::default();
        Self {
            params,
            last: None,
            accepted: None,
            interval_s: None,
            dropped: 0,
            frozen: 0,
            seen: None,
            refusals,
        }
    }

    /// Takes a frame received at `now`.
    ///
    /// # Errors
    /// The [`Refusal`], which is counted.
    pub fn on_frame(&mut self, now: Seconds, exposed: Seconds, jpeg: &[u8]) -> Result<Accepted, Refusal> {
        let judged = self.judge(now, exposed, jpeg);
        match judged {
            Ok(header) => {
                let frozen = self.last.is_some_and(|last| last.frozen);
                self.frozen = self.frozen.saturating_add(u64::from(frozen));
                Ok(Accepted { header, dropped: self.follow(exposed), frozen })
            }
            Err(refusal) => {
                self.refusals.count(refusal);
                Err(refusal)
            }
        }
    }

    /// Another highest rate from now on; what was seen and counted stays.
    pub fn retune(&mut self, params: CameraParams) {
        self.params = params;
    }

    /// Refused frames so far.
    #[must_use]
    pub fn refusals(&self) -> Refusals {
        self.refusals
    }

    /// Frames missing so far, by the configured rate.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Accepted frames so far that repeat the one before.
    #[must_use]
    pub fn frozen(&self) -> u64 {
        self.frozen
    }

    /// Time between the last two accepted frames.
    #[must_use]
    pub fn interval(&self) -> Option<Seconds> {
        self.interval_s.map(Seconds)
    }

    /// What is wrong with every frame, with what to do; `None` where nothing does.
    #[must_use]
    pub fn complaint(&self) -> Option<String> {
        let CameraParams { width_px, height_px, .. } = self.params;
        if let Some(seen) = self.seen.filter(|seen| !self.is_wanted(*seen)) {
            let (width, height) = (seen.width_px, seen.height_px);
            return Some(format!(
                "frames are {width}x{height} px where {width_px}x{height_px} are configured: set camera.width_px, \
                 height_px and scale_m, or the camera"
            ));
        }
        self.last
            .is_some_and(|last| last.frozen)
            .then(|| "the picture stands still: every frame has the same bytes".to_owned())
    }

    fn is_wanted(&self, header: Header) -> bool {
        (header.width_px, header.height_px) == (self.params.width_px, self.params.height_px)
    }

    fn judge(&mut self, now: Seconds, exposed: Seconds, jpeg: &[u8]) -> Result<Header, Refusal> {
        self.check_stamp(now, exposed)?;
        if jpeg.len() > BYTES_MAX {
            return Err(Refusal::TooLarge);
        }
        let header = jpeg_header(jpeg).map_err(|_| Refusal::Corrupt)?;
        if !header.bounded() {
            return Err(Refusal::TooLarge);
        }
        self.seen = Some(header);
        if !self.is_wanted(header) {
            return Err(Refusal::Size);
        }
        self.compare(exposed, jpeg)?;
        Ok(header)
    }

    fn check_stamp(&self, now: Seconds, exposed: Seconds) -> Result<(), Refusal> {
        if !(now.0.is_finite() && exposed.0.is_finite()) {
            return Err(Refusal::NotFinite);
        }
        let age_s = now.0 - exposed.0;
        if age_s < -self.params.stamp_future_max_s {
            return Err(Refusal::Future);
        }
        if age_s > self.params.stamp_age_max_s {
            return Err(Refusal::Stale);
        }
        // A stamp far behind the last one is a clock that was set back, not a late frame.
        let late =
            |last: Last| exposed <= last.exposed && (last.exposed - exposed).0 <= self.params.stamp_age_max_s;
        if self.last.is_some_and(late) { Err(Refusal::Order) } else { Ok(()) }
    }

    /// Compares a frame with the last one: whether it repeats it, and comes at a rate that those behind us can take.
    fn compare(&mut self, exposed: Seconds, jpeg: &[u8]) -> Result<(), Refusal> {
        let mut hasher = DefaultHasher::new();
        jpeg.hash(&mut hasher);
        let hash = hasher.finish();
        let mut credit = CREDIT_MAX;
        let mut frozen = false;
        if let Some(last) = self.last.filter(|last| last.exposed < exposed) {
            frozen = last.hash == hash;
            let earned = (exposed - last.exposed).0 * self.params.rate_max_hz;
            credit = (last.credit + earned).min(CREDIT_MAX);
        }
        let fast = credit < 1.0;
        credit -= if fast { 0.0 } else { 1.0 };
        self.last = Some(Last { exposed, hash, credit, frozen });
        if fast { Err(Refusal::TooFast) } else { Ok(()) }
    }

    /// Frames missing before an accepted one.
    fn follow(&mut self, exposed: Seconds) -> u64 {
        let excused = self.refusals.total();
        let before = self.accepted.replace((exposed, excused));
        let Some((then, excused_then)) = before.filter(|(then, _)| *then < exposed) else { return 0 };
        let interval_s = (exposed - then).0;
        self.interval_s = Some(interval_s);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates; not negative")]
        let periods = (interval_s * self.params.rate_hz).round() as u64;
        // What came and was refused is counted there.
        let missing = periods.saturating_sub(1).saturating_sub(excused - excused_then);
        self.dropped = self.dropped.saturating_add(missing);
        missing
    }
}

#[cfg(test)]
mod tests;
