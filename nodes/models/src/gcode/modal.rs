//! Modal state of the interpreter.

use crate::motion::{ReadParams, Role};

/// Millimetres per inch (exact by definition).
const INCH_MM: f64 = 25.4;
/// Metres per millimetre.
pub(super) const MM: f64 = 1e-3;
/// Metres per second in a millimetre per minute.
pub(super) const MM_MIN: f64 = 1e-3 / 60.0;

/// What earlier lines have set.
pub(super) struct Modal {
    /// Tool in machine coordinates `[mm]`.
    pub(super) machine_mm: [f64; 3],
    /// Machine minus program coordinates (`G92`) `[mm]`.
    pub(super) offset_mm: [f64; 3],
    /// E in program coordinates `[mm]`.
    pub(super) e_mm: f64,
    /// Millimetres per unit in force.
    pub(super) unit_mm: f64,
    /// `G91`.
    pub(super) relative: bool,
    /// `M83`.
    pub(super) relative_e: bool,
    /// Feed in force `[m/s]`.
    pub(super) feed_m_s: f64,
    /// Filament is retracted by `G10`.
    pub(super) retracted: bool,
    /// Length of `G10` `[m]`.
    pub(super) retract_m: f64,
    /// Speed of `G10` `[m/s]`.
    pub(super) retract_m_s: f64,
    /// Extra length of `G11` `[m]`.
    pub(super) unretract_extra_m: f64,
    /// Speed of `G11` `[m/s]`.
    pub(super) unretract_m_s: f64,
    /// Filament `[m]`.
    pub(super) filament_diameter_m: f64,
    /// Layer in force.
    pub(super) layer: Option<u32>,
    /// The file marks its layers; else the height of an extrusion tells them.
    pub(super) marked: bool,
    /// A mark was read, the next move begins the layer.
    pub(super) layer_pending: bool,
    /// From `;Z:` `[m]`.
    pub(super) layer_z_m: Option<f64>,
    /// From `;TYPE:`.
    pub(super) role: Role,
    /// From `;WIDTH:` `[m]`.
    pub(super) width_m: Option<f64>,
    /// From `;HEIGHT:` `[m]`.
    pub(super) height_m: Option<f64>,
    /// Heights met in extrusions.
    pub(super) levels: Levels,
}

impl Modal {
    pub(super) fn new(read: &ReadParams) -> Self {
        Self {
            machine_mm: [0.0; 3],
            offset_mm: [0.0; 3],
            e_mm: 0.0,
            unit_mm: 1.0,
            relative: false,
            relative_e: false,
            feed_m_s: read.first_feed_m_s,
            retracted: false,
            retract_m: read.firmware_retract_m,
            retract_m_s: read.firmware_retract_m_s,
            unretract_extra_m: 0.0,
            unretract_m_s: read.firmware_retract_m_s,
            filament_diameter_m: read.filament_diameter_m,
            layer: None,
            marked: false,
            layer_pending: false,
            layer_z_m: None,
            role: Role::Unknown,
            width_m: None,
            height_m: None,
            levels: Levels::default(),
        }
    }

    pub(super) fn inches(&mut self, inches: bool) {
        self.unit_mm = if inches { INCH_MM } else { 1.0 };
    }
}

/// Layer heights where no comment states them: the rise of the newest extrusion over the level before.
#[derive(Debug, Default)]
pub(super) struct Levels {
    first: Option<f64>,
    level_m: Option<f64>,
    height_m: Option<f64>,
}

/// Two heights closer than this are the same layer `[m]`: a tenth of the finest layer that printers lay.
const SAME_LEVEL_M: f64 = 2e-6;

impl Levels {
    /// Takes the height of an extrusion; true where it differs from the one before.
    pub(super) fn extrude_at(&mut self, z_m: f64) -> bool {
        let previous_m = self.level_m.unwrap_or(0.0);
        if self.level_m.is_some() && (z_m - previous_m).abs() < SAME_LEVEL_M {
            return false;
        }
        let first_m = *self.first.get_or_insert(z_m);
        if z_m > previous_m {
            self.height_m = Some(z_m - previous_m);
        } else if (z_m - first_m).abs() < SAME_LEVEL_M {
            self.height_m = Some(first_m); // the next object of a print one after the other
        }
        self.level_m = Some(z_m);
        true
    }

    /// Height of the road at the newest level; `None` before the first or below the bed.
    pub(super) fn height_m(&self) -> Option<f64> {
        self.height_m.filter(|height_m| *height_m > 0.0)
    }
}
