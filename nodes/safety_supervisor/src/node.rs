//! The shell: streams and requests in, a permit every 20 ms out, and one at once for what may not wait.

mod hearts;
mod inlets;
mod journal;
mod latch_file;
mod operators;
mod outlets;
mod record;
mod rivals;
mod standing_file;

use std::path::PathBuf;

use models::units::Seconds;
use runtime::{Level, Node, RuntimeError, topics};
use tokio::time::{MissedTickBehavior, interval};

use crate::cause::Cause;
use crate::event::{Event, Output, What};
use crate::params::Params;
use crate::supervisor::Supervisor;
use hearts::Hearts;
use inlets::{Heard, Inlets};
use latch_file::{LATCH_FILE, LatchFile, Latched};
use operators::Operators;
use outlets::{Outlets, Totals};
use standing_file::{StandingFile, Written};

/// What `/diagnostics` says of a supervisor that waits.
const NOT_ACTIVE: &str = "not active: no permits, nobody watches the heaters";

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
    node.witness_all()?;
    let mut hearts = Hearts::open(&mut node)?;
    let mut looks = interval(rivals::LOOK);
    looks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    // Until then, and where somebody has taken it out of its work again; its first state says what holds after that.
    node.diagnostics().report(Level::Warn, NOT_ACTIVE);
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
                operators.answer_waiting(shell.kept, shell.refusal());
                work.done();
            }
            ask = operators.next() => {
                let now = clock.now();
                let output = ask.request().and_then(|request| shell.take(now, Event::Operator(request)));
                if let Some(output) = &output {
                    shell.publish(now, output, inlets.totals()).await;
                }
                operators.take(ask, output);
                operators.answer_waiting(shell.kept, shell.refusal());
            }
            () = hearts.next_look() => hearts.look(|event| _ = shell.take(clock.now(), event)),
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
    /// Latch, mode and pause are on disk as they are now.
    kept: bool,
    /// Why records of the former run were refused, until it is told.
    refused: Vec<(Cause, String)>,
}

impl Shell {
    /// Goes on where the records of `path` end.
    fn open(node: &mut Node, params: Params, path: Option<PathBuf>) -> Result<Self, RuntimeError> {
        let (standing, standing_refused) = StandingFile::open(path.as_deref());
        let (latch, latch_refused) = LatchFile::open(path);
        let refused = latch_refused
            .map(|why| (Cause::LatchUnreadable, why))
            .into_iter()
            .chain(standing_refused.map(|why| (Cause::StandingUnreadable, why)))
            .collect();
        let mut supervisor = Supervisor::new(params, node.session(), latch.stored().map(Latched::latch));
        if let Some(written) = standing.stored() {
            supervisor = supervisor.after(written.into());
        }
        // The latch comes before the pause below it.
        let evidence = match (latch.stored(), standing.stored()) {
            (Some(latched), _) => latched.evidence(),
            (None, written) => written.and_then(Written::evidence),
        };
        if let Some(evidence) = evidence {
            supervisor = supervisor.resting_on(evidence);
        }
        Ok(Self { supervisor, outlets: Outlets::open(node)?, latch, standing, kept: true, refused })
    }

    /// Why the disk does not keep one of them.
    fn refusal(&self) -> Option<&str> {
        self.latch.failed.as_deref().or(self.standing.failed.as_deref())
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

    /// The latch as it is to be on disk.
    fn latched(&self) -> Option<Latched> {
        let latch = self.supervisor.latch()?;
        Some(Latched::new(latch, self.supervisor.evidence_of(latch.cause)))
    }

    /// Mode and pause as they are to be on disk.
    fn written(&self) -> Option<Written> {
        let standing = self.supervisor.standing()?;
        let evidence = standing.paused.and_then(|cause| self.supervisor.evidence_of(cause));
        Some(Written::new(standing, evidence))
    }

    async fn publish(&mut self, now: Seconds, output: &Output, totals: Totals) {
        let (latched, written) = (self.latched(), self.written());
        let kept = self.latch.keeps(latched).await;
        self.kept = self.standing.keeps(written).await && kept;
        self.outlets.tell_records(&self.latch, &self.standing);
        self.outlets.publish(now, output, kept, totals);
        // Told once the others have found this process.
        if output.events.iter().any(|decision| decision.what == What::Remembered) {
            for (cause, why) in self.refused.drain(..) {
                self.outlets.tell_refused(now, output.state.mode, cause, &why);
            }
        }
    }

    async fn end(&mut self, now: Seconds, output: &Output) {
        let (latched, written) = (self.latched(), self.written());
        let kept = self.latch.keeps(latched).await;
        self.outlets.last(now, output, kept);
        self.latch.end(latched).await;
        self.standing.end(written).await;
    }
}
