//! Drives a shell through the states of its node.

mod shell;

use super::life::Life;
use super::machine::{Outcome, Step};
use super::order::all_active;
use super::services::Order;
use super::stage::Stage;
use crate::error::chain;
use crate::node::Node;
use crate::shutdown::Shutdown;
use futures::FutureExt;
use shell::{By, Configured, End, Next, Shell, Work};
use std::error::Error;
use std::future::{pending, poll_fn};
use std::task::Poll;
use std::time::Duration;
use tokio::sync::{mpsc, oneshot};

/// Time that a shell has to end when its node is deactivated; then the process is ended.
const GRACE: Duration = Duration::from_millis(1800);

/// A deactivated shell that goes on.
#[derive(Debug, thiserror::Error)]
#[error("the node did not stop {} s after it was deactivated", GRACE.as_secs_f64())]
struct DidNotStop;

/// Drives `main` until the process is asked to end, or the shell ends by itself. With `autostart` the node goes to active
/// without being asked, and what its configuration refuses ends the process.
pub(crate) async fn drive<F, R, E>(
    node: &Node,
    main: F,
    orders: mpsc::Receiver<Order>,
    autostart: bool,
) -> End
where
    F: Fn(Node) -> R,
    R: Future<Output = Result<(), E>>,
    E: Error + 'static,
{
    let main = |node: Node| -> Work<'_> {
        let working = main(node);
        Box::pin(async { Ok(working.await?) })
    };
    let life = node.life();
    let driver = Driver { node, main, orders, life, shutdown: node.shutdown_handle(), ended: None };
    driver.run(autostart).await
}

struct Driver<'n, F> {
    node: &'n Node,
    main: F,
    orders: mpsc::Receiver<Order>,
    life: Life,
    shutdown: Shutdown,
    /// Who waits for the end of the step under way.
    ended: Option<oneshot::Sender<bool>>,
}

impl<'a, F: Fn(Node) -> Work<'a>> Driver<'_, F> {
    async fn run(mut self, mut autostart: bool) -> End {
        if !autostart {
            self.ask_for_check().await;
        }
        loop {
            if autostart {
                self.life.begin(Step::Configure);
            } else {
                match self.order().await {
                    Some(Step::Configure) => {}
                    Some(Step::Shutdown) => return self.finalized().await,
                    Some(_) => {
                        // Nothing is configured: an error leads back here from every step.
                        self.settle(Outcome::Error);
                        continue;
                    }
                    None => return Ok(()),
                }
            }
            match self.configure().await {
                Configured::Ready(shell) => {
                    self.settle(Outcome::Success);
                    if let Some(end) = self.configured(shell, autostart).await {
                        return end;
                    }
                }
                Configured::Ended(Err(error)) if !autostart => {
                    tracing::error!("not configured: {}", chain(error.as_ref()));
                    self.settle(Outcome::Failure);
                }
                Configured::Ended(end) => return end,
                Configured::Interrupted => return Ok(()),
            }
            autostart = false;
        }
    }

    /// Has the shell say how it checks its parameters, before it is configured for the first time: what is set until then
    /// is checked as well. It ends at that; what it says of its parameters now, its configuration will say.
    async fn ask_for_check(&self) {
        let mut shell = (self.main)(self.node.asked(Stage::question()));
        poll_fn(|context| {
            // One that does not end there waits for something: it is not to go on.
            _ = shell.as_mut().poll(context);
            Poll::Ready(())
        })
        .await;
    }

    /// From inactive on; `None` leads back to unconfigured.
    async fn configured(&mut self, mut shell: Shell<'a>, mut autostart: bool) -> Option<End> {
        loop {
            match self.inactive(autostart).await {
                Next::Active(by) => {
                    autostart = false;
                    match self.active(shell, by).await {
                        Ok(configured) => shell = configured?,
                        Err(end) => return Some(end),
                    }
                }
                Next::Anew => {
                    // What it has open, the next one opens.
                    drop(shell);
                    match self.configure().await {
                        Configured::Ready(anew) => shell = anew,
                        Configured::Ended(Err(error)) => {
                            tracing::error!("not configured anew: {}", chain(error.as_ref()));
                            return self.unconfigure().await;
                        }
                        Configured::Ended(end) => return Some(end),
                        Configured::Interrupted => return Some(Ok(())),
                    }
                }
                Next::Unconfigured(outcome) => {
                    drop(shell);
                    self.settle(outcome);
                    return None;
                }
                Next::End(end) => return Some(end),
            }
        }
    }

    /// Back to unconfigured: there is no shell any more.
    async fn unconfigure(&mut self) -> Option<End> {
        if self.life.begin(Step::Cleanup) {
            self.life.finish(Outcome::Success);
            return None;
        }
        // Somebody has asked for a step while it was configured anew: that one has begun, and leads there too.
        match self.order().await {
            Some(Step::Cleanup) => self.settle(Outcome::Success),
            Some(Step::Shutdown) => return Some(self.finalized().await),
            Some(_) => self.settle(Outcome::Error),
            None => return Some(Ok(())),
        }
        None
    }

    /// Waits in inactive; with `autostart` until those are active that this node is to start after.
    async fn inactive(&mut self, autostart: bool) -> Next {
        let (node, changed) = (self.node, self.node.parameters_changed());
        let others = async {
            if !autostart {
                pending::<()>().await;
            }
            all_active(node, node.raw_parameters().start_after()).await;
        };
        let step = tokio::select! {
            biased;
            // First: what was set before a step was asked for is in force after it.
            () = changed => return Next::Anew,
            step = self.order() => step,
            () = others => {
                self.life.begin(Step::Activate);
                return Next::Active(By::Itself);
            }
        };
        match step {
            Some(Step::Activate) => Next::Active(By::Request),
            Some(Step::Cleanup) => Next::Unconfigured(Outcome::Success),
            Some(Step::Shutdown) => Next::End(self.finalized().await),
            Some(Step::Configure | Step::Deactivate) => Next::Unconfigured(Outcome::Error),
            None => Next::End(Ok(())),
        }
    }

    /// Works; then the shell that waits for the next activation, `None` where there is none, or the end.
    async fn active(&mut self, mut shell: Shell<'a>, by: By) -> Result<Option<Shell<'a>>, End> {
        self.node.gate().open(by == By::Request);
        shell.stage.go();
        // What it opens first belongs to the activation: whoever asked for that hears of a disk that cannot be written.
        match poll_fn(|context| Poll::Ready(shell.work.as_mut().poll(context))).await {
            Poll::Ready(Err(error)) if by == By::Request => {
                self.node.gate().close();
                tracing::error!("not activated: {}", chain(error.as_ref()));
                self.settle(Outcome::Error);
                return Ok(None);
            }
            Poll::Ready(end) => return Err(end),
            Poll::Pending => self.settle(Outcome::Success),
        }
        let order = tokio::select! {
            biased;
            end = &mut shell.work => return Err(end),
            order = self.orders.recv() => order,
            () = self.shutdown.wait() => None,
        };
        shell.stage.stop.demand();
        let Some(Order { step, ended }) = order else { return Err(shell.work.await) };
        self.ended = Some(ended);
        // Its last word is the safe one: nothing of the node acts after it.
        let end = tokio::time::timeout(GRACE, shell.work).await;
        self.node.gate().close();
        match end {
            Err(_) => return Err(Err(DidNotStop.into())),
            Ok(Err(error)) => return Err(Err(error)),
            Ok(Ok(())) => {}
        }
        if step == Step::Shutdown {
            return Err(self.finalized().await);
        }
        match self.configure().await {
            Configured::Ready(shell) => {
                self.settle(Outcome::Success);
                Ok(Some(shell))
            }
            Configured::Ended(Err(error)) => {
                tracing::error!("not configured anew: {}", chain(error.as_ref()));
                self.settle(Outcome::Error);
                Ok(None)
            }
            Configured::Ended(end) => Err(end),
            Configured::Interrupted => Err(Ok(())),
        }
    }

    /// Lets the shell load and open what it needs.
    async fn configure(&mut self) -> Configured<'a> {
        let stage = Stage::new();
        // What was set up to now it reads.
        _ = self.node.parameters_changed().now_or_never();
        let mut work = (self.main)(self.node.staged(stage.clone()));
        tokio::select! {
            biased;
            end = &mut work => Configured::Ended(end),
            () = stage.ready() => Configured::Ready(Shell { work, stage }),
            () = self.shutdown.wait() => Configured::Interrupted,
        }
    }

    /// Waits for a step to be asked for; `None`: the process is to end.
    async fn order(&mut self) -> Option<Step> {
        tokio::select! {
            order = self.orders.recv() => order.map(|Order { step, ended }| {
                self.ended = Some(ended);
                step
            }),
            () = self.shutdown.wait() => None,
        }
    }

    /// Ends the step under way.
    fn settle(&mut self, outcome: Outcome) {
        self.life.finish(outcome);
        if let Some(ended) = self.ended.take() {
            // Who asked may be gone.
            _ = ended.send(outcome == Outcome::Success);
        }
    }

    /// Nothing more is done, until the process is asked to end: it would be started again.
    async fn finalized(&mut self) -> End {
        self.settle(Outcome::Success);
        self.shutdown.wait().await;
        Ok(())
    }
}

#[cfg(test)]
mod tests;
