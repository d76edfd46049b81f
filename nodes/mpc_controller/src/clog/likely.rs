//! The force that a nozzle needs since it has narrowed, by how well the dip that each one would leave fits the frames.
//!
//! At a feed v a sound nozzle holds `a u^n + K u` compressed, u its outlet. One that needs `rho` times the melt's force lets less
//! through at first, for it holds the same, and goes on by `d/dt (rho a u^n + K u) = v - u`, v what passes the encoder. When it
//! narrowed nobody saw: between the last sound frame and the first of the dip. One that comes free is a `rho` below one.

use super::dip::{Ahead, Look};

/// Largest force over that of the melt that is looked for, and one over the least `[-]`; steps of 6 % between.
const FORCE_MAX: f64 = 12.0;
const FORCES: u32 = 85;
/// Moments at which the nozzle may have narrowed, between two frames.
const MOMENTS: u32 = 6;
/// Scatter of the share that lacks in a frame `[-]`.
const SCATTER: f64 = 0.04;
/// Largest mean square of what no force explains, in the scatter, at which frames tell of one.
const MISFIT_MAX: f64 = 4.0;
/// A sum of squares by which the force that fits best has to fit better than a sound nozzle: that is a million times as likely
/// before any frame, `2 ln 1e6` `[-]`.
const EVIDENCE: f64 = 27.6;
/// A sum of squares so far beyond that weighs nothing beside one that fits.
const HOPELESS: f64 = 60.0;
/// Step of the integration `[s]`: a tenth of the shortest lag.
const STEP_S: f64 = 0.02;
/// Least outlet over the feed at which the lag is taken `[-]`: it grows beyond any bound towards rest.
const OUTLET_MIN: f64 = 0.02;
/// Halvings of the interval of an outlet over the feed.
const HALVINGS: u32 = 20;

/// What the frames of a dip tell of the nozzle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Likely {
    /// Force over that before `[-]`.
    pub(super) force: f64,
    /// Share of what it comes to hold more that it holds when a law can act `[-]`, 0 to 1.
    pub(super) share: f64,
}

impl Likely {
    /// The mean over what is open, of forces by their logarithm, each as likely beforehand as the others; `None` where none fits,
    /// or a sound nozzle and the noise of widths may have been it.
    pub(super) fn of(sound: Look, dip: &[Look], ahead: Ahead) -> Option<Self> {
        let gap_s = dip.first()?.exposed_s - sound.exposed_s;
        let runs: Vec<Run> = (0..FORCES * MOMENTS)
            .map(|run| {
                let power = 2.0 * f64::from(run / MOMENTS) / f64::from(FORCES - 1) - 1.0;
                let began_s = gap_s * (f64::from(run % MOMENTS) + 0.5) / f64::from(MOMENTS);
                Run::of(sound, dip, (FORCE_MAX.powf(power), sound.exposed_s + began_s), ahead)
            })
            .collect();
        let least = runs.iter().map(|run| run.misfit).fold(f64::INFINITY, f64::min);
        let unchanged = Run::of(sound, dip, (1.0, sound.exposed_s), ahead).misfit;
        if least > MISFIT_MAX * frames(dip) || unchanged < least + EVIDENCE {
            return None;
        }
        let (mut weight, mut logarithm, mut share) = (0.0, 0.0, 0.0);
        for run in runs {
            let likely = (0.5 * (least - run.misfit)).exp();
            weight += likely;
            logarithm += likely * run.force.ln();
            share += likely * run.share;
        }
        Some(Self { force: (logarithm / weight).exp(), share: share / weight })
    }
}

fn frames(dip: &[Look]) -> f64 {
    dip.iter().map(|_| 1.0).sum()
}

/// What a force from a moment on would have left.
#[derive(Debug, Clone, Copy)]
struct Run {
    force: f64,
    /// Sum of squares of what the frames lack beside it, in their scatter `[-]`.
    misfit: f64,
    share: f64,
}

impl Run {
    fn of(sound: Look, dip: &[Look], (force, began_s): (f64, f64), ahead: Ahead) -> Self {
        let mut nozzle = Nozzle::narrowed(sound, force, began_s);
        let (mut last, mut misfit) = (sound, 0.0);
        let hopeless = HOPELESS + MISFIT_MAX * frames(dip);
        for look in dip {
            // What slipped before the nozzle narrowed lacks since.
            let excess_m_s = (look.excess_m - last.excess_m) / (look.exposed_s - nozzle.now_s);
            nozzle.run((look.feed_m_s + excess_m_s) / sound.feed_m_s, look.exposed_s);
            let lacks = 1.0 - nozzle.outlet * sound.feed_m_s / look.feed_m_s;
            misfit += ((look.lacking - lacks) / SCATTER).powi(2);
            if misfit > hopeless {
                return Self { force, misfit, share: nozzle.share() };
            }
            last = *look;
        }
        let fed = last.feed_m_s / sound.feed_m_s;
        let since_s = ahead.now_s - nozzle.now_s;
        if since_s > 0.0 {
            let excess = (ahead.excess_m - last.excess_m) / (since_s * sound.feed_m_s);
            nozzle.run(fed + excess, ahead.now_s);
        }
        nozzle.run(fed, ahead.acts_s);
        Self { force, misfit, share: nozzle.share() }
    }
}

/// A nozzle since it has narrowed.
#[derive(Debug, Clone, Copy)]
struct Nozzle {
    sound: Look,
    force: f64,
    now_s: f64,
    /// Over the feed before `[-]`.
    outlet: f64,
}

impl Nozzle {
    /// It holds the same still: `force a w^n + K w = a u^n + K u`.
    fn narrowed(sound: Look, force: f64, began_s: f64) -> Self {
        let mut nozzle = Self { sound, force, now_s: began_s, outlet: 0.0 };
        let (mut low, mut high) = (0.0, force.recip().max(1.0).powf(sound.index.recip()));
        for _ in 0..HALVINGS {
            nozzle.outlet = 0.5 * (low + high);
            if nozzle.more_m() < 0.0 { low = nozzle.outlet } else { high = nozzle.outlet }
        }
        nozzle
    }

    /// Follows a feed over that before until `until_s`.
    fn run(&mut self, fed: f64, until_s: f64) {
        while self.now_s < until_s {
            let dt_s = STEP_S.min(until_s - self.now_s);
            self.outlet = fed + (self.outlet - fed) * (-dt_s / self.lag_s()).exp();
            self.now_s += dt_s;
        }
    }

    /// `rho a n u^(n-1) + K` at the present outlet `[s]`.
    fn lag_s(&self) -> f64 {
        let Look { melt_m, linear_m, index, feed_m_s, .. } = self.sound;
        let steep = index * self.outlet.max(OUTLET_MIN).powf(index - 1.0);
        (self.force * melt_m * steep + linear_m) / feed_m_s
    }

    /// Filament that it holds more than the sound one did `[m]`.
    fn more_m(&self) -> f64 {
        let Look { melt_m, linear_m, index, .. } = self.sound;
        let outlet = self.outlet.max(0.0);
        melt_m * (self.force * outlet.powf(index) - 1.0) + linear_m * (outlet - 1.0)
    }

    /// The same over what that comes to at the feed of before `[-]`, 0 to 1.
    fn share(&self) -> f64 {
        let whole_m = (self.force - 1.0) * self.sound.melt_m;
        if whole_m == 0.0 { 1.0 } else { (self.more_m() / whole_m).clamp(0.0, 1.0) }
    }
}
