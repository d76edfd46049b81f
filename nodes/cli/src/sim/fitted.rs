//! Printers without some of the sensors, and hosts that are slow to tell and to act.

use std::collections::BTreeMap;

/// Sensors that a printer may do without.
pub(super) const SENSORS: [&str; 3] = ["encoder", "width", "tachometer"];

/// Host profiles.
pub(super) const HOSTS: [&str; 4] = ["native", "serial", "moonraker", "octoprint"];

/// A host over HTTP: its state is older than a firmware's, and so is what is compared with it. Name, longest age of its
/// state and of the encoder's interval `[s]`, and where the supervisor takes it as lost `[s]` (1 s and 2 s).
const SLOW: [(&str, &str, &str); 2] = [("moonraker", "0.6", "1.0"), ("octoprint", "1.2", "2.0")];

/// Parameters beside the files', by node.
pub(super) fn overrides(host: &str, sensors: &[String]) -> BTreeMap<String, Vec<(String, String)>> {
    let mut overrides = without(sensors);
    let mut set = |node: &str, name: &str, value: &str| {
        overrides.entry(node.to_owned()).or_default().push((name.to_owned(), value.to_owned()));
    };
    for (_, age_s, lost_s) in SLOW.iter().filter(|(name, ..)| *name == host) {
        set("state_estimator", "telemetry.age_limit_s", age_s);
        set("state_estimator", "encoder.interval_max_s", age_s);
        set("mpc_controller", "status_age_limit_s", age_s);
        set("mpc_controller", "period_s", "1.0");
        set("mpc_controller", "bumpless.adopt_s", "5.0");
        set("mpc_controller", "slip.serial_gain_1_s", "0.03");
        set("safety_supervisor", "stale.printer.degraded_s", lost_s);
    }
    overrides
}

/// Parameters of a printer without these sensors: who lets corrections act must not wait for them.
fn without(sensors: &[String]) -> BTreeMap<String, Vec<(String, String)>> {
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
