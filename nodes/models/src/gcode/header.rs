//! What a file says of itself in comments near its start and its end: slicer, limits, filament, time.
//!
//! PrusaSlicer writes its settings at the END, so both ends are read before planning.

use super::modal::MM;
use super::number::number;
use crate::motion::{Cornering, Limits};
use crate::units::Seconds;
use std::io::{self, Read, Seek, SeekFrom};

/// Facts from the comments.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Header {
    /// Slicer and version as stated.
    pub slicer: Option<String>,
    /// Firmware flavour as stated.
    pub flavour: Option<String>,
    /// Klipper commands stand in the file.
    pub klipper: bool,
    /// The slicer marks layers in comments.
    pub marks_layers: bool,
    /// Filament diameter `[m]`.
    pub filament_diameter_m: Option<f64>,
    /// Printing time as the slicer estimates it, heating excluded.
    pub stated_time: Option<Seconds>,
    /// Filament as the slicer counts it `[m]`.
    pub stated_filament_m: Option<f64>,
    machine: Vec<(MachineMax, f64)>,
}

/// One `machine_max_*` comment.
#[derive(Debug, Clone, Copy, PartialEq)]
enum MachineMax {
    Feedrate(usize),
    Acceleration(usize),
    Jerk(usize),
    Extruding,
    Retracting,
    Travel,
    JunctionDeviation,
}

/// Slicers by the words they sign with; those that mark layers first.
const SIGNATURES: [(&str, bool); 10] = [
    ("PrusaSlicer", true),
    ("SuperSlicer", true),
    ("OrcaSlicer", true),
    ("BambuStudio", true),
    ("Cura_SteamEngine", true),
    ("CuraEngine", true),
    ("Slic3r", false),
    ("Simplify3D", false),
    ("ideaMaker", false),
    ("KISSlicer", false),
];

impl Header {
    /// Reads the comments in the first and the last bytes of a file; for a short file both may be the whole.
    #[must_use]
    pub fn scan(head: &[u8], tail: &[u8]) -> Self {
        let mut header = Self::default();
        for part in [head, tail] {
            for line in part.split(|byte| *byte == b'\n') {
                let line = line.trim_ascii();
                match line.strip_prefix(b";") {
                    Some(comment) => header.comment(comment.trim_ascii()),
                    None => header.klipper |= is_klipper(line),
                }
            }
        }
        header
    }

    /// Reads both ends of a seekable source, at most `end_bytes` each, and leaves it at its start.
    ///
    /// # Errors
    /// Those of the source.
    pub fn read_ends<S: Read + Seek>(source: &mut S, end_bytes: usize) -> io::Result<Self> {
        let total = source.seek(SeekFrom::End(0))?;
        let end_bytes = total.min(end_bytes as u64);
        let mut ends = [Vec::new(), Vec::new()];
        for (end, from) in ends.iter_mut().zip([0, total - end_bytes]) {
            source.seek(SeekFrom::Start(from))?;
            source.by_ref().take(end_bytes).read_to_end(end)?;
        }
        source.rewind()?;
        let [head, tail] = ends;
        Ok(Self::scan(&head, &tail))
    }

    /// Flavour and slicer in one line.
    #[must_use]
    pub fn dialect(&self) -> String {
        let slicer = self.slicer.as_deref().unwrap_or("unknown slicer");
        let flavour = if self.klipper { Some("klipper") } else { self.flavour.as_deref() };
        format!("{slicer}, {}", flavour.unwrap_or("unknown flavour"))
    }

    /// The printer's limits with the file's `machine_max_*` in their place; the first value of a pair is the normal
    /// mode. Zero means "not limited here": the printer's own stays.
    #[must_use]
    pub fn limits(&self, mut limits: Limits) -> Limits {
        for (what, value) in &self.machine {
            let value = value * MM;
            match *what {
                MachineMax::Feedrate(axis) => limits.feedrate_m_s[axis] = value,
                MachineMax::Acceleration(axis) => limits.acceleration_m_s2[axis] = value,
                MachineMax::Jerk(axis) => {
                    limits.jerk_m_s[axis] = value;
                }
                MachineMax::Extruding => limits.extruding_m_s2 = value,
                MachineMax::Retracting => limits.retract_m_s2 = value,
                MachineMax::Travel => limits.travel_m_s2 = value,
                MachineMax::JunctionDeviation => limits.junction_deviation_m = value,
            }
        }
        let has = |wanted: fn(&MachineMax) -> bool| self.machine.iter().any(|(what, _)| wanted(what));
        if has(|what| matches!(what, MachineMax::JunctionDeviation)) {
            limits.cornering = Cornering::JunctionDeviation;
        } else if has(|what| matches!(what, MachineMax::Jerk(_))) {
            limits.cornering = Cornering::ClassicJerk;
        }
        limits
    }

    fn comment(&mut self, text: &[u8]) {
        self.signature(text);
        self.marks_layers |= text == b"LAYER_CHANGE" || text.starts_with(b"LAYER:");
        if let Some(rest) = text.strip_prefix(b"FLAVOR:") {
            self.flavour = Some(plain(rest));
        } else if let Some(rest) = text.strip_prefix(b"TIME:") {
            self.stated_time = number(rest).map(|(value_s, _)| Seconds(value_s));
        } else if let Some(rest) = text.strip_prefix(b"Filament used:") {
            // metres; Cura's engine alone leaves a zero in place
            let metres = number(rest.trim_ascii()).map(|(metres, _)| metres);
            self.stated_filament_m = metres.filter(|metres| *metres > 0.0);
        }
        let Some(equals) = text.windows(3).position(|window| window == b" = ") else { return };
        let (key, value) = (&text[..equals], &text[equals + 3..]);
        match key {
            b"gcode_flavor" => self.flavour = Some(plain(value)),
            b"estimated printing time (normal mode)" => self.stated_time = duration(value),
            b"filament used [mm]" => {
                self.stated_filament_m = positive(value).map(|value| value * MM);
            }
            b"filament_diameter" => {
                // 1 to 4 mm: outside of it the value is no diameter
                let diameter = positive(value).filter(|value| (1.0..=4.0).contains(value));
                self.filament_diameter_m = diameter.map(|value| value * MM);
            }
            _ => {
                if let (Some(what), Some(value)) = (machine_max(key), positive(value)) {
                    self.machine.push((what, value));
                }
            }
        }
    }

    fn signature(&mut self, text: &[u8]) {
        if self.slicer.is_some() {
            return;
        }
        let by = ["generated by ", "Generated with ", "Sliced by "];
        let name = by.iter().find_map(|by| text.strip_prefix(by.as_bytes()));
        let bambu = || text.starts_with(b"BambuStudio").then_some(text);
        let Some(name) = name.or_else(bambu) else { return };
        let name = plain(name);
        let name = name.split(" on ").next().unwrap_or_default().trim().to_owned();
        self.marks_layers |=
            SIGNATURES.iter().any(|(signature, marks)| *marks && name.starts_with(signature));
        self.slicer = Some(name);
    }
}

fn is_klipper(line: &[u8]) -> bool {
    let macros: [&[u8]; 6] = [
        b"START_PRINT",
        b"PRINT_START",
        b"SET_PRESSURE_ADVANCE",
        b"SET_RETRACTION",
        b"SET_VELOCITY_LIMIT",
        b"EXCLUDE_OBJECT",
    ];
    macros.iter().any(|name| line.starts_with(name))
}

fn machine_max(key: &[u8]) -> Option<MachineMax> {
    let rest = key.strip_prefix(b"machine_max_")?;
    let axis = |name: &[u8]| [b"x", b"y", b"z", b"e"].iter().position(|axis| name == axis.as_slice());
    if rest == b"junction_deviation" {
        Some(MachineMax::JunctionDeviation)
    } else if let Some(name) = rest.strip_prefix(b"feedrate_") {
        axis(name).map(MachineMax::Feedrate)
    } else if let Some(name) = rest.strip_prefix(b"jerk_") {
        axis(name).map(MachineMax::Jerk)
    } else {
        match rest.strip_prefix(b"acceleration_")? {
            b"extruding" => Some(MachineMax::Extruding),
            b"retracting" => Some(MachineMax::Retracting),
            b"travel" => Some(MachineMax::Travel),
            name => axis(name).map(MachineMax::Acceleration),
        }
    }
}

fn positive(value: &[u8]) -> Option<f64> {
    number(value).map(|(value, _)| value).filter(|value| value.is_finite() && *value > 0.0)
}

/// `1d 2h 3m 4s`.
fn duration(text: &[u8]) -> Option<Seconds> {
    let mut total_s = 0.0;
    for part in text.split(|byte| *byte == b' ').filter(|part| !part.is_empty()) {
        let (value, length) = number(part)?;
        total_s += value
            * match &part[length..] {
                b"d" => 86_400.0,
                b"h" => 3_600.0,
                b"m" => 60.0,
                b"s" => 1.0,
                _ => return None,
            };
    }
    Some(Seconds(total_s))
}

fn plain(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes.trim_ascii()).into_owned()
}
