//! Between messages and the brain's types.

use fdm_loop_msgs::{
    ControlCommand, DefectReport, FilamentMotion, Header, ImuBatch, MotionTrim, PrintEvent, PrinterState,
    SafetyState as StateMessage, StateEstimate, Temperature,
};
use models::command::{Mode, Scheduled};
use models::units::Seconds;
use runtime::wire::{self, WireError};

use crate::cause::Cause;
use crate::event::{
    Decision, Defect, Event, Evidence, Operator, PrinterReport, SafetyState, VisionReport, What, Worker,
};

pub fn hotend(message: &Temperature) -> Result<(Seconds, Event), WireError> {
    let (stamp, temp) = wire::temperature_from_wire(message)?;
    Ok((stamp, Event::Hotend { stamp, temp }))
}

pub fn bed(message: &Temperature) -> Result<(Seconds, Event), WireError> {
    let (stamp, temp) = wire::temperature_from_wire(message)?;
    Ok((stamp, Event::Bed { stamp, temp }))
}

pub fn encoder(message: &FilamentMotion) -> Result<(Seconds, Event), WireError> {
    let read = wire::filament_from_wire(message)?;
    Ok((read.stamp, Event::Encoder { stamp: read.stamp, position_m: read.position_m }))
}

pub fn printer(message: &PrinterState) -> Result<(Seconds, Event), WireError> {
    let status = wire::status_from_wire(message)?;
    Ok((status.stamp, Event::Printer(PrinterReport::from(&status))))
}

/// A wish, and what the controller says of the work behind it: in this order, since of a stranger neither counts.
pub fn command(message: &ControlCommand) -> Result<(Seconds, [Event; 2]), WireError> {
    let health = wire::control_health_from_wire(message)?;
    let wish = Event::Command(wire::command_from_wire(message)?);
    Ok((wire::stamp_from_wire(&message.header)?, [wish, Event::ControlHealth(health)]))
}

/// A trim of a coming move.
pub fn scheduled(message: &MotionTrim) -> Result<(Seconds, Scheduled), WireError> {
    Ok((wire::stamp_from_wire(&message.header)?, wire::schedule_from_wire(message)?))
}

/// Of an estimate the supervisor takes that there is one, and its health; a broken one is none.
pub fn estimate(message: &StateEstimate) -> Result<(Seconds, [Event; 2]), WireError> {
    let read = wire::estimate_from_wire(message)?;
    let heard = Event::EstimateHeartbeat { stamp: read.stamp };
    Ok((read.stamp, [Event::EstimateHealth(read.health), heard]))
}

pub fn imu(message: &ImuBatch) -> Result<(Seconds, Event), WireError> {
    let read = wire::imu_from_wire(message)?;
    Ok((read.first, Event::Imu { first: read.first, period: read.period, samples: read.samples }))
}

pub fn vision(message: &DefectReport) -> Result<(Seconds, Event), WireError> {
    let read = wire::defects_from_wire(message)?;
    let report = VisionReport {
        usable: read.usable,
        confidence: read.confidence,
        defect: Defect::from_name(&read.cause),
        confirmed: read.confirmed,
        told: read.told,
        offset_m: read.offset_m,
    };
    Ok((read.exposed, Event::Vision(report)))
}

/// The node of a process whose heart is listened to.
pub fn node_of(worker: Worker) -> &'static str {
    match worker {
        Worker::Encoder => "filament_encoder",
        Worker::Estimator => "state_estimator",
        Worker::Controller => "mpc_controller",
        Worker::Camera => "camera",
        Worker::Judge => "defect_classifier",
    }
}

/// A mode that a person may set.
pub fn set_mode(value: u8) -> Option<Mode> {
    [Mode::Observe, Mode::Advise, Mode::Act].into_iter().find(|mode| *mode as u8 == value)
}

/// State as sent, without the counters of the shell.
pub fn state(now: Seconds, state: &SafetyState) -> StateMessage {
    StateMessage {
        header: Header::at(now.0),
        mode: state.mode as u8,
        set_mode: state.set_mode as u8,
        attention: state.attention as u8,
        cause: state.cause.map_or_else(String::new, |cause| caused(cause, state.evidence)),
        since_s: state.since.0,
        what_to_do: state.what_to_do.to_owned(),
        latched: state.mode >= Mode::SafeOff,
        clamped: state.clamped_commands,
        ..StateMessage::default()
    }
}

/// A decision as sent.
pub fn event(now: Seconds, who: &str, decision: &Decision) -> PrintEvent {
    PrintEvent {
        header: Header::at(now.0),
        severity: severity(decision),
        who: who.to_owned(),
        what: what(decision.what),
        why: told(decision),
        before: mode_name(decision.before).to_owned(),
        after: mode_name(decision.after).to_owned(),
    }
}

/// Why it was decided, with cause, number and what to do; of a mode that was set, which.
pub fn told(decision: &Decision) -> String {
    let set = match decision.what {
        What::Granted(Operator::SetMode(mode)) => format!("{} is set: ", mode_name(mode)),
        _ => String::new(),
    };
    let Some((cause, number)) = decision.cause else { return format!("{set}{}", decision.why) };
    let why = if decision.why == cause.text() { String::new() } else { format!("{}; ", decision.why) };
    format!("{set}{why}{}. What to do: {}", caused(cause, number), cause.what_to_do())
}

/// A record of the former run that cannot be read: why, what is in force instead, and what to do.
pub fn record_refused(now: Seconds, who: &str, mode: Mode, cause: Cause, why: &str) -> PrintEvent {
    PrintEvent {
        header: Header::at(now.0),
        severity: PrintEvent::SEVERITY_ERROR,
        who: who.to_owned(),
        what: "record_refused".to_owned(),
        why: format!("{why}. What to do: {}", cause.what_to_do()),
        before: mode_name(mode).to_owned(),
        after: mode_name(mode).to_owned(),
    }
}

/// A cause behind its ID, with the number it rests on.
fn caused(cause: Cause, evidence: Option<Evidence>) -> String {
    let number = evidence.map_or_else(String::new, |number| format!(" ({number})"));
    format!("{}: {}{number}", cause.id(), cause.text())
}

fn severity(decision: &Decision) -> u8 {
    match decision.what {
        What::ModeChanged | What::CauseChanged | What::Remembered if decision.after >= Mode::SafeOff => {
            PrintEvent::SEVERITY_ERROR
        }
        What::ModeChanged | What::CauseChanged | What::Remembered if decision.after >= Mode::Degraded => {
            PrintEvent::SEVERITY_WARN
        }
        What::Granted(Operator::Stop | Operator::Estop) => PrintEvent::SEVERITY_ERROR,
        What::Granted(_) if decision.after > decision.before && decision.after >= Mode::Degraded => {
            PrintEvent::SEVERITY_WARN
        }
        What::ModeChanged | What::CauseChanged | What::Remembered | What::Granted(_) => {
            PrintEvent::SEVERITY_INFO
        }
        What::AlsoRaised
        | What::CommandClamped
        | What::CommandRefused(_)
        | What::Denied(_)
        | What::Impulse
        | What::PartFanSlow
        | What::StoodStill => PrintEvent::SEVERITY_WARN,
    }
}

fn what(what: What) -> String {
    match what {
        What::ModeChanged => "mode_changed".to_owned(),
        What::CauseChanged => "cause_changed".to_owned(),
        What::AlsoRaised => "also_raised".to_owned(),
        What::Remembered => "remembered".to_owned(),
        What::CommandClamped => "command_clamped".to_owned(),
        What::CommandRefused(refusal) => format!("command_refused_{}", refusal.name()),
        What::Granted(request) => format!("{}_granted", operator_name(request)),
        What::Denied(request) => format!("{}_denied", operator_name(request)),
        What::Impulse => "impulse".to_owned(),
        What::PartFanSlow => "part_fan_slow".to_owned(),
        What::StoodStill => "stood_still".to_owned(),
    }
}

fn operator_name(request: Operator) -> &'static str {
    match request {
        Operator::Pause => "pause",
        Operator::Resume => "resume",
        Operator::Stop => "stop",
        Operator::Estop => "estop",
        Operator::Acknowledge => "acknowledge",
        Operator::SetMode(_) => "set_mode",
        Operator::Approve => "approve",
    }
}

/// Name of a mode, snake_case.
pub fn mode_name(mode: Mode) -> &'static str {
    match mode {
        Mode::Init => "init",
        Mode::Observe => "observe",
        Mode::Advise => "advise",
        Mode::Act => "act",
        Mode::Degraded => "degraded",
        Mode::Paused => "paused",
        Mode::SafeOff => "safe_off",
        Mode::Estop => "estop",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decision(what: What, after: Mode) -> Decision {
        Decision { what, why: "on request", cause: None, before: Mode::Observe, after }
    }

    /// Cause, number and what to do: of an event as of the state.
    #[test]
    fn an_event_says_cause_number_and_what_to_do() {
        let evidence = Some(Evidence { value: 450.04, unit: "degC", digits: 1, limit: Some(285.0) });
        let found = Decision {
            why: Cause::HotendRange.text(),
            cause: Some((Cause::HotendRange, evidence)),
            ..decision(What::ModeChanged, Mode::SafeOff)
        };
        assert_eq!(
            event(Seconds(1.0), "safety_supervisor", &found).why,
            "S1: hot end temperature outside of the possible range (450.0 degC, limit 285.0 degC). What to do: \
             check thermistor and its plug, then `fdm acknowledge`"
        );
        let taken_over = Decision { what: What::Remembered, why: "taken over", ..found };
        let told = event(Seconds(1.0), "safety_supervisor", &taken_over);
        assert!(told.why.starts_with("taken over; S1: hot end temperature"), "{}", told.why);
        assert!(told.why.ends_with(
            "(450.0 degC, limit 285.0 degC). What to do: check thermistor and its plug, then `fdm acknowledge`"
        ));
        assert_eq!(told.severity, PrintEvent::SEVERITY_ERROR, "the heaters are off");
        let set = Decision {
            why: "it holds then",
            cause: Some((Cause::StopInput, None)),
            ..decision(What::Granted(Operator::SetMode(Mode::Advise)), Mode::Advise)
        };
        let told = event(Seconds(1.0), "safety_supervisor", &set).why;
        let what = "advise is set: it holds then; P13: the stop contact is open: button or door. What to do: close it";
        assert!(told.starts_with(what), "{told}");
        assert_eq!(caused(Cause::StopInput, None), "P13: the stop contact is open: button or door");
    }

    #[test]
    fn what_a_person_stops_stands_out_in_the_log() {
        for (request, after, severity) in [
            (Operator::Estop, Mode::Estop, PrintEvent::SEVERITY_ERROR),
            (Operator::Stop, Mode::SafeOff, PrintEvent::SEVERITY_ERROR),
            (Operator::Pause, Mode::Paused, PrintEvent::SEVERITY_WARN),
            (Operator::SetMode(Mode::Act), Mode::Act, PrintEvent::SEVERITY_INFO),
        ] {
            let told = event(Seconds(1.0), "safety_supervisor", &decision(What::Granted(request), after));
            assert_eq!(told.severity, severity, "{request:?}");
        }
    }
}
