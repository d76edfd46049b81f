//! What the supervisor says: permits on their way to the printer, and what counts as noticed.

use super::Printing;
use crate::sim::message::{Content, Message};
use crate::sim::report::Detection;
use models::command::Mode;
use models::units::Seconds;
use safety_supervisor::{Event as Safety, What};

impl Printing {
    pub(super) fn permit(&mut self, now: Seconds) {
        if let Some(output) = self.supervisor.on_event(now, Safety::Tick { now }) {
            self.say(now, output);
        }
    }

    /// What the supervisor says: a permit for the printer, its state and its decisions.
    pub(super) fn say(&mut self, now: Seconds, output: safety_supervisor::Output) {
        self.send(now, Message::new(now, Content::Permit(output.permit)));
        let onset_s = self.simulator.newest_onset().map(|onset| onset.0);
        let cause = output.state.cause.map_or_else(String::new, |cause| cause.id().to_owned());
        if let Some(bagging) = &mut self.bagging {
            bagging.safety(now, &output);
        }
        self.safety = Some(output.state);
        for event in &output.events {
            let (fault, action) = match event.what {
                What::Impulse => ("P8".to_owned(), "flagged".to_owned()),
                What::PartFanSlow => ("P4".to_owned(), "flagged".to_owned()),
                _ if event.before == event.after => continue,
                _ if event.after == Mode::Paused && self.adopts_pause(now, output.state.cause) => continue,
                _ if event.after >= Mode::Degraded
                    || event.after == Mode::Observe && event.before != Mode::Init =>
                {
                    (cause.clone(), format!("{:?}", event.after).to_lowercase())
                }
                _ => continue,
            };
            self.noticed.push(Detection { fault, onset_s, detected_s: now.0, action });
        }
    }
}
