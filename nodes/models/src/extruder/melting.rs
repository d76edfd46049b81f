//! Law of a melt that flow cools, where a compressed length drives it: temperature and outlet follow from each other.

use super::Extruder;
use super::law::{Outlet, StaticLaw};
use crate::melt::Melt;
use crate::units::Kelvin;

/// Relative step at which Newton's quadratic convergence has used up the digits that matter: what is left is its square.
const TOLERANCE: f64 = 1e-5;
/// Steps at most; one or two are the rule from a warm start.
const STEPS: usize = 60;

/// A nozzle that melts what passes it, `T_m = T_f + (T_n - T_f)(1 - exp(-q_c/q))` (model book 1.2).
#[derive(Debug, Clone, Copy)]
pub struct Melting<'a> {
    /// Material in the nozzle.
    pub melt: &'a Melt,
    /// Whose nozzle it is.
    pub extruder: &'a Extruder,
    /// Nozzle.
    pub nozzle: Kelvin,
    /// Incoming filament.
    pub filament: Kelvin,
    /// Share of the nozzle that is free, kappa in `(0, 1]`.
    pub clog: f64,
    /// Flow that is melted per outlet speed `[m2]`, > 0: the filament's area, more where a part of it leaks away.
    pub area_m2: f64,
}

impl Melting<'_> {
    /// Law at the temperature of the melt that leaves at `outlet_m_s`, 0 or more.
    #[must_use]
    pub fn law_at(&self, outlet_m_s: f64) -> StaticLaw {
        StaticLaw::new(self.melt, self.extruder, self.temp_at(outlet_m_s), self.clog)
    }

    /// Law where `compression_m` of filament is held, that of the outlet `u` `[m/s]` at which
    /// `a(T_m(u)) u^n + K_lin u = x`; the left side rises with it. `warm_m_s` is an outlet nearby, or 0.
    ///
    /// The temperature of the flow just before will not do for the next one: where the force of a melt that flow cools grows
    /// faster than `u^(2n)`, thick and thin would take turns from step to step for ever.
    #[must_use]
    pub fn law_holding(&self, compression_m: f64, warm_m_s: f64) -> StaticLaw {
        // A melt as hot as the nozzle lets the most through.
        let most_m_s = || self.law_at(0.0).outlet(compression_m, Outlet::STILL).speed_m_s;
        let mut outlet_m_s = if warm_m_s > 0.0 { warm_m_s } else { most_m_s() };
        if compression_m <= 0.0 || outlet_m_s <= 0.0 {
            return self.law_at(0.0);
        }
        let (mut low_m_s, mut high_m_s) = (0.0, f64::INFINITY);
        for _ in 0..STEPS {
            let (held_m, lag_s) = self.held_at(outlet_m_s);
            let change_m_s = (compression_m - held_m) / lag_s;
            let next_m_s = outlet_m_s + change_m_s;
            if change_m_s.abs() <= TOLERANCE * outlet_m_s {
                return self.law_at(next_m_s);
            }
            (low_m_s, high_m_s) =
                if change_m_s < 0.0 { (low_m_s, outlet_m_s) } else { (outlet_m_s, high_m_s) };
            let is_between = low_m_s < next_m_s && next_m_s < high_m_s;
            outlet_m_s = if is_between { next_m_s } else { 0.5 * (low_m_s + high_m_s) };
        }
        self.law_at(outlet_m_s)
    }

    fn temp_at(&self, outlet_m_s: f64) -> Kelvin {
        self.melt.melt_temperature(self.nozzle, self.filament, outlet_m_s * self.area_m2)
    }

    /// Compressed length x `[m]` at an outlet speed `[m/s]` above 0, and how it grows with that, dx/du `[s]`.
    fn held_at(&self, outlet_m_s: f64) -> (f64, f64) {
        let (compliance_m_n, linear_lag_s) = (self.extruder.compliance_m_n, self.extruder.linear_lag_s);
        let (temp, index) = (self.temp_at(outlet_m_s), self.melt.flow_index());
        let steep = index + self.melt.cooling_index(self.nozzle, temp, outlet_m_s * self.area_m2);
        let sheared_m = compliance_m_n * self.melt.force_scale(temp) / self.clog * outlet_m_s.powf(index);
        (sheared_m + linear_lag_s * outlet_m_s, steep * sheared_m / outlet_m_s + linear_lag_s)
    }
}

#[cfg(test)]
mod tests {
    use super::super::law::Pressure;
    use super::super::tests::bowden;
    use super::*;
    use crate::material::tests::pla;
    use crate::units::Seconds;

    const SETTLED_MS: u32 = 20_000;

    fn melting<'a>((melt, extruder): (&'a Melt, &'a Extruder), clog: f64) -> Melting<'a> {
        let area_m2 = melt.filament_area_m2();
        Melting { melt, extruder, nozzle: Kelvin(483.15), filament: Kelvin(298.15), clog, area_m2 }
    }

    #[test]
    fn what_an_outlet_holds_drives_that_outlet_from_any_start() {
        let (extruder, melt) = (bowden(), Melt::new(&pla(), &bowden()));
        for clog in [1.0, 0.2] {
            let melting = melting((&melt, &extruder), clog);
            for outlet_m_s in [1e-6, 1e-4, 1e-3, 3e-3, 6e-3, 1e-2] {
                let held_m = melting.law_at(outlet_m_s).compression_m(outlet_m_s);
                for warm_m_s in [0.0, 1e-5, 0.99 * outlet_m_s, 1e-3, 0.1] {
                    let found = melting.law_holding(held_m, warm_m_s);
                    let off = found.outlet(held_m, Outlet::STILL).speed_m_s / outlet_m_s - 1.0;
                    assert!(off.abs() < 1e-8, "{outlet_m_s} from {warm_m_s}: {off}");
                }
            }
            assert_eq!(melting.law_holding(-1e-3, 1e-3), melting.law_at(0.0), "dry");
        }
    }

    /// A change below the last place is one that is found.
    #[test]
    fn what_is_short_by_rounding_alone_is_the_same() {
        let (extruder, melt) = (bowden(), Melt::new(&pla(), &bowden()));
        let melting = melting((&melt, &extruder), 1.0);
        for step in 0..1000 {
            let outlet_m_s = 1e-3 + 4e-6 * f64::from(step);
            let held_m = melting.held_at(outlet_m_s).0.next_down();
            let found = melting.law_holding(held_m, outlet_m_s);
            assert!((found.compression_m(outlet_m_s) / held_m - 1.0).abs() < 1e-9, "{outlet_m_s}");
        }
    }

    /// How far a steady feed's outlet is off at last `[-]`, of 1 % at first, each millisecond under the law that `next` tells.
    fn left(melting: &Melting, feed_m_s: f64, next: impl Fn(&Pressure) -> StaticLaw) -> f64 {
        let mut pressure = Pressure::steady(&melting.law_at(feed_m_s), 1.01 * feed_m_s);
        for _ in 0..SETTLED_MS {
            pressure.step(&next(&pressure), feed_m_s, Seconds(1e-3));
        }
        (pressure.outlet().speed_m_s / feed_m_s - 1.0).abs()
    }

    /// 12 mm3/s of PLA, whose force grows with flow to the power of 1.5.
    #[test]
    fn a_fast_flow_is_steady() {
        let (extruder, melt) = (bowden(), Melt::new(&pla(), &bowden()));
        let melting = melting((&melt, &extruder), 1.0);
        let outlet_m_s = |pressure: &Pressure| pressure.outlet().speed_m_s;
        let follows = left(&melting, 5e-3, |at| melting.law_holding(at.compression_m(), outlet_m_s(at)));
        assert!(follows < 1e-6, "{follows}");
        let late = left(&melting, 5e-3, |at| melting.law_at(outlet_m_s(at)));
        assert!(late > 0.1, "with the temperature of the flow before: {late}");
    }
}
