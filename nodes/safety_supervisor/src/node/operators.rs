//! The services through which a person asks.

use fdm_loop_msgs::{SetMode, SetModeResponse, Trigger, TriggerResponse};
use runtime::{Asked, Node, RuntimeError, Server, topics};

use crate::convert;
use crate::event::{Decision, Operator, Output, What};
use models::command::Mode;

/// Every service of the supervisor.
pub(super) struct Operators {
    pause: Server<Trigger>,
    resume: Server<Trigger>,
    stop: Server<Trigger>,
    estop: Server<Trigger>,
    acknowledge: Server<Trigger>,
    approve: Server<Trigger>,
    set_mode: Server<SetMode>,
    /// Requests whose answers wait for the disk, and how often it was looked at.
    waiting: Vec<(Ask, Option<Output>)>,
    looks: u32,
}

/// Looks at the disk for which an answer waits at most: half a second of ticks, or as many further requests.
pub(super) const PATIENCE: u32 = 25;

/// A request that waits for its answer.
pub(super) enum Ask {
    Trigger(Operator, Asked<Trigger>),
    SetMode(Asked<SetMode>),
}

impl Ask {
    /// What is asked; `None` where it is nothing that can be.
    pub(super) fn request(&self) -> Option<Operator> {
        match self {
            Self::Trigger(request, _) => Some(*request),
            Self::SetMode(asked) => convert::set_mode(asked.request.mode).map(Operator::SetMode),
        }
    }
}

impl Operators {
    pub(super) fn serve(node: &mut Node) -> Result<Self, RuntimeError> {
        Ok(Self {
            pause: node.serve(&topics::SAFETY_PAUSE)?,
            resume: node.serve(&topics::SAFETY_RESUME)?,
            stop: node.serve(&topics::SAFETY_STOP)?,
            estop: node.serve(&topics::SAFETY_ESTOP)?,
            acknowledge: node.serve(&topics::SAFETY_ACKNOWLEDGE)?,
            approve: node.serve(&topics::CONTROL_APPROVE)?,
            set_mode: node.serve(&topics::SAFETY_SET_MODE)?,
            waiting: Vec::new(),
            looks: 0,
        })
    }

    /// The next request, the most urgent first. Cancelling loses none.
    pub(super) async fn next(&mut self) -> Ask {
        tokio::select! {
            biased;
            asked = self.estop.next() => Ask::Trigger(Operator::Estop, asked),
            asked = self.stop.next() => Ask::Trigger(Operator::Stop, asked),
            asked = self.pause.next() => Ask::Trigger(Operator::Pause, asked),
            asked = self.resume.next() => Ask::Trigger(Operator::Resume, asked),
            asked = self.acknowledge.next() => Ask::Trigger(Operator::Acknowledge, asked),
            asked = self.approve.next() => Ask::Trigger(Operator::Approve, asked),
            asked = self.set_mode.next() => Ask::SetMode(asked),
        }
    }

    /// Takes a request with the brain's answer to it. What is to outlive the process is answered when it is on disk.
    pub(super) fn take(&mut self, ask: Ask, output: Option<Output>) {
        match ask.request() {
            Some(Operator::SetMode(_) | Operator::Pause | Operator::Resume | Operator::Acknowledge) => {
                self.waiting.push((ask, output));
            }
            Some(Operator::Stop | Operator::Estop | Operator::Approve) | None => {
                self.answer(&ask, output.as_ref(), None);
            }
        }
    }

    /// Tells what became of the requests that waited, where the disk has done its work, refuses it, or takes too long.
    pub(super) fn answer_waiting(&mut self, kept: bool, failed: Option<&str>) {
        if self.waiting.is_empty() {
            return;
        }
        self.looks += 1;
        let Some(disk) = said_of_disk(kept, failed, self.looks) else { return };
        self.looks = 0;
        for (ask, output) in std::mem::take(&mut self.waiting) {
            self.answer(&ask, output.as_ref(), disk);
        }
    }

    /// Tells what became of a request: `output` is the brain's answer to it, `disk` why a restart would not know of it.
    fn answer(&self, ask: &Ask, output: Option<&Output>, disk: Option<&str>) {
        let (success, mut message) = output
            .map_or_else(|| (false, "mode must be 1 (observe), 2 (advise) or 3 (act)".to_owned()), verdict);
        if let Some(error) = disk.filter(|_| success) {
            message.push_str("; a restart would not know of it: ");
            message.push_str(error);
        }
        match ask {
            Ask::SetMode(asked) => {
                self.set_mode.answer(asked, SetModeResponse { accepted: success, message })
            }
            Ask::Trigger(request, asked) => {
                let server = match request {
                    Operator::Pause => &self.pause,
                    Operator::Resume => &self.resume,
                    Operator::Stop => &self.stop,
                    Operator::Estop => &self.estop,
                    Operator::Acknowledge => &self.acknowledge,
                    Operator::Approve | Operator::SetMode(_) => &self.approve,
                };
                server.answer(asked, TriggerResponse { success, message })
            }
        };
    }
}

/// What an answer says of the disk, where it says anything; `None` as long as it is waited for.
fn said_of_disk(kept: bool, failed: Option<&str>, looks: u32) -> Option<Option<&str>> {
    match (kept, failed) {
        (true, _) => Some(None),
        (false, Some(error)) => Some(Some(error)),
        (false, None) if looks < PATIENCE => None,
        (false, None) => Some(Some("the disk takes long")),
    }
}

/// Whether the newest request was granted: the mode in force and what is still to come, or the reason.
fn verdict(output: &Output) -> (bool, String) {
    let newest =
        output.events.iter().rev().find(|event| matches!(event.what, What::Granted(_) | What::Denied(_)));
    let mode = convert::mode_name(output.state.mode);
    let Some(event) = newest else { return (false, format!("no decision, mode {mode}")) };
    let told = convert::told(event);
    match event.what {
        What::Denied(_) => (false, told),
        _ if event.why == Decision::ON_REQUEST => (true, format!("mode {mode}")),
        // It reads on as a sentence. Behind a latch a job waits in any mode.
        What::Granted(Operator::Resume) if output.state.mode == Mode::Paused => {
            (true, format!("granted: mode {mode} {told}"))
        }
        What::Granted(Operator::Resume) => (true, format!("granted: mode {mode}, the job waits {told}")),
        _ => (true, format!("mode {mode}: {told}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cause::Cause;
    use crate::event::Event;
    use crate::supervisor::Supervisor;
    use models::units::Seconds;

    #[test]
    fn an_answer_waits_for_the_disk_but_not_for_ever() {
        assert_eq!(said_of_disk(true, None, 1), Some(None));
        assert_eq!(said_of_disk(false, None, 1), None);
        assert_eq!(said_of_disk(false, None, PATIENCE), Some(Some("the disk takes long")));
        assert_eq!(said_of_disk(false, Some("/x: full"), 1), Some(Some("/x: full")));
        assert_eq!(said_of_disk(true, Some("/x: full"), 1), Some(None), "an older refusal");
    }

    /// What `fdm` shows of an answer: of a mode that is set beneath a pause, which, why it waits, and what to do.
    #[test]
    fn an_answer_says_what_came_of_the_request_and_what_to_do() {
        let text = include_str!("../../../../config/safety_supervisor.param.yaml");
        let mut file: serde_json::Value = serde_saphyr::from_str(text).unwrap();
        let params = serde_json::from_value(file["/**"]["ros__parameters"].take()).unwrap();
        let mut supervisor = Supervisor::new(params, 1, None);
        let mut ask = |request| {
            let output = supervisor.on_event(Seconds(1.0), Event::Operator(request)).unwrap();
            verdict(&output)
        };
        let observe = Operator::SetMode(Mode::Observe);
        let told = |text: &str| (true, text.to_owned());
        assert_eq!(ask(observe), told("mode init: observe is set: it holds as soon as the start is over"));
        let refused = |text: &str| (false, text.to_owned());
        assert_eq!(ask(Operator::Acknowledge), refused("not latched: nothing to acknowledge"));
        assert_eq!(ask(Operator::Approve), refused("not in advise: `fdm mode advise` first"));
        let paused = format!("P13: paused by a person. What to do: {}", Cause::OperatorPause.what_to_do());
        assert_eq!(ask(Operator::Pause), told(&format!("mode paused: {paused}")));
        let set = "mode paused: advise is set: it holds as soon as what is in force is over";
        assert_eq!(ask(Operator::SetMode(Mode::Advise)), told(&format!("{set}; {paused}")));
        let stopped =
            format!("P13: emergency stop by a person. What to do: {}", Cause::OperatorEstop.what_to_do());
        assert_eq!(ask(Operator::Estop), told(&format!("mode estop: {stopped}")));
        let latched = format!("latched: `fdm acknowledge` first; {stopped}");
        assert_eq!(ask(Operator::Resume), refused(&latched));
    }
}
