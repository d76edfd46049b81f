//! The shell: streams and requests in, a permit every 20 ms out, and one at once for what may not wait.

mod inlets;
mod latch_file;
mod operators;
mod outlets;
mod record;
mod rivals;
mod standing_file;

use std::path::PathBuf;

use models::units::Seconds;
use runtime::{Node, RuntimeError, topics};
use tokio::time::{MissedTickBehavior, interval};

use crate::event::{Event, Output, What};
use crate::params::Params;
use crate::supervisor::Supervisor;
use inlets::{Heard, Inlets};
use latch_file::{LATCH_FILE, LatchFile};
use operators::Operators;
use outlets::{Outlets, Totals};
use standing_file::{StandingFile, Written};

/// Runs the node to its end; its last word is a permit with the slicer's own values.
///
/// # Errors
/// [`RuntimeError`] where it cannot start.
pub async fn run(mut node: Node) -> Result<(), RuntimeError> {
    node.check_parameters(|parameters| {
        _ = latch_file::path_of(parameters)?;
        parameters.without(&[LATCH_FILE]).parse::<Params>().map(drop)
    })?;
    let parameters = node.raw_parameters();
    let path = latch_file::path_of(parameters)?;
    let params: Params = parameters.without(&[LATCH_FILE]).parse()?;
    let mut inlets = Inlets::open(&mut node, &params)?;
    let mut operators = Operators::serve(&mut node)?;
    let mut shell = Shell::open(&mut node, params, path)?;
    let mut ticks =
        node.timer(topics::PERMIT_PERIOD).tell_irregular(node.diagnostics(), topics::PERMIT_JITTER);
    let (clock, work) = (node.clock(), node.work());
    node.witness(&[])?;
    let mut looks = interval(rivals::LOOK);
    looks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    node.activated().await;
    loop {
        tokio::select! {
            // Time first: a flood of messages must not hold a permit up.
            biased;
            () = node.shutdown() => break,
            now = ticks.next() => {
                if let Some(output) = shell.take(now, Event::Tick { now }) {
                    inlets.follow(&output.state);
                    shell.publish(now, &output, inlets.totals()).await;
                }
                operators.answer_waiting(shell.kept, shell.standing.failed.as_deref());
                work.done();
            }
            ask = operators.next() => {
                let now = clock.now();
                let output = ask.request().and_then(|request| shell.take(now, Event::Operator(request)));
                if let Some(output) = &output {
                    shell.publish(now, output, inlets.totals()).await;
                }
                operators.take(ask, output);
                operators.answer_waiting(shell.kept, shell.standing.failed.as_deref());
            }
            _ = looks.tick() => inlets.look_for_rivals(&mut node),
            heard = inlets.next() => {
                let now = clock.now();
                if let Some(output) = shell.hear(now, heard) {
                    shell.publish(now, &output, inlets.totals()).await;
                }
                // Where messages never end the timers of the executor would not get their turn.
                tokio::task::yield_now().await;
            }
        }
    }
    let now = clock.now();
    if let Some(output) = shell.take(now, Event::Tick { now }) {
        shell.end(now, &output).await;
        node.spoken().await;
    }
    Ok(())
}

struct Shell {
    supervisor: Supervisor,
    outlets: Outlets,
    latch: LatchFile,
    standing: StandingFile,
    /// Mode and pause are on disk as they are now.
    kept: bool,
    /// Why the record of the former run was refused, until it is told.
    refused: Option<String>,
}

impl Shell {
    /// Goes on where the records of `path` end.
    fn open(node: &mut Node, params: Params, path: Option<PathBuf>) -> Result<Self, RuntimeError> {
        let (standing, refused) = StandingFile::open(path.as_deref());
        let latch = LatchFile::open(path);
        let supervisor = Supervisor::new(params, node.session(), latch.stored());
        let supervisor = match standing.stored() {
            Some(written) => supervisor.after(written.into()),
            None => supervisor,
        };
        Ok(Self { supervisor, outlets: Outlets::open(node)?, latch, standing, kept: true, refused })
    }

    fn take(&mut self, now: Seconds, event: Event) -> Option<Output> {
        self.supervisor.on_event(now, event)
    }

    fn hear(&mut self, now: Seconds, heard: Heard) -> Option<Output> {
        match heard {
            Heard::Event(event) => self.take(now, event),
            Heard::Scheduled(scheduled) => {
                if let Some(allowed) = self.supervisor.on_scheduled(now, scheduled) {
                    self.outlets.schedule(now, &allowed);
                }
                None
            }
        }
    }

    async fn publish(&mut self, now: Seconds, output: &Output, totals: Totals) {
        let kept = self.latch.keeps(self.supervisor.latch()).await;
        self.kept = self.standing.keeps(self.supervisor.standing().map(Written::from)).await;
        self.outlets.tell_records(&self.latch, &self.standing);
        self.outlets.publish(now, output, kept, totals);
        // Told once the others have found this process.
        if output.events.iter().any(|decision| decision.what == What::Remembered)
            && let Some(why) = self.refused.take()
        {
            self.outlets.tell_refused(now, output.state.mode, why);
        }
    }

    async fn end(&mut self, now: Seconds, output: &Output) {
        let latch = self.supervisor.latch();
        let kept = self.latch.keeps(latch).await;
        self.outlets.last(now, output, kept);
        self.latch.end(latch).await;
        self.standing.end(self.supervisor.standing().map(Written::from)).await;
    }
}
