//! From messages to the brains, and from what they say to messages.

use super::{Brains, CLASSIFIER, FOREVER, SUPERVISOR, Said, encode};
use crate::report::decode::decode;
use advance_predictor::convert as foresight;
use bag_recorder::order;
use defect_classifier::{Output as Saw, convert as sight};
use fdm_loop_msgs::{ControlCommand, RosType};
use models::command::{MotionTrim, Scheduled};
use models::units::Seconds;
use mpc_controller::convert as control;
use runtime::topics::{self, Topic};
use runtime::wire::{self, WireError};
use safety_supervisor::{Event as Safety, Stream, convert as safety};

impl Brains<'_> {
    pub(super) fn give_estimator<T: RosType>(
        &mut self,
        now: Seconds,
        payload: &[u8],
        limit_s: f64,
        read: impl Fn(&T) -> Result<(Seconds, state_estimator::Event), WireError>,
    ) {
        if let Some(Ok(event)) = taken(now, payload, Seconds(limit_s), read) {
            // Only ticks yield an estimate.
            _ = self.estimator.on_event(event);
        }
    }

    pub(super) fn give_controller<T: RosType>(
        &mut self,
        now: Seconds,
        payload: &[u8],
        limit_s: f64,
        read: impl Fn(&T) -> Result<(Seconds, mpc_controller::Event), WireError>,
    ) {
        if let Some(Ok(event)) = taken(now, payload, Seconds(limit_s), read) {
            self.control(now, event);
        }
    }

    pub(super) fn give_supervisor<T: RosType, const N: usize>(
        &mut self,
        now: Seconds,
        payload: &[u8],
        (stream, limit): (Stream, Seconds),
        read: impl Fn(&T) -> Result<(Seconds, [Safety; N]), WireError>,
    ) {
        match taken(now, payload, limit, read) {
            None => {}
            Some(Ok(events)) => events.into_iter().for_each(|event| self.supervise(now, event)),
            Some(Err(())) => self.supervise(now, Safety::Refused { stream }),
        }
    }

    pub(super) fn control(&mut self, now: Seconds, event: mpc_controller::Event) {
        let Some(command) = self.controller.on_event(event) else { return };
        let health = self.controller.health() as u8;
        let message = ControlCommand { health, ..wire::command_to_wire(now, &command) };
        if let Some(payload) =
            self.say(now, &topics::CONTROL_COMMAND, &message).filter(|_| self.feeds.command)
        {
            self.hear_command(now, &payload);
        }
    }

    /// A move that is known before it begins: the controller's trim of it, where it has one.
    pub(super) fn hear_coming(&mut self, now: Seconds, payload: &[u8]) {
        let limit = Seconds(self.settings.controller.status_age_limit_s);
        let Some(Ok(coming)) = taken(now, payload, limit, control::coming) else { return };
        if let Some(trim) = self.controller.on_coming(now, &coming) {
            self.attach(now, trim);
        }
    }

    /// Trims that the controller sends anew, of moves that have not begun.
    pub(super) fn attach_anew(&mut self, now: Seconds) {
        for trim in self.controller.take_anew(now) {
            self.attach(now, trim);
        }
    }

    fn attach(&mut self, now: Seconds, trim: MotionTrim) {
        self.trims += 1;
        let validity = Seconds(self.settings.controller.advance.schedule_validity_s);
        let session = self.settings.sessions.controller;
        let wished = Scheduled { session, sequence: self.trims, validity, trim };
        let payload = self.say(now, &topics::CONTROL_SCHEDULE, &wire::schedule_to_wire(now, &wished));
        if let Some(payload) = payload.filter(|_| self.feeds.command) {
            self.hear_schedule(now, &payload);
        }
    }

    /// A trim of a coming move: what the supervisor lets through of it.
    pub(super) fn hear_schedule(&mut self, now: Seconds, payload: &[u8]) {
        let limit = self.settings.supervisor.stale.command.oldest_stamp();
        let Some(Ok(wished)) = taken(now, payload, limit, safety::scheduled) else { return };
        if let Some(allowed) = self.supervisor.on_scheduled(now, wished) {
            self.say(now, &topics::SAFETY_SCHEDULE, &wire::schedule_to_wire(now, &allowed));
        }
    }

    pub(super) fn supervise(&mut self, now: Seconds, event: Safety) {
        let Some(output) = self.supervisor.on_event(now, event) else { return };
        self.say(now, &topics::SAFETY_COMMAND, &wire::permit_to_wire(now, &output.permit));
        for decision in &output.events {
            self.say(now, &topics::EVENTS, &safety::event(now, SUPERVISOR, decision));
        }
    }

    pub(super) fn foretell<T: RosType>(
        &mut self,
        now: Seconds,
        payload: &[u8],
        read: impl Fn(&T) -> Result<(Seconds, advance_predictor::Event), WireError>,
    ) {
        let Some(predictor) = &mut self.predictor else { return };
        let Some(Ok(event)) = taken(now, payload, FOREVER, read) else { return };
        let Some(output) = predictor.on_event(event) else { return };
        let message = foresight::prediction(now, &output);
        let payload = self.say(now, &topics::ADVANCE_PREDICTION, &message);
        if let Some(payload) = payload.filter(|_| self.feeds.prediction) {
            let limit = self.settings.controller.advance.age_limit_s;
            self.give_controller(now, &payload, limit, control::prediction);
        }
    }

    pub(super) fn see<T: RosType>(
        &mut self,
        now: Seconds,
        payload: &[u8],
        read: impl Fn(&T) -> Result<(Seconds, defect_classifier::Event), WireError>,
    ) {
        let (Some(classifier), Some(setup)) = (&mut self.classifier, &self.settings.sight) else { return };
        let Some(Ok(event)) = taken(now, payload, FOREVER, read) else { return };
        let outputs = classifier.on_event(event);
        let classes = classifier.classes().to_vec();
        for output in outputs {
            match output {
                Saw::Width(width) => {
                    let payload = self.say(now, &topics::BEAD_WIDTH, &sight::width(&width));
                    if let Some(payload) = payload.filter(|_| self.feeds.vision) {
                        self.hear_width(now, &payload);
                    }
                }
                Saw::Defects(defects) => {
                    let payload = self.say(now, &topics::DEFECTS, &sight::defects(&defects, &classes));
                    if let Some(payload) = payload.filter(|_| self.feeds.vision) {
                        self.hear(now, topics::DEFECTS.name(), &payload);
                    }
                }
                Saw::Quality(figure) => {
                    self.say(now, &topics::LAYER_QUALITY, &sight::quality(&figure, &setup.params.machine));
                }
                Saw::Note(note) => _ = self.say(now, &topics::EVENTS, &sight::note(&note, CLASSIFIER)),
                Saw::Picture { .. } => {}
            }
        }
    }

    /// Keeps what a brain says.
    pub(super) fn say<T: RosType>(&mut self, now: Seconds, topic: &Topic<T>, message: &T) -> Option<Vec<u8>> {
        let payload = encode(message)?;
        let at_ns = order::nanoseconds(now);
        self.said.push(Said { topic: topic.name(), at_ns, payload: payload.clone() });
        Some(payload)
    }
}

/// A message as its reader takes it; `Err` where reading or the age of its stamp refuses it, `None` where it is none of
/// that type.
fn taken<T: RosType, V>(
    now: Seconds,
    payload: &[u8],
    limit: Seconds,
    read: impl Fn(&T) -> Result<(Seconds, V), WireError>,
) -> Option<Result<V, ()>> {
    let message: T = decode(payload)?;
    let taken = read(&message)
        .map_err(drop)
        .and_then(|(stamp, value)| runtime::check_age((now - stamp).0, limit).map(|()| value).map_err(drop));
    Some(taken)
}
