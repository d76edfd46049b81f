//! What the firmware says it is and can.

use std::collections::BTreeMap;

/// Most capabilities that are kept: Marlin 2.1 has some 30, a line that lies has no end of them.
const CAPABILITIES_MAX: usize = 64;

/// The answer to M115.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Firmware {
    name: Option<String>,
    capabilities: BTreeMap<String, bool>,
}

impl Firmware {
    /// Its name and version; `None` before it has said so.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// Whether it has a capability; `None` where it does not speak of it, which Marlin means as no.
    #[must_use]
    pub fn can(&self, capability: &str) -> Option<bool> {
        self.capabilities.get(capability).copied()
    }

    /// All capabilities that it has.
    pub fn abilities(&self) -> impl Iterator<Item = &str> {
        self.capabilities.iter().filter(|(_, on)| **on).map(|(name, _)| name.as_str())
    }

    /// It reports temperatures by itself (M155).
    #[must_use]
    pub fn reports_temperatures(&self) -> bool {
        self.can("AUTOREPORT_TEMP") == Some(true)
    }

    /// M112 passes while it is busy.
    #[must_use]
    pub fn has_emergency_parser(&self) -> bool {
        self.can("EMERGENCY_PARSER") == Some(true)
    }

    /// It is known to watch no heater.
    #[must_use]
    pub fn protection_is_off(&self) -> bool {
        self.can("THERMAL_PROTECTION") == Some(false)
    }

    pub(crate) fn named(&mut self, name: String) {
        self.name = Some(name);
    }

    /// False where there are too many.
    pub(crate) fn has(&mut self, capability: String, on: bool) -> bool {
        let room = self.capabilities.len() < CAPABILITIES_MAX || self.capabilities.contains_key(&capability);
        if room {
            self.capabilities.insert(capability, on);
        }
        room
    }
}
