//! From parameters and files to a simulator: shared by the node and by `fdm sim`.

use crate::job::{SetPoints, Wishes};
use crate::params::Params;
use models::hotend::{Hotend, Inputs};
use models::material::Material;
use models::units::Kelvin;

impl Params {
    /// Set-points that slicers would state for a material on the nominal printer: the block's, not the nozzle's.
    #[must_use]
    pub fn set_points(&self, nominal: &Hotend, material: &Material) -> SetPoints {
        let air = self.plant.ambient();
        let inputs = Inputs {
            heater_w: 0.0,
            fan: material.fan,
            ambient_k: air.0,
            filament_k: air.0,
            melt_w_k: material.heat_flow_w_k(self.simulator.firmware.reference_flow_m3_s),
        };
        let block = Kelvin(nominal.steady(material.nozzle_temp_k, &inputs).block_k);
        SetPoints { hotend: block.into(), bed: Kelvin(material.bed_temp_k).into(), fan: material.fan }
    }

    /// What is asked of a file: its first layers, and the material's set-points instead of its own.
    #[must_use]
    pub fn wishes(&self, layers: u32, override_by: Option<(&Hotend, &Material)>) -> Wishes {
        Wishes {
            layers: (layers > 0).then_some(layers),
            set_points: override_by.map(|(nominal, material)| self.set_points(nominal, material)),
        }
    }
}
