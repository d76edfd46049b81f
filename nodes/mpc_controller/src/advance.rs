//! Which pressure advance is sent: the foretold `K_A`, changed where a change disturbs least.
//!
//! The drive holds `K_A v` of filament compressed. While a road is laid a change of `K_A` pushes
//! `d(K_A v)/dt = v dK_A/dt` beside the feed: the relative width error of a straight is the slew itself, `[s/s]`. At a
//! corner the wrong `K_A` costs more: a change of speed `dv` leaves `(K - K_A) dv` of filament out of place. So a change
//! is slow on a straight, fast while a turn is foreseen, so that it is over before the speed falls, and at once where
//! nothing is laid (`v = 0`). It never slows the tool.
//!
//! A host that executes trims of coming moves gets the foretold law, or the melt's own, over the feed with each of them
//! instead, times the factor that widths taught: then no `K_A` changes while a road is laid. One behind which a change
//! acts half a second and more late gets the material's constant: what was meant for a pause of the filament would come
//! in the midst of a road.

use crate::params::{AdvanceSource, Level, RawAdvance};
use attached::Attached;
pub(crate) use attached::{Driven, Sent};
use fit::Learnt;
pub(crate) use learning::Nozzle;
use learning::{Learning, SLOW_M_S};
use models::command::AdvanceLaw;
use models::status::{HostProfile, PrinterStatus};
use models::units::Seconds;

mod attached;
mod fit;
pub(crate) mod learning;

/// Who foretold a `K_A`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Basis {
    /// Networks, inside of their data.
    Network,
    /// The physical model, outside of them.
    Physics,
}

/// A `K_A` foretold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foretold {
    /// `K_A` `[s]`, 0 or more.
    pub advance_s: f64,
    /// Half width of its 95 % interval `[s]`, 0 or more.
    pub half_width_s: f64,
    /// The same over the feed.
    pub law: AdvanceLaw,
    /// Who says so.
    pub basis: Basis,
}

/// The next turn of the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// Probability that there is one within the predictor's horizon `[0, 1]`.
    pub probability: f64,
    /// The probability is above the predictor's threshold.
    pub expected: bool,
    /// Time until it begins `[s]`, 0 or more.
    pub lead: Seconds,
}

/// A word of the advance predictor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// Time of validity.
    pub stamp: Seconds,
    /// `K_A`; `None` where the conditions are not known or out of bounds.
    pub advance: Option<Foretold>,
    /// The next turn; `None` before the first move.
    pub turn: Option<Turn>,
}

impl Prediction {
    pub(crate) fn is_valid(&self) -> bool {
        let size = |value: f64| value.is_finite() && value >= 0.0;
        self.stamp.0.is_finite()
            && self.advance.is_none_or(|k| size(k.advance_s) && size(k.half_width_s) && k.law.is_valid())
            && self.turn.is_none_or(|turn| (0.0..=1.0).contains(&turn.probability) && size(turn.lead.0))
    }
}

/// Whether a host executes trims with the moves that they belong to.
fn attaches(host: HostProfile) -> bool {
    matches!(host, HostProfile::Native | HostProfile::Serial)
}

impl AdvanceSource {
    /// What is in force where this one is asked for: the file's own under a level that corrects nothing, the material's
    /// constant behind a host that attaches nothing to moves.
    #[must_use]
    pub fn in_force(self, level: Level, host: HostProfile) -> Self {
        if level == Level::Off { Self::File } else { self.behind(host) }
    }

    fn behind(self, host: HostProfile) -> Self {
        match self {
            Self::Planned | Self::Predicted if !attaches(host) => Self::Material,
            source => source,
        }
    }
}

/// What became of the predictions, for diagnostics.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AdvanceReport {
    /// Newest advance sent `[s]`; `None` leaves the file's own.
    pub sent_s: Option<f64>,
    /// Commands without a foretold advance, since it was missing, stale or doubtful.
    pub without: u64,
    /// Commands that hurried a change since a turn was foreseen.
    pub hurried: u64,
    /// Laws of coming moves that were held to `law_high_s`.
    pub bounded: u64,
    /// Learnt factor on the foretold advance `[-]`.
    pub learnt: f64,
    /// Learnt offset of the melt's flow index `[-]`.
    pub learnt_index: f64,
}

/// The advance over time.
#[derive(Debug, Clone)]
pub(crate) struct Advance {
    settings: RawAdvance,
    newest: Option<Prediction>,
    held_s: Option<f64>,
    at_s: f64,
    learning: Learning,
    report: AdvanceReport,
}

impl Advance {
    pub(crate) fn new(settings: RawAdvance, level: Level) -> Self {
        Self {
            settings,
            newest: None,
            held_s: None,
            at_s: 0.0,
            learning: Learning::new(settings.learning_at(level)),
            report: AdvanceReport::default(),
        }
    }

    pub(crate) fn newest_stamp(&self) -> Option<Seconds> {
        self.newest.map(|newest| newest.stamp)
    }

    pub(crate) fn report(&self) -> AdvanceReport {
        let Learnt { factor, index, .. } = self.learning.learnt();
        AdvanceReport { learnt: factor, learnt_index: index, ..self.report }
    }

    pub(crate) fn on_prediction(&mut self, prediction: Prediction) {
        self.newest = Some(prediction);
    }

    /// Follows feed and outlet, for what frames will show of them. `melt` is the nominal law of melt and filament now, `None`
    /// while it is not known, in the nozzle that there is. Returns how much more a planned law holds at this feed by what was
    /// learnt since `[m]`: the nozzle holds what it holds already.
    pub(crate) fn on_status(
        &mut self,
        status: &PrinterStatus,
        melt: Option<AdvanceLaw>,
        nozzle: Nozzle,
    ) -> f64 {
        let foretold = match self.settings.source {
            AdvanceSource::Planned => melt.map(|law| Foretold {
                advance_s: law.advance_s(status.planned_feed_m_s.max(SLOW_M_S)),
                half_width_s: 0.0,
                law,
                basis: Basis::Physics,
            }),
            _ => self.foretold(status.stamp.0),
        };
        let grown_m = foretold.map(|foretold| self.learning.on_status(status, &foretold, nozzle));
        grown_m.filter(|_| self.settings.source == AdvanceSource::Planned).unwrap_or(0.0)
    }

    /// A width; how much more a nozzle that has narrowed is known to hold since then `[m]`.
    pub(crate) fn on_width(&mut self, exposed: Seconds, width_m: f64) -> f64 {
        match self.settings.source {
            AdvanceSource::Planned | AdvanceSource::Predicted => self.learning.on_width(exposed.0, width_m),
            _ => 0.0,
        }
    }

    /// Forgets what is held: nothing is printed. What was learnt of the printer stays.
    pub(crate) fn rest(&mut self) {
        self.held_s = None;
    }

    /// Moves that were sent with a trim.
    pub(crate) fn attached(&self) -> &Attached {
        self.learning.attached()
    }

    /// The same, to send more of them, or anew.
    pub(crate) fn attached_mut(&mut self) -> &mut Attached {
        self.learning.attached_mut()
    }

    /// What the drive holds now for a nozzle that has narrowed.
    pub(crate) fn driven(&self, status: &PrinterStatus) -> Driven {
        self.learning.driven(status)
    }

    /// Follows the moves that were sent: the fastest feed of the one under way `[m/s]`; `None` before the first.
    pub(crate) fn on_move(&mut self, status: &PrinterStatus) -> Option<f64> {
        self.learning.on_move(status)
    }

    /// The foretold law for a coming move, with what was learnt; `None` where it is missing, stale or doubtful.
    pub(crate) fn law(&self, now_s: f64) -> Option<AdvanceLaw> {
        Some(self.with_learnt(self.foretold(now_s)?.law))
    }

    /// A law with what was learnt of the printer.
    pub(crate) fn with_learnt(&self, law: AdvanceLaw) -> AdvanceLaw {
        self.learning.learnt().of(law)
    }

    /// Force of the melt over its nominal one `[-]`, as far as widths told of a planned law: what is held compressed is
    /// proportional to it.
    pub(crate) fn stiffness(&self) -> f64 {
        if self.settings.source == AdvanceSource::Planned { self.learning.learnt().force() } else { 1.0 }
    }

    /// Force of the melt over that of the nozzle as its dip left it, learnt since `[-]`.
    pub(crate) fn narrowing(&self) -> f64 {
        let learnt = self.learning.learnt();
        learnt.force() / learnt.factor
    }

    /// Factor on a law so that it may be sent: within `law_high_s` at the feed at which the supervisor looks.
    pub(crate) fn bound(&mut self, law: AdvanceLaw) -> f64 {
        let (advance_s, high_s) = (law.advance_s(self.settings.law_feed_m_s), self.settings.law_high_s);
        if advance_s <= high_s {
            return 1.0;
        }
        self.report.bounded += 1;
        high_s / advance_s
    }

    /// The advance to send at `now_s`, from `low_s` to `high_s`; `nominal_s` is the material's constant.
    pub(crate) fn command(&mut self, now_s: f64, status: &PrinterStatus, nominal_s: f64) -> Option<f64> {
        self.report.sent_s = match self.settings.source.behind(status.host) {
            AdvanceSource::None => Some(0.0),
            AdvanceSource::File => None,
            AdvanceSource::Material | AdvanceSource::Planned => {
                Some(nominal_s.clamp(self.settings.low_s, self.settings.high_s))
            }
            AdvanceSource::Predicted => self.predicted(now_s, status),
        };
        self.report.sent_s
    }

    /// What was foretold; `None` where it is missing, stale or doubtful.
    fn foretold(&self, now_s: f64) -> Option<Foretold> {
        let newest = self.newest.filter(|newest| now_s - newest.stamp.0 <= self.settings.age_limit_s)?;
        let foretold = newest.advance?;
        let sure = foretold.half_width_s <= self.settings.doubt_max * foretold.advance_s;
        sure.then_some(foretold)
    }

    fn predicted(&mut self, now_s: f64, status: &PrinterStatus) -> Option<f64> {
        let dt_s = (now_s - self.at_s).max(0.0);
        self.at_s = now_s;
        let Some(Foretold { advance_s: foretold_s, .. }) = self.foretold(now_s) else {
            self.report.without += 1;
            self.held_s = None;
            return None;
        };
        let goal_s =
            (foretold_s * self.learning.learnt().factor).clamp(self.settings.low_s, self.settings.high_s);
        let before_s = self.held_s.filter(|_| status.depositing && status.planned_feed_m_s > 0.0);
        let next_s = before_s.map_or(goal_s, |before_s| {
            let turn = self.turn_comes(now_s);
            let slew = if turn { self.settings.turn_slew_s_s } else { self.settings.straight_slew_s_s };
            let most_s = slew * dt_s;
            let change_s = goal_s - before_s;
            self.report.hurried += u64::from(turn && change_s.abs() > self.settings.straight_slew_s_s * dt_s);
            before_s + change_s.clamp(-most_s, most_s)
        });
        self.held_s = Some(next_s);
        Some(next_s)
    }

    fn turn_comes(&self, now_s: f64) -> bool {
        let Some(newest) = self.newest else { return false };
        let age_s = now_s - newest.stamp.0;
        newest.turn.is_some_and(|turn| {
            turn.expected && age_s <= turn.lead.0 && turn.lead.0 - age_s <= self.settings.turn_lead_s
        })
    }
}

#[cfg(test)]
pub(crate) mod tests;
