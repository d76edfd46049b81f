//! Share of the wanted flow that leaves a sound nozzle: less while pressure builds up, more while it fades (model book 2.1).
//!
//! Where no advance is in force roads are thin after every start, and nothing is wrong with the printer. What the nominal
//! melt lays of the filament that was commanded, advance included, is held against what the plan wanted there. A printer
//! that tells often enough tells itself what it commanded; of one that seldom tells the coming moves do.

mod shares;
#[cfg(test)]
mod tests;

use crate::layer::Nominal;
use models::extruder::StaticLaw;
use models::melt::Melt;
use models::motion::{MoveKind, Segment};
use models::params::{ParamError, in_range, ordered};
use models::status::PrinterStatus;
use models::units::{Kelvin, Seconds};
use serde::Deserialize;
use shares::Shares;

/// Step along a move `[s]`: a tenth of a short lag.
const STEP_S: f64 = 0.02;
/// Moves that follow each other within this follow at once: the plan's time is told in steps `[s]`.
const JOINT_S: f64 = 0.1;
/// Rest between two moves after which the nozzle is at rest too, whatever lay between them `[s]`.
const REST_MAX_S: f64 = 10.0;
/// Steps along one move at most: a move of some minutes.
const MOVE_STEPS_MAX: f64 = 10_000.0;

/// How the commanded filament is followed. Built only from a valid [`RawPressure`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawPressure")]
pub struct PressureParams(RawPressure);

/// The `pressure` block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawPressure {
    /// How long shares are kept: longer than a frame is under way `[s]`.
    pub kept_s: f64,
    /// Statuses farther apart do not show how the filament moved in between: the moves have to tell `[s]`.
    pub gap_max_s: f64,
    /// More filament between two statuses is a new count, not a move `[m]`.
    pub jump_max_m: f64,
    /// The law is exact at the fastest feed and at this share of it `[-]`.
    pub slow_rel: f64,
    /// Smallest and largest share that is believed `[-]`.
    pub share: [f64; 2],
    /// What the law may err by, of what it takes off or adds `[-]`.
    pub unsure: f64,
}

impl TryFrom<RawPressure> for PressureParams {
    type Error = ParamError;

    fn try_from(raw: RawPressure) -> Result<Self, ParamError> {
        in_range("pressure.kept_s", raw.kept_s, "s", (0.1, 60.0))?;
        in_range("pressure.gap_max_s", raw.gap_max_s, "s", (0.005, 1.0))?;
        in_range("pressure.jump_max_m", raw.jump_max_m, "m", (1e-4, 1.0))?;
        in_range("pressure.slow_rel", raw.slow_rel, "-", (0.01, 0.9))?;
        in_range("pressure.share[0]", raw.share[0], "-", (0.1, 1.0))?;
        in_range("pressure.share[1]", raw.share[1], "-", (1.0, 3.0))?;
        in_range("pressure.unsure", raw.unsure, "-", (0.0, 1.0))?;
        ordered(("pressure.share[0]", raw.share[0]), ("pressure.share[1]", raw.share[1]))?;
        Ok(Self(raw))
    }
}

/// Filament that flows, and what of it was wanted.
#[derive(Debug, Clone)]
struct Followed {
    flow_m_s: f64,
    /// Time `[s]` and wanted filament `[m]`, advance included, at which it stands.
    at: Option<(f64, f64)>,
    shares: Shares,
}

impl Followed {
    fn new(kept_s: f64) -> Self {
        Self { flow_m_s: 0.0, at: None, shares: Shares::new(kept_s) }
    }

    /// Not known what became of the filament.
    fn forget(&mut self) {
        *self = Self::new(self.shares.kept_s());
    }
}

/// Flow of a sound nozzle. Knows no clock.
#[derive(Debug, Clone)]
pub(crate) struct NominalFlow {
    params: RawPressure,
    nominal: Nominal,
    ambient: Kelvin,
    melt: Melt,
    /// The law, with the set-point and the fastest feed `[m/s]` that it was made for.
    law: Option<(StaticLaw, Kelvin, f64)>,
    fastest_m_s: f64,
    newest: Option<PrinterStatus>,
    /// As the statuses tell, over their stamps.
    told: Followed,
    /// As the moves tell, over the plan's own time.
    planned: Followed,
}

impl NominalFlow {
    /// A nozzle that rests.
    pub(crate) fn new(params: PressureParams, nominal: Nominal, ambient: Kelvin) -> Self {
        Self {
            params: params.0,
            melt: Melt::new(&nominal.material, &nominal.printer.extruder),
            nominal,
            ambient,
            law: None,
            fastest_m_s: 0.0,
            newest: None,
            told: Followed::new(params.0.kept_s),
            planned: Followed::new(params.0.kept_s),
        }
    }

    /// Share of the wanted flow that left the nozzle then, `path_s` along the plan; 1 where it is not known.
    pub(crate) fn share(&self, laid: Seconds, path_s: Option<f64>) -> f64 {
        let gap_s = self.params.gap_max_s;
        let planned = || path_s.and_then(|path_s| self.planned.shares.at(path_s, gap_s));
        let share = self.told.shares.at(laid.0, gap_s).or_else(planned);
        share.map_or(1.0, |share| share.clamp(self.params.share[0], self.params.share[1]))
    }

    /// Width over that of a sound nozzle which lays this share `[-]`; `ratio` is the width over the wanted one. What the
    /// law may err by explains a difference: then it is 1.
    pub(crate) fn beside_sound(&self, ratio: f64, share: f64) -> f64 {
        let unsure = self.params.unsure * (1.0 - share).abs();
        ratio / ratio.clamp(share - unsure, share + unsure)
    }

    /// Follows the filament wanted since the last status.
    pub(crate) fn on_status(&mut self, status: &PrinterStatus) {
        self.newest = Some(*status);
        let (stamp_s, wanted_m) = (status.stamp.0, status.wanted_position_m);
        let Some((before_s, before_m)) = self.told.at else {
            self.told.at = Some((stamp_s, wanted_m));
            return;
        };
        let (dt_s, moved_m) = (stamp_s - before_s, wanted_m - before_m);
        if dt_s.is_nan() || dt_s <= 0.0 {
            return;
        }
        if moved_m.is_nan() || moved_m.abs() > self.params.jump_max_m || dt_s > self.params.gap_max_s {
            self.told.forget();
            self.told.at = Some((stamp_s, wanted_m));
            return;
        }
        self.told.at = Some((stamp_s, wanted_m));
        let wanted_m_s = status.planned_feed_m_s * status.trims.speed * status.trims.flow;
        if status.depositing {
            self.fastest_m_s = self.fastest_m_s.max(wanted_m_s);
        }
        let Some(law) = self.law(Kelvin::from(status.hotend_target)) else { return };
        let lag = Seconds(self.nominal.material.lag_s);
        self.told.flow_m_s = law.flow_after(self.told.flow_m_s, moved_m / dt_s, Seconds(dt_s), lag);
        let share = status.depositing.then(|| self.told.flow_m_s.max(0.0) / wanted_m_s);
        self.told.shares.keep(stamp_s, share);
    }

    /// Follows the filament of a move that begins `path_s` along the plan, under the corrections told last.
    pub(crate) fn on_move(&mut self, path_s: f64, segment: &Segment) {
        let Some(status) = self.newest else { return };
        let (per_path, deposits) = (segment.filament_per_path(), segment.kind == MoveKind::Deposit);
        let (pace, flow) = (status.trims.speed, status.trims.flow);
        if !per_path.is_finite() {
            return;
        }
        if deposits {
            let feed_m_s = segment.profile.cruise_m_s * per_path * pace * flow;
            self.fastest_m_s = self.fastest_m_s.max(feed_m_s);
        }
        let Some(law) = self.law(Kelvin::from(status.hotend_target)) else { return };
        let lag = Seconds(self.nominal.material.lag_s);
        let planned = &mut self.planned;
        let (end_s, mut ahead_m) = planned.at.unwrap_or((path_s, 0.0));
        let mut begin_s = path_s.max(end_s);
        if !path_s.is_finite() || path_s < end_s - JOINT_S || path_s > end_s + REST_MAX_S {
            planned.forget();
            (begin_s, ahead_m) = (path_s, 0.0);
        } else if path_s > end_s + JOINT_S {
            let rest_s = (path_s - end_s) / pace;
            planned.flow_m_s = law.flow_after(planned.flow_m_s, -ahead_m / rest_s, Seconds(rest_s), lag);
            ahead_m = 0.0;
        }
        let duration_s = segment.profile.duration().0;
        let count = (duration_s / STEP_S).ceil().clamp(1.0, MOVE_STEPS_MAX);
        let step_s = duration_s / count;
        let mut done = 0.0;
        while done < count && step_s > 0.0 {
            let state = segment.profile.at(Seconds((done + 0.5) * step_s));
            let wanted_m_s = state.speed_m_s * per_path * pace * flow;
            let wanted_ahead_m = if deposits { status.advance_s * wanted_m_s } else { 0.0 };
            let moved_m = wanted_m_s * step_s / pace + wanted_ahead_m - ahead_m;
            ahead_m = wanted_ahead_m;
            let dt = Seconds(step_s / pace);
            planned.flow_m_s = law.flow_after(planned.flow_m_s, moved_m / dt.0, dt, lag);
            done += 1.0;
            let share = deposits.then(|| planned.flow_m_s.max(0.0) / wanted_m_s);
            planned.shares.keep(begin_s + done * step_s, share);
        }
        planned.at = Some((begin_s + duration_s, ahead_m));
    }

    /// The law at a set-point, made anew where it or the fastest feed has changed.
    fn law(&mut self, nozzle: Kelvin) -> Option<StaticLaw> {
        let made = self.law.filter(|(_, of, fastest_m_s)| *of == nozzle && *fastest_m_s >= self.fastest_m_s);
        if made.is_none() && self.fastest_m_s > 0.0 {
            let outlets_m_s = (self.params.slow_rel * self.fastest_m_s, self.fastest_m_s);
            let extruder = &self.nominal.printer.extruder;
            let law = StaticLaw::of_melting((&self.melt, extruder), (nozzle, self.ambient), outlets_m_s);
            self.law = law.map(|law| (law, nozzle, self.fastest_m_s));
            return law;
        }
        made.map(|(law, ..)| law)
    }
}
