//! Controller profile of the wire process: corrects feed and head speed from measured layer heights (model book 3.3).
//!
//! What was measured of layer k corrects layer k+1 at the same place, and nothing else does: an older measurement would
//! count a layer twice and halve the range of stable gains. Where there is none, or an old one, the answer is neutral
//! and the process runs at its planned speeds.
//!
//! [`WireControl`] makes a loop of it: heights and states of the machine in, a command per tick out, which goes through
//! the supervisor like any other ([`WireTrims::trims`]).

use models::command::Trims;
use models::params::{ParamError, in_range, positive};
use models::units::Seconds;
use models::wire::{Law, Limits, Mode};
use serde::Deserialize;
use std::collections::BTreeMap;

mod control;

pub use control::{LoopParams, RawLoop, WireControl, WireEvent, WireLevel, WireReport};

/// The profile. Built only from valid [`RawParams`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawParams")]
pub struct Params(RawParams);

/// The `wire_controller` block of `config/wire/controller.yaml` as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawParams {
    /// Which speeds are moved.
    pub mode: Mode,
    /// Length over which samples are averaged `[m]`, in `[1e-4, 1]`: about a drop.
    pub cell_m: f64,
    /// Oldest measurement that is used `[s]`, above 0: longer than a layer takes.
    pub valid_s: f64,
    /// Largest distance of a height from the plan that is believed `[m]`, above 0.
    pub error_max_m: f64,
}

impl TryFrom<RawParams> for Params {
    type Error = ParamError;

    fn try_from(raw: RawParams) -> Result<Self, ParamError> {
        in_range("cell_m", raw.cell_m, "m", (1e-4, 1.0))?;
        in_range("valid_s", raw.valid_s, "s", (0.1, 1e5))?;
        in_range("error_max_m", raw.error_max_m, "m", (1e-9, 0.1))?;
        Ok(Self(raw))
    }
}

/// A measured height of the wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// When it was measured.
    pub stamp: Seconds,
    /// Layer that was measured, from 1.
    pub layer: u32,
    /// Place along the path of a layer `[m]`.
    pub position_m: f64,
    /// Height of the wall above its base `[m]`.
    pub height_m: f64,
}

/// Why a measurement was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// A value that is no number.
    NotFinite,
    /// A height farther from the plan than is believed.
    OutOfRange,
    /// Of a layer before the newest one of its place, or of layer 0.
    OldLayer,
}

/// Numbers of refused measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Refusals {
    /// Values that were no numbers.
    pub not_finite: u64,
    /// Heights out of range.
    pub out_of_range: u64,
    /// Old layers.
    pub old_layer: u64,
}

/// Corrections relative to the planned speeds `[-]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WireTrims {
    /// Speed of the wire.
    pub wire: f64,
    /// Speed of the head.
    pub head: f64,
    /// Whether a limit took something away.
    pub limited: bool,
}

impl WireTrims {
    /// The planned speeds.
    pub const NEUTRAL: Self = Self { wire: 1.0, head: 1.0, limited: false };

    /// The same as a command: flow is wire per path, speed is the head's.
    #[must_use]
    pub fn trims(&self) -> Trims {
        Trims { flow: self.wire / self.head, speed: self.head, ..Trims::NEUTRAL }
    }
}

/// What the profile answers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Answer {
    /// Corrections.
    Correct(WireTrims),
    /// Nothing was measured of the layer below at this place: the planned speeds.
    Unmeasured,
    /// What was measured is older than allowed: the planned speeds.
    Stale,
}

impl Answer {
    /// What to run at.
    #[must_use]
    pub fn trims(&self) -> WireTrims {
        match self {
            Self::Correct(trims) => *trims,
            Self::Unmeasured | Self::Stale => WireTrims::NEUTRAL,
        }
    }
}

/// Mean of what was measured of one layer over one cell.
#[derive(Debug, Clone, Copy)]
struct Cell {
    layer: u32,
    newest: Seconds,
    sum_m: f64,
    count: u32,
}

/// The brain of the profile.
#[derive(Debug, Clone)]
pub struct HeightController {
    params: RawParams,
    law: Law,
    limits: Limits,
    cells: BTreeMap<i64, Cell>,
    refusals: Refusals,
}

impl HeightController {
    /// Nothing measured yet.
    ///
    /// # Errors
    /// [`ParamError::OutOfRange`] for a gain outside (0, 2): from layer to layer the error would grow.
    pub fn new(params: Params, law: Law, limits: Limits) -> Result<Self, ParamError> {
        positive("gain", law.gain, "-")?;
        if law.gain >= 2.0 {
            let rule = "in (0, 2), or the height error grows from layer to layer".to_owned();
            return Err(ParamError::OutOfRange { name: "gain", value: law.gain, unit: "-", rule });
        }
        Ok(Self::unchecked(params, law, limits))
    }

    /// As [`HeightController::new`] with any gain of the law: for simulations that show where it fails.
    #[must_use]
    pub fn unchecked(params: Params, law: Law, limits: Limits) -> Self {
        Self { params: params.0, law, limits, cells: BTreeMap::new(), refusals: Refusals::default() }
    }

    /// Numbers of refused measurements.
    #[must_use]
    pub fn refusals(&self) -> Refusals {
        self.refusals
    }

    /// Takes a measurement in.
    ///
    /// # Errors
    /// [`Refused`]; it is counted too.
    pub fn on_height(&mut self, measured: Measured) -> Result<(), Refused> {
        let taken = self.take(measured);
        match taken {
            Ok(()) => {}
            Err(Refused::NotFinite) => self.refusals.not_finite += 1,
            Err(Refused::OutOfRange) => self.refusals.out_of_range += 1,
            Err(Refused::OldLayer) => self.refusals.old_layer += 1,
        }
        taken
    }

    fn take(&mut self, measured: Measured) -> Result<(), Refused> {
        if ![measured.stamp.0, measured.position_m, measured.height_m].iter().all(|value| value.is_finite()) {
            return Err(Refused::NotFinite);
        }
        let error_m = measured.height_m - f64::from(measured.layer) * self.law.height_m;
        if error_m.abs() > self.params.error_max_m {
            return Err(Refused::OutOfRange);
        }
        let index = self.index(measured.position_m);
        let fresh = Cell { layer: measured.layer, newest: measured.stamp, sum_m: error_m, count: 1 };
        let cell = self.cells.entry(index).or_insert(Cell { count: 0, sum_m: 0.0, ..fresh });
        match measured.layer.cmp(&cell.layer) {
            _ if measured.layer == 0 => return Err(Refused::OldLayer),
            std::cmp::Ordering::Less => return Err(Refused::OldLayer),
            std::cmp::Ordering::Greater => *cell = fresh,
            std::cmp::Ordering::Equal => {
                cell.newest = measured.stamp;
                cell.sum_m += error_m;
                cell.count += 1;
            }
        }
        Ok(())
    }

    #[allow(clippy::cast_possible_truncation, reason = "a saturated place is a place too")]
    fn index(&self, position_m: f64) -> i64 {
        (position_m / self.params.cell_m).floor() as i64
    }

    /// Corrections for laying `layer` at a place.
    #[must_use]
    pub fn answer(&self, now: Seconds, layer: u32, position_m: f64) -> Answer {
        let below =
            self.cells.get(&self.index(position_m)).filter(|cell| cell.layer.checked_add(1) == Some(layer));
        let Some(cell) = below else { return Answer::Unmeasured };
        let age_s = now.0 - cell.newest.0;
        if age_s.is_nan() || age_s > self.params.valid_s {
            return Answer::Stale;
        }
        let height_m = self.law.height_m + cell.sum_m / f64::from(cell.count);
        match self.law.correct_within(self.params.mode, &self.limits, height_m) {
            Ok(speeds) => Answer::Correct(WireTrims {
                wire: speeds.wire_m_s / self.law.wire_m_s,
                head: speeds.head_m_s / self.law.head_m_s,
                limited: speeds.limited,
            }),
            // Only sums of finite errors stand in a cell; what is no height all the same is not measured.
            Err(_) => Answer::Unmeasured,
        }
    }
}

#[cfg(test)]
mod tests;
