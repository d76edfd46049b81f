//! The dip that a narrowing nozzle leaves in the roads, and what it tells of the melt's force.
//!
//! What the nozzle holds compressed is what went in and did not come out: the filament that lacks in the roads, plus what
//! passed the encoder beyond the slicer's own feed. A nozzle that narrows at a feed u holds `(rho - rho') a u^n` more once the
//! dip has passed, `a u^n` the melt's part of the law of a sound one. A dip that does not pass tells of no force: a leak.

use crate::params::RawClog;

/// Least share of its deepest that counts as left of a dip, and least that counts as gone: between them it fades by a time
/// constant `[-]`.
const REST_MIN: f64 = 0.01;

/// Rounds in which what lacked before the first frame and the force are found together: each brings half a digit and more.
const ROUNDS: u32 = 6;

/// Halvings of an interval: to a millionth.
const HALVINGS: u32 = 20;

/// What a frame of a steady road tells, and what the encoder does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Look {
    /// Exposure `[s]`.
    pub(crate) exposed_s: f64,
    /// Share of the slicer's flow that lacked in the road then `[-]`.
    pub(crate) lacking: f64,
    /// Filament that had passed the encoder beyond the slicer's feed until then `[m]`.
    pub(crate) excess_m: f64,
    /// The slicer's feed then `[m/s]`, > 0.
    pub(crate) feed_m_s: f64,
    /// Filament that the melt's part of the law holds at it, `a u^n` `[m]`, > 0.
    pub(crate) melt_m: f64,
    /// The same of the linear part, `K_lin u` `[m]`.
    pub(crate) linear_m: f64,
    /// Flow index n `[-]`, in `(0, 1]`.
    pub(crate) index: f64,
}

/// A dip under way.
#[derive(Debug, Clone, Copy)]
struct Dip {
    /// The sound road before it.
    before: Look,
    first: Look,
    last: Look,
    /// Largest share that lacked, or was too much, `[-]`, > 0.
    deepest: f64,
    /// What lacked since the first frame `[m]`.
    lacked_m: f64,
}

/// Frames in turn, and the dip in them.
#[derive(Debug, Clone)]
pub(crate) struct Dips {
    settings: RawClog,
    before: Option<Look>,
    dip: Option<Dip>,
    passed: Option<Dip>,
    has_begun: bool,
}

impl Dips {
    pub(crate) fn new(settings: RawClog) -> Self {
        Self { settings, before: None, dip: None, passed: None, has_begun: false }
    }

    /// Share of the flow that lacks at `now_s` by a dip under way, or by what is left of one `[-]`, 0 or more.
    pub(crate) fn rest(&self, now_s: f64) -> f64 {
        let left = |dip: &Dip| {
            dip.rest() * dip.deepest * (-(now_s - dip.last.exposed_s).max(0.0) / dip.fade_s()).exp()
        };
        let late = |dip: &&Dip| now_s - dip.first.exposed_s > self.settings.lasts_s;
        let under_way = self.dip.as_ref().filter(|dip| !late(dip)).map(|dip| dip.deepest);
        under_way.or_else(|| self.passed.as_ref().map(left)).unwrap_or(0.0)
    }

    /// How much more filament is held, once a dip has passed or another road has cut it off `[m]`.
    pub(crate) fn on_look(&mut self, look: Look) -> Option<f64> {
        let before = self.before.replace(look)?;
        let Some(mut dip) = self.dip.take() else {
            self.dip = self.begin(before, look);
            self.has_begun |= self.dip.is_some();
            return None;
        };
        if look.exposed_s - dip.first.exposed_s > self.settings.lasts_s {
            return None;
        }
        if !self.belongs(dip.last, look) || self.differs(dip.first, look) {
            return self.cut_off(dip);
        }
        dip.lacked_m += lacked_m(dip.last, look);
        dip.last = look;
        let depth = look.lacking * dip.first.lacking.signum();
        dip.deepest = dip.deepest.max(depth);
        if depth > self.settings.passed * dip.deepest {
            self.dip = Some(dip);
            return None;
        }
        self.passed = Some(dip);
        Some(dip.held_m())
    }

    /// How much more filament is held, beside what the melt held `[m]`, where a road at this feed `[m/s]` that is not settled yet is
    /// faster than that of a dip, and cuts it off: a slower one may be a corner of the same.
    pub(super) fn on_unsettled(&mut self, feed_m_s: f64) -> Option<(f64, f64)> {
        let faster = |dip: &mut Dip| feed_m_s > (1.0 + self.settings.feed_spread) * dip.first.feed_m_s;
        let dip = self.dip.take_if(faster)?;
        Some((self.cut_off(dip)?, dip.last.melt_m))
    }

    /// Whether a dip has been seen to begin.
    pub(super) fn has_begun(&self) -> bool {
        self.has_begun
    }

    /// What was seen of it has to do, where it was seen to fade.
    fn cut_off(&mut self, dip: Dip) -> Option<f64> {
        let fades = dip.rest() <= self.settings.cut_off;
        self.passed = fades.then_some(dip).or(self.passed);
        fades.then(|| dip.held_m())
    }

    /// A dip begins beside a sound road: at the start of one that was thin already, nobody knows when.
    fn begin(&self, before: Look, look: Look) -> Option<Dip> {
        let sound = before.lacking.abs() < self.settings.sound;
        let deep = look.lacking.abs() > self.settings.begins;
        (sound && deep && self.belongs(before, look) && !self.differs(before, look)).then(|| Dip {
            before,
            first: look,
            last: look,
            deepest: look.lacking.abs(),
            lacked_m: 0.0,
        })
    }

    fn belongs(&self, last: Look, look: Look) -> bool {
        look.exposed_s - last.exposed_s <= self.settings.gap_s
    }

    fn differs(&self, one: Look, other: Look) -> bool {
        (other.feed_m_s / one.feed_m_s - 1.0).abs() > self.settings.feed_spread
    }
}

impl Dip {
    /// What is held more than before `[m]`; the rest fades as the dip has faded.
    fn held_m(&self) -> f64 {
        let rest = self.first.lacking.signum() * self.rest() * self.deepest;
        let coming_m = rest * self.last.feed_m_s * self.fade_s();
        let fed_m = self.last.excess_m - self.before.excess_m;
        let since_first_m = self.lacked_m + coming_m + fed_m;
        (0..ROUNDS).fold(since_first_m, |held_m, _| {
            since_first_m + self.before_first_m(1.0 + held_m / self.last.melt_m)
        })
    }

    /// What lacked before the first frame, in a nozzle that needs `force` times the melt's force since `[m]`: from what it let
    /// through at first it had faded to what the frame shows, or the last sound road was later than that.
    fn before_first_m(&self, force: f64) -> f64 {
        let (seen, gap_s) = (self.first.lacking.abs(), self.first.exposed_s - self.before.exposed_s);
        let began = if self.first.lacking > 0.0 { self.first.lacks_at_first(force).max(seen) } else { seen };
        let since_s = if began > seen { self.fade_s() * (began / seen).ln() } else { 0.5 * gap_s };
        0.5 * (began + seen) * self.first.lacking.signum() * self.first.feed_m_s * since_s.min(gap_s)
    }
}

impl Look {
    /// Share of the flow that lacks just after the nozzle has come to need `force` times the melt's force: it holds the same
    /// filament still, `force a w^n + K w = a u^n + K u` `[-]`.
    fn lacks_at_first(&self, force: f64) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let share = 0.5 * (low + high);
            let holds_m = force * self.melt_m * f64::powf(share, self.index) + self.linear_m * share;
            if holds_m < self.melt_m + self.linear_m { low = share } else { high = share }
        }
        1.0 - low
    }
}

impl Dip {
    /// What is left of its deepest `[-]`.
    fn rest(&self) -> f64 {
        (self.first.lacking.signum() * self.last.lacking / self.deepest).clamp(REST_MIN, 1.0 - REST_MIN)
    }

    /// Time constant with which it has faded `[s]`.
    fn fade_s(&self) -> f64 {
        (self.last.exposed_s - self.first.exposed_s) / -self.rest().ln()
    }
}

/// What lacked from one frame to the next, fading from one share to the other `[m]`.
fn lacked_m(last: Look, look: Look) -> f64 {
    let (from, to) = (last.lacking * last.feed_m_s, look.lacking * look.feed_m_s);
    let mean = if from * to > 0.0 && (from / to - 1.0).abs() > 1e-3 {
        (from - to) / (from / to).ln()
    } else {
        0.5 * (from + to)
    };
    mean * (look.exposed_s - last.exposed_s)
}
