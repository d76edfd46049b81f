//! The plots, each with what it is made from and what is missing.

use super::chart::Plot;
use super::ink::Ink;
use super::trace::Trace;
use super::words::percent;
use super::{View, absent, bars};
use crate::report::series::Series;
use maud::{Markup, html};
use runtime::topics;

impl<'a> View<'a> {
    /// A plot of this print.
    pub(super) fn plot(&'a self, title: &'a str, unit: &'a str, traces: Vec<Trace<'a>>) -> Plot<'a> {
        let markers = &self.markers;
        Plot {
            title,
            unit,
            span_s: self.span_s,
            traces,
            markers,
            onset_s: None,
            shows: None,
            band: None,
            logarithm: false,
        }
    }
}

/// Names of topics whose signal is missing.
fn missing(signals: &[(&Series, &'static str, &'static str)]) -> Markup {
    html! {
        @for (series, what, topic) in signals {
            @if series.is_empty() { (absent(what, topic)) }
        }
    }
}

/// Hot end, nozzle and bed.
pub(crate) fn temperatures(view: &View) -> Markup {
    let signals = &view.record.signals;
    let hot = vec![
        Trace::line("set-point", Ink::Target, &signals.hotend_target_degc),
        Trace::line("hot end, measured", Ink::Measured, &signals.hotend_degc),
        Trace::estimated("nozzle, estimated ±2σ", Ink::Estimated, &signals.nozzle_degc),
        Trace::line("nozzle, measured", Ink::Fourth, &signals.nozzle_sensor_degc),
    ];
    let bed = vec![
        Trace::line("set-point", Ink::Target, &signals.bed_target_degc),
        Trace::line("bed, measured", Ink::Measured, &signals.bed_degc),
    ];
    let error = vec![Trace::line("measured less set-point", Ink::Measured, &signals.hotend_error_k)];
    let error = Plot { shows: Some((-2.0, 2.0)), ..view.plot("Hot end while roads are laid", "K", error) };
    html! {
        (view.plot("Hot end", "°C", hot).draw())
        (error.draw())
        (Plot { shows: around(&signals.bed_target_degc), ..view.plot("Bed", "°C", bed) }.draw())
        (missing(&[
            (&signals.hotend_degc, "Hot end", topics::HOTEND_TEMPERATURE.name()),
            (&signals.bed_degc, "Bed", topics::BED_TEMPERATURE.name()),
            (&signals.nozzle_degc.value, "Estimated nozzle", topics::ESTIMATE.name()),
            (&signals.hotend_target_degc, "Set-points", topics::PRINTER_STATE.name()),
        ]))
    }
}

/// A few kelvin around the newest set-point: noise of a tenth is not to fill the plot.
fn around(target_degc: &Series) -> Option<(f64, f64)> {
    let newest = target_degc.columns(usize::MAX, 1.0).last()?.cell.mean();
    Some((newest - 2.0, newest + 2.0))
}

/// Slip of the drive gear and gain of the road.
pub(crate) fn slip(view: &View) -> Markup {
    let signals = &view.record.signals;
    if signals.slip_percent.value.is_empty() {
        return absent("Slip and gain", topics::ESTIMATE.name());
    }
    let slip = vec![Trace::estimated("slip ±2σ", Ink::Estimated, &signals.slip_percent)];
    let gain = vec![Trace::estimated("gain ±2σ", Ink::Fifth, &signals.gain_percent)];
    let slip = Plot { shows: Some((0.0, 5.0)), ..view.plot("Filament lost in the drive gear", "%", slip) };
    let gain = Plot {
        shows: Some((95.0, 105.0)),
        ..view.plot("Section of the road over the nominal one", "%", gain)
    };
    html! {
        (slip.draw())
        (gain.draw())
        @if signals.estimates_refused > 0 {
            p.note { (signals.estimates_refused) " of " (signals.estimates) " estimates have numbers that cannot be." }
        }
    }
}

/// Target, measured and estimated width.
pub(crate) fn width(view: &View) -> Markup {
    let signals = &view.record.signals;
    let traces = vec![
        Trace::line("estimated", Ink::Estimated, &signals.width_estimated),
        Trace::dots("measured", Ink::Measured, &signals.width_measured),
        Trace::line("target", Ink::Target, &signals.width_target),
    ];
    let (count, sum, squares) = view.record.layers.measured_rel;
    let mean = sum / count.max(1) as f64;
    let rms = (squares / count.max(1) as f64).sqrt();
    html! {
        (view.plot("Road width", "mm", traces).draw())
        @if !signals.width_estimated.is_empty() {
            p.note { "Estimated: flow of melt over path speed at the nozzle, as a stadium. Lines are means of a column of "
                "the plot, shades reach from its smallest to its largest value: corners are narrow in time and wide in value." }
        }
        @if count > 0 {
            p.note { "Measured against the target: mean " (percent(mean, 1)) ", RMS " (percent(rms, 1)) " over " (count)
                " measurements; source: " (signals.width_sources.join(", ")) "." }
        }
        (missing(&[
            (&signals.width_measured, "Measured width", topics::BEAD_WIDTH.name()),
            (&signals.width_estimated, "Estimated width", topics::ESTIMATE.name()),
            (&signals.width_target, "Target width", topics::PRINTER_STATE.name()),
        ]))
    }
}

/// Plots of commands that a wire machine knows: flow and speed.
const WALL_PLOTS: usize = 2;

/// What the controller wished and what the supervisor permitted.
pub(crate) fn commands(view: &View) -> Markup {
    let (wish, permit) = (&view.record.signals.wish, &view.record.signals.permit);
    let of_wall = view.record.wall.layers().is_some();
    let pair = |wished, permitted| {
        vec![
            Trace::broad("permitted", Ink::Estimated, permitted),
            Trace::line("wished", Ink::Measured, wished),
        ]
    };
    let plots = [
        ("Flow", "%", pair(&wish.flow_percent, &permit.flow_percent), (98.0, 102.0)),
        ("Speed", "%", pair(&wish.speed_percent, &permit.speed_percent), (98.0, 102.0)),
        ("Hot end set-point, offset", "K", pair(&wish.offset_k, &permit.offset_k), (-1.0, 1.0)),
        ("Pressure advance", "s", pair(&wish.advance_s, &permit.advance_s), (0.0, 0.1)),
        ("Slip made up for", "%", pair(&wish.slip_percent, &permit.slip_percent), (-1.0, 1.0)),
    ];
    html! {
        (missing(&[
            (&wish.flow_percent, "Wishes of the controller", topics::CONTROL_COMMAND.name()),
            (&permit.flow_percent, "Permits of the supervisor", topics::SAFETY_COMMAND.name()),
        ]))
        @for (title, unit, traces, shows) in plots.into_iter().take(if of_wall { WALL_PLOTS } else { usize::MAX }) {
            (Plot { shows: Some(shows), ..view.plot(title, unit, traces) }.draw())
        }
        @if !of_wall && !wish.flow_percent.is_empty() && wish.advance_s.is_empty() && permit.advance_s.is_empty() {
            p.note { "No pressure advance was commanded: the file's own was in force." }
        }
    }
}

/// Q of each layer.
pub(crate) fn quality(view: &View) -> Markup {
    let qualities: Vec<_> =
        view.record.layers.layers.values().filter_map(|layer| layer.quality.as_ref()).collect();
    if qualities.is_empty() {
        return absent("Quality of the layers", topics::LAYER_QUALITY.name());
    }
    let refused = view.record.layers.qualities_refused;
    html! {
        (bars::draw(&qualities))
        p.note { "What the loop could know of a layer: widths where the camera could measure one, noise taken off, the porosity of \
            the layer as a whole, and the estimated nozzle beside the temperature that the file's set-point means." }
        @if refused > 0 { p.note { (refused) " messages have numbers that cannot be." } }
    }
}

/// Confidence that the print fails.
pub(crate) fn confidence(view: &View) -> Markup {
    let signals = &view.record.signals;
    if signals.confidence.is_empty() {
        return absent("Confidence c_k in a defect", topics::DEFECTS.name());
    }
    let traces = vec![
        Trace::line("confidence c_k", Ink::Error, &signals.confidence),
        Trace::line("detection by the camera", Ink::Measured, &signals.detection),
        Trace::line("residual a_k over its limit, cut at 1", Ink::Target, &signals.residual),
    ];
    html! {
        (Plot { shows: Some((0.0, 1.0)), ..view.plot("Confidence in a defect", "-", traces) }.draw())
        p.note { (signals.frames) " frames, " (signals.frames_unusable) " of them could not be judged." }
    }
}

/// Whether the estimator's stated uncertainty fits.
pub(crate) fn consistency(view: &View) -> Markup {
    const INKS: [Ink; 5] = [Ink::Measured, Ink::Estimated, Ink::Fourth, Ink::Fifth, Ink::Target];
    let signals = &view.record.signals;
    if signals.channels.is_empty() {
        return absent("Normalised innovations (NIS)", topics::ESTIMATE.name());
    }
    let inks = INKS.into_iter().cycle();
    let traces = signals.channels.iter().zip(inks);
    let traces =
        traces.map(|(channel, ink)| Trace::line(&channel.name, ink, &channel.windowed_log)).collect();
    let (low, high) = band(signals.window);
    let plot = view.plot("NIS, mean over the window", "-", traces);
    let plot =
        Plot { band: Some((low.log10(), high.log10())), shows: Some((-1.0, 1.0)), logarithm: true, ..plot };
    html! {
        (plot.draw())
        p.note { "95 % of a consistent filter's windows of " (signals.window) " updates lie between "
            (format!("{low:.2}")) " and " (format!("{high:.2}")) " (shaded); less is cautious. Since the start "
            (signals.steps) " steps were taken as given, " (signals.resets) " resets." }
        div.scroll { table {
            thead { tr { th { "channel" } th.n { "mean NIS" } th.n { "gated" } th.n { "silent" } } }
            tbody { @for channel in &signals.channels { tr {
                td { (channel.name) }
                td.n { (channel.mean.map_or("-".to_owned(), |mean| format!("{mean:.2}"))) }
                td.n { (channel.gated) }
                td.n { (percent(channel.silent as f64 / channel.estimates.max(1) as f64, 1)) " of the time" }
            } } }
        } }
    }
}

/// 2.5 % and 97.5 % points of a mean of `count` squared standard normal numbers, by Wilson and Hilferty (1931).
fn band(count: u32) -> (f64, f64) {
    let spread = 2.0 / (9.0 * f64::from(count.max(1)));
    let point = |z: f64| (1.0 - spread + z * spread.sqrt()).powi(3);
    (point(-1.96).max(1e-3), point(1.96))
}

/// Shaking of the tool.
pub(crate) fn vibration(view: &View) -> Markup {
    let imu = &view.record.signals.imu;
    if imu.peak_m_s2.is_empty() {
        return absent("Accelerations", topics::IMU_BATCH.name());
    }
    let traces = vec![Trace::peaks("largest of each batch", Ink::Measured, &imu.peak_m_s2)];
    html! {
        (Plot { shows: Some((0.0, 1.0)), ..view.plot("Acceleration beside the mean", "m/s²", traces) }.draw())
        p.note { (imu.samples) " samples, " (imu.saturated) " at the range of the sensor, " (imu.refused) " batches refused." }
    }
}

/// What the simulated printer really did; `None` on a real one.
pub(crate) fn truth(view: &View) -> Option<Markup> {
    let (truth, signals) = (&view.record.truth, &view.record.signals);
    truth.last.as_ref()?;
    let nozzle = vec![
        Trace::line("right by the file", Ink::Target, &truth.reference_degc),
        Trace::line("true", Ink::Fourth, &truth.nozzle_degc),
        Trace::estimated("estimated ±2σ", Ink::Estimated, &signals.nozzle_degc),
    ];
    let slip = vec![
        Trace::line("true slip", Ink::Fourth, &truth.slip_percent),
        Trace::estimated("estimated ±2σ", Ink::Estimated, &signals.slip_percent),
    ];
    let width = vec![
        Trace::line("true", Ink::Fourth, &truth.width_mm),
        Trace::line("target", Ink::Target, &truth.target_mm),
    ];
    let latent = vec![
        Trace::line("adhesion", Ink::Fourth, &truth.adhesion),
        Trace::line("porosity", Ink::Error, &truth.porosity),
    ];
    let shift = vec![Trace::line("layer shift", Ink::Fifth, &truth.shift_mm)];
    let figure = |value: Option<f64>| value.map_or("-".to_owned(), |value| percent(value, 2));
    Some(html! {
        div.simulated {
            p { "The printer was simulated. This is what it really did; no node of the loop was told." }
            p.note { "Q counts every moment here, starts, corners and ends of roads too, and the porosity of each moment by \
                itself: it is larger than Q by layer, which knows a layer's measured widths and its porosity as a whole. Of \
                the width error there are three figures: the true one here, the measured one under Width, of places where \
                the camera could measure, and the estimated one beside each map, by flow over path speed. A nozzle beside \
                \u{201c}right by the file\u{201d} all along is the controller's choice: see Commands." }
            dl.cards {
                div { dt { "Feed error" } dd { (figure(truth.feed_error_rel())) } }
                div { dt { "Width error, RMS" } dd { (figure(truth.width_rms_rel())) } }
                div { dt { "Mean Q" } dd { (truth.quality_mean().map_or("-".to_owned(), |mean| format!("{mean:.2}"))) } }
                div { dt { "First fault" } dd { (truth.onset_s.map_or("none".to_owned(), super::words::clock)) } }
            }
            (view.plot("Nozzle", "°C", nozzle).draw())
            (Plot { shows: Some((0.0, 5.0)), ..view.plot("Slip", "%", slip) }.draw())
            (view.plot("Road width", "mm", width).draw())
            (Plot { shows: Some((0.0, 1.0)), ..view.plot("Latent quality", "-", latent) }.draw())
            (Plot { shows: Some((0.0, 1.0)), ..view.plot("Offset of the layer", "mm", shift) }.draw())
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chi-square with 20 degrees of freedom: 9.591 and 34.170 (tables).
    #[test]
    fn the_band_of_a_window_is_that_of_chi_square() {
        let (low, high) = band(20);
        assert!((low * 20.0 - 9.591).abs() < 0.06 && (high * 20.0 - 34.170).abs() < 0.06, "{low} {high}");
    }
}
