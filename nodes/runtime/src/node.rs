//! A node: name, parameters, clock, endpoints, diagnostics, heartbeat, self loop.
//!
//! Lifecycle (five services, `transition_event`, gated publishers) is not here yet;
//! they will be started by [`Node::start`] beside the heartbeat.

mod endpoints;

use crate::args::Args;
use crate::clock::{Clock, Timer};
use crate::diagnostics::Diagnostics;
use crate::environment::{Environment, Services};
use crate::error::RuntimeError;
use crate::heartbeat::{self, Heart, Work};
use crate::names::Names;
use crate::params::services::ParameterServices;
use crate::params::store::{Checked, Store};
use crate::params::{NodePath, ParamFileError, Parameters};
use crate::participants::Participants;
use crate::self_loop::SelfLoop;
use crate::shutdown::{self, Shutdown, ShutdownSender};
use crate::topics;
use crate::{background, bounds, logging};
use models::units::Seconds;
use ros2_client::{Context, NodeOptions};
use serde::de::DeserializeOwned;
use std::hash::{BuildHasher, Hasher};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use tokio::task::{AbortHandle, JoinSet};

/// A node of the graph; dropping it takes it from the graph.
pub struct Node {
    // Dropped in this order: tasks hold readers and writers, the watchdog a participant of its own.
    tasks: JoinSet<()>,
    self_loop: SelfLoop,
    ros: ros2_client::Node,
    context: Context,
    names: Names,
    parameters: Parameters,
    rest: Vec<String>,
    services: Services,
    clock: Clock,
    diagnostics: Diagnostics,
    work: Work,
    session: u64,
    shutdown: Shutdown,
    shutdown_sender: ShutdownSender,
    refused: Arc<AtomicBool>,
    clock_task: Option<AbortHandle>,
    check: Checked,
}

impl std::fmt::Debug for Node {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Node").field("name", &self.names.qualified()).finish_non_exhaustive()
    }
}

/// A random number that tells one run of a node from the next.
fn random_session() -> u64 {
    // The standard library seeds its hash maps from the operating system's random source.
    std::collections::hash_map::RandomState::new().build_hasher().finish()
}

/// Watches over this process's middleware: what happens where it is deaf is told, and where it is overcrowded the process
/// leaves the graph.
fn watch_middleware(
    participants: Participants,
    session: u64,
    on_silence: impl FnOnce() + Send + 'static,
    leave: ShutdownSender,
) -> Result<SelfLoop, RuntimeError> {
    let on_crowd = move |count| {
        if bounds::leave_the_crowd() {
            tracing::error!(
                "{count} participants in the domain: leaving, to come back without those that are none"
            );
            leave.demand();
        }
    };
    SelfLoop::start(participants, session, on_silence, on_crowd)
}

impl Node {
    /// Starts the node from the arguments and the environment of this process. Needs a tokio executor.
    ///
    /// # Errors
    /// [`RuntimeError`]; `is_usage()` tells what a person has to change.
    pub fn start(name: &str) -> Result<Self, RuntimeError> {
        Self::start_with(name, Args::from_env()?)
    }

    /// As [`Node::start`] with given arguments.
    ///
    /// # Errors
    /// [`RuntimeError`]
    pub fn start_with(name: &str, args: Args) -> Result<Self, RuntimeError> {
        Self::start_or(name, args, || {
            tracing::error!("hears nothing through DDS any more: ending the process to be started again");
            bounds::end_deaf();
        })
    }

    /// As [`Node::start_with`], for a process that nobody starts again: where the node hears nothing any more, `on_deaf` is
    /// called once, from another thread, and the node is to be replaced by a new one.
    ///
    /// # Errors
    /// [`RuntimeError`]
    pub fn start_or(
        name: &str,
        args: Args,
        on_deaf: impl FnOnce() + Send + 'static,
    ) -> Result<Self, RuntimeError> {
        logging::start(&args);
        let environment = Environment::from_env()?;
        let names = Names::new(name, &args)?;
        let path = NodePath { qualified: names.qualified(), base: names.base().to_owned() };
        let parameters = Parameters::read(&args.params_files, &args.parameters, &path)?;
        let clock = if parameters.use_sim_time() { Clock::simulated() } else { Clock::monotonic() };

        let participants = Participants::join(&environment)?;
        let participant = participants.own.clone();
        let session = random_session();
        let (shutdown_sender, shutdown) = Shutdown::channel();
        let self_loop = watch_middleware(participants, session, on_deaf, shutdown_sender.clone())?;
        let context = Context::from_domain_participant(participant)
            .map_err(|error| RuntimeError::create("context", &error))?;
        let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
        let ros = context
            .new_node(names.node().clone(), options)
            .map_err(|error| RuntimeError::create(format!("node {}", path.qualified), &error))?;
        shutdown::follow_signals(shutdown_sender.clone())?;
        shutdown::abort_when_continued(shutdown.clone())?;
        let mut node = Self {
            tasks: JoinSet::new(),
            self_loop,
            ros,
            context,
            names,
            parameters,
            rest: args.rest,
            services: environment.services,
            clock,
            diagnostics: Diagnostics::default(),
            work: Work::default(),
            session,
            shutdown,
            shutdown_sender,
            refused: Arc::default(),
            clock_task: None,
            check: Checked::default(),
        };
        node.start_background()?;
        Ok(node)
    }

    /// Starts `/clock`, `/rosout`, `/diagnostics` and the heartbeat.
    fn start_background(&mut self) -> Result<(), RuntimeError> {
        if self.clock.is_simulated() {
            let readings = self.subscribe(&topics::CLOCK)?;
            let task = background::follow_clock(self.clock.clone(), readings, self.diagnostics.clone());
            self.clock_task = Some(self.tasks.spawn(task));
        }
        if let Some(lines) = logging::rosout_lines() {
            let publisher = self.publish_on(&topics::ROSOUT)?;
            self.tasks.spawn(background::publish_log(self.clock.clone(), lines, publisher));
        }
        let publisher = self.publish_on(&topics::DIAGNOSTICS)?;
        let reporter = background::Reporter {
            node: self.names.qualified(),
            clock: self.clock.clone(),
            diagnostics: self.diagnostics.clone(),
            work: self.work.clone(),
            self_loop: self.self_loop.age(),
        };
        self.tasks.spawn(background::publish_diagnostics(reporter, publisher));
        let publisher = self.publish_on(&topics::HEARTBEAT)?;
        let heart = Heart {
            node: self.names.qualified(),
            session: self.session,
            work: self.work.clone(),
            clock: self.clock.clone(),
            self_loop: self.self_loop.age(),
        };
        self.tasks.spawn(heartbeat::beat(heart, publisher));
        let services = ParameterServices::open(self)?;
        let store = Store::new(self.parameters.clone(), self.check.clone());
        self.tasks.spawn(services.serve(store, self.clock.clone(), self.names.qualified()));
        Ok(())
    }

    /// Parses the parameters into the node's checked struct.
    ///
    /// # Errors
    /// [`RuntimeError::Parameters`] with file, line, field, value and range.
    pub fn parameters<T: DeserializeOwned + 'static>(&self) -> Result<T, RuntimeError> {
        self.check_parameters(|parameters| parameters.parse::<T>().map(drop));
        self.parameters.parse().map_err(|error| {
            self.refused.store(true, Ordering::Relaxed);
            RuntimeError::Parameters(error)
        })
    }

    /// How the node parses its parameters, where it does so by itself: what somebody asks to set is checked by it.
    pub fn check_parameters(
        &self,
        check: impl Fn(&Parameters) -> Result<(), ParamFileError> + Send + 'static,
    ) {
        self.check.tell(check);
    }

    /// Notes refused parameters in `refused` from now on.
    pub(crate) fn remember_refusals(&mut self, refused: Arc<AtomicBool>) {
        self.refused = refused;
    }

    /// The parameters in force as text and hash, for the record.
    #[must_use]
    pub fn raw_parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// A timer on the node's clock, first due one period from now.
    #[must_use]
    pub fn timer(&self, period: Seconds) -> Timer {
        self.clock.timer(period)
    }

    /// The node's clock.
    #[must_use]
    pub fn clock(&self) -> Clock {
        self.clock.clone()
    }

    /// The registry behind `/diagnostics`.
    #[must_use]
    pub fn diagnostics(&self) -> Diagnostics {
        self.diagnostics.clone()
    }

    /// The work counter behind the heartbeat.
    #[must_use]
    pub fn work(&self) -> Work {
        self.work.clone()
    }

    /// Random id of this run.
    #[must_use]
    pub fn session(&self) -> u64 {
        self.session
    }

    /// Namespace and name.
    #[must_use]
    pub fn name(&self) -> String {
        self.names.qualified()
    }

    /// Name of a topic or service on the graph, namespace and remapping included.
    #[must_use]
    pub fn resolve(&self, name: &str) -> String {
        self.names.resolve(name)
    }

    /// Arguments outside of `--ros-args`.
    #[must_use]
    pub fn rest(&self) -> &[String] {
        &self.rest
    }

    /// A handle that tells when the end is demanded (SIGINT, SIGTERM, [`Node::stop`]).
    #[must_use]
    pub fn shutdown_handle(&self) -> Shutdown {
        self.shutdown.clone()
    }

    /// Waits for the demand to end.
    pub async fn shutdown(&mut self) {
        self.shutdown.wait().await;
    }

    /// Keeps the middleware while the node's tasks end.
    pub(crate) fn middleware(&self) -> Context {
        self.context.clone()
    }

    /// Demands the end of this node.
    pub fn stop(&self) {
        self.shutdown_sender.demand();
    }
}
