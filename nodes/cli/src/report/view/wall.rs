//! The wall of the wire process.

use super::ink::Ink;
use super::trace::Trace;
use super::{View, absent};
use maud::{Markup, html};
use runtime::topics;

/// Whether a section is of what a wire machine does not have, and the bag does not either.
pub(crate) fn is_foreign(view: &View, section: &str) -> bool {
    let (signals, layers) = (&view.record.signals, &view.record.layers);
    let estimated = !signals.nozzle_degc.value.is_empty();
    match section {
        "temperatures" => signals.hotend_degc.is_empty() && signals.bed_degc.is_empty() && !estimated,
        "slip" => signals.slip_percent.value.is_empty(),
        "width" => signals.width_measured.is_empty() && signals.width_estimated.is_empty(),
        "quality" => layers.layers.values().all(|layer| layer.quality.is_none()),
        "confidence" => signals.confidence.is_empty(),
        "pictures" => view.record.pictures.seen == 0,
        "layers" => layers.roads.is_empty(),
        "consistency" => signals.channels.is_empty(),
        "vibration" => signals.imu.peak_m_s2.is_empty(),
        _ => false,
    }
}

/// Measured heights, and the truth apart from them; `None` where no wall was built.
pub(crate) fn wall(view: &View) -> Option<Markup> {
    let wall = &view.record.wall;
    if wall.measured_mm.is_empty() && wall.last.is_none() {
        return None;
    }
    let measured = vec![Trace::line("measured", Ink::Measured, &wall.measured_mm)];
    let height = vec![Trace::line("true, mean over the length", Ink::Fourth, &wall.height_mm)];
    let error = vec![Trace::line("RMS of the last complete layer", Ink::Fourth, &wall.layer_rms_mm)];
    Some(html! {
        p.note { "A wire machine has no hot end, bed, drive gear or camera: sections of what the bag does not hold are left out." }
        (view.plot("Height of the wall", "mm", measured).draw())
        @if wall.measured_mm.is_empty() { (absent("Height", topics::LAYER_HEIGHT.name())) }
        @if let Some(last) = &wall.last {
            div.simulated {
                p { "The process was simulated. This is what it really laid; no node of the loop was told." }
                dl.cards {
                    div { dt { "Layers complete" } dd { (last.layers_complete) } }
                    div { dt { "Height error, RMS of all layers" } dd { (format!("{:.3} mm", last.rms_m * 1e3)) } }
                    div { dt { "Height error, RMS of the last layer" } dd { (format!("{:.3} mm", last.layer_rms_m * 1e3)) } }
                }
                (view.plot("True height of the wall", "mm", height).draw())
                (view.plot("Height error", "mm", error).draw())
            }
        }
    })
}
