//! The printer that files are sliced for: what of it says which nozzle temperature a set-point means.
//!
//! It belongs to the simulated world and not to what estimator and controller believe of their printer: who gives them
//! another belief, a learned one say, prints with the same set-points and is scored by the same measure.

use crate::job::{SetPoints, Wishes};
use crate::params::{Params, PlantParams};
use models::hotend::Inputs;
use models::material::Material;
use models::params::{ParamError, in_range};
use models::units::Kelvin;
use serde::Deserialize;

/// The `plant.sliced_for` block of a plant file as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawSlicedFor {
    /// Block to nozzle `[W/K]`.
    pub coupling_w_k: f64,
    /// Nozzle to air `[W/K]`.
    pub nozzle_loss_w_k: f64,
    /// The same, added at full part fan `[W/K]`.
    pub nozzle_loss_fan_w_k: f64,
}

/// Nozzle of the printer that files are sliced for.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawSlicedFor")]
pub struct SlicedFor(RawSlicedFor);

impl TryFrom<RawSlicedFor> for SlicedFor {
    type Error = ParamError;

    fn try_from(raw: RawSlicedFor) -> Result<Self, ParamError> {
        in_range("coupling_w_k", raw.coupling_w_k, "W/K", (0.05, 100.0))?;
        in_range("nozzle_loss_w_k", raw.nozzle_loss_w_k, "W/K", (1e-5, 1.0))?;
        in_range("nozzle_loss_fan_w_k", raw.nozzle_loss_fan_w_k, "W/K", (0.0, 1.0))?;
        Ok(Self(raw))
    }
}

impl SlicedFor {
    /// How much colder than its block the nozzle is that is held at `nozzle_k` `[K]`: as `Hotend::steady` (model book 1.2).
    #[must_use]
    pub fn drop_k(&self, nozzle_k: f64, inputs: &Inputs) -> f64 {
        let loss_w_k = self.0.nozzle_loss_w_k + inputs.fan * self.0.nozzle_loss_fan_w_k;
        let across_w =
            loss_w_k * (nozzle_k - inputs.ambient_k) + inputs.melt_w_k * (nozzle_k - inputs.filament_k);
        across_w / self.0.coupling_w_k
    }
}

impl PlantParams {
    /// How much colder than its block the nozzle is for a material at the flow at which set-points are meant `[K]`: a
    /// file's set-point less this counts as the right nozzle temperature.
    #[must_use]
    pub fn nozzle_drop_k(&self, material: &Material, reference_flow_m3_s: f64) -> f64 {
        let air = self.ambient();
        let inputs = Inputs {
            heater_w: 0.0,
            fan: material.fan,
            ambient_k: air.0,
            filament_k: air.0,
            melt_w_k: material.heat_flow_w_k(reference_flow_m3_s),
        };
        self.sliced_for.drop_k(material.nozzle_temp_k, &inputs)
    }
}

impl Params {
    /// Set-points that slicers would state for a material: the block's, not the nozzle's.
    #[must_use]
    pub fn set_points(&self, material: &Material) -> SetPoints {
        let drop_k = self.plant.nozzle_drop_k(material, self.simulator.firmware.reference_flow_m3_s);
        let block = Kelvin(material.nozzle_temp_k + drop_k);
        SetPoints { hotend: block.into(), bed: Kelvin(material.bed_temp_k).into(), fan: material.fan }
    }

    /// What is asked of a file: its first layers, and a material's set-points instead of its own.
    #[must_use]
    pub fn wishes(&self, layers: u32, override_by: Option<&Material>) -> Wishes {
        Wishes {
            layers: (layers > 0).then_some(layers),
            set_points: override_by.map(|material| self.set_points(material)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::tests::load;
    use models::printer::Printer;

    #[derive(Deserialize)]
    struct PrinterFile {
        printer: Printer,
    }

    #[derive(Deserialize)]
    struct PlantFile {
        plant: PlantParams,
    }

    /// Files are sliced for the printer as it is shipped: what the plant's file says of it is what that one's file says.
    #[test]
    fn the_drop_is_the_shipped_printers() {
        let shipped = load::<PrinterFile>("printers/ender3.yaml").printer.hotend;
        let sliced_for = load::<PlantFile>("plants/ender3.yaml").plant.sliced_for;
        for (fan, melt_w_k) in [(0.0, 0.0), (1.0, 0.0), (0.5, 0.01)] {
            let inputs = Inputs { heater_w: 0.0, fan, ambient_k: 298.15, filament_k: 296.15, melt_w_k };
            let block_k = 483.15 + sliced_for.drop_k(483.15, &inputs);
            let wanted_k = shipped.steady(483.15, &inputs).block_k;
            assert!((block_k - wanted_k).abs() < 1e-9, "{fan} {melt_w_k}: {block_k} for {wanted_k}");
        }
    }
}
