//! A node: name, parameters, clock, endpoints, diagnostics, heartbeat, self loop.

mod background;
mod domain;
mod endpoints;
mod middleware;

use crate::args::Args;
use crate::clock::{Clock, Timer};
use crate::diagnostics::Diagnostics;
use crate::environment::{Environment, Services};
use crate::error::RuntimeError;
use crate::heartbeat::Work;
use crate::lifecycle::{Gate, Life, Stage};
use crate::matches::Matches;
use crate::names::Names;
use crate::params::store::{LiveParameters, Store};
use crate::params::{NodePath, ParamFileError, Parameters};
use crate::participants::Participants;
use crate::self_loop::{Making, SelfLoop};
use crate::shutdown::{self, Shutdown, ShutdownSender};
use crate::{bounds, logging};
use middleware::{once, random_session, watch_middleware};
use models::units::Seconds;
use ros2_client::{Context, NodeOptions};
use serde::de::DeserializeOwned;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::task::{AbortHandle, JoinSet};

/// A node of the graph; dropping it takes it from the graph.
pub struct Node {
    core: Arc<Core>,
    parameters: Parameters,
    /// What its messages pass.
    gate: Gate,
    /// Where somebody drives it through its states.
    stage: Option<Stage>,
    /// Another one a configuration: who was deactivated counts its messages anew.
    session: u64,
    shutdown: Shutdown,
}

/// What all configurations of a node share.
struct Core {
    // Dropped in this order: tasks hold readers and writers, the watchdog a participant of its own.
    tasks: Mutex<JoinSet<()>>,
    self_loop: SelfLoop,
    making: Making,
    ros: Mutex<ros2_client::Node>,
    context: Context,
    names: Names,
    rest: Vec<String>,
    services: Services,
    matches: Matches,
    clock: Clock,
    diagnostics: Diagnostics,
    work: Work,
    /// Whether it speaks for nodes that have gone.
    witness: AtomicBool,
    /// Whether a shell was configured before.
    staged: AtomicBool,
    shutdown_sender: ShutdownSender,
    refused: Mutex<Arc<AtomicBool>>,
    clock_task: Mutex<Option<AbortHandle>>,
    store: Store,
    life: Life,
}

impl std::fmt::Debug for Node {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Node").field("name", &self.core.names.qualified()).finish_non_exhaustive()
    }
}

/// What is behind a lock, whatever happened to who held it.
fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
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
        let on_deaf = || {
            tracing::error!("hears nothing through DDS any more: ending the process to be started again");
            bounds::end_deaf();
        };
        Self::start_by(name, args, on_deaf, || {
            tracing::error!("was stopped and continued: ending the process to be started again");
            logging::write_last_lines();
            std::process::abort();
        })
    }

    /// As [`Node::start_with`], for a process that nobody starts again: where the node hears nothing any more, or may not
    /// since the process was stopped and continued, `on_deaf` is called once, from any thread, and the node is to be
    /// replaced by a new one.
    ///
    /// # Errors
    /// [`RuntimeError`]
    pub fn start_or(
        name: &str,
        args: Args,
        on_deaf: impl FnOnce() + Send + 'static,
    ) -> Result<Self, RuntimeError> {
        let (deaf, continued) = once(on_deaf);
        Self::start_by(name, args, deaf, continued)
    }

    fn start_by(
        name: &str,
        args: Args,
        on_deaf: impl FnOnce() + Send + 'static,
        on_continued: impl FnOnce() + Send + 'static,
    ) -> Result<Self, RuntimeError> {
        let names = Names::new(name, &args);
        logging::start(&args, &names.as_ref().map_or_else(|_| name.to_owned(), Names::qualified));
        let unsupported = Environment::remarks(|name| std::env::var(name).ok());
        args.remarks.iter().chain(&unsupported).for_each(|remark| tracing::warn!("{remark}"));
        let (names, environment) = (names?, Environment::from_env()?);
        let path = NodePath { qualified: names.qualified(), base: names.base().to_owned() };
        let parameters = Parameters::read(&args.params_files, &args.parameters, &path)?;
        let clock = if parameters.use_sim_time() { Clock::simulated() } else { Clock::monotonic() };

        let participants = Participants::join(&environment)?;
        let participant = participants.own.clone();
        let session = random_session();
        let (shutdown_sender, shutdown) = Shutdown::channel();
        let making = Making::default();
        let watched = (participants, making.clone());
        let self_loop = watch_middleware(watched, session, on_deaf, shutdown_sender.clone())?;
        let context = Context::from_domain_participant(participant.clone())
            .map_err(|error| RuntimeError::create("context", &error))?;
        let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
        let ros = context
            .new_node(names.node().clone(), options)
            .map_err(|error| RuntimeError::create(format!("node {}", path.qualified), &error))?;
        shutdown::follow_signals(shutdown_sender.clone())?;
        shutdown::when_continued(shutdown.clone(), on_continued)?;
        let core = Core {
            tasks: Mutex::new(JoinSet::new()),
            self_loop,
            making,
            ros: Mutex::new(ros),
            context,
            names,
            rest: args.rest,
            services: environment.services,
            matches: Matches::of(participant.clone()),
            clock,
            diagnostics: Diagnostics::default(),
            work: Work::default(),
            witness: AtomicBool::new(false),
            staged: AtomicBool::new(false),
            shutdown_sender,
            refused: Mutex::default(),
            clock_task: Mutex::default(),
            store: Store::new(parameters.clone()),
            life: Life::default(),
        };
        let (core, gate) = (Arc::new(core), Gate::open_always());
        let mut node = Self { core, parameters, gate, stage: None, session, shutdown };
        node.start_background()?;
        Ok(node)
    }

    /// Parses the parameters into the node's checked struct.
    ///
    /// # Errors
    /// [`RuntimeError::Parameters`] with file, line, field, value and range.
    pub fn parameters<T: DeserializeOwned + 'static>(&self) -> Result<T, RuntimeError> {
        self.check_parameters(|parameters| parameters.parse::<T>().map(drop))?;
        self.parameters.parse().map_err(|error| {
            self.refuse();
            RuntimeError::Parameters(error)
        })
    }

    /// How the node parses its parameters, where it does so by itself: what somebody asks to set is checked by it. Comes
    /// before all else in a shell: one that is not configured yet is asked for this alone.
    ///
    /// # Errors
    /// [`RuntimeError::Asked`] where nothing but this was wanted.
    pub fn check_parameters(
        &self,
        check: impl Fn(&Parameters) -> Result<(), ParamFileError> + Send + 'static,
    ) -> Result<(), RuntimeError> {
        self.core.store.tell_check(check);
        match &self.stage {
            Some(stage) if stage.is_question() => Err(RuntimeError::Asked),
            _ => Ok(()),
        }
    }

    /// Declares which parameters may change while the node is active, and follows their changes. All others may change
    /// while it is inactive.
    #[must_use]
    pub fn live_parameters(&self, names: &'static [&'static str]) -> LiveParameters {
        self.core.store.declare(names)
    }

    /// A shell refuses what its parameters name, by an error of its own: the process ends as after a refused parameter.
    pub fn refuse(&self) {
        if self.stage.as_ref().is_some_and(Stage::is_question) {
            return;
        }
        lock(&self.core.refused).store(true, Ordering::Relaxed);
    }

    /// Notes refused parameters in `refused` from now on.
    pub(crate) fn remember_refusals(&mut self, refused: Arc<AtomicBool>) {
        *lock(&self.core.refused) = refused;
    }

    /// The parameters in force as text and hash, for the record.
    #[must_use]
    pub fn raw_parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// A timer on the node's clock, first due one period from now.
    #[must_use]
    pub fn timer(&self, period: Seconds) -> Timer {
        self.core.clock.timer(period)
    }

    /// The node's clock.
    #[must_use]
    pub fn clock(&self) -> Clock {
        self.core.clock.clone()
    }

    /// The registry behind `/diagnostics`.
    #[must_use]
    pub fn diagnostics(&self) -> Diagnostics {
        self.core.diagnostics.clone()
    }

    /// The work counter behind the heartbeat.
    #[must_use]
    pub fn work(&self) -> Work {
        self.core.work.clone()
    }

    /// Random id of this run, from its activation to its end.
    #[must_use]
    pub fn session(&self) -> u64 {
        self.session
    }

    /// Namespace and name.
    #[must_use]
    pub fn name(&self) -> String {
        self.core.names.qualified()
    }

    /// Name of a topic or service on the graph, namespace and remapping included.
    #[must_use]
    pub fn resolve(&self, name: &str) -> String {
        self.core.names.resolve(name)
    }

    /// Arguments outside of `--ros-args`.
    #[must_use]
    pub fn rest(&self) -> &[String] {
        &self.core.rest
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

    /// Demands the end of this node.
    pub fn stop(&self) {
        match &self.stage {
            Some(stage) => stage.stop.demand(),
            None => self.core.shutdown_sender.demand(),
        }
    }
}
