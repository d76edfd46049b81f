//! What of a bag a printer is learned from: what a real one records. What a simulation knows beyond is not read.

use crate::report::bag::{Bag, there_are};
use crate::report::decode::{decode, short};
use crate::report::scan::{Raw, Visitor, scan_what_is_there};
use anyhow::bail;
use fdm_loop_msgs::{PrintEvent, PrintInfo};
use models::status::PrinterStatus;
use models::units::Kelvin;
use runtime::topics;
use runtime::wire;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Stamps that fall by more than this belong to another print `[s]`.
const BACK_S: f64 = 1.0;

/// No drive feeds or retracts faster `[m/s]`, and no count steps by more at once `[m]`.
const FEED_MOST_M_S: f64 = 0.3;
const FEED_AT_ONCE_M: f64 = 0.01;

/// Most warnings that are told.
const WARNED: usize = 8;
/// Longest reason that is told `[characters]`.
const WHY: usize = 160;

/// A reading at a time `[s]`.
pub(super) type At = (f64, f64);

/// A measured width of the road.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Width {
    /// Exposure `[s]`.
    pub(super) at_s: f64,
    pub(super) width_m: f64,
    /// Noise as its source states it `[m]`.
    pub(super) sigma_m: f64,
}

/// The readings of a print, each in the order of its stamps.
#[derive(Debug, Clone, Default)]
pub(super) struct Recorded {
    /// Thermistor of the hot end `[K]`.
    pub(super) hotend_k: Vec<At>,
    /// State of printer and job.
    pub(super) states: Vec<PrinterStatus>,
    /// Filament past the encoder `[m]`.
    pub(super) encoder_m: Vec<At>,
    pub(super) widths: Vec<Width>,
    /// Messages that say what cannot be.
    pub(super) refused: u64,
    /// What somebody in the graph warned of, the first time each.
    pub(super) warned: Vec<String>,
    namespace: Option<String>,
    /// Namespaces other than the chosen one.
    others: BTreeSet<String>,
    jumped: bool,
    /// Material of the configuration in force.
    material: Option<String>,
}

/// What a configuration says before the name of its material.
const MATERIAL: &str = "material.name: ";

impl Recorded {
    /// Reads a bag.
    pub(super) fn read(path: &Path, namespace: Option<&str>) -> anyhow::Result<Self> {
        let chosen = namespace.map(|name| name.trim_end_matches('/').to_owned());
        let mut recorded = Self { namespace: chosen, ..Self::default() };
        for file in Bag::find(path)?.files {
            scan_what_is_there(&file, &mut recorded)?;
        }
        if let (Some(asked), true) = (namespace, recorded.states.is_empty() && recorded.hotend_k.is_empty()) {
            let others = there_are(&recorded.others);
            bail!("{}: --namespace {asked}: the bag holds nothing of it{others}", path.display());
        }
        if recorded.jumped {
            bail!("{}: its time jumps back: more than one print is in it", path.display());
        }
        recorded.widths.sort_by(|one, other| one.at_s.total_cmp(&other.at_s));
        Ok(recorded)
    }

    /// Filament that the drive has fed `[m]`: what the encoder saw, or the motor's own count where there is none.
    pub(super) fn fed_m(&self) -> Vec<At> {
        if self.encoder_m.is_empty() {
            self.states.iter().map(|state| (state.stamp.0, state.motor_position_m)).collect()
        } else {
            self.encoder_m.clone()
        }
    }

    /// Material that was printed, as the print's configuration says.
    pub(super) fn material(&self) -> Option<&str> {
        self.material.as_deref()
    }

    fn take(&mut self, topic: &str, payload: &[u8]) -> Option<()> {
        match topic {
            topic if topic == topics::HOTEND_TEMPERATURE.name() => {
                let (stamp, temp) = wire::temperature_from_wire(&decode(payload)?).ok()?;
                push(&mut self.hotend_k, (stamp.0, Kelvin::from(temp).0), &mut self.jumped);
            }
            topic if topic == topics::FILAMENT_MOTION.name() => {
                let read = wire::filament_from_wire(&decode(payload)?).ok()?;
                let reading = (read.stamp.0, read.position_m);
                let can_be = self.encoder_m.last().is_none_or(|last| is_fed(*last, reading));
                can_be.then(|| push(&mut self.encoder_m, reading, &mut self.jumped))?;
            }
            topic if topic == topics::PRINTER_STATE.name() => {
                let state = wire::status_from_wire(&decode(payload)?).ok()?;
                let newest_s = self.states.last().map_or(f64::NEG_INFINITY, |last| last.stamp.0);
                self.jumped |= state.stamp.0 < newest_s - BACK_S;
                if state.stamp.0 > newest_s {
                    self.states.push(state);
                }
            }
            topic if topic == topics::BEAD_WIDTH.name() => {
                let read = wire::bead_width_from_wire(&decode(payload)?).ok()?;
                let (at_s, width_m, sigma_m) = (read.exposed.0, read.width_m, read.sigma_m);
                self.widths.push(Width { at_s, width_m, sigma_m });
            }
            topic if topic == topics::PRINT_INFO.name() => {
                let info: PrintInfo = decode(payload)?;
                let name = info.config.lines().find_map(|line| line.strip_prefix(MATERIAL));
                self.material = name.map(|name| name.trim().trim_matches('"').to_owned());
            }
            topic if topic == topics::EVENTS.name() => {
                let event: PrintEvent = decode(payload)?;
                let why = short(&event.why, WHY);
                let news = self.warned.len() < WARNED && !self.warned.contains(&why);
                if news && event.severity >= PrintEvent::SEVERITY_WARN {
                    self.warned.push(why);
                }
            }
            _ => {}
        }
        Some(())
    }
}

/// Whether a drive can have fed from one count to the next.
fn is_fed(last: At, next: At) -> bool {
    (next.1 - last.1).abs() <= FEED_MOST_M_S * (next.0 - last.0).abs() + FEED_AT_ONCE_M
}

/// Takes a reading that is newer than the last one.
fn push(readings: &mut Vec<At>, reading: At, jumped: &mut bool) {
    let newest_s = readings.last().map_or(f64::NEG_INFINITY, |last| last.0);
    *jumped |= reading.0 < newest_s - BACK_S;
    if reading.0 > newest_s {
        readings.push(reading);
    }
}

/// Topics that are read.
const READ: [&str; 6] = [
    topics::EVENTS.name(),
    topics::PRINT_INFO.name(),
    topics::HOTEND_TEMPERATURE.name(),
    topics::PRINTER_STATE.name(),
    topics::FILAMENT_MOTION.name(),
    topics::BEAD_WIDTH.name(),
];

impl Visitor for Recorded {
    fn message(&mut self, raw: &Raw<'_>) {
        let found = READ.iter().find_map(|name| {
            let namespace = raw.topic.strip_suffix(name)?.strip_suffix('/')?;
            Some((*name, namespace))
        });
        let Some((topic, namespace)) = found.filter(|_| raw.encoding == "cdr") else { return };
        let chosen = self.namespace.get_or_insert_with(|| namespace.to_owned());
        if *chosen != namespace {
            _ = self.others.insert(namespace.to_owned());
        } else if self.take(topic, raw.payload).is_none() {
            self.refused += 1;
        }
    }

    fn note(&mut self, _: &str, _: &BTreeMap<String, String>) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A retraction of 100 mm/s and a pause are fed; a count of kilometres, of which a fit would make knots, is not.
    #[test]
    fn a_count_that_no_drive_can_feed_is_left_out() {
        let last = (10.0, 1.0);
        for (reading, can_be) in
            [((10.02, 0.998), true), ((70.0, 3.0), true), ((10.02, 9e5), false), ((10.02, -1.0), false)]
        {
            assert_eq!(is_fed(last, reading), can_be, "{reading:?}");
        }
    }

    #[test]
    fn what_was_warned_of_is_told_once_and_what_was_none_is_not() {
        let mut recorded = Recorded::default();
        for (severity, why) in [(0, "the start is over"), (1, "P4: fan"), (1, "P4: fan"), (2, "P2: heater")] {
            let event = PrintEvent { severity, why: why.to_owned(), ..PrintEvent::default() };
            recorded.take(topics::EVENTS.name(), &crate::replay::encode(&event).unwrap()).unwrap();
        }
        assert_eq!(recorded.warned, ["P4: fan", "P2: heater"]);
    }

    #[test]
    fn the_material_is_the_one_of_the_prints_configuration() {
        let read = |config: &str| {
            let info = PrintInfo { config: config.to_owned(), ..PrintInfo::default() };
            let mut recorded = Recorded::default();
            recorded.take(topics::PRINT_INFO.name(), &crate::replay::encode(&info).unwrap()).unwrap();
            recorded.material().map(str::to_owned)
        };
        let config = "# imu 0f\nperiod_s: 0.1\n\n# mpc_controller 1a\nmaterial.name: \"PETG\"\n";
        assert_eq!(read(config).as_deref(), Some("PETG"));
        assert_eq!(read("# imu 0f\nperiod_s: 0.1\n"), None);
    }
}
