//! Test lines to train with: the grid of Table 1 and more, printed by the virtual test line, scored with noise.

use super::ensemble::Hull;
use super::measured::Factor;
use crate::network::chance::Stream;
use models::advance::published::Published;
use models::advance::{Condition, DriveKind, Physics, Polymer};
use models::params::{ParamError, in_range, ordered};
use models::units::{Celsius, Seconds};
use serde::Deserialize;

/// How data are made. Built only from a valid [`RawData`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawData")]
pub struct DataParams(RawData);

/// The block `data` of `config/models/advance_training.yaml` as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawData {
    /// Step of the temperatures `[K]`.
    pub temperature_step_k: f64,
    /// Layer heights `[m]`.
    pub heights_m: Vec<f64>,
    /// Line widths `[m]`.
    pub widths_m: Vec<f64>,
    /// Step of the virtual printer `[s]`.
    pub step_s: f64,
    /// Scoring of Bowden lines.
    pub bowden: Scoring,
    /// Scoring of direct lines.
    pub direct: Scoring,
    /// Share of the lines at inner temperatures that are never trained with.
    pub held_out_share: f64,
    /// Conditions anywhere in the hull that the interval is fitted with.
    pub calibration: u32,
    /// Conditions anywhere in the hull that only figures are taken from.
    pub anywhere: u32,
}

/// How a person scores a printed pattern.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scoring {
    /// Standard deviation `[s]`.
    pub sigma_s: f64,
    /// Step between two lines of the pattern, to which a score is rounded `[s]`.
    pub reading_s: f64,
}

impl TryFrom<RawData> for DataParams {
    type Error = ParamError;

    fn try_from(raw: RawData) -> Result<Self, ParamError> {
        in_range("data.temperature_step_k", raw.temperature_step_k, "K", (0.1, 50.0))?;
        rising("data.heights_m", &raw.heights_m, (1e-5, 5e-3))?;
        rising("data.widths_m", &raw.widths_m, (1e-5, 1e-2))?;
        in_range("data.step_s", raw.step_s, "s", (1e-5, 1e-2))?;
        for scoring in [raw.bowden, raw.direct] {
            in_range("data.sigma_s", scoring.sigma_s, "s", (0.0, 1.0))?;
            in_range("data.reading_s", scoring.reading_s, "s", (1e-5, 1.0))?;
        }
        in_range("data.held_out_share", raw.held_out_share, "-", (0.01, 0.9))?;
        in_range("data.calibration", f64::from(raw.calibration), "-", (20.0, 1e5))?;
        in_range("data.anywhere", f64::from(raw.anywhere), "-", (1.0, 1e5))?;
        Ok(Self(raw))
    }
}

/// Two or more values in a range, each above the one before: they are the ends and the steps of a grid.
fn rising(name: &'static str, values_m: &[f64], range_m: (f64, f64)) -> Result<(), ParamError> {
    #[expect(clippy::cast_precision_loss, reason = "a small count")]
    in_range(name, values_m.len() as f64, "values", (2.0, 1000.0))?;
    for value_m in values_m {
        in_range(name, *value_m, "m", range_m)?;
    }
    values_m.windows(2).try_for_each(|pair| ordered((name, pair[0]), (name, pair[1])))
}

/// What a line is used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Use {
    /// Training.
    Train,
    /// Figures alone.
    HeldOut,
    /// The interval: held out of training beside own lines.
    Interval,
    /// The paper prints a value for it: left to the comparison with that.
    Published,
}

impl Use {
    /// Name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::HeldOut => "held_out",
            Self::Interval => "interval",
            Self::Published => "published",
        }
    }
}

/// One test line.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Polymer.
    pub polymer: String,
    /// Condition.
    pub at: Condition,
    /// A person's printer over the physical model, which the compensations hold already `[-]`; 1 without own lines.
    pub factor: f64,
    /// The best compensation, without noise `[s]`.
    pub true_s: f64,
    /// The same as scored `[s]`.
    pub scored_s: f64,
    /// Whether Table 1 has it.
    pub in_table: bool,
    /// What it is used for.
    pub purpose: Use,
}

/// All lines of a drive.
#[derive(Debug, Clone, PartialEq)]
pub struct DataSet {
    /// Drive.
    pub drive: DriveKind,
    /// The grid.
    pub lines: Vec<Line>,
    /// Anywhere in the hull, for the interval.
    pub calibration: Vec<Line>,
    /// Anywhere in the hull, for figures.
    pub anywhere: Vec<Line>,
}

impl DataSet {
    /// Lines of all uses.
    #[must_use]
    pub fn count(&self) -> usize {
        self.lines.len() + self.calibration.len() + self.anywhere.len()
    }

    /// The same lines on a person's printer. Those that come to lie outside of the drive's range are left out.
    #[must_use]
    pub fn scaled(&self, factor: &Factor, [low_s, high_s]: [f64; 2]) -> Self {
        let scaled = |lines: &[Line]| -> Vec<Line> {
            let lines = lines.iter().map(|line| {
                let factor = factor.at(&line.polymer, &line.at);
                let (true_s, scored_s) = (factor * line.true_s, factor * line.scored_s);
                Line { factor, true_s, scored_s, ..line.clone() }
            });
            let within = |value_s: f64| (low_s..=high_s).contains(&value_s);
            lines.filter(|line| within(line.true_s) && within(line.scored_s)).collect()
        };
        let mut lines = scaled(&self.lines);
        if factor.lines() > 0 {
            give_to_interval(&mut lines);
        }
        Self {
            drive: self.drive,
            lines,
            calibration: scaled(&self.calibration),
            anywhere: scaled(&self.anywhere),
        }
    }
}

/// Gives every other line held out to the interval: networks err most at the edges of the data, where the grid has many
/// lines and conditions anywhere are few.
fn give_to_interval(lines: &mut [Line]) {
    let held_out = lines.iter_mut().filter(|line| line.purpose == Use::HeldOut);
    held_out.step_by(2).for_each(|line| line.purpose = Use::Interval);
}

impl DataParams {
    /// Standard deviation of a score `[s]`: of the eye, and of a step of the pattern within which it may lie anywhere.
    pub(super) fn noise_s(&self, drive: DriveKind) -> f64 {
        let Scoring { sigma_s, reading_s } = self.scoring(drive);
        sigma_s.hypot(reading_s / 12.0_f64.sqrt())
    }

    fn scoring(&self, drive: DriveKind) -> Scoring {
        match drive {
            DriveKind::Bowden => self.0.bowden,
            DriveKind::Direct => self.0.direct,
        }
    }

    /// Step of the virtual printer.
    #[must_use]
    pub fn step(&self) -> Seconds {
        Seconds(self.0.step_s)
    }

    /// Ranges of the grid for a polymer.
    #[must_use]
    pub fn hull(&self, polymer: &Polymer) -> Hull {
        let range = |values: &[f64]| {
            let fold = |of: fn(f64, f64) -> f64, start| values.iter().copied().fold(start, of);
            [fold(f64::min, f64::INFINITY), fold(f64::max, 0.0)]
        };
        Hull {
            temperature_c: polymer.range_c,
            height_m: range(&self.0.heights_m),
            width_m: range(&self.0.widths_m),
        }
    }

    /// Prints and scores all lines of a drive.
    #[must_use]
    pub fn generate(&self, drive: DriveKind, physics: &Physics, published: &Published, seed: u64) -> DataSet {
        let mut chance = Stream::new(seed);
        let mut lines = vec![];
        for (name, polymer) in &physics.polymers {
            for at in self.grid(polymer) {
                let [low_c, high_c] = polymer.range_c;
                let inner = at.temperature.0 > low_c + 1e-6 && at.temperature.0 < high_c - 1e-6;
                let held_out = chance.uniform() < self.0.held_out_share;
                let purpose = match (is_published(published, drive, name, &at), inner && held_out) {
                    (true, _) => Use::Published,
                    (false, true) => Use::HeldOut,
                    (false, false) => Use::Train,
                };
                lines.extend(self.print(drive, physics, (name, at, purpose), &mut chance));
            }
        }
        let mut random = |count: u32, purpose: Use| -> Vec<Line> {
            let names: Vec<(&String, &Polymer)> = physics.polymers.iter().collect();
            let line = |_| {
                let (name, polymer) = names.get(chance.place(names.len()))?;
                let hull = self.hull(polymer);
                let at = Condition {
                    temperature: Celsius(chance.between(hull.temperature_c.into())),
                    height_m: chance.between(hull.height_m.into()),
                    width_m: chance.between(hull.width_m.into()),
                };
                self.print(drive, physics, (name, at, purpose), &mut chance)
            };
            (0..count).filter_map(line).collect()
        };
        let calibration = random(self.0.calibration, Use::Train);
        let anywhere = random(self.0.anywhere, Use::HeldOut);
        DataSet { drive, lines, calibration, anywhere }
    }

    fn grid(&self, polymer: &Polymer) -> Vec<Condition> {
        let [low_c, high_c] = polymer.range_c;
        let mut grid = vec![];
        for step in 0_u32.. {
            let temperature = Celsius(low_c + f64::from(step) * self.0.temperature_step_k);
            if temperature.0 > high_c + 1e-6 {
                break;
            }
            for height_m in &self.0.heights_m {
                for width_m in &self.0.widths_m {
                    grid.push(Condition { temperature, height_m: *height_m, width_m: *width_m });
                }
            }
        }
        grid
    }

    fn print(
        &self,
        drive: DriveKind,
        physics: &Physics,
        (name, at, purpose): (&str, Condition, Use),
        chance: &mut Stream,
    ) -> Option<Line> {
        let true_s = physics.best(drive, name, &at, self.step())?.advance_s;
        let scoring = self.scoring(drive);
        let noisy_s = true_s + scoring.sigma_s * chance.normal();
        let scored_s = (noisy_s / scoring.reading_s).round() * scoring.reading_s;
        // Table 1 varies the width at its highest layer alone.
        let in_table = (at.width_m - 4e-4).abs() < 1e-9 || (at.height_m - 4e-4).abs() < 1e-9;
        Some(Line { polymer: name.to_owned(), at, factor: 1.0, true_s, scored_s, in_table, purpose })
    }
}

/// Whether the paper prints a value for this condition.
fn is_published(published: &Published, drive: DriveKind, polymer: &str, at: &Condition) -> bool {
    polymer == published.polymer
        && (at.temperature.0 - published.temperature_c).abs() < 1e-6
        && (at.width_m - published.width_m).abs() < 1e-9
        && published.points.iter().any(|p| p.drive == drive && (p.height_m - at.height_m).abs() < 1e-9)
}
