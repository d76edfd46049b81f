//! The nominal process as plan, controller and printer believe it: `config/wire/process.yaml`.

use serde::Deserialize;

use super::drop::radius_m;
use super::melting::wire_volume_m3;
use super::{Feed, Law, Limits};
use crate::params::{ParamError, in_range};

/// The `wire_process` block. Read only where its parts fit each other.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawProcess")]
pub struct Process {
    /// Name of the metal, a block of `config/wire/materials.yaml`.
    pub material: String,
    /// Wire and power.
    pub feed: Feed,
    /// Planned layer, planned speeds and the correction law.
    pub law: Law,
    /// What drives and laser can do.
    pub limits: Limits,
}

/// The block as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawProcess {
    /// As in [`Process`].
    pub material: String,
    /// As in [`Process`].
    pub feed: Feed,
    /// As in [`Process`].
    pub law: Law,
    /// As in [`Process`].
    pub limits: Limits,
}

/// Part by which planned height and speeds may differ from what the wire makes of itself: losses, rounded figures.
const BALANCE: f64 = 0.1;

impl TryFrom<RawProcess> for Process {
    type Error = ParamError;

    fn try_from(raw: RawProcess) -> Result<Self, ParamError> {
        let RawProcess { material, feed, law, limits } = raw;
        in_range("law.wire_m_s", law.wire_m_s, "m/s", (limits.wire_low_m_s, limits.wire_high_m_s))?;
        in_range("law.head_m_s", law.head_m_s, "m/s", (limits.head_low_m_s, limits.head_high_m_s))?;
        let drop_m = radius_m(wire_volume_m3(feed.diameter_m, feed.drop_length_m));
        balanced(("law.height_m", law.height_m, "m"), drop_m, "height of a drop of `feed`")?;
        // A drop's length of wire makes a pitch of the head: spacing times the drop's radius.
        let wire_m_s = law.head_m_s * feed.drop_length_m / (feed.spacing * drop_m);
        balanced(("law.wire_m_s", law.wire_m_s, "m/s"), wire_m_s, "wire that `feed` lays at law.head_m_s")?;
        Ok(Self { material, feed, law, limits })
    }
}

/// Passes a planned value near what the mass balance makes it.
fn balanced(
    (name, value, unit): (&'static str, f64, &'static str),
    balance: f64,
    what: &str,
) -> Result<(), ParamError> {
    if (value / balance - 1.0).abs() <= BALANCE {
        return Ok(());
    }
    let rule = format!("within {:.0} % of {balance:.6}, the {what} (mass balance)", 100.0 * BALANCE);
    Err(ParamError::OutOfRange { name, value, unit, rule })
}

#[cfg(test)]
mod tests {
    use super::super::{RawFeed, RawLaw, RawLimits};
    use super::*;
    use proptest::prelude::*;

    const LAW: RawLaw = RawLaw {
        height_m: 2.16e-3,
        wire_m_s: 3.5e-3,
        head_m_s: 1.68e-3,
        gain: 0.635,
        split: 2.0 / 3.0,
        ratio_low: 0.2,
        ratio_high: 1.8,
    };

    fn process(law: RawLaw) -> Result<Process, ParamError> {
        let feed = RawFeed { diameter_m: 3e-3, drop_length_m: 3e-3, absorbed_w: 64.885, spacing: 2.0 / 3.0 };
        let limits = RawLimits {
            wire_low_m_s: 0.5e-3,
            wire_high_m_s: 5.4e-3,
            head_low_m_s: 0.5e-3,
            head_high_m_s: 10e-3,
        };
        Process::try_from(RawProcess {
            material: "aluminium".into(),
            feed: Feed::try_from(feed)?,
            law: Law::try_from(law)?,
            limits: Limits::try_from(limits)?,
        })
    }

    /// A thousand times the head, ten times the layer, 29 % more wire: nothing of it is what this wire lays.
    #[test]
    fn a_plan_that_machine_or_mass_balance_forbid_is_refused() {
        assert!(process(LAW).is_ok());
        for (law, parts) in [
            (RawLaw { head_m_s: 1.68, ..LAW }, ["law.head_m_s = 1.68 m/s", "must be in [0.0005, 0.01]"]),
            (RawLaw { height_m: 0.0216, ..LAW }, ["law.height_m = 0.0216 m", "mass balance"]),
            (RawLaw { wire_m_s: 4.5e-3, ..LAW }, ["law.wire_m_s = 0.0045 m/s", "mass balance"]),
        ] {
            let said = process(law).unwrap_err().to_string();
            assert!(parts.iter().all(|part| said.contains(part)), "{said}");
        }
    }

    proptest! {
        /// Where the plan itself lies within the limits, limits only take away from the law: no command goes beyond it.
        #[test]
        fn no_command_lays_a_section_beyond_the_laws(
            height_m in -5e-3..9e-3_f64,
            wire_high_m_s in 3.5e-3..6e-3_f64,
            head_low_m_s in 0.3e-3..1.68e-3_f64,
        ) {
            let law = Law::try_from(LAW).unwrap();
            let limits = RawLimits { wire_low_m_s: 0.5e-3, wire_high_m_s, head_low_m_s, head_high_m_s: 2e-3 };
            let limits = Limits::try_from(limits).unwrap();
            for mode in [super::super::Mode::Both, super::super::Mode::Wire, super::super::Mode::Head] {
                let ratio = law.correct_within(mode, &limits, height_m).unwrap().section_ratio;
                prop_assert!((0.2 - 1e-9..=1.8 + 1e-9).contains(&ratio), "{mode:?} {ratio}");
            }
        }
    }
}
