//! A melt behind a nozzle that narrows, and frames of its roads.

use super::*;

mod early;
mod none;

pub(crate) const SETTINGS: RawClog = RawClog {
    force_max: 3.5,
    sound: 0.095,
    begins: 0.18,
    passed: 0.4,
    deep: 0.8,
    cut_off: 0.75,
    lasts_s: 12.0,
    gap_s: 3.0,
    feed_spread: 0.35,
    steady_s: 0.04,
    settles_s: 0.15,
    settled: 0.15,
};
/// The same where a dip tells by its first frames.
const EAGER: RawClog = RawClog { deep: 0.2, ..SETTINGS };
const FEED_M_S: f64 = 1.3e-3;
/// PETG, about.
const SOUND: AdvanceLaw = AdvanceLaw { linear_s: 0.45, shear: 2.4e-2, index: 0.45 };
const STEP_S: f64 = 1e-3;

/// Steps of a millisecond: what the nozzle holds follows `dx/dt = v - u`, `x = rho a u^n + K u`.
struct Melt {
    held_m: f64,
    now_s: f64,
    excess_m: f64,
    driven: Driven,
}

impl Melt {
    /// Steady behind a sound nozzle.
    fn steady() -> Self {
        Self { held_m: SOUND.held_m(FEED_M_S), now_s: 0.0, excess_m: 0.0, driven: Driven::SOUND }
    }

    /// Feed that leaves `[m/s]`, by halving.
    fn outlet_m_s(&self, force: f64) -> f64 {
        let law = AdvanceLaw { shear: SOUND.shear * force, ..SOUND };
        let (mut low, mut high) = (0.0, 0.1);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if law.held_m(middle) < self.held_m { low = middle } else { high = middle }
        }
        low
    }

    /// Runs on for a time behind a nozzle that needs `force` times the melt's force, with a share of the slicer's feed that
    /// reaches the encoder; a frame each half second, from `first_s` on.
    fn run(&mut self, clog: &mut Clog, (lasts_s, first_s): (f64, f64), force: f64, fed: f64) {
        let mut next_s = self.now_s + first_s;
        let until_s = self.now_s + lasts_s;
        while self.now_s < until_s {
            let outlet_m_s = self.outlet_m_s(force);
            self.held_m += (fed * FEED_M_S - outlet_m_s) * STEP_S;
            self.excess_m += (fed - 1.0) * FEED_M_S * STEP_S;
            self.now_s += STEP_S;
            if self.now_s >= next_s {
                next_s += 0.5;
                clog.on_look(self.look(1.0 - outlet_m_s / FEED_M_S), self.ahead());
            }
        }
    }

    /// Trims act as soon as they are sent.
    fn ahead(&self) -> Ahead {
        let now_s = self.now_s;
        Ahead { now_s, acts_s: now_s, excess_m: self.excess_m, driven: self.driven }
    }

    /// What the melt's part of a sound law holds `[m]`.
    fn melt_m(&self) -> f64 {
        SOUND.shear * FEED_M_S.powf(SOUND.index)
    }

    /// The drive comes to hold what the laws say by now.
    fn push(&mut self, clog: &Clog) {
        let driven = Driven { force: clog.factor(), carried_m: clog.carried_m() };
        let more_m = driven.beyond_m(self.melt_m()) - self.driven.beyond_m(self.melt_m());
        (self.held_m, self.excess_m) = (self.held_m + more_m, self.excess_m + more_m);
        self.driven = driven;
    }

    fn look(&self, lacking: f64) -> Look {
        let melt_m = SOUND.shear * FEED_M_S.powf(SOUND.index);
        let (linear_m, index) = (SOUND.linear_s * FEED_M_S, SOUND.index);
        let excess_m = self.excess_m;
        Look { exposed_s: self.now_s, lacking, excess_m, feed_m_s: FEED_M_S, melt_m, linear_m, index }
    }
}

/// A sound road of 2 s, then a nozzle that needs `force` times as much, seen from `first_s` after that on.
fn narrowed(force: f64, first_s: f64) -> (Melt, Clog) {
    let (mut melt, mut clog) = (Melt::steady(), Clog::new(SETTINGS));
    melt.run(&mut clog, (2.0, 0.5), 1.0, 1.0);
    melt.run(&mut clog, (12.0, first_s), force, 1.0);
    (melt, clog)
}

/// Whenever within the frames' half second the nozzle narrows: what it held more, `(rho - 1) a u^n`, was lacking in the roads.
#[test]
fn the_force_of_a_narrowed_nozzle_is_read_off_its_dip() {
    let melt_m = SOUND.shear * FEED_M_S.powf(SOUND.index);
    for force in [1.0 / 0.7, 2.0, 2.5] {
        for first_s in [0.02, 0.15, 0.25, 0.35, 0.48] {
            let (_, clog) = narrowed(force, first_s);
            let error = clog.factor() / force - 1.0;
            assert!(error.abs() < 0.1, "{force} seen after {first_s} s: {}", clog.factor());
            let carried_m = (clog.factor() - 1.0) * melt_m;
            assert!(
                (clog.carried_m() / carried_m - 1.0).abs() < 1e-9,
                "{} of {carried_m} m",
                clog.carried_m()
            );
        }
    }
}

/// A law that has grown, less what is carried, is the sound one's at the feed of the dip, and `rho` times as steep in the melt.
#[test]
fn a_grown_law_pushes_nothing_at_the_feed_of_the_dip() {
    let (_, clog) = narrowed(2.5, 0.25);
    let grown = clog.law(SOUND);
    let pushed_m = grown.held_m(FEED_M_S) - clog.carried_m() - SOUND.held_m(FEED_M_S);
    assert!(pushed_m.abs() < 1e-9, "{pushed_m} m");
    assert!((grown.shear / SOUND.shear - clog.factor()).abs() < 1e-12);
    assert!((grown.linear_s - SOUND.linear_s).abs() < 1e-15);
}

/// The nozzle comes free again: the roads get what was held.
#[test]
fn a_nozzle_that_comes_free_is_followed_back() {
    let (mut melt, mut clog) = narrowed(2.5, 0.25);
    let carried_m = clog.carried_m();
    melt.run(&mut clog, (12.0, 0.25), 1.0, 1.0);
    assert!((clog.factor() - 1.0).abs() < 0.2, "{}", clog.factor());
    assert!(clog.carried_m() < 0.15 * carried_m, "{} of {carried_m} m", clog.carried_m());
}

/// A nozzle that narrows beyond what is followed and comes free again is sound: what it needed is known beside what is followed.
#[test]
fn one_that_was_beyond_comes_free_as_well() {
    let (mut melt, mut clog) = narrowed(7.0, 0.25);
    assert!(clog.is_beyond() && (clog.factor() - SETTINGS.force_max).abs() < 1e-12);
    melt.run(&mut clog, (20.0, 0.25), 7.0, 1.0);
    melt.run(&mut clog, (12.0, 0.25), 1.0, 1.0);
    assert!(!clog.is_beyond() && clog.factor() < 1.5, "{}", clog.factor());
}

/// The road goes over to a fifth more feed in the midst of a dip: one road still.
#[test]
fn a_dip_at_two_feeds_tells_the_same_force() {
    let (mut melt, mut clog) = (Melt::steady(), Clog::new(SETTINGS));
    melt.run(&mut clog, (2.0, 0.5), 1.0, 1.0);
    melt.run(&mut clog, (0.251, 0.25), 2.0, 1.0);
    for _ in 0..12 {
        // Nobody sees it but by the frame at its end.
        melt.run(&mut Clog::new(SETTINGS), (0.5, 9.0), 2.0, 1.2);
        melt.excess_m = 0.0;
        let lacking = 1.0 - melt.outlet_m_s(2.0) / (1.2 * FEED_M_S);
        clog.on_look(Look { feed_m_s: 1.2 * FEED_M_S, ..melt.look(lacking) }, melt.ahead());
    }
    assert!((clog.factor() / 2.0 - 1.0).abs() < 0.1, "{}", clog.factor());
}

/// The road goes over to twice the feed in the midst of a dip: what was seen of its fading tells the force, a lack that has not
/// faded is no dip, and a setting of 0 waits for the next one.
#[test]
fn a_dip_that_another_road_cuts_off_tells_what_was_seen_of_it() {
    let cut_off_at = |force: f64, settings: RawClog| {
        let (mut melt, mut clog) = (Melt::steady(), Clog::new(settings));
        melt.run(&mut clog, (2.0, 0.5), 1.0, 1.0);
        melt.run(&mut clog, (1.2, 0.25), force, 1.0);
        melt.now_s += 0.4;
        clog.on_look(Look { feed_m_s: 2.0 * FEED_M_S, ..melt.look(0.1) }, melt.ahead());
        clog.factor()
    };
    for force in [1.6, 2.0] {
        let told = cut_off_at(force, SETTINGS);
        assert!((told / force - 1.0).abs() < 0.2, "{force}: {told}");
    }
    assert!((cut_off_at(2.0, RawClog { cut_off: 0.0, ..SETTINGS }) - 1.0).abs() < 1e-15);
    let (mut leak, mut melt) = (Clog::new(SETTINGS), Melt::steady());
    for lacking in [0.0, 0.0, 0.25, 0.25] {
        melt.now_s += 0.5;
        leak.on_look(melt.look(lacking), melt.ahead());
    }
    leak.on_look(
        Look { exposed_s: melt.now_s + 0.5, feed_m_s: 2.0 * FEED_M_S, ..melt.look(0.25) },
        melt.ahead(),
    );
    assert!((leak.factor() - 1.0).abs() < 1e-15);
}

/// The law of the sound nozzle pushes at a change of feed, the road that cuts a dip off fills by itself until moves have the new law,
/// 1.5 s later: what it holds then beyond that law is carried.
#[test]
fn what_another_road_comes_to_hold_is_carried() {
    for (settled, times) in [(true, 3.0), (true, 0.6), (false, 3.0)] {
        let (mut melt, mut clog) = (Melt::steady(), Clog::new(SETTINGS));
        melt.run(&mut clog, (2.0, 0.5), 1.0, 1.0);
        melt.run(&mut clog, (1.2, 0.25), 2.0, 1.0);
        let feed_m_s = times * FEED_M_S;
        melt.held_m += SOUND.held_m(feed_m_s) - SOUND.held_m(FEED_M_S);
        melt.run(&mut Clog::new(SETTINGS), (0.4, 9.0), 2.0, times);
        let melt_m = SOUND.shear * feed_m_s.powf(SOUND.index);
        if settled {
            melt.excess_m = 0.0;
            let lacking = 1.0 - melt.outlet_m_s(2.0) / feed_m_s;
            clog.on_look(Look { feed_m_s, melt_m, ..melt.look(lacking) }, melt.ahead());
        } else {
            clog.on_unsettled(feed_m_s, 0.0, melt.ahead());
        }
        melt.run(&mut Clog::new(SETTINGS), (1.1, 9.0), 2.0, times);
        let (carried_m, more_m) = (clog.carried_m(), melt.held_m - SOUND.held_m(feed_m_s));
        assert!((carried_m / more_m - 1.0).abs() < 0.3, "{settled} {times}: {carried_m} of {more_m} m");
    }
}

/// A frame of a faster road cuts it off as well before that road is settled; one of a slower road may be a corner of the same. A
/// dip of a single frame tells no force, and yet that there may be one, unless it is more than can be followed.
#[test]
fn a_faster_road_cuts_a_dip_off_before_it_is_settled() {
    let factor_after = |lasts_s: f64, unsettled: f64| {
        let (mut melt, mut clog) = (Melt::steady(), Clog::new(SETTINGS));
        melt.run(&mut clog, (2.0, 0.5), 1.0, 1.0);
        assert!(clog.doubt() <= 0.0);
        melt.run(&mut clog, (lasts_s, 0.25), 2.0, 1.0);
        clog.on_unsettled(unsettled * FEED_M_S, 0.0, melt.ahead());
        (clog.factor(), clog.doubt(), clog.rest(melt.now_s + 30.0))
    };
    let (told, doubt, rest) = factor_after(1.2, 2.0);
    assert!(
        (told / 2.0 - 1.0).abs() < 0.2 && (doubt - TOLD_DOUBT).abs() < 1e-15 && rest < 1e-3,
        "{told} {rest}"
    );
    let (slower, _, _) = factor_after(1.2, 0.5);
    assert!((slower - 1.0).abs() < 1e-15, "{slower}");
    let (single, doubt, _) = factor_after(0.3, 2.0);
    assert!((single - 1.0).abs() < 1e-15 && (doubt - 1.0).abs() < 1e-15, "{single}");
    let (_, narrow) = narrowed(9.0, 0.25);
    assert!(narrow.is_beyond() && narrow.doubt() <= 0.0);
}

/// The dip is there until it has faded, by its own time constant.
#[test]
fn a_dip_counts_until_it_has_faded() {
    let (mut melt, mut clog) = (Melt::steady(), Clog::new(SETTINGS));
    melt.run(&mut clog, (2.0, 0.5), 1.0, 1.0);
    assert!(clog.rest(melt.now_s).abs() < 1e-15);
    melt.run(&mut clog, (1.0, 0.25), 2.5, 1.0);
    assert!(clog.rest(melt.now_s) > 0.3, "{}", clog.rest(melt.now_s));
    melt.run(&mut clog, (4.0, 0.25), 2.5, 1.0);
    let lacks = 1.0 - melt.outlet_m_s(2.5) / FEED_M_S;
    let rest = clog.rest(melt.now_s);
    assert!((0.5 * lacks..2.0 * lacks).contains(&rest), "{rest}, lacks {lacks}");
    assert!(clog.rest(melt.now_s + 20.0) < 1e-3);
}

impl Clog {
    /// As if the nozzle had been seen to need more than what is followed, or not.
    pub(crate) fn set_beyond(&mut self, beyond: bool) {
        self.needed = if beyond { 2.0 * self.settings.force_max } else { 1.0 };
    }
}
