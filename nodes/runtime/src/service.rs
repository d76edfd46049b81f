//! Services: a server that answers when the shell says so, and a client that never waits for ever.

use crate::lifecycle::Gate;
use fdm_loop_msgs::RosService;
use futures::FutureExt;
use models::units::Seconds;
use ros2_client::RmwRequestId;
use rustdds::DomainParticipant;
use serde::de::{Deserialize, DeserializeOwned, Deserializer};
use serde::{Serialize, Serializer};
use std::time::Duration;

/// A request or a reply in the client's eyes. (Its trait and our types live in other crates.)
#[derive(Debug, Clone)]
pub(crate) struct Wire<T>(pub(crate) T);

impl<T: Serialize> Serialize for Wire<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Wire<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        T::deserialize(deserializer).map(Self)
    }
}

impl<T: Serialize + DeserializeOwned> ros2_client::Message for Wire<T> {}

type RosServer<S> = ros2_client::Server<Wire<<S as RosService>::Request>, Wire<<S as RosService>::Response>>;
type RosClient<S> = ros2_client::Client<Wire<<S as RosService>::Request>, Wire<<S as RosService>::Response>>;

/// A request to be answered.
#[derive(Debug)]
pub struct Asked<S: RosService> {
    /// What is asked.
    pub request: S::Request,
    id: RmwRequestId,
}

/// The answering end of a service.
pub struct Server<S: RosService> {
    server: RosServer<S>,
    undecodable: u64,
    gate: Gate,
    /// Nothing was taken yet.
    fresh: bool,
}

impl<S: RosService> std::fmt::Debug for Server<S> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Server").field("undecodable", &self.undecodable).finish_non_exhaustive()
    }
}

impl<S: RosService> Server<S> {
    /// Its first answer is nobody's, and is given before any client is known. A reliable reader of Cyclone DDS takes all
    /// that the first heartbeat it hears tells of for what was before its time. Of a writer without a sample that can be
    /// the heartbeat of its first answer, which is lost then; a client acknowledges this one, and has heard a heartbeat.
    pub(crate) fn new(server: RosServer<S>, gate: Gate) -> Self
    where
        S::Response: Default,
    {
        // Where the middleware does not take it, all else is as without it.
        _ = server.send_response(RmwRequestId::default(), Wire(S::Response::default()));
        Self { server, undecodable: 0, gate, fresh: true }
    }

    /// Waits for the next request. What cannot be decoded is counted and skipped. Cancelling loses no request. What was
    /// asked of a node that was not active is not done when it becomes active: it may be long past.
    pub async fn next(&mut self) -> Asked<S> {
        if std::mem::replace(&mut self.fresh, false) && self.gate.was_waited_for() {
            while !matches!(self.server.receive_request(), Ok(None)) {}
        }
        loop {
            match self.server.async_receive_request().await {
                Ok((id, request)) => return Asked { request: request.0, id },
                Err(_) => self.undecodable += 1,
            }
        }
    }

    /// Answers a request; false where the middleware did not take the answer.
    pub fn answer(&self, asked: &Asked<S>, response: S::Response) -> bool {
        self.server.send_response(asked.id, Wire(response)).is_ok()
    }

    /// Requests that could not be decoded so far.
    #[must_use]
    pub fn undecodable(&self) -> u64 {
        self.undecodable
    }
}

/// Why a call has no answer.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CallError {
    /// No server is on the graph.
    #[error("no server for {0}")]
    NoServer(String),
    /// The server did not answer in time. Whether it acted is not known.
    #[error("no answer from {0} in time")]
    TimedOut(String),
    /// The middleware failed.
    #[error("call of {service} failed: {reason}")]
    Failed {
        /// Name of the service.
        service: String,
        /// Why.
        reason: String,
    },
}

/// The asking end of a service.
pub struct Client<S: RosService> {
    client: RosClient<S>,
    participant: DomainParticipant,
    name: String,
}

impl<S: RosService> std::fmt::Debug for Client<S> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Client").field("name", &self.name).finish_non_exhaustive()
    }
}

/// Pause between two looks for a server.
const LOOK: Duration = Duration::from_millis(20);
/// A server that was just discovered needs this long until both ends are matched: requests sent before are lost.
const MATCHING: Duration = Duration::from_millis(100);

impl<S: RosService> Client<S>
where
    S::Request: Clone,
{
    pub(crate) fn new(client: RosClient<S>, participant: DomainParticipant, name: String) -> Self {
        Self { client, participant, name }
    }

    /// Waits for a server, asks, and waits for the answer, all within `timeout` of real time.
    ///
    /// # Errors
    /// [`CallError`]; after [`CallError::TimedOut`] the server may have acted all the same.
    pub async fn call(&self, request: S::Request, timeout: Seconds) -> Result<S::Response, CallError> {
        let limit = Duration::from_secs_f64(timeout.0.clamp(0.0, 3600.0));
        let deadline = tokio::time::Instant::now() + limit;
        tokio::time::timeout_at(deadline, self.wait_for_server())
            .await
            .map_err(|_| CallError::NoServer(self.name.clone()))?;
        tokio::time::timeout_at(deadline, self.ask(request))
            .await
            .map_err(|_| CallError::TimedOut(self.name.clone()))?
    }

    /// Sends and receives. Replies to other clients pass on the same topic and are skipped by the client.
    async fn ask(&self, request: S::Request) -> Result<S::Response, CallError> {
        let failed = |reason: String| CallError::Failed { service: self.name.clone(), reason };
        let id = self.client.send_request(Wire(request)).map_err(|error| failed(error.to_string()))?;
        let reply = self.client.async_receive_response(id).map(|reply| reply.map(|wire| wire.0));
        reply.await.map_err(|error| failed(error.to_string()))
    }

    /// Waits until both ends of a server are discovered.
    async fn wait_for_server(&self) {
        if self.server_known() {
            return;
        }
        while !self.server_known() {
            tokio::time::sleep(LOOK).await;
        }
        tokio::time::sleep(MATCHING).await;
    }

    /// Whether somebody reads the requests and somebody writes the replies.
    fn server_known(&self) -> bool {
        let request = format!("rq{}Request", self.name);
        let reply = format!("rr{}Reply", self.name);
        let readers = self.participant.discovered_readers();
        let writers = self.participant.discovered_writers();
        readers.iter().any(|reader| *reader.subscription_topic_data.topic_name() == request)
            && writers.iter().any(|writer| writer.publication_topic_data.topic_name == reply)
    }
}
