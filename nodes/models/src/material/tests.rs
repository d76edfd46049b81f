//! Also the material of other modules' tests.

use super::*;

pub(crate) fn raw_pla() -> RawMaterial {
    RawMaterial {
        name: "PLA".into(),
        density_kg_m3: 1240.0,
        heat_capacity_j_kg_k: 1800.0,
        flow_index: 0.4,
        consistency_pa_sn: 9000.0,
        reference_temp_k: 483.15,
        activation_energy_j_mol: 60e3,
        nozzle_temp_k: 483.15,
        bed_temp_k: 333.15,
        min_temp_k: 460.0,
        max_temp_k: 503.15,
        glass_temp_k: 333.15,
        adhesion_time_s: 0.8,
        fan: 1.0,
        lag_s: 0.63,
    }
}

pub(crate) fn pla() -> Material {
    raw_pla().try_into().unwrap()
}

#[test]
fn a_material_outside_its_ranges_is_refused_by_name() {
    type Spoil = fn(&mut RawMaterial);
    let cases: [(&str, Spoil); 6] = [
        ("density_kg_m3", |m| m.density_kg_m3 = 0.0),
        ("flow_index", |m| m.flow_index = 1.2),
        ("nozzle_temp_k", |m| m.nozzle_temp_k = 520.0),
        ("fan", |m| m.fan = -0.1),
        ("min_temp_k", |m| m.min_temp_k = 510.0),
        ("lag_s", |m| m.lag_s = f64::NAN),
    ];
    for (name, spoil) in cases {
        let mut raw = raw_pla();
        spoil(&mut raw);
        let error = Material::try_from(raw).unwrap_err().to_string();
        assert!(error.starts_with(name), "{error}");
    }
}

#[test]
fn a_deviation_changes_what_it_names_and_nothing_else() {
    let deviation = Deviation::try_from(RawDeviation {
        flow_index_offset: 0.03,
        consistency_factor: 0.85,
        activation_energy_factor: 1.1,
        heat_capacity_factor: 1.05,
    })
    .unwrap();
    let expected = RawMaterial {
        flow_index: 0.4 + 0.03,
        consistency_pa_sn: 9000.0 * 0.85,
        activation_energy_j_mol: 60e3 * 1.1,
        heat_capacity_j_kg_k: 1800.0 * 1.05,
        ..raw_pla()
    };
    assert_eq!(*deviation.apply(&pla()).unwrap(), expected);
}
