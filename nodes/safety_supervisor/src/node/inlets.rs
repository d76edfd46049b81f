//! What the supervisor listens to. What is refused of a stream reaches the brain as that.

use fdm_loop_msgs::{
    ControlCommand, DefectReport, FilamentMotion, ImuBatch, MotionTrim, PrinterState, StateEstimate,
    Temperature,
};
use models::command::Scheduled;
use models::units::Seconds;
use runtime::wire::WireError;
use runtime::{FRAMES_HANDOVER, Gid, HANDOVER, Inlet, Node, Reason, Refused, RuntimeError, Sessions, topics};

use super::outlets::Totals;
use super::rivals::Rivals;
use crate::convert;
use crate::event::{Event, SafetyState, Stream};
use crate::params::{Params, StaleParams};

/// What was heard.
pub(super) enum Heard {
    /// Something that the brain judges.
    Event(Event),
    /// A trim of a coming move, which goes on at once or not at all.
    Scheduled(Scheduled),
}

/// Every stream.
pub(super) struct Inlets {
    hotend: Inlet<Temperature>,
    bed: Inlet<Temperature>,
    encoder: Inlet<FilamentMotion>,
    printer: Inlet<PrinterState>,
    command: Inlet<ControlCommand>,
    estimate: Inlet<StateEstimate>,
    imu: Inlet<ImuBatch>,
    vision: Inlet<DefectReport>,
    schedule: Inlet<MotionTrim>,
    rivals: Rivals,
    sessions: Sessions,
    /// Second event of a message that told two things.
    also: Option<Event>,
}

impl Inlets {
    /// A longer silence than the age at which its stream degrades shows in the diagnostics.
    pub(super) fn open(node: &mut Node, params: &Params) -> Result<Self, RuntimeError> {
        let silence = |stale: &StaleParams| Seconds(stale.degraded_s);
        let stale = &params.stale;
        Ok(Self {
            hotend: node
                .inlet(&topics::HOTEND_TEMPERATURE, silence(&stale.hotend))?
                .with_stamps_within(stale.hotend.oldest_stamp())
                .from_one_source(HANDOVER),
            bed: node
                .inlet(&topics::BED_TEMPERATURE, silence(&stale.bed))?
                .with_stamps_within(stale.bed.oldest_stamp())
                .from_one_source(HANDOVER),
            encoder: node
                .inlet(&topics::FILAMENT_MOTION, silence(&stale.encoder))?
                .with_stamps_within(stale.encoder.oldest_stamp())
                .from_one_source(HANDOVER),
            printer: node
                .inlet(&topics::PRINTER_STATE, silence(&stale.printer))?
                .with_stamps_within(stale.printer.oldest_stamp())
                .from_one_source(HANDOVER),
            command: node
                .inlet(&topics::CONTROL_COMMAND, silence(&stale.command))?
                .with_stamps_within(stale.command.oldest_stamp()),
            estimate: node
                .inlet(&topics::ESTIMATE, silence(&stale.estimate))?
                .with_stamps_within(stale.estimate.oldest_stamp())
                .from_one_source(HANDOVER),
            imu: node
                .inlet(&topics::IMU_BATCH, silence(&stale.imu))?
                .with_stamps_within(stale.imu.oldest_stamp())
                .from_one_source(HANDOVER),
            vision: node
                .inlet(&topics::DEFECTS, silence(&stale.vision))?
                .with_stamps_within(stale.vision.oldest_stamp())
                .from_one_source(FRAMES_HANDOVER),
            // A host that attaches nothing to moves is silent here.
            schedule: node
                .inlet(&topics::CONTROL_SCHEDULE, Seconds(f64::INFINITY))?
                .with_stamps_within(stale.command.oldest_stamp()),
            rivals: Rivals::new(node),
            sessions: Sessions::default(),
            also: None,
        })
    }

    /// The next message of any stream. Cancelling loses none.
    pub(super) async fn next(&mut self) -> Heard {
        if let Some(event) = self.also.take() {
            return Heard::Event(event);
        }
        let sessions = &self.sessions;
        let (taken, stream) = tokio::select! {
            taken = self.hotend.next(convert::hotend) => (taken, Stream::Hotend),
            taken = self.bed.next(convert::bed) => (taken, Stream::Bed),
            taken = self.encoder.next(convert::encoder) => (taken, Stream::Encoder),
            taken = self.printer.next(convert::printer) => (taken, Stream::Printer),
            taken = self.command.next_of(|message, publisher| command(sessions, message, publisher)) => {
                (both(taken, &mut self.also), Stream::Command)
            }
            taken = self.estimate.next(convert::estimate) => {
                (both(taken, &mut self.also), Stream::Estimate)
            }
            taken = self.imu.next(convert::imu) => (taken, Stream::Imu),
            taken = self.vision.next(convert::vision) => (taken, Stream::Vision),
            taken = self.schedule.next_of(|message, publisher| scheduled(sessions, message, publisher)) => match taken {
                Ok(scheduled) => return Heard::Scheduled(scheduled),
                Err(reason) => (Err(reason), Stream::Command),
            },
            () = self.rivals.next() => return Heard::Event(Event::RivalPermit),
        };
        // Only a stream of one source knows this reason here: what the brain refuses it counts itself.
        let refused =
            |reason| if reason == Reason::Gate { Event::RivalSample } else { Event::Refused { stream } };
        Heard::Event(taken.unwrap_or_else(refused))
    }

    /// Looks whether somebody else publishes permits.
    pub(super) fn look_for_rivals(&mut self, node: &mut Node) {
        self.rivals.look(node);
    }

    /// Takes over what the brain itself has refused.
    pub(super) fn follow(&mut self, state: &SafetyState) {
        self.command.refused.follow(Reason::Gate, state.refused_commands);
        self.schedule.refused.follow(Reason::Gate, state.refused_schedule);
    }

    /// Refused messages of all streams.
    pub(super) fn totals(&self) -> Totals {
        let all: [&Refused; 10] = [
            &self.hotend.refused,
            &self.bed.refused,
            &self.encoder.refused,
            &self.printer.refused,
            &self.command.refused,
            &self.estimate.refused,
            &self.imu.refused,
            &self.vision.refused,
            &self.schedule.refused,
            &self.rivals.refused,
        ];
        let sum = |reason| all.iter().map(|refused| refused.total(reason)).sum::<u64>();
        Totals {
            not_finite: sum(Reason::NotFinite),
            out_of_range: sum(Reason::OutOfRange) + sum(Reason::Malformed),
            stale: sum(Reason::Stale),
            sequence: sum(Reason::Order) + sum(Reason::Gate),
        }
    }
}

/// A controller is who sends its commands, not who knows its session.
fn command(
    sessions: &Sessions,
    message: &ControlCommand,
    publisher: Gid,
) -> Result<(Seconds, [Event; 2]), WireError> {
    let session_id = sessions.of(publisher, message.session_id);
    convert::command(&ControlCommand { session_id, ..message.clone() })
}

/// So is who sends its schedule.
fn scheduled(
    sessions: &Sessions,
    message: &MotionTrim,
    publisher: Gid,
) -> Result<(Seconds, Scheduled), WireError> {
    let session_id = sessions.of(publisher, message.session_id);
    convert::scheduled(&MotionTrim { session_id, ..message.clone() })
}

/// The first of two events; the second waits.
fn both(taken: Result<[Event; 2], Reason>, also: &mut Option<Event>) -> Result<Event, Reason> {
    taken.map(|[first, second]| {
        *also = Some(second);
        first
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::command::{Command, Trims};
    use runtime::wire::command_to_wire;

    /// C8, X2: the same session from two processes is two controllers.
    #[test]
    fn a_copied_session_is_another_one() {
        let (sessions, now) = (Sessions::default(), Seconds(1.0));
        let wish = Command { session: 7, sequence: 1, validity: Seconds(1.0), trims: Trims::NEUTRAL };
        let of = |process: u8| match command(&sessions, &command_to_wire(now, &wish), Gid([process; 16])) {
            Ok((_, [Event::Command(command), _])) => command.session,
            other => panic!("{other:?}"),
        };
        let of_schedule = |process: u8| {
            let message = MotionTrim {
                session_id: 7,
                validity_s: 1.0,
                segment: 1,
                flow_factor: 1.0,
                speed_factor: 1.0,
                advance_index: 1.0,
                ..MotionTrim::default()
            };
            scheduled(&sessions, &message, Gid([process; 16])).unwrap().1.session
        };
        assert_ne!(of(1), of(2));
        assert_eq!(of(1), of_schedule(1), "beside its own commands");
        assert_ne!(of(1), of_schedule(2));
    }
}
