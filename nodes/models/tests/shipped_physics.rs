//! The shipped printer, plant, material and quality files: they load, they carry the model book's reference row, and
//! the plant differs from what the estimator believes by the mismatch of model book 1.5.

use std::path::Path;

use models::bed::Bed;
use models::extruder::{Extruder, Filament, SlipParams};
use models::heater::PidParams;
use models::hotend::Hotend;
use models::latent::Cooling;
use models::material::{Deviation, Material};
use models::melt::Melt;
use models::quality::Quality;
use models::units::Kelvin;
use serde::Deserialize;
use serde::de::DeserializeOwned;

#[derive(Deserialize)]
struct File<T> {
    #[serde(rename = "/**")]
    any_node: Parameters<T>,
}

#[derive(Deserialize)]
struct Parameters<T> {
    #[serde(rename = "ros__parameters")]
    parameters: T,
}

#[derive(Deserialize)]
struct MaterialFile {
    material: Material,
}

#[derive(Deserialize)]
struct PrinterFile {
    printer: Printer,
}

/// Only the blocks of the physics: the file holds more.
#[derive(Deserialize)]
struct Printer {
    hotend: Hotend,
    bed: Bed,
    extruder: Extruder,
    #[serde(rename = "cooling")]
    _cooling: Cooling,
}

#[derive(Deserialize)]
struct PlantFile {
    plant: Plant,
}

#[derive(Deserialize)]
struct Plant {
    hotend: Hotend,
    bed: Bed,
    extruder: Extruder,
    #[serde(rename = "cooling")]
    _cooling: Cooling,
    #[serde(rename = "heater")]
    _heater: PidParams,
    #[serde(rename = "bed_heater")]
    _bed_heater: PidParams,
    #[serde(rename = "slip")]
    _slip: SlipParams,
    filament: Filament,
    material_deviation: Deviation,
    ambient_temp_k: f64,
}

#[derive(Deserialize)]
struct QualityFile {
    #[serde(rename = "quality")]
    _quality: Quality,
}

fn read(name: &str) -> Result<String, String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config").join(name);
    std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))
}

fn load<T: DeserializeOwned>(name: &str) -> Result<T, String> {
    let file: File<T> = serde_saphyr::from_str(&read(name)?).map_err(|error| format!("{name}: {error}"))?;
    Ok(file.any_node.parameters)
}

fn material(name: &str) -> Result<Material, String> {
    Ok(load::<MaterialFile>(&format!("materials/{name}.yaml"))?.material)
}

fn close(got: f64, expected: f64) -> bool {
    (got - expected).abs() <= 1e-9 * expected.abs()
}

/// Model book 1.3: force at 4.8 mm3/s and largest flow of margin 0.8, both to the digit printed.
#[test]
fn the_shipped_materials_have_the_reference_rows() {
    let printer = load::<PrinterFile>("printers/ender3.yaml").unwrap().printer;
    for (name, force_n, flow_mm3_s) in [("pla", 13.9, 14.5), ("petg", 20.4, 11.4), ("abs", 19.4, 11.3)] {
        let material = material(name).unwrap();
        assert_eq!(material.name, name.to_uppercase());
        let melt = Melt::new(&material, &printer.extruder);
        let nozzle = material.nozzle_temp();
        assert!((melt.force_n(4.8e-9, nozzle) - force_n).abs() <= 0.051, "{name}");
        let flow = melt.flow_max_m3_s(nozzle, Kelvin(298.15), 0.8) * 1e9;
        assert!((flow - flow_mm3_s).abs() <= 0.051, "{name}: {flow} mm3/s");
    }
}

/// Model book 1.5, the mismatch under which estimator and controller are judged.
#[test]
fn the_plant_differs_from_the_printer_file_by_the_mismatch() {
    let printer = load::<PrinterFile>("printers/ender3.yaml").unwrap().printer;
    let plant = load::<PlantFile>("plants/ender3.yaml").unwrap().plant;
    let ratios = [
        (plant.hotend.block_capacity_j_k / printer.hotend.block_capacity_j_k, 1.08),
        (plant.hotend.nozzle_capacity_j_k / printer.hotend.nozzle_capacity_j_k, 0.92),
        (plant.hotend.coupling_w_k / printer.hotend.coupling_w_k, 0.93),
        (plant.hotend.block_loss_w_k / printer.hotend.block_loss_w_k, 1.06),
        (plant.hotend.nozzle_loss_w_k / printer.hotend.nozzle_loss_w_k, 1.10),
        (plant.extruder.compliance_m_n / printer.extruder.compliance_m_n, 1.12),
        (plant.extruder.linear_lag_s / printer.extruder.linear_lag_s, 1.05),
        (plant.material_deviation.consistency_factor, 0.85),
        (plant.material_deviation.activation_energy_factor, 1.10),
        (plant.material_deviation.heat_capacity_factor, 1.05),
        (plant.material_deviation.flow_index_offset, 0.03),
    ];
    for (k, (got, expected)) in ratios.into_iter().enumerate() {
        assert!(close(got, expected), "entry {k}: {got} instead of {expected}");
    }
    assert_eq!(plant.bed, printer.bed);
    assert!(close(plant.filament.diameter_m, printer.extruder.filament_diameter_m));
    assert!(close(plant.ambient_temp_k, 298.15));
}

#[test]
fn the_deviation_leaves_every_shipped_material_valid() {
    let deviation = load::<PlantFile>("plants/ender3.yaml").unwrap().plant.material_deviation;
    for name in ["pla", "petg", "abs"] {
        let nominal = material(name).unwrap();
        let real = deviation.apply(&nominal).unwrap();
        assert!(close(real.flow_index, nominal.flow_index + 0.03));
        assert!(close(real.density_kg_m3, nominal.density_kg_m3));
    }
}

#[test]
fn the_shipped_quality_weights_load() {
    load::<QualityFile>("quality.yaml").unwrap();
}

#[test]
fn an_unknown_key_and_a_value_out_of_range_are_refused() {
    let text = read("materials/pla.yaml").unwrap();
    for (from, to, word) in [("lag_s:", "lagg_s:", "lagg_s"), ("fan: 1.0", "fan: 1.5", "[0, 1]")] {
        let spoiled = text.replace(from, to);
        let refused = serde_saphyr::from_str::<File<MaterialFile>>(&spoiled).err().map(|e| e.to_string());
        assert!(refused.as_deref().is_some_and(|message| message.contains(word)), "{refused:?}");
    }
}
