//! Comments with meaning: layer marks, roles, widths and heights.

use super::modal::{MM, Modal};
use super::number::number;
use crate::motion::Role;

/// Reads the text after `;`.
pub(super) fn read(text: &[u8], modal: &mut Modal) {
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
        Some(b'W') => stated(value(b"WIDTH:"), &mut modal.width_m),
        Some(b'H') => stated(value(b"HEIGHT:"), &mut modal.height_m),
        Some(b'Z') => stated(value(b"Z:").or(value(b"Z_HEIGHT:")), &mut modal.layer_z_m),
        Some(b'L') => {
            stated(value(b"LINE_WIDTH:"), &mut modal.width_m);
            stated(value(b"LAYER_HEIGHT:"), &mut modal.height_m);
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

/// A positive millimetre value in metres; anything else takes the stated value away.
fn stated(text: Option<&[u8]>, field: &mut Option<f64>) {
    if let Some(text) = text {
        *field = number(text).map(|(mm, _)| mm * MM).filter(|value_m| *value_m > 0.0 && value_m.is_finite());
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
