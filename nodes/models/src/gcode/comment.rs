//! Comments with meaning: layer marks, roles, widths and heights.

use super::modal::{MM, Modal};
use super::number::number;
use super::oddity::{Oddities, Oddity};
use crate::motion::Role;

/// Widths of roads `[mm]`: nozzles have 0.1 to 3 mm. A file in micrometres lies far outside.
const WIDTH_MM: (f64, f64) = (0.05, 5.0);
/// Heights of roads `[mm]`: ironing states a hundredth.
const HEIGHT_MM: (f64, f64) = (0.001, 5.0);

/// Reads the text after `;`.
pub(super) fn read(text: &[u8], modal: &mut Modal, odd: &mut Oddities) {
    let text = text.trim_ascii();
    let value = |key: &[u8]| text.strip_prefix(key).map(<[u8]>::trim_ascii);
    match text.first() {
        Some(b'T') => {
            if let Some(name) = value(b"TYPE:") {
                modal.role = role(name);
            }
        }
        Some(b'F') => {
            if let Some(name) = value(b"FEATURE:") {
                modal.role = role(name);
            }
        }
        Some(b'W') => stated("WIDTH", value(b"WIDTH:"), WIDTH_MM, (&mut modal.width_m, odd)),
        Some(b'H') => stated("HEIGHT", value(b"HEIGHT:"), HEIGHT_MM, (&mut modal.height_m, odd)),
        Some(b'Z') => {
            if let Some(text) = value(b"Z:").or(value(b"Z_HEIGHT:")) {
                let z_m = number(text).map(|(mm, _)| mm * MM);
                modal.layer_z_m = z_m.filter(|z_m| *z_m > 0.0 && z_m.is_finite());
            }
        }
        Some(b'L') => {
            stated("LINE_WIDTH", value(b"LINE_WIDTH:"), WIDTH_MM, (&mut modal.width_m, odd));
            stated("LAYER_HEIGHT", value(b"LAYER_HEIGHT:"), HEIGHT_MM, (&mut modal.height_m, odd));
            if text == b"LAYER_CHANGE" {
                next_layer(modal);
            } else if let Some(Some((index, _))) = value(b"LAYER:").map(number) {
                // Cura counts raft layers below zero: they count as layer 0
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
                let layer = index.clamp(0.0, f64::from(u32::MAX)) as u32;
                modal.marked = true;
                modal.layer_pending = modal.layer != Some(layer);
                modal.layer = Some(layer);
                modal.layer_z_m = None;
            }
        }
        Some(b'C') if text == b"CHANGE_LAYER" => next_layer(modal),
        _ => {}
    }
}

fn next_layer(modal: &mut Modal) {
    let seen = if modal.marked { modal.layer } else { None };
    modal.marked = true;
    modal.layer = Some(seen.map_or(0, |layer| layer.saturating_add(1)));
    modal.layer_pending = true;
    modal.layer_z_m = None;
}

/// Takes a millimetre value of a road; one that no road has is told, and takes the stated value away as no number does.
fn stated(
    name: &'static str,
    text: Option<&[u8]>,
    (low, high): (f64, f64),
    (field, odd): (&mut Option<f64>, &mut Oddities),
) {
    let Some(text) = text else { return };
    let value = number(text).map(|(mm, _)| mm);
    *field = value.filter(|mm| (low..=high).contains(mm)).map(|mm| mm * MM);
    if let (Some(value), None) = (value, &field) {
        odd.push(Oddity::Comment { name, value, low, high });
    }
}

fn role(name: &[u8]) -> Role {
    match name {
        b"Custom" => Role::Custom,
        b"SKIRT" | b"Skirt" | b"Brim" | b"Skirt/Brim" | b"skirt" | b"brim" => Role::Skirt,
        b"WALL-OUTER" | b"External perimeter" | b"Outer wall" | b"outer perimeter" => Role::ExternalPerimeter,
        b"WALL-INNER" | b"Perimeter" | b"Inner wall" | b"inner perimeter" => Role::Perimeter,
        b"Overhang perimeter" | b"Overhang wall" => Role::Overhang,
        b"FILL" | b"Internal infill" | b"Sparse infill" | b"infill" => Role::Infill,
        b"SKIN" | b"Solid infill" | b"Internal solid infill" | b"Bottom surface" | b"solid layer" => {
            Role::Solid
        }
        b"Top solid infill" | b"Top surface" => Role::TopSolid,
        b"Bridge infill" | b"Bridge" | b"Internal Bridge" | b"Internal bridge infill" | b"bridge" => {
            Role::Bridge
        }
        b"Gap fill" | b"Gap infill" | b"gap fill" => Role::GapFill,
        b"SUPPORT"
        | b"SUPPORT-INTERFACE"
        | b"Support material"
        | b"Support material interface"
        | b"Support"
        | b"Support interface"
        | b"support" => Role::Support,
        b"Ironing" => Role::Ironing,
        b"PRIME-TOWER" | b"Wipe tower" | b"Prime tower" => Role::Tower,
        _ => Role::Unknown,
    }
}
