//! The shell: streams and requests in, a permit every 20 ms out, and one at once for what may not wait.

mod inlets;
mod latch_file;
mod operators;
mod outlets;

use models::units::Seconds;
use runtime::{Node, RuntimeError, topics};

use crate::event::{Event, Output};
use crate::params::Params;
use crate::supervisor::Supervisor;
use inlets::{Heard, Inlets};
use latch_file::{LATCH_FILE, LatchFile};
use operators::Operators;
use outlets::{Outlets, Totals};

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
    let latch = LatchFile::open(latch_file::path_of(parameters)?);
    let params: Params = parameters.without(&[LATCH_FILE]).parse()?;
    let mut inlets = Inlets::open(&mut node, &params)?;
    let mut operators = Operators::serve(&mut node)?;
    let mut shell = Shell {
        supervisor: Supervisor::new(params, node.session(), latch.stored()),
        outlets: Outlets::open(&mut node)?,
        latch,
    };
    let mut ticks =
        node.timer(topics::PERMIT_PERIOD).tell_irregular(node.diagnostics(), topics::PERMIT_JITTER);
    let (clock, work) = (node.clock(), node.work());
    node.witness(&[])?;
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
                work.done();
            }
            ask = operators.next() => {
                let now = clock.now();
                let output = ask.request().and_then(|request| shell.take(now, Event::Operator(request)));
                if let Some(output) = &output {
                    shell.publish(now, output, inlets.totals()).await;
                }
                operators.answer(&ask, output.as_ref());
            }
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
}

impl Shell {
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
        self.outlets.tell_latch(&self.latch);
        self.outlets.publish(now, output, kept, totals);
    }

    async fn end(&mut self, now: Seconds, output: &Output) {
        let latch = self.supervisor.latch();
        let kept = self.latch.keeps(latch).await;
        self.outlets.last(now, output, kept);
        self.latch.end(latch).await;
    }
}
