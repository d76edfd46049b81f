//! What leaves the supervisor: permits, state, events, diagnostics.

use fdm_loop_msgs::{ControlCommand, MotionTrim, PrintEvent, SafetyState as StateMessage};
use models::command::{Mode, Permit, Request, Scheduled, Trims};
use models::units::Seconds;
use runtime::wire::{permit_to_wire, schedule_to_wire};
use runtime::{Diagnostics, Level, Node, Publisher, RuntimeError, topics};

use super::journal::Journal;
use super::latch_file::LatchFile;
use super::operators::PATIENCE;
use super::standing_file::StandingFile;
use crate::cause::Cause;
use crate::checks::part_fan;
use crate::convert;
use crate::event::{Output, SafetyState};

/// Refused messages of all topics, by what `safety/state` tells apart.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Totals {
    pub(super) not_finite: u64,
    pub(super) out_of_range: u64,
    pub(super) stale: u64,
    pub(super) sequence: u64,
}

/// Every publisher of the supervisor.
pub(super) struct Outlets {
    permits: Publisher<ControlCommand>,
    schedule: Publisher<MotionTrim>,
    states: Publisher<StateMessage>,
    events: Publisher<PrintEvent>,
    journal: Journal,
    diagnostics: Diagnostics,
    name: String,
    session: u64,
    sequence: u64,
    /// Why the disk does not keep the latch, or its end.
    disk: Option<String>,
    /// Why it does not keep mode and pause.
    forgetful: Option<String>,
    /// Publications in a row for which the latch, or its end, has been on its way to the disk.
    unkept: u32,
    /// What a new message on `safety/state` would tell.
    told: Option<(Mode, Mode, Option<Cause>, u8, bool)>,
    told_at: Seconds,
}

impl Outlets {
    pub(super) fn open(node: &mut Node) -> Result<Self, RuntimeError> {
        Ok(Self {
            permits: node.publish_on(&topics::SAFETY_COMMAND)?,
            schedule: node.publish_on(&topics::SAFETY_SCHEDULE)?,
            states: node.publish_on(&topics::SAFETY_STATE)?,
            events: node.publish_on(&topics::EVENTS)?,
            journal: Journal::default(),
            diagnostics: node.diagnostics(),
            name: node.name(),
            session: node.session(),
            sequence: 0,
            disk: None,
            forgetful: None,
            unkept: 0,
            told: None,
            told_at: Seconds(f64::NEG_INFINITY),
        })
    }

    /// Publishes an output. `kept`: the latch, or its end, is on disk.
    pub(super) fn publish(&mut self, now: Seconds, output: &Output, kept: bool, totals: Totals) {
        let permit = if kept { output.permit } else { unannounced(output.permit) };
        self.permits.send(permit_to_wire(now, &permit));
        for decision in &output.events {
            self.say(now, convert::event(now, &self.name, decision));
        }
        self.unkept = if kept { 0 } else { self.unkept.saturating_add(1) };
        if !is_announced(self.unkept, self.disk.is_some()) {
            return;
        }
        let state = SafetyState { mode: told_mode(permit.mode, output.permit.mode), ..output.state };
        let tells = (state.mode, state.set_mode, state.cause, state.attention as u8, self.disk.is_some());
        let due = (now - self.told_at).0 >= topics::SAFETY_STATE_PERIOD.0 || now < self.told_at;
        if due || self.told != Some(tells) {
            self.told = Some(tells);
            self.told_at = now;
            self.tell(now, &state, totals);
        }
    }

    /// Sends a trim of a coming move on.
    pub(super) fn schedule(&self, now: Seconds, allowed: &Scheduled) {
        self.schedule.send(schedule_to_wire(now, allowed));
    }

    /// The last word: the permit with the slicer's own values.
    pub(super) fn last(&self, now: Seconds, output: &Output, kept: bool) {
        let permit = if kept { output.permit } else { unannounced(output.permit) };
        self.permits.send(permit_to_wire(now, &Permit { trims: Trims::NEUTRAL, ..permit }));
    }

    /// What the disk has to say; told with the next state too.
    pub(super) fn tell_records(&mut self, latch: &LatchFile, standing: &StandingFile) {
        self.diagnostics.set("latch_file", latch.failed.as_deref().unwrap_or("ok"));
        self.diagnostics.set("standing_file", standing.failed.as_deref().unwrap_or("ok"));
        self.disk.clone_from(&latch.failed);
        self.forgetful.clone_from(&standing.failed);
    }

    /// A record of the former run that was refused for this cause, and why.
    pub(super) fn tell_refused(&mut self, now: Seconds, mode: Mode, cause: Cause, why: &str) {
        self.say(now, convert::record_refused(now, &self.name, mode, cause, why));
    }

    fn say(&mut self, now: Seconds, event: PrintEvent) {
        self.journal.write(now, &event);
        self.events.send(event);
    }

    fn tell(&mut self, now: Seconds, state: &SafetyState, totals: Totals) {
        self.sequence += 1;
        self.states.send(StateMessage {
            session_id: self.session,
            sequence: self.sequence,
            refused_not_finite: totals.not_finite,
            refused_out_of_range: totals.out_of_range,
            refused_stale: totals.stale,
            refused_sequence: totals.sequence,
            ..with_disk(convert::state(now, state), self.disk.as_deref())
        });
        self.diagnostics.set("mode", convert::mode_name(state.mode));
        self.diagnostics.set("refused_values", state.refused_values);
        self.diagnostics.set("refused_commands", state.refused_commands);
        self.diagnostics.set("clamped_commands", state.clamped_commands);
        self.diagnostics.set("scheduled", state.scheduled);
        self.diagnostics.set("refused_schedule", state.refused_schedule);
        self.diagnostics.set("clamped_schedule", state.clamped_schedule);
        self.diagnostics.set("hotend_excess_w", format_args!("{:.2}", state.hotend_excess_w));
        self.diagnostics.set("impulses", state.impulses);
        if let Some(slip) = state.slip {
            self.diagnostics.set("slip", format_args!("{slip:.3}"));
        }
        let level = match state.mode {
            Mode::SafeOff | Mode::Estop => Level::Error,
            Mode::Degraded | Mode::Paused => Level::Warn,
            Mode::Init | Mode::Observe | Mode::Advise | Mode::Act => Level::Ok,
        };
        let (level, cause) = match state.cause {
            None if state.part_fan_slow => (level.max(Level::Warn), part_fan::SLOW),
            cause => (level, cause.map_or("ok", Cause::text)),
        };
        match (&self.disk, &self.forgetful) {
            (Some(error), _) => {
                self.diagnostics.report(Level::Error, &format!("latch_file not written: {error}"));
            }
            (None, Some(error)) if level <= Level::Warn => {
                self.diagnostics.report(Level::Warn, &format!("mode and pause not written: {error}"));
            }
            (None, _) => self.diagnostics.report(level, cause),
        }
    }
}

/// A person is told of a latch in its own name, also where it reaches no disk; without one, of the mode that the printer is in.
fn told_mode(sent: Mode, in_force: Mode) -> Mode {
    if in_force >= Mode::SafeOff { in_force } else { sent }
}

/// A person has to know why the heaters stay off, beside the cause or where it is gone, or that a latch may be forgotten.
fn with_disk(state: StateMessage, refusal: Option<&str>) -> StateMessage {
    let Some(error) = refusal else { return state };
    let what_to_do = if state.latched {
        format!("a restart of the supervisor would not know of it: latch_file cannot be written ({error})")
    } else {
        format!("the heaters stay off until latch_file can be written ({error})")
    };
    let before = if state.what_to_do.is_empty() { String::new() } else { format!("{}; ", state.what_to_do) };
    StateMessage { what_to_do: format!("{before}{what_to_do}"), ..state }
}

/// Whether a state is told: not while the disk is at work, for a latch under another mode's name would be a pause that
/// there is not. Where it refuses or takes long a person has to know.
fn is_announced(unkept: u32, refused: bool) -> bool {
    unkept == 0 || refused || unkept > PATIENCE
}

/// While the disk is not done the printer is as safe as latched, without being told so: the heaters are off, or the
/// emergency stop is in force, and stay so where the latch has just been ended.
fn unannounced(permit: Permit) -> Permit {
    Permit {
        mode: permit.mode.min(Mode::Paused),
        request: permit.request.max(Request::HeatersOff),
        trims: Trims::NEUTRAL,
        ..permit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_latch_that_is_not_on_disk_acts_but_is_not_announced() {
        let permit = |mode, request| Permit {
            session: 1,
            sequence: 1,
            validity: Seconds(0.25),
            mode,
            request,
            trims: Trims { flow: 1.1, ..Trims::NEUTRAL },
        };
        for (mode, request, wanted) in [
            (Mode::SafeOff, Request::HeatersOff, Request::HeatersOff),
            (Mode::Estop, Request::EmergencyStop, Request::EmergencyStop),
            (Mode::Act, Request::Run, Request::HeatersOff),
        ] {
            let sent = unannounced(permit(mode, request));
            assert!(sent.mode < Mode::SafeOff);
            assert_eq!((sent.request, sent.trims), (wanted, Trims::NEUTRAL));
        }
    }

    #[test]
    fn a_state_waits_for_the_disk_but_not_for_ever() {
        for (unkept, refused, announced) in [
            (0, false, true),
            (1, false, false),
            (PATIENCE, false, false),
            (PATIENCE + 1, false, true),
            (1, true, true),
        ] {
            assert_eq!(is_announced(unkept, refused), announced, "{unkept} {refused}");
        }
    }

    #[test]
    fn a_person_is_told_of_the_disk_that_keeps_the_heaters_off() {
        let state =
            |what_to_do: &str| StateMessage { what_to_do: what_to_do.to_owned(), ..StateMessage::default() };
        let told = |before: &str| with_disk(state(before), Some("/x/latch.json: full")).what_to_do;
        let disk = "the heaters stay off until latch_file can be written (/x/latch.json: full)";
        assert_eq!(told(""), disk, "acknowledged, but the record of it stays");
        assert_eq!(told("acknowledge"), format!("acknowledge; {disk}"));
        let latched = StateMessage { latched: true, ..state("") };
        assert!(
            with_disk(latched, Some("full"))
                .what_to_do
                .contains("a restart of the supervisor would not know")
        );
        assert_eq!(told_mode(Mode::Paused, Mode::Estop), Mode::Estop);
        assert_eq!(told_mode(Mode::Paused, Mode::Act), Mode::Paused);
        assert_eq!(with_disk(state("acknowledge"), None), state("acknowledge"));
    }
}
