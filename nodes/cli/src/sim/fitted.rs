//! Printers without some of the sensors, or with others; host profiles by name.

use std::collections::BTreeMap;

/// Sensors that a printer may do without.
pub(super) const SENSORS: [&str; 3] = ["encoder", "width", "tachometer"];

/// Sensors that may be fitted besides.
pub const EXTRAS: [&str; 1] = ["nozzle"];

/// Host profiles.
pub(super) const HOSTS: [&str; 4] = ["native", "serial", "moonraker", "octoprint"];

/// Parameters of a printer without these sensors and with those extras: who lets corrections act must not wait for what
/// is not there.
pub(super) fn fitted(sensors: &[String], extras: &[String]) -> BTreeMap<String, Vec<(String, String)>> {
    let mut overrides: BTreeMap<String, Vec<(String, String)>> = BTreeMap::new();
    let mut set = |node: &str, name: &str, value: &str| {
        overrides.entry(node.to_owned()).or_default().push((name.to_owned(), value.to_owned()));
    };
    for sensor in sensors {
        match sensor.as_str() {
            "encoder" => {
                set("printer_sim", "simulator.encoder_period_s", "0.0");
                set("safety_supervisor", "required_to_act", "[estimate]");
                set("mpc_controller", "slip.encoder_fitted", "false");
            }
            "width" => set("printer_sim", "simulator.width_period_s", "0.0"),
            _ => set("printer_sim", "simulator.part_fan.full_1_s", "0.0"),
        }
    }
    if extras.iter().any(|extra| extra == "nozzle") {
        set("printer_sim", "simulator.nozzle_sensor", "true");
    }
    overrides
}
