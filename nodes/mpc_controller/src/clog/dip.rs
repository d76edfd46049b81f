//! The dip that a narrowing nozzle leaves in the roads, from its first frame until it has passed.
//!
//! What each force would leave in them, and so which it is, [`super::likely`] tells. A dip that does not pass tells of none: a leak.

use super::likely::Likely;
use crate::advance::Driven;
use crate::params::RawClog;

/// Least share of its deepest that counts as left of a dip, and least that counts as gone: between them it fades by a time
/// constant `[-]`.
const REST_MIN: f64 = 0.01;

/// Times the share from which on a dip begins that lacks in two roads in a row that are not settled where the nozzle may have narrowed:
/// what a law that is off leaves behind changes of speed is less `[-]`.
const THIN: f64 = 2.0;

/// What a frame of a steady road tells, and what the encoder does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Look {
    /// Exposure `[s]`.
    pub(crate) exposed_s: f64,
    /// Share of the slicer's flow that lacked in the road then `[-]`.
    pub(crate) lacking: f64,
    /// Filament that had passed the encoder until then beyond the slicer's feed with the advance of a sound nozzle `[m]`.
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

/// What has come to pass since the newest frame, and what a law can still do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ahead {
    /// Now `[s]`.
    pub(crate) now_s: f64,
    /// When a law that is sent now acts `[s]`.
    pub(crate) acts_s: f64,
    /// As in a [`Look`], until now `[m]`.
    pub(crate) excess_m: f64,
    /// What the drive holds now.
    pub(crate) driven: Driven,
}

impl Look {
    /// What the law's melt holds at another feed `[m/s]`, `a u^n` `[m]`.
    fn melt_at_m(&self, feed_m_s: f64) -> f64 {
        self.melt_m * (feed_m_s / self.feed_m_s).powf(self.index)
    }
}

/// What a dip tells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Word {
    /// Of the nozzle, and what the law's melt held at the feed at which it is booked `[m]`.
    Narrowed(Likely, f64),
    /// The same by one frame more, instead of what it told before.
    Again(Likely, f64),
    /// That what it told early was no narrowing.
    Withdrawn,
}

/// A dip under way.
#[derive(Debug, Clone)]
struct Dip {
    /// The sound road before it.
    before: Look,
    /// Its frames, one at least.
    looks: Vec<Look>,
    /// Largest share that lacked, or was too much, `[-]`, > 0.
    deepest: f64,
    /// It has told of a force already.
    told: bool,
}

/// Frames in turn, and the dip in them.
#[derive(Debug, Clone)]
pub(crate) struct Dips {
    settings: RawClog,
    before: Option<Look>,
    dip: Option<Dip>,
    passed: Option<Dip>,
    has_begun: bool,
    /// When the last frame of a road that is not settled came, where much lacked `[s]`.
    thin_s: Option<f64>,
}

impl Dips {
    pub(crate) fn new(settings: RawClog) -> Self {
        Self { settings, before: None, dip: None, passed: None, has_begun: false, thin_s: None }
    }

    /// Share of the flow that lacks at `now_s` by a dip under way, or by what is left of one `[-]`, 0 or more.
    pub(crate) fn rest(&self, now_s: f64) -> f64 {
        let left = |dip: &Dip| {
            dip.rest() * dip.deepest * (-(now_s - dip.last().exposed_s).max(0.0) / dip.fade_s()).exp()
        };
        let under_way = self.dip.as_ref().filter(|dip| !self.is_late(dip, now_s)).map(|dip| dip.deepest);
        under_way.or_else(|| self.passed.as_ref().map(left)).unwrap_or(0.0)
    }

    /// What a dip tells: by each of its frames where it is deep, else once it has passed or another road has cut it off. What was
    /// told is withdrawn where the next frame does not bear it out, or the dip lasts.
    pub(super) fn on_look(&mut self, look: Look, ahead: Ahead) -> Option<Word> {
        let before = self.before.replace(look)?;
        let Some(mut dip) = self.dip.take() else {
            let mut dip = self.begin(before, look)?;
            self.has_begun = true;
            let word = self.tell(&mut dip, ahead);
            self.dip = Some(dip);
            return word;
        };
        let lasts = self.is_late(&dip, look.exposed_s);
        if lasts && !dip.told {
            return None;
        }
        if !self.belongs(dip.last(), look) || self.differs(dip.first(), look) {
            return self.cut_off(dip, look.melt_m, ahead);
        }
        if dip.take(look) <= self.settings.passed * dip.deepest {
            return self.pass(dip, look.melt_m, ahead);
        }
        if lasts {
            return Some(Word::Withdrawn);
        }
        let word = self.tell(&mut dip, ahead);
        self.dip = Some(dip);
        word
    }

    /// The same where a road at this feed `[m/s]` that is not settled yet is faster than that of a dip, and cuts it off: a slower
    /// one may be a corner of the same. A nozzle that narrows among roads that never settle tells no force: where two in a row lack
    /// much, `lacking` `[-]`, it is open.
    pub(super) fn on_unsettled(&mut self, feed_m_s: f64, lacking: f64, ahead: Ahead) -> Option<Word> {
        if lacking > THIN * self.settings.begins {
            let last_s = self.thin_s.replace(ahead.now_s);
            self.has_begun |= last_s.is_some_and(|last_s| ahead.now_s - last_s <= self.settings.gap_s);
        } else {
            self.thin_s = None;
        }
        let faster = |dip: &mut Dip| feed_m_s > (1.0 + self.settings.feed_spread) * dip.first().feed_m_s;
        let dip = self.dip.take_if(faster)?;
        if self.is_late(&dip, ahead.now_s) && !dip.told {
            return None;
        }
        let melt_m = dip.last().melt_at_m(feed_m_s);
        self.cut_off(dip, melt_m, ahead)
    }

    /// Whether a dip has been seen to begin, or roads that never settled to be thin.
    pub(super) fn has_begun(&self) -> bool {
        self.has_begun
    }

    /// What was seen of it has to do, where it was seen to fade. What it told already stands, unless it was a single frame that told it:
    /// that may have been a bubble, or misread.
    fn cut_off(&mut self, dip: Dip, melt_m: f64, ahead: Ahead) -> Option<Word> {
        if dip.told {
            return (dip.looks.len() == 1).then_some(Word::Withdrawn);
        }
        if dip.rest() > self.settings.cut_off { None } else { self.pass(dip, melt_m, ahead) }
    }

    /// By all its frames. What it holds counts as all that it will at the feed that there is by then, where the law's melt holds
    /// `melt_m`: until moves have the new law the road has filled by itself, and a push of what is left makes the next one fat.
    fn pass(&mut self, mut dip: Dip, melt_m: f64, ahead: Ahead) -> Option<Word> {
        let word = if dip.told {
            self.tell(&mut dip, ahead)
        } else {
            dip.likely(ahead).map(|likely| Word::Narrowed(Likely { share: 1.0, ..likely }, melt_m))
        };
        self.passed = Some(dip);
        word
    }

    /// What a deep dip tells by its frames so far.
    fn tell(&self, dip: &mut Dip, ahead: Ahead) -> Option<Word> {
        let deep = dip.first().lacking > 0.0 && dip.deepest > self.settings.deep;
        if !deep {
            return None;
        }
        let likely = dip.likely(ahead);
        let melt_m = dip.before.melt_m;
        match (std::mem::replace(&mut dip.told, likely.is_some()), likely) {
            (false, likely) => likely.map(|likely| Word::Narrowed(likely, melt_m)),
            (true, Some(likely)) => Some(Word::Again(likely, melt_m)),
            (true, None) => Some(Word::Withdrawn),
        }
    }

    /// A dip begins beside a sound road: at the start of one that was thin already, nobody knows when.
    fn begin(&self, before: Look, look: Look) -> Option<Dip> {
        let sound = before.lacking.abs() < self.settings.sound;
        let deep = look.lacking.abs() > self.settings.begins;
        (sound && deep && self.belongs(before, look) && !self.differs(before, look)).then(|| Dip {
            before,
            looks: vec![look],
            deepest: look.lacking.abs(),
            told: false,
        })
    }

    /// Whether a dip lasts for longer than one that passes.
    fn is_late(&self, dip: &Dip, now_s: f64) -> bool {
        now_s - dip.first().exposed_s > self.settings.lasts_s
    }

    fn belongs(&self, last: Look, look: Look) -> bool {
        look.exposed_s - last.exposed_s <= self.settings.gap_s
    }

    fn differs(&self, one: Look, other: Look) -> bool {
        (other.feed_m_s / one.feed_m_s - 1.0).abs() > self.settings.feed_spread
    }
}

impl Dip {
    fn first(&self) -> Look {
        self.looks[0]
    }

    fn last(&self) -> Look {
        self.looks[self.looks.len() - 1]
    }

    /// Its next frame; how deep it is there, to its own side `[-]`.
    fn take(&mut self, look: Look) -> f64 {
        self.looks.push(look);
        let depth = look.lacking * self.first().lacking.signum();
        self.deepest = self.deepest.max(depth);
        depth
    }

    fn likely(&self, ahead: Ahead) -> Option<Likely> {
        Likely::of(self.before, &self.looks, ahead)
    }

    /// What is left of its deepest `[-]`.
    fn rest(&self) -> f64 {
        let left = self.first().lacking.signum() * self.last().lacking / self.deepest;
        left.clamp(REST_MIN, 1.0 - REST_MIN)
    }

    /// Time constant with which it has faded `[s]`.
    fn fade_s(&self) -> f64 {
        (self.last().exposed_s - self.first().exposed_s) / -self.rest().ln()
    }
}
