//! Drives, polymers and test line of `config/advance/physics.yaml`.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::drive::{Condition, Drive, DriveKind, Polymer};
use super::line::TestLine;
use super::virtual_line::{Best, VirtualLine};
use crate::command::AdvanceLaw;
use crate::units::Seconds;

/// The block `advance_physics`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Physics {
    /// Test line.
    pub test_line: TestLine,
    /// Drives.
    pub drives: Drives,
    /// Polymers by name.
    pub polymers: BTreeMap<String, Polymer>,
}

/// Both drives.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drives {
    /// On the frame.
    pub bowden: Drive,
    /// On the hot end.
    pub direct: Drive,
}

impl Physics {
    /// A drive.
    #[must_use]
    pub fn drive(&self, kind: DriveKind) -> &Drive {
        match kind {
            DriveKind::Bowden => &self.drives.bowden,
            DriveKind::Direct => &self.drives.direct,
        }
    }

    /// The virtual test line; `None` for a polymer that is not known.
    #[must_use]
    pub fn line(&self, kind: DriveKind, polymer: &str, at: &Condition, step: Seconds) -> Option<VirtualLine> {
        let polymer = self.polymers.get(polymer)?;
        Some(VirtualLine::new(self.drive(kind), polymer, at, &self.test_line, step))
    }

    /// The compensation that prints the test line best; `None` for a polymer that is not known.
    #[must_use]
    pub fn best(&self, kind: DriveKind, polymer: &str, at: &Condition, step: Seconds) -> Option<Best> {
        self.line(kind, polymer, at, step)?.best()
    }

    /// A compensation as a law over the feed: the drive's own, scaled so that `advance` is its secant between the speeds
    /// of the test line. One `K_A` holds at one speed alone; `None` for a polymer that is not known.
    #[must_use]
    pub fn law(
        &self,
        kind: DriveKind,
        polymer: &str,
        at: &Condition,
        advance: Seconds,
    ) -> Option<AdvanceLaw> {
        let law = self.drive(kind).law(self.polymers.get(polymer)?, at);
        Some(law.advance().scaled(advance.0 / self.secant_s(kind, polymer, at)?))
    }

    /// The same in closed form, within 2 %: the secant of the static law between the speeds of the test line `[s]`.
    #[must_use]
    pub fn secant_s(&self, kind: DriveKind, polymer: &str, at: &Condition) -> Option<f64> {
        let speeds_m_s = (self.test_line.low_m_s, self.test_line.high_m_s);
        Some(self.drive(kind).secant_s(self.polymers.get(polymer)?, at, speeds_m_s))
    }
}
