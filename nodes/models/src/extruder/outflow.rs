//! Flow of an outlet behind compressed filament, as one number that may run dry.

use super::law::{Pressure, StaticLaw};
use crate::units::Seconds;

/// Longest step of the compressed length `[s]`: a stroke of pressure advance takes some 40 ms.
const STEP_MAX_S: f64 = 5e-3;

impl StaticLaw {
    /// Flow `[m/s]` after `dt` under a constant filament speed `[m/s]`.
    ///
    /// Below zero a flow stands for the filament that is missing until the chamber is full again, `dry_lag` times the flow: a
    /// retraction is taken back by the same length.
    #[must_use]
    pub fn flow_after(&self, flow_m_s: f64, filament_m_s: f64, dt: Seconds, dry_lag: Seconds) -> f64 {
        let mut pressure = if flow_m_s > 0.0 {
            Pressure::steady(self, flow_m_s)
        } else {
            Pressure::dry(-flow_m_s * dry_lag.0)
        };
        let count = (dt.0 / STEP_MAX_S).ceil().max(1.0);
        let step = Seconds(dt.0 / count);
        let mut done = 0.0;
        while done < count {
            pressure.step(self, filament_m_s, step);
            done += 1.0;
        }
        let missing_m = pressure.compression_m();
        if missing_m < 0.0 { missing_m / dry_lag.0 } else { pressure.outlet().speed_m_s }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::bowden;
    use super::*;
    use crate::material::tests::pla;
    use crate::melt::Melt;
    use crate::units::Kelvin;

    const DRY_LAG: Seconds = Seconds(0.63);
    const ROOM: Kelvin = Kelvin(298.15);

    fn melting(nozzle_k: f64) -> Option<StaticLaw> {
        let melt = Melt::new(&pla(), &bowden());
        StaticLaw::of_melting((&melt, &bowden()), (Kelvin(nozzle_k), ROOM), (6e-4, 2.4e-3))
    }

    /// At 2.4 mm/s the melt is 2.4 K colder and its force 7 % higher: met there, and within 4 % in between.
    #[test]
    fn one_power_law_stands_for_a_melt_that_flow_cools() {
        let (melt, law) = (Melt::new(&pla(), &bowden()), melting(483.15).unwrap());
        for (outlet_m_s, off) in [(6e-4, 1e-12), (1.2e-3, 0.045), (1.8e-3, 0.045), (2.4e-3, 1e-12)] {
            let flow_m3_s = outlet_m_s * melt.filament_area_m2();
            let temp = melt.melt_temperature(Kelvin(483.15), ROOM, flow_m3_s);
            assert!((law.force_n(outlet_m_s) / melt.force_n(flow_m3_s, temp) - 1.0).abs() < off);
        }
        assert!(law.force_n(2.4e-3) > 1.05 * melt.force_n(2.4e-3 * melt.filament_area_m2(), Kelvin(483.15)));
        assert_eq!(melting(1.0), None, "frozen");
    }

    /// 3 mm back and forth in 0.2 s, 40 mm/s: what was not laid meanwhile is compressed again.
    #[test]
    fn a_stroke_that_runs_dry_is_taken_back_by_its_length() {
        let law = melting(483.15).unwrap();
        let after =
            |flow_m_s, filament_m_s, dt_s| law.flow_after(flow_m_s, filament_m_s, Seconds(dt_s), DRY_LAG);
        let dry = after(2e-3, -0.04, 0.075);
        assert!(dry < 0.0);
        assert!((after(dry, 0.0, 10.0) - dry).abs() < 1e-12, "nothing flows, so nothing fades");
        let back = after(dry, 0.04, 0.075);
        assert!(back < 2e-3 && back > 1.8e-3, "{back}");
        // a steady feed is its own flow
        assert!((after(1.5e-3, 1.5e-3, 0.02) - 1.5e-3).abs() < 1e-12);
        assert!((after(back, 2e-3, 20.0) - 2e-3).abs() < 1e-9);
    }
}
