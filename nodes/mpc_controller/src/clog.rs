//! How much more force the melt needs than that of a sound nozzle: a clog that the laws of coming moves follow.
//!
//! A nozzle that has narrowed needs `rho` times the melt's force at every feed, and holds as many times the filament (model
//! book 1.2). A law for the sound nozzle pushes and draws back too little at each change of speed from then on. What the
//! narrowing itself took from the roads is held already: the law grows, and is less by that at every feed. So it pushes
//! nothing at the feed of the road that tells of it (of a deep dip, what it does not hold yet), and the right amount wherever the
//! speed changes.

mod dip;
mod likely;

use crate::advance::Driven;
use crate::params::RawClog;
use dip::Word;
pub(crate) use dip::{Ahead, Dips, Look};
use likely::Likely;
use models::command::AdvanceLaw;

/// Share of what is open of a force that its dip has told `[-]`: it tells a force of 1.4 to 2.5 to some per cent.
const TOLD_DOUBT: f64 = 0.15;

/// The force factor rho, and what is held for it.
#[derive(Debug, Clone)]
pub(crate) struct Clog {
    settings: RawClog,
    dips: Dips,
    /// Force over that of a sound nozzle, however much `[-]`.
    needed: f64,
    carried_m: f64,
    /// Both before the last dip told of a force.
    before: (f64, f64),
}

impl Clog {
    /// A sound nozzle.
    pub(crate) fn new(settings: RawClog) -> Self {
        Self { settings, dips: Dips::new(settings), needed: 1.0, carried_m: 0.0, before: (1.0, 0.0) }
    }

    /// Force over that of a sound nozzle, as far as it is followed `[-]`, 1 or more.
    pub(crate) fn factor(&self) -> f64 {
        self.needed.min(self.settings.force_max)
    }

    /// Filament that is held for it without an advance that pushed it `[m]`, 0 or more.
    pub(crate) fn carried_m(&self) -> f64 {
        self.carried_m
    }

    /// Whether the nozzle has been seen to need more than what is followed.
    pub(crate) fn is_beyond(&self) -> bool {
        self.needed > self.settings.force_max
    }

    /// The nozzle is known to hold so much more, or less, at the feed as it is `[m]`: no law has to push it.
    pub(crate) fn carry(&mut self, more_m: f64) {
        self.carried_m = (self.carried_m + more_m).max(0.0);
    }

    /// A law of the sound nozzle for the one that there is.
    pub(crate) fn law(&self, sound: AdvanceLaw) -> AdvanceLaw {
        AdvanceLaw { shear: sound.shear * self.factor(), ..sound }
    }

    /// Share of the flow that lacks, or is too much, at `now_s` by a dip that has not passed wholly `[-]`.
    pub(crate) fn rest(&self, now_s: f64) -> f64 {
        self.dips.rest(now_s)
    }

    /// How much is open of a nozzle's force since a dip has begun: all where it was cut off before it told any, told too little
    /// or the nozzle has come free, none without a dip or behind one that is followed in part `[-]`.
    pub(crate) fn doubt(&self) -> f64 {
        match (self.dips.has_begun() && !self.is_beyond(), self.factor() > 1.0) {
            (false, _) => 0.0,
            (true, false) => 1.0,
            (true, true) => TOLD_DOUBT,
        }
    }

    /// A frame of a steady road while the encoder speaks; whether laws are others since.
    pub(crate) fn on_look(&mut self, look: Look, ahead: Ahead) -> bool {
        let word = self.dips.on_look(Look { melt_m: self.needed * look.melt_m, ..look }, ahead);
        self.follow(word, ahead.driven)
    }

    /// The same of a road that is not settled, at a feed `[m/s]`, in which a share lacks `[-]`.
    pub(crate) fn on_unsettled(&mut self, feed_m_s: f64, lacking: f64, ahead: Ahead) -> bool {
        let word = self.dips.on_unsettled(feed_m_s, lacking, ahead);
        self.follow(word, ahead.driven)
    }

    /// What a dip tells comes to be what is followed; whether it tells anything. What the drive has pushed since an earlier word of the
    /// same dip is held without having been taken from the roads.
    fn follow(&mut self, word: Option<Word>, driven: Driven) -> bool {
        match word {
            Some(Word::Narrowed(likely, melt_m)) => {
                self.before = (self.needed, self.carried_m);
                self.narrow(likely, melt_m / self.needed, 0.0);
            }
            Some(Word::Again(likely, melt_m)) => {
                (self.needed, self.carried_m) = self.before;
                let sound_m = melt_m / self.needed;
                let before = Driven { force: self.factor(), carried_m: self.carried_m };
                self.narrow(likely, sound_m, driven.beyond_m(sound_m) - before.beyond_m(sound_m));
            }
            Some(Word::Withdrawn) => (self.needed, self.carried_m) = self.before,
            None => {}
        }
        word.is_some()
    }

    /// The nozzle comes to need more than it did: as far as the drive can push, the law grows, and what the nozzle neither holds yet nor
    /// has been `pushed_m` is pushed. `sound_m` is what the melt of a sound one holds.
    fn narrow(&mut self, likely: Likely, sound_m: f64, pushed_m: f64) {
        let (needed, factor) = (self.needed, self.factor());
        self.needed = (needed * likely.force).max(1.0);
        self.carry(likely.share * (self.factor() - factor) * sound_m - pushed_m);
    }
}

#[cfg(test)]
pub(crate) mod tests;
