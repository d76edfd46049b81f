//! Who gets what: messages between printer and brains, through the relay where there is one.

use super::Printing;
use crate::sim::bagging::as_stamped;
use crate::sim::foresight;
use crate::sim::message::{Content, Lane, Message};
use crate::sim::sight::Seen;
use models::command::Command;
use models::motion::Segment;
use models::units::{Kelvin, Seconds};
use printer_sim::Output;
use safety_supervisor::{Event as Safety, PrinterReport, Stream};
use state_estimator::{Channel, state};

impl Printing {
    pub(super) fn pass_on(&mut self, now: Seconds, output: Output) {
        match output {
            Output::Temperatures { stamp, hotend, bed, nozzle } => {
                self.send(now, Message::new(stamp, Content::Hotend(hotend)));
                self.send(now, Message::new(stamp, Content::Bed(bed)));
                if let Some(nozzle) = nozzle {
                    self.send(now, Message::new(stamp, Content::Nozzle(nozzle)));
                }
            }
            Output::Encoder { stamp, counts } => {
                #[allow(clippy::cast_precision_loss, reason = "counts of a print are far below 2^52")]
                let position_m = counts as f64 * self.encoder_quantum_m;
                self.send(now, Message::new(stamp, Content::Encoder(position_m)));
            }
            Output::Width { exposed, width_m, sigma_m } => {
                let exposed = match &mut self.bagging {
                    None => exposed,
                    Some(bagging) => bagging.width(now, exposed, (width_m, sigma_m)),
                };
                self.deliver_width(now, exposed, (width_m, sigma_m));
            }
            Output::Status(status) => {
                self.note_extremes(&status.trims);
                self.told_phase = Some(status.phase);
                self.send(now, Message::new(status.stamp, Content::Printer(status)));
            }
            Output::Imu(batch) => self.send(now, Message::new(batch.first, Content::Imu(batch))),
            Output::Frame { exposed, jpeg, .. } => {
                if self.sight.is_some() {
                    self.send(now, Message::new(exposed, Content::Frame(jpeg)));
                }
            }
            Output::Motion { start, segment } => self.move_on(now, start, *segment),
            Output::Coming { stamp, sequence, start_s, segment } => {
                self.foresee(now, (stamp, start_s, sequence), &segment);
            }
            Output::Note { .. } => {}
        }
    }

    /// What the relay has held back until now.
    pub(super) fn deliver_late(&mut self, now: Seconds) {
        let due = self.relay.as_mut().map(|relay| relay.due(now)).unwrap_or_default();
        due.into_iter().for_each(|message| self.deliver(now, message));
    }

    pub(super) fn send(&mut self, now: Seconds, message: Message) {
        if let Some(bagging) = &mut self.bagging {
            bagging.message(now, &message);
            let stream = stream_of(message.lane());
            return match message.over_the_wire() {
                Ok(sound) => self.deliver(now, Message { stamp: as_stamped(sound.stamp), ..sound }),
                Err(_refused) => self.refuse(now, stream),
            };
        }
        let Some(relay) = self.relay.as_mut().filter(|relay| relay.is_active()) else {
            return self.deliver(now, message);
        };
        let stream = stream_of(message.lane());
        for arrived in relay.pass(now, message) {
            match arrived.over_the_wire() {
                Ok(sound) => self.deliver(now, sound),
                Err(_refused) => self.refuse(now, stream),
            }
        }
    }

    /// What a node's conversion, or the check of a stamp's age, has refused.
    fn refuse(&mut self, now: Seconds, stream: Option<Stream>) {
        if let Some(stream) = stream {
            self.supervisor.on_event(now, Safety::Refused { stream });
        }
    }

    /// To the supervisor, unless the stamp is too old for it or ahead of the clock.
    fn hand_to_supervisor(&mut self, now: Seconds, stamp: Seconds, (stream, event): (Stream, Safety)) {
        let stale = &self.stale;
        let limit = match stream {
            Stream::Hotend => stale.hotend.oldest_stamp(),
            Stream::Bed => stale.bed.oldest_stamp(),
            Stream::Encoder => stale.encoder.oldest_stamp(),
            Stream::Printer => stale.printer.oldest_stamp(),
            Stream::Command => stale.command.oldest_stamp(),
            Stream::Estimate => stale.estimate.oldest_stamp(),
            Stream::Imu => stale.imu.oldest_stamp(),
            Stream::Vision => stale.vision.oldest_stamp(),
        };
        match runtime::check_age((now - stamp).0, limit) {
            Ok(()) => {
                if let Some(output) = self.supervisor.on_event(now, event) {
                    self.say(now, output);
                }
            }
            Err(_refused) => self.refuse(now, Some(stream)),
        }
    }

    fn deliver(&mut self, now: Seconds, Message { stamp, content }: Message) {
        match content {
            Content::Hotend(temp) => {
                self.estimator.on_event(state_estimator::Event::Hotend { stamp, temp });
                self.hand_to_supervisor(now, stamp, (Stream::Hotend, Safety::Hotend { stamp, temp }));
            }
            Content::Bed(temp) => {
                self.hand_to_supervisor(now, stamp, (Stream::Bed, Safety::Bed { stamp, temp }))
            }
            Content::Nozzle(temp) => {
                self.estimator.on_event(state_estimator::Event::Nozzle { stamp, temp });
            }
            Content::Encoder(position_m) => {
                self.estimator.on_event(state_estimator::Event::Encoder { stamp, position_m });
                self.controller.on_event(mpc_controller::Event::Encoder { stamp, position_m });
                self.hand_to_supervisor(now, stamp, (Stream::Encoder, Safety::Encoder { stamp, position_m }));
            }
            Content::Printer(status) => {
                let seen = self.sight.as_mut().map(|sight| sight.on_status(&status));
                self.keep(now, seen.as_deref());
                self.estimator.on_event(state_estimator::Event::Printer(*status));
                let told = self.foresight.on_status(&status);
                self.controller.on_event(mpc_controller::Event::Printer(*status));
                self.tell((now, status.stamp), told);
                self.hand_to_supervisor(
                    now,
                    stamp,
                    (Stream::Printer, Safety::Printer(PrinterReport::from(&*status))),
                );
            }
            Content::Imu(batch) => {
                let (first, period, samples) = (batch.first, batch.period, batch.samples);
                self.hand_to_supervisor(now, stamp, (Stream::Imu, Safety::Imu { first, period, samples }));
            }
            Content::Frame(jpeg) => self.see(now, stamp, jpeg),
            Content::Vision(report) => {
                self.hand_to_supervisor(now, stamp, (Stream::Vision, Safety::Vision(report)));
            }
            Content::Estimate(health) => {
                if runtime::check_age((now - stamp).0, self.stale.estimate.oldest_stamp()).is_ok() {
                    self.supervisor.on_event(now, Safety::EstimateHealth(health));
                }
                self.hand_to_supervisor(now, stamp, (Stream::Estimate, Safety::EstimateHeartbeat { stamp }));
            }
            Content::Command(command, health) => {
                if runtime::check_age((now - stamp).0, self.stale.command.oldest_stamp()).is_ok() {
                    self.supervisor.on_event(now, Safety::ControlHealth(health));
                }
                self.hand_to_supervisor(now, stamp, (Stream::Command, Safety::Command(command)));
            }
            // A refused permit is counted by the dead-man itself.
            Content::Permit(permit) => {
                let young = runtime::check_age((now - stamp).0, printer_sim::PERMIT_STAMP_LIMIT);
                let arrived = young.ok().and_then(|()| permit.arrived(now - stamp));
                let taken = arrived.filter(|permit| self.simulator.on_permit(*permit).is_ok());
                self.obeyed = taken.map(|permit| permit.session).or(self.obeyed);
            }
        }
    }

    fn deliver_width(&mut self, now: Seconds, exposed: Seconds, (width_m, sigma_m): (f64, f64)) {
        self.estimator.on_event(state_estimator::Event::Width { exposed, width_m, sigma_m });
        self.controller.on_event(mpc_controller::Event::Width { exposed, width_m });
        self.attach_anew(now);
    }

    /// A move begins.
    fn move_on(&mut self, now: Seconds, start: Seconds, segment: Segment) {
        let path_time_s = self.simulator.truth().path_time_s;
        let (start, segment) = match &mut self.bagging {
            None => (start, segment),
            Some(bagging) => {
                let Some(read) = bagging.motion(now, (start, path_time_s), &segment) else { return };
                read
            }
        };
        let seen = self.sight.as_mut().map(|sight| sight.on_motion((start, path_time_s), &segment));
        self.keep(now, seen.as_deref());
        let told = self.foresight.on_motion(&segment);
        self.tell((now, start), told);
    }

    fn tell(&mut self, (now, stamp): (Seconds, Seconds), told: Option<advance_predictor::Output>) {
        let Some(output) = told else { return };
        let prediction = match &mut self.bagging {
            None => Some(mpc_controller::Event::Prediction(foresight::told(stamp, &output))),
            Some(bagging) => bagging.prediction(now, &output),
        };
        if let Some(event) = prediction {
            self.controller.on_event(event);
        }
    }

    /// Keeps what the classifier says, where a bag is written.
    fn keep(&mut self, now: Seconds, outputs: Option<&[defect_classifier::Output]>) {
        if let (Some(bagging), Some(sight), Some(outputs)) = (&mut self.bagging, &self.sight, outputs) {
            bagging.sight(now, outputs, sight.classes());
        }
    }

    fn see(&mut self, now: Seconds, exposed: Seconds, jpeg: Vec<u8>) {
        let Some(sight) = &mut self.sight else { return };
        let outputs = sight.on_frame(exposed, jpeg);
        for output in outputs {
            self.keep(now, Some(std::slice::from_ref(&output)));
            let seen = self.sight.as_mut().and_then(|sight| sight.seen(output));
            match seen {
                None => {}
                Some(Seen::Width { laid, width_m, sigma_m }) => {
                    let laid = if self.bagging.is_some() { as_stamped(laid) } else { laid };
                    self.deliver_width(now, laid, (width_m, sigma_m));
                }
                Some(Seen::Report(report)) => {
                    self.send(now, Message::new(exposed, Content::Vision(report)));
                }
            }
        }
    }

    pub(super) fn estimate(&mut self, now: Seconds) {
        let Some(estimate) = self.estimator.on_event(state_estimator::Event::Tick { now }) else { return };
        self.consistency.add(&estimate, self.simulator.truth());
        self.nis_mean = estimate.nis_mean;
        if let Some(bagging) = &mut self.bagging {
            bagging.estimate(now, &estimate);
        }
        let seen = self.sight.as_mut().map(|sight| sight.on_estimate(&estimate));
        self.keep(now, seen.as_deref());
        self.send(now, Message::new(now, Content::Estimate(estimate.health)));
        let for_control = mpc_controller::Estimate {
            stamp: estimate.stamp,
            nozzle: Kelvin(estimate.x[state::NOZZLE]),
            flow_m_s: estimate.x[state::FLOW].max(0.0),
            slip: estimate.x[state::SLIP],
            gain: estimate.x[state::GAIN],
            reference_feed_m_s: estimate.reference_feed_m_s,
            encoder_alive: estimate.alive[Channel::Encoder as usize],
            width_alive: estimate.alive[Channel::Width as usize],
        };
        if let Some(command) = self.controller.on_event(mpc_controller::Event::Estimate(for_control)) {
            self.wish(now, command);
        }
    }

    pub(super) fn wish(&mut self, now: Seconds, command: Command) {
        self.send(now, Message::new(now, Content::Command(command, self.controller.health())));
    }
}

/// The supervisor's stream that a way leads to.
fn stream_of(lane: Lane) -> Option<Stream> {
    Some(match lane {
        Lane::Hotend => Stream::Hotend,
        Lane::Bed => Stream::Bed,
        Lane::Encoder => Stream::Encoder,
        Lane::Printer => Stream::Printer,
        Lane::Imu => Stream::Imu,
        Lane::Vision => Stream::Vision,
        Lane::Estimate => Stream::Estimate,
        Lane::Command => Stream::Command,
        Lane::Nozzle | Lane::Frames | Lane::Permit => return None,
    })
}
