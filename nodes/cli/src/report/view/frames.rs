//! Pictures of the camera and maps of layers.

use super::map::{self, Colouring, ERRORS, Map};
use super::words::clock;
use super::{View, absent};
use crate::report::record::layers::Layer;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use maud::{Markup, PreEscaped, html};
use runtime::topics;

/// Layers that are drawn.
const LAYERS_MAX: usize = 6;

/// Pictures of what was flagged, with its cause.
pub(crate) fn pictures(view: &View) -> Markup {
    let pictures = &view.record.pictures;
    let chosen = pictures.chosen();
    html! {
        @if pictures.seen == 0 {
            (absent("Pictures", topics::ANNOTATED.name()))
        } @else {
            p.note {
                "Frames that were flagged, and what the camera saw at warnings and errors: " (chosen.len()) " of "
                (pictures.seen) " frames. The line in a picture is what the camera's judge makes of that frame by its looks; \
                 what the supervisor decided, and why, stands below it."
                @if pictures.left_out > 0 { " " (pictures.left_out) " lighter ones were left out." }
                @if pictures.refused > 0 { " " (pictures.refused) " are no JPEG or PNG, or too large to be shown here." }
            }
        }
        div.grid.pictures {
            @for picture in chosen {
                figure {
                    img alt=(picture.title) src=(format!("data:{};base64,{}", picture.media, BASE64_STANDARD.encode(&picture.data)));
                    figcaption { b { (picture.title) } " at " (clock(picture.at)) br; (picture.detail) }
                }
            }
        }
    }
}

/// Maps of the layers that one wants to see.
pub(crate) fn layers(view: &View) -> Markup {
    let layers = &view.record.layers;
    if layers.roads.is_empty() {
        return absent("Roads of the layers", topics::PRINTER_MOTION.name());
    }
    let maps: Vec<(u32, String, Map)> = of_interest(view)
        .into_iter()
        .filter_map(|(number, why)| Some((number, why, map::draw(layers, number)?)))
        .collect();
    let errors = maps.iter().any(|(.., map)| map.colouring == Colouring::Error);
    let fastest = maps.iter().find_map(|(.., map)| match map.colouring {
        Colouring::Speed(fastest) => Some(fastest),
        Colouring::Error => None,
    });
    html! {
        p.note { "From above, each road as wide as it was asked for." }
        @if errors { (error_scale()) }
        @if let Some(fastest) = fastest { (speed_scale(fastest)) }
        div.grid {
            @for (number, why, map) in &maps {
                figure {
                    div role="img" aria-label=(format!("layer {}", u64::from(*number) + 1)) { (PreEscaped(&map.drawing)) }
                    figcaption {
                        b { "Layer " (u64::from(*number) + 1) } ", " (why) br;
                        (format!("{:.1} mm x {:.1} mm, {} roads", map.size_mm[0], map.size_mm[1], map.roads))
                        @if map.left_out > 0 { ", " (map.left_out) " left out" }
                        @if let Some(layer) = layers.layers.get(number) { (figures(layer)) }
                    }
                }
            }
        }
        @if layers.beyond + layers.refused > 0 {
            p.note { (layers.beyond) " roads were too many to be kept, " (layers.refused) " have numbers that cannot be." }
        }
    }
}

fn figures(layer: &Layer) -> Markup {
    html! {
        @if let Some((from, to)) = layer.span_s { br; "from " (clock(from)) " to " (clock(to)) }
        @if let Some(rms) = layer.width_rms() { br; (format!("width error {:.1} % RMS by the estimate", rms * 100.0)) }
        @if let Some(quality) = &layer.quality { br; (format!("Q {:.2}", quality.quality)) @if !quality.complete { ", not complete" } }
        @if layer.flagged > 0 { br; (layer.flagged) " frames flagged" }
    }
}

/// First, last, worst and flagged layers, each with the reason.
fn of_interest(view: &View) -> Vec<(u32, String)> {
    let layers = &view.record.layers.layers;
    let badness =
        |layer: &Layer| layer.quality.as_ref().map(|quality| quality.quality).or_else(|| layer.width_rms());
    let mut by_badness: Vec<(u32, f64)> =
        layers.iter().filter_map(|(number, layer)| Some((*number, badness(layer)?))).collect();
    by_badness.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut flagged: Vec<(u32, u64)> = layers
        .iter()
        .filter(|(_, layer)| layer.flagged > 0)
        .map(|(number, layer)| (*number, layer.flagged))
        .collect();
    flagged.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let named = |number: Option<u32>, why: &str| number.map(|number| (number, why.to_owned()));
    let known: Vec<u32> = layers.keys().copied().collect();
    let wanted = [
        named(known.first().copied(), "the first"),
        named(by_badness.first().map(|(number, _)| *number), "the worst"),
        named(flagged.first().map(|(number, _)| *number), "flagged"),
        named(flagged.get(1).map(|(number, _)| *number), "flagged"),
        named(by_badness.get(1).map(|(number, _)| *number), "the second worst"),
        named(known.last().copied(), "the last"),
    ];
    let mut chosen: Vec<(u32, String)> = Vec::new();
    for (number, why) in wanted.into_iter().flatten() {
        match chosen.iter_mut().find(|(known, _)| *known == number) {
            Some((_, reasons)) if !reasons.contains(&why) => reasons.push_str(&format!(", {why}")),
            Some(_) => {}
            None => chosen.push((number, why)),
        }
    }
    chosen.truncate(LAYERS_MAX);
    chosen.sort();
    chosen
}

fn error_scale() -> Markup {
    let names: Vec<String> = (0..=ERRORS.len())
        .map(|class| match class {
            0 => format!("below {:.0} %", ERRORS[0] * 100.0),
            last if last == ERRORS.len() => format!("above {:+.0} %", ERRORS[last - 1] * 100.0),
            class => format!("{:+.0} to {:+.0} %", ERRORS[class - 1] * 100.0, ERRORS[class] * 100.0),
        })
        .collect();
    scale("Estimated width against the target:", &names, true)
}

fn speed_scale(fastest_mm_s: f32) -> Markup {
    let end = |class: usize| f64::from(fastest_mm_s) * class as f64 / (ERRORS.len() + 1) as f64;
    let names: Vec<String> =
        (0..=ERRORS.len()).map(|class| format!("{:.0} to {:.0} mm/s", end(class), end(class + 1))).collect();
    scale("No width is known, so planned speed:", &names, false)
}

fn scale(title: &str, names: &[String], unknown: bool) -> Markup {
    html! {
        div.scale {
            span { (title) }
            @for (class, name) in names.iter().enumerate() {
                span { i style=(format!("background:var(--c{class})")) {} (name) }
            }
            @if unknown { span { i style="background:var(--c7)" {} "not known" } }
        }
    }
}
