//! Endpoints of a node: topics and services.

use super::{Node, lock};
use crate::clock::ClockDriver;
use crate::error::RuntimeError;
use crate::publisher::Publisher;
use crate::qos;
use crate::raw::{Bytes, PassThrough, RawNames, RawSubscription};
use crate::raw_publisher::Serialized;
use crate::self_loop::Begun;
use crate::service::{Client, Server};
use crate::stats::TopicStats;
use crate::subscription::Subscription;
use crate::topics::{self, Service, Topic, TopicInfo};
use fdm_loop_msgs::{RosService, RosType};
use ros2_client::{MessageTypeName, ServiceTypeName};
use rustdds::{QosPolicies, TopicKind};
use std::sync::{Arc, MutexGuard};

impl Node {
    /// Listens to a topic.
    ///
    /// # Errors
    /// [`RuntimeError::Create`] or [`RuntimeError::Name`]
    pub fn subscribe<T: RosType>(&mut self, topic: &Topic<T>) -> Result<Subscription<T>, RuntimeError> {
        let subscription = self.listen(topic)?;
        self.core.diagnostics.watch(subscription.stats());
        Ok(subscription)
    }

    /// Listens to a topic that is none of the shell's: its figures are not shown.
    pub(crate) fn listen<T: RosType>(&self, topic: &Topic<T>) -> Result<Subscription<T>, RuntimeError> {
        let name = self.core.names.resolve(topic.name());
        let profile = topic.qos().requested.profile();
        let failed =
            |error: ros2_client::CreateError| RuntimeError::create(format!("subscription {name}"), &error);
        let ros_topic = self.create_topic(&name, &topic.info(), &profile)?;
        let (_begun, mut ros) = self.ros();
        let reader = ros.create_subscription(&ros_topic, Some(profile)).map_err(failed)?;
        let stats = Arc::new(TopicStats::subscriber(&name));
        Ok(Subscription::new(reader, self.core.clock.clone(), stats, self.gate.clone()))
    }

    /// Publishes on a topic.
    ///
    /// # Errors
    /// [`RuntimeError::Create`] or [`RuntimeError::Name`]
    pub fn publish_on<T: RosType>(&mut self, topic: &Topic<T>) -> Result<Publisher<T>, RuntimeError> {
        let name = self.core.names.resolve(topic.name());
        let profile = topic.qos().offered.profile();
        let failed =
            |error: ros2_client::CreateError| RuntimeError::create(format!("publisher {name}"), &error);
        let ros_topic = self.create_topic(&name, &topic.info(), &profile)?;
        let (_begun, mut ros) = self.ros();
        let writer = ros.create_publisher(&ros_topic, Some(profile)).map_err(failed)?;
        let stats = Arc::new(TopicStats::publisher(&name));
        self.core.diagnostics.watch(Arc::clone(&stats));
        Ok(Publisher::new(writer, stats, self.gate.clone()))
    }

    /// Listens to a topic without decoding it. (It does not show in `ros2 node info`: the client cannot announce it.)
    ///
    /// # Errors
    /// [`RuntimeError::Create`] or [`RuntimeError::Name`]
    pub fn subscribe_raw(&mut self, topic: &TopicInfo) -> Result<RawSubscription, RuntimeError> {
        let name = self.core.names.resolve(topic.name);
        self.core.names.check(&name)?;
        let failed =
            |error: rustdds::dds::CreateError| RuntimeError::create(format!("subscription {name}"), &error);
        let qos = QosPolicies::from(topic.qos.requested.profile());
        let _begun = self.core.making.begin();
        let participant = self.core.context.domain_participant();
        let type_name = MessageTypeName::new(topic.definition.package, topic.definition.name);
        let dds_topic = participant
            .create_topic(format!("rt{name}"), type_name.dds_msg_type(), &qos, TopicKind::NoKey)
            .map_err(failed)?;
        let subscriber = participant.create_subscriber(&qos).map_err(failed)?;
        let reader = subscriber
            .create_simple_datareader_no_key::<Bytes, PassThrough>(&dds_topic, Some(qos))
            .map_err(failed)?;
        let stats = Arc::new(TopicStats::subscriber(&name));
        self.core.diagnostics.watch(Arc::clone(&stats));
        let latched = topic.qos.requested.durability == qos::Durability::TransientLocal;
        let names = RawNames { topic: name, type_name: topic.definition.full_name(), latched };
        Ok(RawSubscription::new(reader, names, self.core.clock.clone(), stats, self.gate.clone()))
    }

    /// A writer of bytes, with the name on the graph and the type as they are given.
    pub(crate) fn raw_writer(
        &self,
        topic: &str,
        type_name: &str,
        offered: qos::End,
    ) -> Result<rustdds::no_key::DataWriter<Serialized>, RuntimeError> {
        let name = self.core.names.resolve(topic);
        self.core.names.check(&name)?;
        let failed =
            |error: rustdds::dds::CreateError| RuntimeError::create(format!("publisher {name}"), &error);
        let qos = QosPolicies::from(offered.profile());
        let (package, message) = type_name.split_once("/msg/").unwrap_or(("", type_name));
        let type_name = MessageTypeName::new(package, message).dds_msg_type();
        let _begun = self.core.making.begin();
        let participant = self.core.context.domain_participant();
        let dds_topic = participant
            .create_topic(format!("rt{name}"), type_name, &qos, TopicKind::NoKey)
            .map_err(failed)?;
        let publisher = participant.create_publisher(&qos).map_err(failed)?;
        publisher.create_datawriter_no_key_cdr::<Serialized>(&dds_topic, Some(qos)).map_err(failed)
    }

    /// Offers a service.
    ///
    /// # Errors
    /// [`RuntimeError::Create`] or [`RuntimeError::Name`]
    pub fn serve<S>(&mut self, service: &Service<S>) -> Result<Server<S>, RuntimeError>
    where
        S: RosService<Request: Clone, Response: Default>,
    {
        let name = self.core.names.resolve(service.name());
        let ros_name = self.core.names.check(&name)?;
        let profile = qos::SERVICE.profile();
        let (_begun, mut ros) = self.ros();
        let server = ros.create_server(
            self.core.services.mapping(),
            &ros_name,
            &ServiceTypeName::new(S::PACKAGE, S::NAME),
            profile.clone(),
            profile,
        );
        let gate = self.gate.clone();
        server
            .map(|server| Server::new(server, gate, self.core.matches.clone(), &name))
            .map_err(|error| RuntimeError::create(format!("service {name}"), &error))
    }

    /// Prepares calls of a service.
    ///
    /// # Errors
    /// [`RuntimeError::Create`] or [`RuntimeError::Name`]
    pub fn client<S>(&mut self, service: &Service<S>) -> Result<Client<S>, RuntimeError>
    where
        S: RosService<Request: Clone>,
    {
        let name = self.core.names.resolve(service.name());
        self.client_named(name)
    }

    /// Prepares calls of a private service (`~/...`) of another node, given with its namespace.
    ///
    /// # Errors
    /// [`RuntimeError::Create`] or [`RuntimeError::Name`]
    pub fn client_of<S>(&mut self, node: &str, service: &Service<S>) -> Result<Client<S>, RuntimeError>
    where
        S: RosService<Request: Clone>,
    {
        self.client_at(node, service)
    }

    pub(crate) fn client_at<S>(&self, node: &str, service: &Service<S>) -> Result<Client<S>, RuntimeError>
    where
        S: RosService<Request: Clone>,
    {
        self.client_named(format!("{node}/{}", service.name().trim_start_matches("~/")))
    }

    fn client_named<S>(&self, name: String) -> Result<Client<S>, RuntimeError>
    where
        S: RosService<Request: Clone>,
    {
        let ros_name = self.core.names.check(&name)?;
        let profile = qos::SERVICE.profile();
        let (_begun, mut ros) = self.ros();
        let client = ros.create_client(
            self.core.services.mapping(),
            &ros_name,
            &ServiceTypeName::new(S::PACKAGE, S::NAME),
            profile.clone(),
            profile,
        );
        let client = client.map_err(|error| RuntimeError::create(format!("client of {name}"), &error))?;
        Ok(Client::new(client, self.core.matches.clone(), name))
    }

    /// Takes `/clock` over: the simulated printer owns it. Under `use_sim_time` the node's own clock follows the driver
    /// from now on, not the topic (on a `lo` without multicast a process does not hear itself).
    ///
    /// # Errors
    /// [`RuntimeError::Create`]
    pub fn drive_clock(&mut self) -> Result<ClockDriver, RuntimeError> {
        if let Some(following) = lock(&self.core.clock_task).take() {
            following.abort();
        }
        let publisher = self.publish_on(&topics::CLOCK)?;
        Ok(ClockDriver::new(self.core.clock.clone(), publisher))
    }

    /// The client, to make an endpoint with: the watchdog looks how long that takes.
    fn ros(&self) -> (Begun<'_>, MutexGuard<'_, ros2_client::Node>) {
        (self.core.making.begin(), lock(&self.core.ros))
    }

    /// The client's topic.
    fn create_topic(
        &self,
        name: &str,
        info: &TopicInfo,
        profile: &ros2_client::QosProfile,
    ) -> Result<rustdds::Topic, RuntimeError> {
        let ros_name = self.core.names.check(name)?;
        let type_name = MessageTypeName::new(info.definition.package, info.definition.name);
        let (_begun, ros) = self.ros();
        ros.create_topic(&ros_name, type_name, profile)
            .map_err(|error| RuntimeError::create(format!("topic {name}"), &error))
    }
}
