//! What a node does beside its work, and how it is managed.

use super::{Node, lock, random_session};
use crate::background;
use crate::error::RuntimeError;
use crate::heartbeat::{self, Heart};
use crate::lifecycle::{Gate, Life, LifecycleServices, Order, Stage};
use crate::logging;
use crate::params::services::{ParameterServices, Subject};
use crate::topics::{self, Topic};
use fdm_loop_msgs::Heartbeat;
use ros2_client::Context;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use tokio::sync::mpsc;

/// Real time in which the middleware sends what was said last.
const LAST_WORD: std::time::Duration = std::time::Duration::from_millis(50);

impl Node {
    /// Starts `/clock`, `/rosout`, `/diagnostics`, the heartbeat and the parameter services.
    pub(super) fn start_background(&mut self) -> Result<(), RuntimeError> {
        self.spawn(self.core.matches.clone().follow());
        let (clock, diagnostics) = (self.clock(), self.diagnostics());
        if clock.is_simulated() {
            let readings = self.subscribe(&topics::CLOCK)?;
            let task = self.spawn(background::follow_clock(clock.clone(), readings, diagnostics.clone()));
            *lock(&self.core.clock_task) = Some(task);
        }
        if let Some(lines) = logging::rosout_lines() {
            let publisher = self.publish_on(&topics::ROSOUT)?;
            self.spawn(background::publish_log(clock.clone(), lines, publisher));
        }
        let publisher = self.publish_on(&topics::DIAGNOSTICS)?;
        let reporter = background::Reporter {
            node: self.name(),
            clock: clock.clone(),
            diagnostics,
            work: self.work(),
            self_loop: self.core.self_loop.age(),
        };
        self.spawn(background::publish_diagnostics(reporter, publisher));
        self.beat_on(&topics::HEARTBEAT)?;
        let services = ParameterServices::open(self)?;
        let (store, life) = (self.core.store.clone(), self.life());
        self.spawn(services.serve(Subject { store, life, clock, node: self.name() }));
        Ok(())
    }

    /// Beats on a topic from now on, whatever the shell does.
    pub(crate) fn beat_on(&mut self, topic: &Topic<Heartbeat>) -> Result<(), RuntimeError> {
        let publisher = self.publish_on(topic)?;
        let heart = Heart {
            node: self.name(),
            session: self.session(),
            work: self.work(),
            clock: self.clock(),
            self_loop: self.core.self_loop.age(),
        };
        self.spawn(heartbeat::beat(heart, publisher));
        Ok(())
    }

    pub(crate) fn spawn(&self, task: impl Future<Output = ()> + Send + 'static) -> tokio::task::AbortHandle {
        lock(&self.core.tasks).spawn(task)
    }

    /// Offers the services of a managed node. What is asked for comes through the receiver; whether the node is to go
    /// to active by itself.
    pub(crate) fn manage(&mut self) -> Result<(mpsc::Receiver<Order>, bool), RuntimeError> {
        let services = LifecycleServices::open(self)?;
        let events = self.publish_on(&topics::TRANSITION_EVENT)?;
        self.life().tell(events, self.clock(), self.diagnostics());
        self.gate = Gate::closed();
        let (sender, orders) = mpsc::channel(1);
        self.spawn(services.serve(self.life(), sender));
        Ok((orders, self.parameters.autostart()))
    }

    /// The node for one configuration of its shell, with the parameters in force.
    pub(crate) fn staged(&self, stage: Stage) -> Self {
        self.core.diagnostics.forget_shell();
        let first = !self.core.staged.swap(true, Ordering::Relaxed);
        Self { session: if first { self.session } else { random_session() }, ..self.asked(stage) }
    }

    /// A node for a shell that is asked something, and that is nobody's configuration.
    pub(crate) fn asked(&self, stage: Stage) -> Self {
        Self {
            session: self.session,
            core: Arc::clone(&self.core),
            parameters: self.core.store.parameters(),
            gate: self.gate.clone(),
            shutdown: stage.stopped.clone(),
            stage: Some(stage),
        }
    }

    /// Tells that everything is loaded and open, and waits until the node may act. What is not managed may at once.
    pub async fn activated(&self) {
        if let Some(stage) = &self.stage {
            stage.activated().await;
        }
    }

    /// Whether it speaks for others already; it does from now on.
    pub(crate) fn is_witness(&self) -> bool {
        self.core.witness.swap(true, Ordering::Relaxed)
    }

    /// Waits until a last word has left the process: RustDDS forgets a writer together with what it has not sent yet.
    pub async fn spoken(&self) {
        tokio::time::sleep(LAST_WORD).await;
    }

    /// Waits until a last report on `/diagnostics` has left the process as well.
    pub async fn reported(&self) {
        tokio::time::sleep(background::LOOK).await;
        self.spoken().await;
    }

    /// The state that its services tell.
    pub(crate) fn life(&self) -> Life {
        self.core.life.clone()
    }

    /// What its messages pass.
    pub(crate) fn gate(&self) -> &Gate {
        &self.gate
    }

    /// Waits for a change of parameters while the shell waits.
    pub(crate) fn parameters_changed(&self) -> impl Future<Output = ()> + use<> {
        let store = self.core.store.clone();
        async move { store.changed().await }
    }

    /// The parameters that its services ask and set.
    #[cfg(test)]
    pub(crate) fn store(&self) -> &crate::params::store::Store {
        &self.core.store
    }

    /// Keeps the middleware while the node's tasks end.
    pub(crate) fn middleware(&self) -> Context {
        self.core.context.clone()
    }
}
