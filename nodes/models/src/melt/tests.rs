use super::*;
use crate::extruder::tests::bowden;
use crate::material::tests::pla;
use proptest::prelude::*;

fn melt() -> Melt {
    Melt::new(&pla(), &bowden())
}

/// Model book 1.3: eta(764 1/s) = 167.7 Pa s, F(4.8 mm3/s) = 13.9 N, q_max at margin 1 15.8 and at 0.8 14.5 mm3/s.
#[test]
fn the_reference_row_of_pla() {
    let (melt, temp) = (melt(), Kelvin(483.15));
    assert!((melt.viscosity_pa_s(4.8e-9, temp) - 167.65).abs() < 0.05);
    assert!((melt.force_n(4.8e-9, temp) - 13.86).abs() < 0.05);
    for (margin, flow_mm3_s) in [(1.0, 15.8), (0.8, 14.5)] {
        let flow = melt.flow_max_m3_s(temp, Kelvin(298.15), margin);
        assert!((flow * 1e9 - flow_mm3_s).abs() < 0.05, "{} mm3/s", flow * 1e9);
    }
}

/// Model book 1.2: 1.136 at n = 0.4.
#[test]
fn the_rabinowitsch_flag_raises_the_pressure_and_the_inverse_follows() {
    let corrected =
        Extruder::try_from(crate::extruder::RawExtruder { rabinowitsch: true, ..*bowden() }).unwrap();
    let with = Melt::new(&pla(), &corrected);
    let temp = Kelvin(483.15);
    let ratio = with.pressure_pa(4.8e-9, temp) / melt().pressure_pa(4.8e-9, temp);
    assert!((ratio - 1.136).abs() < 5e-4);
    let back = with.flow_m3_s(with.pressure_pa(4.8e-9, temp), temp);
    assert!((back / 4.8e-9 - 1.0).abs() < 1e-6);
}

#[test]
fn the_cooling_index_is_the_slope_of_the_consistency() {
    let (melt, nozzle, filament) = (melt(), Kelvin(483.15), Kelvin(298.15));
    for flow_m3_s in [4e-9, 8e-9, 1.2e-8, 4e-8] {
        let temp = |flow_m3_s| melt.melt_temperature(nozzle, filament, flow_m3_s);
        let consistency = |flow_m3_s| melt.consistency_pa_sn(temp(flow_m3_s)).ln();
        let slope =
            (consistency(1.001 * flow_m3_s) - consistency(flow_m3_s / 1.001)) / (2.0 * 1.001_f64.ln());
        let told = melt.cooling_index(nozzle, temp(flow_m3_s), flow_m3_s);
        assert!((told - slope).abs() < 1e-4 * slope.max(1e-2), "{told} for {slope} at {flow_m3_s} m3/s");
    }
}

#[test]
fn no_pressure_drives_no_flow() {
    for pressure_pa in [0.0, -1e6] {
        assert!(melt().flow_m3_s(pressure_pa, Kelvin(483.15)).abs() < f64::EPSILON);
    }
}

proptest! {
    #[test]
    fn consistency_falls_with_temperature(temp_k in 400.0..560.0_f64, warmer_k in 0.1..50.0_f64) {
        let melt = melt();
        prop_assert!(melt.consistency_pa_sn(Kelvin(temp_k + warmer_k)) < melt.consistency_pa_sn(Kelvin(temp_k)));
    }

    #[test]
    fn pressure_and_flow_are_inverse(flow_mm3_s in 1e-3..50.0_f64, temp_k in 440.0..540.0_f64) {
        let melt = melt();
        let flow = flow_mm3_s * 1e-9;
        let back = melt.flow_m3_s(melt.pressure_pa(flow, Kelvin(temp_k)), Kelvin(temp_k));
        prop_assert!((back / flow - 1.0).abs() < 1e-6);
    }

    #[test]
    fn pressure_is_8_eta_l_q_over_pi_r4(flow_mm3_s in 0.1..50.0_f64, temp_k in 440.0..540.0_f64) {
        let (melt, flow) = (melt(), flow_mm3_s * 1e-9);
        let poiseuille = 8.0 * melt.viscosity_pa_s(flow, Kelvin(temp_k)) * 4.5e-3 * flow / (PI * 2e-4_f64.powi(4));
        prop_assert!((melt.pressure_pa(flow, Kelvin(temp_k)) / poiseuille - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_largest_flow_sits_on_the_force_limit(nozzle_k in 465.0..510.0_f64, margin in 0.2..1.0_f64) {
        let (melt, nozzle, filament) = (melt(), Kelvin(nozzle_k), Kelvin(298.15));
        let flow = melt.flow_max_m3_s(nozzle, filament, margin);
        let force_n = melt.force_n(flow, melt.melt_temperature(nozzle, filament, flow));
        prop_assert!((force_n / (margin * 80.0) - 1.0).abs() < 1e-9);
    }
}
