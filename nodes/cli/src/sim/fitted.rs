//! Printers without some of the sensors; host profiles by name.

use std::collections::BTreeMap;

/// Sensors that a printer may do without.
pub(super) const SENSORS: [&str; 3] = ["encoder", "width", "tachometer"];

/// Host profiles.
pub(super) const HOSTS: [&str; 4] = ["native", "serial", "moonraker", "octoprint"];

/// Parameters of a printer without these sensors: who lets corrections act must not wait for them.
pub(super) fn without(sensors: &[String]) -> BTreeMap<String, Vec<(String, String)>> {
    let mut overrides: BTreeMap<String, Vec<(String, String)>> = BTreeMap::new();
    let mut set = |node: &str, name: &str, value: &str| {
        overrides.entry(node.to_owned()).or_default().push((name.to_owned(), value.to_owned()));
    };
    for sensor in sensors {
        match sensor.as_str() {
            "encoder" => {
                set("printer_sim", "simulator.encoder_period_s", "0.0");
                set("safety_supervisor", "required_to_act", "[estimate]");
            }
            "width" => set("printer_sim", "simulator.width_period_s", "0.0"),
            _ => set("printer_sim", "simulator.part_fan.full_1_s", "0.0"),
        }
    }
    overrides
}
