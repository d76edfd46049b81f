//! Whether a bag holds what is to be learned from it, and what is missing.

use super::params::Excitation;
use super::record::{At, Recorded};
use super::series;
use models::extruder::Extruder;
use models::status::PrinterStatus;
use runtime::topics;

/// A state lasts until the next one, but not across a gap `[s]`.
const GAP_S: f64 = 1.0;
/// Longer than this nothing may be missing `[s]`: what heated meanwhile nobody knows.
const HOLE_S: f64 = 2.0;
/// Time over which a flow is averaged `[s]`.
const FLOW_S: f64 = 0.2;

/// What a moment of the print was like.
#[derive(Debug, Clone, Copy)]
struct Moment {
    lasts_s: f64,
    hot: bool,
    duty: f64,
    fan: f64,
    flow_m3_s: f64,
    depositing: bool,
}

/// Everything that the print lacks whose topics are all there, one line each; nothing where it holds enough.
pub(super) fn print(
    recorded: &Recorded,
    extruder: &Extruder,
    wanted: &Excitation,
    with_flow: bool,
) -> Vec<String> {
    let mut lacking = Vec::new();
    let fed_m = recorded.fed_m();
    let flow_m3_s = |at_s: f64| {
        let fed_m = series::at(&fed_m, at_s) - series::at(&fed_m, at_s - FLOW_S);
        extruder.filament_area_m2() * fed_m / FLOW_S
    };
    let start_k = recorded.hotend_k.first().map_or(0.0, |first| first.1);
    let moment = |pair: &[PrinterStatus]| Moment {
        lasts_s: (pair[1].stamp.0 - pair[0].stamp.0).min(GAP_S),
        hot: series::at(&recorded.hotend_k, pair[0].stamp.0) - start_k > wanted.hot_k,
        duty: pair[0].hotend_duty,
        fan: pair[0].fan,
        flow_m3_s: flow_m3_s(pair[0].stamp.0),
        depositing: pair[0].depositing,
    };
    let moments: Vec<Moment> = recorded.states.windows(2).map(moment).collect();
    lacking.extend(heat(recorded, &moments, wanted));
    lacking.extend(cooling(&moments, wanted));
    if with_flow {
        lacking.extend(steps(recorded, &moments, wanted, &flow_m3_s));
    }
    lacking
}

/// Topics that are not there, or too slow, one line each.
pub(super) fn streams(recorded: &Recorded, wanted: &Excitation, with_flow: bool) -> Vec<String> {
    let state_hz = if with_flow { wanted.motion_hz } else { wanted.state_hz };
    let times = |samples: &[At]| series::rate_hz(samples.iter().map(|(at_s, _)| *at_s));
    let mut lacking = Vec::new();
    lacking.extend(hole(topics::HOTEND_TEMPERATURE.name(), recorded.hotend_k.iter().map(|(at_s, _)| *at_s)));
    lacking.extend(hole(topics::PRINTER_STATE.name(), recorded.states.iter().map(|state| state.stamp.0)));
    let mut demand = |topic: &str, hz: f64, wanted_hz: f64, what: &str| {
        if hz <= 0.0 {
            lacking.push(format!("{topic}: not in the bag: {what}"));
        } else if hz < wanted_hz * 0.95 {
            lacking.push(format!("{topic}: {hz:.1} times a second, {wanted_hz} are needed: {what}"));
        }
    };
    let hotend_hz = times(&recorded.hotend_k);
    demand(topics::HOTEND_TEMPERATURE.name(), hotend_hz, wanted.temperature_hz, "the thermistor's readings");
    let states_hz = series::rate_hz(recorded.states.iter().map(|state| state.stamp.0));
    let what = if with_flow {
        "duty, fan, speed of the tool; --only hotend does with fewer"
    } else {
        "duty and fan"
    };
    demand(topics::PRINTER_STATE.name(), states_hz, state_hz, what);
    if with_flow && !recorded.encoder_m.is_empty() {
        let encoder_hz = times(&recorded.encoder_m);
        demand(topics::FILAMENT_MOTION.name(), encoder_hz, wanted.motion_hz, "what was fed");
    }
    if with_flow && recorded.widths.is_empty() {
        lacking.push(format!(
            "{}: not in the bag: a camera tells the lag; --only hotend does without",
            topics::BEAD_WIDTH.name()
        ));
    }
    lacking
}

/// The longest hole of a topic that is too long, from its first message on.
fn hole(topic: &str, stamps_s: impl Iterator<Item = f64>) -> Option<String> {
    let stamps_s: Vec<f64> = stamps_s.collect();
    let holes = stamps_s.windows(2).map(|pair| (pair[0] - stamps_s[0], pair[1] - pair[0]));
    let (at_s, for_s) = holes.filter(|(_, for_s)| *for_s > HOLE_S).max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(format!(
        "{topic}: nothing for {for_s:.1} s from {at_s:.0} s on, {HOLE_S} s may be missing: what went on meanwhile would be \
         guessed; record without a break, from a disk that keeps up"
    ))
}

fn heat(recorded: &Recorded, moments: &[Moment], wanted: &Excitation) -> Vec<String> {
    let mut lacking = Vec::new();
    let temps = recorded.hotend_k.iter().map(|(_, temp_k)| *temp_k);
    let (low_k, high_k) =
        temps.fold((f64::INFINITY, 0.0_f64), |(low, high), temp| (low.min(temp), high.max(temp)));
    let rise_k = high_k - recorded.hotend_k.first().map_or(high_k, |first| first.1);
    if rise_k < wanted.rise_k || low_k < recorded.hotend_k[0].1 - 5.0 {
        let needed_k = wanted.rise_k;
        lacking.push(format!(
            "temperature: it rises by {rise_k:.0} K from the start of the bag, {needed_k} K are needed: begin to record \
             before a cold printer heats"
        ));
    }
    let cold_s: f64 = moments.iter().take_while(|at| at.duty <= wanted.duty_low).map(|at| at.lasts_s).sum();
    let mut demand = |found_s: f64, wanted_s: f64, what: &str, how: &str| {
        if found_s < wanted_s {
            // A sum of nothing is -0.
            lacking.push(format!("{what} for {:.0} s, {wanted_s} s are needed: {how}", found_s + 0.0));
        }
    };
    demand(cold_s, wanted.cold_s, "duty: heater off at the start", "G4 before the first M104");
    let spent_s =
        |is: &dyn Fn(&Moment) -> bool| moments.iter().filter(|at| is(at)).map(|at| at.lasts_s).sum();
    let full_s = spent_s(&|at| at.duty >= wanted.duty_high);
    let none_s = spent_s(&|at| at.hot && at.duty <= wanted.duty_low);
    demand(full_s, wanted.duty_s, "duty: nearly full", "heat up from cold in one go");
    demand(none_s, wanted.duty_s, "duty: hot and hardly any", "a set-point 40 K lower for a while");
    lacking
}

fn cooling(moments: &[Moment], wanted: &Excitation) -> Vec<String> {
    let mut lacking = Vec::new();
    let spent_s = |is: &dyn Fn(&Moment) -> bool| -> f64 {
        moments.iter().filter(|at| at.hot && is(at)).map(|at| at.lasts_s).sum()
    };
    let still_m3_s = 0.1 * wanted.flow_m3_s;
    let mut demand = |found_s: f64, wanted_s: f64, what: &str, how: &str| {
        if found_s < wanted_s {
            // A sum of nothing is -0.
            lacking.push(format!("{what} for {:.0} s, {wanted_s} s are needed: {how}", found_s + 0.0));
        }
    };
    let off = |at: &Moment| at.fan <= wanted.fan_low;
    let still_s = spent_s(&|at| off(at) && at.flow_m3_s < still_m3_s);
    let fan_s = spent_s(&|at| at.fan >= wanted.fan_high);
    let flow_s = spent_s(&|at| at.flow_m3_s >= wanted.flow_m3_s);
    demand(still_s, wanted.still_s, "fan and flow: hot without both", "G4 with M107 at the set-point");
    let on = format!("fan: hot with {:.0} % or more", 100.0 * wanted.fan_high);
    demand(fan_s, wanted.fan_s, &on, "M106 S255, then G4, at the set-point");
    let flow = format!("flow: hot with {:.1} mm3/s or more", 1e9 * wanted.flow_m3_s);
    demand(flow_s, wanted.flow_s, &flow, "long roads at 30 mm/s or more: it tells the nozzle from the block");
    lacking
}

fn steps(
    recorded: &Recorded,
    moments: &[Moment],
    wanted: &Excitation,
    flow_m3_s: &dyn Fn(f64) -> f64,
) -> Vec<String> {
    let mut lacking = Vec::new();
    let found = recorded.widths.len();
    if found < wanted.widths {
        lacking.push(format!("widths: {found}, {} are needed: longer roads under the camera", wanted.widths));
    }
    let after = |at_s: f64| {
        let now = flow_m3_s(at_s);
        let changed = |before: f64| (before - now).abs() > wanted.step_rel * now.abs().max(1e-12);
        (1..=5).any(|part| changed(flow_m3_s(at_s - wanted.after_s * f64::from(part) / 5.0)))
    };
    let changed = recorded.widths.iter().filter(|width| after(width.at_s)).count();
    if changed < wanted.after_step {
        lacking.push(format!(
            "flow: {changed} widths within {} s of a change by {:.0} %, {} are needed: roads whose speed changes every 2 to 3 s",
            wanted.after_s,
            100.0 * wanted.step_rel,
            wanted.after_step
        ));
    }
    let mut flows: Vec<f64> = moments.iter().filter(|at| at.depositing).map(|at| at.flow_m3_s).collect();
    flows.sort_by(f64::total_cmp);
    let share = |part: usize| flows.get(flows.len() * part / 20).copied().unwrap_or(0.0);
    let (low, high) = (share(2), share(18));
    if !(high >= wanted.flow_ratio * low && low > 0.0) {
        lacking.push(format!(
            "flow: from {:.1} to {:.1} mm3/s, the fast {:.1} times the slow; {} times are needed: slow and fast roads",
            1e9 * low,
            1e9 * high,
            if low > 0.0 { high / low } else { 0.0 },
            wanted.flow_ratio
        ));
    }
    lacking
}
