//! A part fan that gives less than it is told to.

use super::*;

/// Steady nozzle under a block at 226 degC: `(K_en T_e + h_n T_amb + m_dot c_p T_f) / (K_en + h_n + m_dot c_p)`, `T_f = T_amb`.
fn nozzle_k(fan: f64) -> f64 {
    let hotend = nominal_hotend();
    let melt_w_k = pla().heat_flow_w_k(bowden().filament_area_m2() * 0.99 * FEED_M_S);
    let losses_w_k = hotend.nozzle_loss_w_k + fan * hotend.nozzle_loss_fan_w_k + melt_w_k;
    298.15 + (499.15 - 298.15) * hotend.coupling_w_k / (hotend.coupling_w_k + losses_w_k)
}

/// The nozzle is hotter by 6 K where three tenths of the fan's air cool it: known where a tachometer shows the fan, not else.
#[test]
fn a_weak_fan_is_believed_where_a_tachometer_shows_it() {
    for (part_fan_1_s, fan) in [(None, 1.0), (Some(83.0), 1.0), (Some(0.3 * 83.0), 0.3), (Some(100.0), 1.0)] {
        let mut rig = Rig::new();
        rig.part_fan_1_s = part_fan_1_s;
        let told_k = rig.run(12_000).x[state::NOZZLE];
        assert!((told_k - nozzle_k(fan)).abs() < 0.5, "{part_fan_1_s:?}: {told_k} {}", nozzle_k(fan));
    }
    assert!(nozzle_k(0.3) - nozzle_k(1.0) > 5.0);
}

#[test]
fn a_tachometer_that_cannot_be_is_refused() {
    for speed_1_s in [f64::NAN, f64::INFINITY, -1.0] {
        let mut rig = Rig::new();
        let status = PrinterStatus { part_fan_speed_1_s: Some(speed_1_s), ..status(0.1, 0.0) };
        rig.estimator.on_event(Event::Printer(status));
        assert!(rig.estimator.inbox.status.is_none(), "{speed_1_s}");
    }
}
