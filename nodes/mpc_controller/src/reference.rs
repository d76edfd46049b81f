//! What the slicer's set-point means for the nozzle.
//!
//! Slicers state the block's set-point. The nozzle is cooler by what air and melt draw through the joint; a nozzle
//! at that steady temperature for a usual flow is what the profile was tuned for.

use models::hotend::{Hotend, Inputs};
use models::material::Material;
use models::units::Kelvin;

/// Steady nozzle temperature at a block temperature, a flow and the material's own part fan.
///
/// `T_n = (K_en T_e + h_n T_amb + m_dot c_p T_f) / (K_en + h_n + m_dot c_p)`: model book 1.2 with `dT_n/dt = 0`.
/// `heater_w` plays no part: the block is held. `T_f = T_amb`.
#[must_use]
pub fn nozzle_reference(
    hotend: &Hotend,
    material: &Material,
    block: Kelvin,
    (flow_m3_s, ambient): (f64, Kelvin),
) -> Kelvin {
    let inputs = Inputs {
        heater_w: 0.0,
        fan: material.fan,
        ambient_k: ambient.0,
        filament_k: ambient.0,
        melt_w_k: material.heat_flow_w_k(flow_m3_s),
    };
    // the drop is linear in the nozzle's excess over air: one evaluation gives its slope
    let excess_k = block.0 - ambient.0;
    let drop_at_full_k = hotend.steady(block.0, &inputs).block_k - block.0;
    if excess_k <= 0.0 {
        return block;
    }
    let slope = drop_at_full_k / excess_k;
    Kelvin(ambient.0 + excess_k / (1.0 + slope))
}
