//! A node: name, parameters, clock, endpoints, diagnostics, heartbeat, self loop.
//!
//! Lifecycle (five services, `transition_event`, gated publishers) and the six parameter services are not here yet;
//! they will be started by [`Node::start`] beside the heartbeat.

use crate::args::Args;
use crate::clock::{Clock, Timer};
use crate::diagnostics::Diagnostics;
use crate::environment::{Environment, Services};
use crate::error::RuntimeError;
use crate::heartbeat::{self, Heart, Work};
use crate::names::Names;
use crate::params::{NodePath, Parameters};
use crate::participants::Participants;
use crate::publisher::Publisher;
use crate::qos;
use crate::raw::{Bytes, PassThrough, RawNames, RawSubscription};
use crate::self_loop::SelfLoop;
use crate::service::{Client, Server};
use crate::shutdown::{self, Shutdown, ShutdownSender};
use crate::stats::TopicStats;
use crate::subscription::Subscription;
use crate::topics::{self, Service, Topic, TopicInfo};
use crate::{background, logging};
use fdm_loop_msgs::{RosService, RosType};
use models::units::Seconds;
use ros2_client::{Context, MessageTypeName, NodeOptions, ServiceTypeName};
use rustdds::{QosPolicies, TopicKind};
use serde::de::DeserializeOwned;
use std::hash::{BuildHasher, Hasher};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use tokio::task::JoinSet;

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
        logging::start(&args);
        let environment = Environment::from_env()?;
        let names = Names::new(name, &args)?;
        let path = NodePath { qualified: names.qualified(), base: names.base().to_owned() };
        let parameters = Parameters::read(&args.params_files, &args.parameters, &path)?;
        let clock = if parameters.use_sim_time() { Clock::simulated() } else { Clock::monotonic() };

        let participants = Participants::join(&environment)?;
        let participant = participants.own.clone();
        let session = random_session();
        let self_loop = SelfLoop::start(participants, session, || {
            tracing::error!(
                "own messages do not come back through DDS: ending the process to be started again"
            );
            std::process::abort();
        })?;
        let context = Context::from_domain_participant(participant)
            .map_err(|error| RuntimeError::create("context", &error))?;
        let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
        let ros = context
            .new_node(names.node().clone(), options)
            .map_err(|error| RuntimeError::create(format!("node {}", path.qualified), &error))?;
        let (shutdown_sender, shutdown) = Shutdown::channel();
        shutdown::follow_signals(shutdown_sender.clone())?;
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
        };
        node.start_background()?;
        Ok(node)
    }

    /// Starts `/clock`, `/rosout`, `/diagnostics` and the heartbeat.
    fn start_background(&mut self) -> Result<(), RuntimeError> {
        if self.clock.is_simulated() {
            let readings = self.subscribe(&topics::CLOCK)?;
            self.tasks.spawn(background::follow_clock(
                self.clock.clone(),
                readings,
                self.diagnostics.clone(),
            ));
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
        Ok(())
    }

    /// Parses the parameters into the node's checked struct.
    ///
    /// # Errors
    /// [`RuntimeError::Parameters`] with file, line, field, value and range.
    pub fn parameters<T: DeserializeOwned>(&self) -> Result<T, RuntimeError> {
        self.parameters.parse().map_err(|error| {
            self.refused.store(true, Ordering::Relaxed);
            RuntimeError::Parameters(error)
        })
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

    /// Listens to a topic.
    ///
    /// # Errors
    /// [`RuntimeError::Create`] or [`RuntimeError::Name`]
    pub fn subscribe<T: RosType>(&mut self, topic: &Topic<T>) -> Result<Subscription<T>, RuntimeError> {
        let name = self.names.resolve(topic.name());
        let profile = topic.qos().requested.profile();
        let failed =
            |error: ros2_client::CreateError| RuntimeError::create(format!("subscription {name}"), &error);
        let ros_topic = self.create_topic(&name, &topic.info(), &profile)?;
        let reader = self.ros.create_subscription(&ros_topic, Some(profile)).map_err(failed)?;
        let stats = Arc::new(TopicStats::subscriber(&name));
        self.diagnostics.watch(Arc::clone(&stats));
        Ok(Subscription::new(reader, self.clock.clone(), stats))
    }

    /// Publishes on a topic.
    ///
    /// # Errors
    /// [`RuntimeError::Create`] or [`RuntimeError::Name`]
    pub fn publish_on<T: RosType>(&mut self, topic: &Topic<T>) -> Result<Publisher<T>, RuntimeError> {
        let name = self.names.resolve(topic.name());
        let profile = topic.qos().offered.profile();
        let failed =
            |error: ros2_client::CreateError| RuntimeError::create(format!("publisher {name}"), &error);
        let ros_topic = self.create_topic(&name, &topic.info(), &profile)?;
        let writer = self.ros.create_publisher(&ros_topic, Some(profile)).map_err(failed)?;
        let stats = Arc::new(TopicStats::publisher(&name));
        self.diagnostics.watch(Arc::clone(&stats));
        Ok(Publisher::new(writer, stats))
    }

    /// Listens to a topic without decoding it. (It does not show in `ros2 node info`: the client cannot announce it.)
    ///
    /// # Errors
    /// [`RuntimeError::Create`] or [`RuntimeError::Name`]
    pub fn subscribe_raw(&mut self, topic: &TopicInfo) -> Result<RawSubscription, RuntimeError> {
        let name = self.names.resolve(topic.name);
        self.names.check(&name)?;
        let failed =
            |error: rustdds::dds::CreateError| RuntimeError::create(format!("subscription {name}"), &error);
        let qos = QosPolicies::from(topic.qos.requested.profile());
        let participant = self.context.domain_participant();
        let type_name = MessageTypeName::new(topic.definition.package, topic.definition.name);
        let dds_topic = participant
            .create_topic(format!("rt{name}"), type_name.dds_msg_type(), &qos, TopicKind::NoKey)
            .map_err(failed)?;
        let subscriber = participant.create_subscriber(&qos).map_err(failed)?;
        let reader = subscriber
            .create_simple_datareader_no_key::<Bytes, PassThrough>(&dds_topic, Some(qos))
            .map_err(failed)?;
        let stats = Arc::new(TopicStats::subscriber(&name));
        self.diagnostics.watch(Arc::clone(&stats));
        let names = RawNames { topic: name, type_name: topic.definition.full_name() };
        Ok(RawSubscription::new(reader, names, self.clock.clone(), stats))
    }

    /// Offers a service.
    ///
    /// # Errors
    /// [`RuntimeError::Create`] or [`RuntimeError::Name`]
    pub fn serve<S>(&mut self, service: &Service<S>) -> Result<Server<S>, RuntimeError>
    where
        S: RosService<Request: Clone>,
    {
        let name = self.names.resolve(service.name());
        let ros_name = self.names.check(&name)?;
        let profile = qos::SERVICE.profile();
        let server = self.ros.create_server(
            self.services.mapping(),
            &ros_name,
            &ServiceTypeName::new(S::PACKAGE, S::NAME),
            profile.clone(),
            profile,
        );
        server.map(Server::new).map_err(|error| RuntimeError::create(format!("service {name}"), &error))
    }

    /// Prepares calls of a service.
    ///
    /// # Errors
    /// [`RuntimeError::Create`] or [`RuntimeError::Name`]
    pub fn client<S>(&mut self, service: &Service<S>) -> Result<Client<S>, RuntimeError>
    where
        S: RosService<Request: Clone>,
    {
        let name = self.names.resolve(service.name());
        let ros_name = self.names.check(&name)?;
        let profile = qos::SERVICE.profile();
        let client = self.ros.create_client(
            self.services.mapping(),
            &ros_name,
            &ServiceTypeName::new(S::PACKAGE, S::NAME),
            profile.clone(),
            profile,
        );
        let client = client.map_err(|error| RuntimeError::create(format!("client of {name}"), &error))?;
        Ok(Client::new(client, self.context.domain_participant(), name))
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

    /// The client's topic.
    fn create_topic(
        &self,
        name: &str,
        info: &TopicInfo,
        profile: &ros2_client::QosProfile,
    ) -> Result<rustdds::Topic, RuntimeError> {
        let ros_name = self.names.check(name)?;
        let type_name = MessageTypeName::new(info.definition.package, info.definition.name);
        self.ros
            .create_topic(&ros_name, type_name, profile)
            .map_err(|error| RuntimeError::create(format!("topic {name}"), &error))
    }
}
