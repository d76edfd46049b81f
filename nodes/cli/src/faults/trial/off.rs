//! Behind SAFE_OFF and ESTOP nothing is heated: not by the printer's orders, and not by a switch that no order reaches.

use super::Reaction;
use crate::sim::printing::Printing;
use models::units::{Celsius, Kelvin};

/// How long it is looked at behind the reaction `[s]`.
pub(in crate::faults) const WATCHED_S: f64 = 10.0;
/// Time in which the printer carries the order out `[s]`: its heaters' loop runs ten times a second.
const CARRIED_OUT_S: f64 = 0.3;
/// How far the block may rise all the same: the heat of a cartridge on its way `[K]`.
pub(in crate::faults) const BLOCK_RISE_MAX_K: f64 = 3.0;
/// How far the bed may: one whose heater sticks gains 2.7 K while it is looked at `[K]`.
pub(in crate::faults) const BED_RISE_MAX_K: f64 = 1.0;

/// What is hot at a moment.
#[derive(Debug, Clone, Copy)]
struct Heat {
    block_c: f64,
    bed_c: f64,
    /// Ordered, with the mains on `[0, 1]`.
    duty: f64,
}

impl Heat {
    fn of(printing: &Printing) -> Self {
        let (truth, status) = (printing.simulator().truth(), printing.simulator().status());
        let duty = status.hotend_duty.max(status.bed_duty);
        Self {
            block_c: Celsius::from(Kelvin(truth.block_k)).0,
            bed_c: Celsius::from(Kelvin(truth.bed_k)).0,
            duty: if printing.simulator().mains_on() { duty } else { 0.0 },
        }
    }
}

/// Looks on from the reaction on.
#[derive(Debug, Default)]
pub(super) struct Off {
    at_first: Option<Heat>,
}

impl Off {
    /// Looks `behind_s` after a reaction; what is heated although nothing should be.
    pub(super) fn look(&mut self, reaction: Reaction, behind_s: f64, printing: &Printing) -> Option<String> {
        if reaction < Reaction::SafeOff {
            return None;
        }
        let now = Heat::of(printing);
        self.judge(behind_s, now)
    }

    fn judge(&mut self, behind_s: f64, now: Heat) -> Option<String> {
        let at_first = *self.at_first.get_or_insert(now);
        let heats = behind_s > CARRIED_OUT_S && now.duty > 0.0;
        let (block_k, bed_k) = (now.block_c - at_first.block_c, now.bed_c - at_first.bed_c);
        if heats {
            Some(format!("a duty of {:.2} behind the reaction", now.duty))
        } else if block_k > BLOCK_RISE_MAX_K || bed_k > BED_RISE_MAX_K {
            Some(format!("warmer by {:.1} K behind the reaction", block_k.max(bed_k)))
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_ordered_or_warms_behind_the_reaction_is_too_much() {
        let heat = |block_c: f64, bed_c: f64, duty: f64| Heat { block_c, bed_c, duty };
        for (behind_s, now, told) in [
            (0.05, heat(210.0, 60.0, 1.0), false),
            (0.25, heat(210.0, 60.0, 1.0), false),
            (0.35, heat(210.0, 60.0, 0.01), true),
            (5.0, heat(212.0, 60.0, 0.0), false),
            (5.0, heat(214.0, 60.0, 0.0), true),
            (5.0, heat(180.0, 60.9, 0.0), false),
            (5.0, heat(180.0, 61.1, 0.0), true),
        ] {
            let mut off = Off::default();
            assert_eq!(off.judge(0.0, heat(210.0, 60.0, 1.0)), None);
            assert_eq!(off.judge(behind_s, now).is_some(), told, "{behind_s} s, {now:?}");
        }
    }
}
