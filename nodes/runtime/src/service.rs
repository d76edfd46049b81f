//! Services: a server that answers when the shell says so, and a client that never waits for ever.

mod askers;
mod client;

pub use client::{CallError, Client, Patience};

use crate::lifecycle::Gate;
use crate::matches::{Known, Matches, participant_of};
use askers::Askers;
use fdm_loop_msgs::RosService;
use ros2_client::RmwRequestId;
use serde::de::{Deserialize, DeserializeOwned, Deserializer};
use serde::{Serialize, Serializer};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tokio::time::Instant;

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
    matches: Matches,
    /// Name of the answers' topic in DDS.
    answers: String,
    askers: Mutex<Askers<(RmwRequestId, S::Response)>>,
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
    pub(crate) fn new(server: RosServer<S>, gate: Gate, matches: Matches, name: &str) -> Self
    where
        S::Response: Default,
    {
        // Where the middleware does not take it, all else is as without it.
        _ = server.send_response(RmwRequestId::default(), Wire(S::Response::default()));
        let answers = format!("rr{name}Reply");
        Self { server, matches, answers, askers: Mutex::default(), undecodable: 0, gate, fresh: true }
    }

    /// Waits for the next request. What cannot be decoded is counted and skipped. Cancelling loses no request. What was
    /// asked of a node that was not active is not done when it becomes active: it may be long past.
    pub async fn next(&mut self) -> Asked<S> {
        if std::mem::replace(&mut self.fresh, false) && self.gate.was_waited_for() {
            while !matches!(self.server.receive_request(), Ok(None)) {}
        }
        loop {
            let received = tokio::select! {
                received = self.server.async_receive_request() => received,
                () = self.release() => continue,
            };
            match received {
                Ok((id, request)) => return Asked { request: request.0, id },
                Err(_) => self.undecodable += 1,
            }
        }
    }

    /// Answers a request; false where the middleware did not take the answer. To one who has only just joined the answer
    /// goes as soon as the reader is matched, while [`Server::next`] waits.
    pub fn answer(&self, asked: &Asked<S>, response: S::Response) -> bool {
        let (asker, answer) = (name_of(&asked.id), (asked.id, response));
        let at_once = self.askers().take(asker, answer, Instant::now(), |asker| self.hears(asker));
        at_once.is_none_or(|(id, response)| self.server.send_response(id, Wire(response)).is_ok())
    }

    /// Whether an answer would reach its reader.
    fn hears(&self, asker: u64) -> bool {
        self.matches.reader(&self.answers, Some(&asker.to_le_bytes())) == Known::Matched
    }

    fn askers(&self) -> MutexGuard<'_, Askers<(RmwRequestId, S::Response)>> {
        self.askers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until answers that were held may go, and sends them. For ever where none is held.
    async fn release(&self) {
        let mut changes = self.matches.changes();
        let due = self.askers().due(Instant::now(), |asker| self.hears(asker));
        let next = self.askers().next();
        for (id, response) in due {
            // As with any answer: who does not get it asks again.
            _ = self.server.send_response(id, Wire(response));
        }
        match next {
            // Its end is that of the node.
            Some(until) => _ = tokio::time::timeout_at(until, changes.changed()).await,
            None => std::future::pending().await,
        }
    }

    /// Requests that could not be decoded so far.
    #[must_use]
    pub fn undecodable(&self) -> u64 {
        self.undecodable
    }
}

/// An asker's participant, as a number.
fn name_of(asker: &RmwRequestId) -> u64 {
    participant_of(asker.writer_gid.as_bytes()).try_into().map_or(0, u64::from_le_bytes)
}
