//! `fdm inject`: a fault for the simulated printer while it prints.

use crate::operate::{executor, in_namespace};
use crate::output;
use crate::participant;
use anyhow::{Context, bail};
use clap::Args;
use fdm_loop_msgs::InjectFaultRequest;
use models::units::Seconds;
use printer_sim::faults::{Component, Kind};
use printer_sim::scenario::{
    COMPONENTS, Course, Entry, FaultError, LONGEST_S, SHORTEST_S, Size, allowed_kinds, size_of,
};
use runtime::{CallError, topics};
use std::fmt::Write;

/// Longest wait for the simulated printer to be found and to answer `[s]`.
const ANSWERED_S: f64 = 5.0;

/// A fault as in a scenario file, from now on. The graph was started with `fdm up --allow-fault-injection`.
#[derive(Debug, Args)]
#[command(after_help = catalogue())]
pub struct InjectArgs {
    /// Part of the printer that fails; all of them stand below.
    component: String,
    /// How it fails.
    kind: String,
    /// How much, in the unit of the kind; needed where the kind has one.
    #[arg(long, allow_negative_numbers = true)]
    size: Option<f64>,
    /// Delay until it sets in [s].
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    start_s: f64,
    /// Time to grow from nothing to full size [s]; 0 at once.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    ramp_s: f64,
    /// How long it lasts from its onset [s]; for good where it is left out.
    #[arg(long, allow_negative_numbers = true)]
    duration_s: Option<f64>,
    /// Seed of what is random in noise, spikes and loose, to have the same again; the seed of the run where it is left out.
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..))]
    seed: Option<u64>,
    /// Namespace of the printer.
    #[arg(long, default_value = "/printer", value_parser = runtime::check_namespace)]
    namespace: String,
}

/// Every fault with unit and range of its size, one component a line.
fn catalogue() -> String {
    let mut text = "Components, their kinds, and unit and range of the size:\n".to_owned();
    for component in COMPONENTS {
        let kinds: Vec<String> = allowed_kinds(component)
            .split(", ")
            .map(|name| {
                let size = Kind::from_name(name).and_then(|kind| size_of(component, kind));
                size.map_or(name.to_owned(), |Size { unit, low, high }| {
                    format!("{name} [{unit}] {low}..{high}")
                })
            })
            .collect();
        // Writing to a string cannot fail.
        _ = writeln!(text, "  {:<18} {}", component.name(), kinds.join(", "));
    }
    text + "What they do: config/scenarios/README.md"
}

/// Asks the simulated printer once, and tells what it has scheduled.
///
/// # Errors
/// What cannot be injected, no simulated printer that takes faults, or one that refuses; exit code 2.
pub fn run(args: &InjectArgs) -> anyhow::Result<()> {
    let request = request(args)?;
    let name = topics::INJECT_FAULT.name();
    let answer = executor()?.block_on(async {
        let mut node = participant::join("fdm", in_namespace(&args.namespace))?;
        // Asked once: a second request would be a second fault.
        anyhow::Ok(node.client(&topics::INJECT_FAULT)?.call(request, Seconds(ANSWERED_S)).await)
    })?;
    let todo = answer.as_ref().err().map_or(String::new(), |error| not_there(error, &args.namespace));
    let answer = answer.context(todo)?;
    if !answer.accepted {
        bail!("the simulated printer refused {name}: {}", answer.message);
    }
    output::line(&format!("injected: {}", answer.message))
}

/// What is asked for, if a simulated printer of this version takes it.
fn request(args: &InjectArgs) -> Result<InjectFaultRequest, FaultError> {
    let component = Component::from_name(&args.component)
        .ok_or_else(|| FaultError::UnknownComponent { component: args.component.clone() })?;
    let kind = Kind::from_name(&args.kind).ok_or_else(|| FaultError::Unknown {
        component: args.component.clone(),
        kind: args.kind.clone(),
        allowed: allowed_kinds(component),
    })?;
    let course = Course { size: args.size, ramp_s: args.ramp_s, duration_s: args.duration_s };
    // On the wire 0 is none: who types one is told that the kind has none.
    if let (Some(size), true) = (args.size, takes_no_size(component, kind)) {
        return Err(FaultError::Sized { size, kind: args.kind.clone() });
    }
    // On the wire 0 is for good.
    if let Some(duration_s) = args.duration_s.filter(|duration_s| *duration_s == 0.0) {
        let (name, unit, high) = ("duration_s", "s", LONGEST_S);
        return Err(FaultError::OutOfRange { name, value: duration_s, unit, low: SHORTEST_S, high });
    }
    let entry = Entry::after(Seconds(0.0), (component, kind), course, args.start_s)?;
    // On the wire 0 is none.
    args.seed.map_or(Ok(entry), |seed| entry.seeded(seed))?;
    Ok(InjectFaultRequest {
        component: args.component.clone(),
        kind: args.kind.clone(),
        size: args.size.unwrap_or(0.0),
        start_s: args.start_s,
        duration_s: args.duration_s.unwrap_or(0.0),
        seed: args.seed.unwrap_or(0),
        ramp_s: args.ramp_s,
    })
}

/// The component has such a fault, and it is there or not.
fn takes_no_size(component: Component, kind: Kind) -> bool {
    size_of(component, kind).is_none()
        && Entry::at(component, kind, Course { size: None, ramp_s: 0.0, duration_s: None }, 0.0).is_ok()
}

/// Who is not there, and what to do.
fn not_there(error: &CallError, namespace: &str) -> String {
    match error {
        CallError::NoServer(_) => format!(
            "no simulated printer of {namespace} takes faults: start it with `fdm up --allow-fault-injection`, in this \
             ROS_DOMAIN_ID (a real printer takes none)"
        ),
        _ => "not confirmed: it may have been injected, the topic `events` tells `fault_injected` then"
            .to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: InjectArgs,
    }

    fn asked(line: &str) -> Result<InjectFaultRequest, String> {
        let args = Line::try_parse_from(["inject"].into_iter().chain(line.split(' '))).unwrap().args;
        request(&args).map_err(|error| error.to_string())
    }

    #[test]
    fn a_line_becomes_a_request() {
        let request =
            asked("hotend_thermistor bias --size -60 --ramp-s 300 --start-s 5 --duration-s 400").unwrap();
        let numbers = [request.size, request.ramp_s, request.start_s, request.duration_s];
        assert_eq!((request.component.as_str(), request.kind.as_str()), ("hotend_thermistor", "bias"));
        let expected = [-60.0, 300.0, 5.0, 400.0];
        let noise = asked("bed_thermistor noise --size 10 --seed 7").unwrap();
        assert_eq!((request.seed, noise.seed), (0, 7));
        assert!(numbers.iter().zip(expected).all(|(told, asked)| (told - asked).abs() < 1e-9), "{numbers:?}");
    }

    /// Before anything is asked of a graph: which word, which number, and what it may be.
    #[test]
    fn what_no_printer_takes_is_refused_with_what_there_is() {
        for (line, told) in [
            (
                "nozzle slip --size 0.1",
                "component = nozzle: there is none of this name; it can be extruder, ",
            ),
            ("extruder slop --size 0.1", "kind = slop: not a fault of extruder; it can be slip, clog, leak"),
            ("extruder slip", "size: slip needs one in [0, 0.95] (no unit), see "),
            ("hotend_thermistor bias", "size: bias needs one in [-300, 300] K, see "),
            (
                "hotend_thermistor open --size 0.5",
                "size = 0.5: open has none, it is there or not; leave it out",
            ),
            ("hotend_thermistor open --size 0", "size = 0: open has none"),
            ("stop_input pressed --size 3", "size = 3: pressed has none"),
            ("part detached --size 0.5", "size = 0.5: detached has none"),
            ("extruder slip --size 2", "size = 2 (no unit): must be in [0, 0.95]"),
            ("extruder slip --size 0.1 --start-s -5", "start_s = -5 s: must be in [0, 604800]"),
            (
                "extruder slip --size 0.1 --duration-s 1e-9",
                "duration_s = 0.000000001 s: must be in [0.001, 604800]",
            ),
            (
                "extruder slip --size 0.1 --seed 7",
                "seed = 7: nothing of slip is random, leave it out (0); noise",
            ),
            ("camera noise --size 2", "kind = noise: not a fault of camera; it can be off, stuck"),
            ("part detached --ramp-s 3", "ramp_s: detached has none, leave it out"),
        ] {
            let refusal = asked(line).unwrap_err();
            assert!(refusal.starts_with(told), "{line}: {refusal}");
        }
    }

    /// A duration of 0 would be for good on the wire.
    #[test]
    fn a_fault_of_no_time_is_refused() {
        let refusal = asked("extruder slip --size 0.1 --duration-s 0").unwrap_err();
        assert_eq!(refusal, "duration_s = 0 s: must be in [0.001, 604800]");
    }

    #[test]
    fn the_help_names_every_fault_with_unit_and_range() {
        let help = catalogue();
        for told in [
            "extruder           slip [-] 0..0.95, clog [-] 0.05..1, leak [-] 0..0.9\n",
            "hotend_heater      gain [-] 0..1, stuck_on\n",
            "motion             layer_shift_x [m] -0.05..0.05, layer_shift_y [m] -0.05..0.05, knock [m/s2] 0..200\n",
            "encoder            off, stuck\n",
            "camera             off, stuck\n",
            "part               detached\n",
        ] {
            assert!(help.contains(told), "{told}: {help}");
        }
        assert_eq!(help.lines().count(), COMPONENTS.len() + 2);
    }
}
