//! The asking end of a service.

use super::{RosClient, Wire};
use crate::matches::{Known, Matches};
use fdm_loop_msgs::RosService;
use futures::FutureExt;
use models::units::Seconds;
use ros2_client::RmwRequestId;
use std::time::Duration;
use tokio::time::{Instant, sleep, timeout_at};

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

/// How long to insist.
#[derive(Debug, Clone, Copy)]
pub struct Patience {
    /// Longest wait for a server to be there.
    pub found: Seconds,
    /// Wait for an answer until the request is sent again.
    pub again: Seconds,
    /// Longest wait for an answer, that for the server included.
    pub answered: Seconds,
}

/// The asking end of a service.
pub struct Client<S: RosService> {
    client: RosClient<S>,
    matches: Matches,
    name: String,
}

impl<S: RosService> std::fmt::Debug for Client<S> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Client").field("name", &self.name).finish_non_exhaustive()
    }
}

/// Pause between two looks for a server that is not there, for one whose announcement is no change of a match.
const LOOK: Duration = Duration::from_millis(20);
/// A server that is known and not matched with this long is asked all the same: a match may have gone untold.
const MATCHING: Duration = Duration::from_millis(500);
/// Pause between two looks for an answer to any of several requests.
const LISTEN: Duration = Duration::from_millis(5);

impl<S: RosService> Client<S>
where
    S::Request: Clone,
{
    pub(crate) fn new(client: RosClient<S>, matches: Matches, name: String) -> Self {
        Self { client, matches, name }
    }

    /// Waits for a server, asks, and waits for the answer, all within `timeout` of real time.
    ///
    /// # Errors
    /// [`CallError`]; after [`CallError::TimedOut`] the server may have acted all the same.
    pub async fn call(&self, request: S::Request, timeout: Seconds) -> Result<S::Response, CallError> {
        let deadline = Instant::now() + limit(timeout);
        timeout_at(deadline, self.wait_for_server())
            .await
            .map_err(|_| CallError::NoServer(self.name.clone()))?;
        timeout_at(deadline, self.ask(request)).await.map_err(|_| CallError::TimedOut(self.name.clone()))?
    }

    /// Waits for a server and asks until there is an answer, to whichever of the requests; and how often it was asked. For
    /// requests that may be granted twice.
    pub async fn insist(
        &self,
        request: S::Request,
        patience: Patience,
    ) -> (Result<S::Response, CallError>, usize) {
        let started = Instant::now();
        if timeout_at(started + limit(patience.found), self.wait_for_server()).await.is_err() {
            return (Err(CallError::NoServer(self.name.clone())), 0);
        }
        let deadline = started + limit(patience.answered);
        let mut asked = Vec::new();
        while asked.is_empty() || Instant::now() < deadline {
            match self.client.send_request(Wire(request.clone())) {
                Ok(id) => asked.push(id),
                Err(error) => return (Err(self.failed(&error)), asked.len()),
            }
            let again = deadline.min(Instant::now() + limit(patience.again));
            if let Ok(answer) = timeout_at(again, self.answer_to(&asked)).await {
                return (answer, asked.len());
            }
        }
        (Err(CallError::TimedOut(self.name.clone())), asked.len())
    }

    /// Sends and receives. Replies to other clients pass on the same topic and are skipped by the client.
    async fn ask(&self, request: S::Request) -> Result<S::Response, CallError> {
        let id = self.client.send_request(Wire(request)).map_err(|error| self.failed(&error))?;
        let reply = self.client.async_receive_response(id).map(|reply| reply.map(|wire| wire.0));
        reply.await.map_err(|error| self.failed(&error))
    }

    /// The answer to one of several requests. (The client's own wait is for one and drops all others.)
    async fn answer_to(&self, asked: &[RmwRequestId]) -> Result<S::Response, CallError> {
        loop {
            while let Some((id, reply)) =
                self.client.receive_response().map_err(|error| self.failed(&error))?
            {
                if asked.contains(&id) {
                    return Ok(reply.0);
                }
            }
            sleep(LISTEN).await;
        }
    }

    fn failed(&self, error: &impl std::fmt::Display) -> CallError {
        CallError::Failed { service: self.name.clone(), reason: error.to_string() }
    }

    /// Waits until this end is matched with both ends of a server: one that reads the requests, and one that writes the
    /// answers. What is sent from then on the server's reader gets, if need be when it has matched this end as well; its
    /// answer waits for that on its side.
    async fn wait_for_server(&self) {
        let mut changes = self.matches.changes();
        let mut since = None;
        loop {
            match self.server_known() {
                Known::Matched => return,
                Known::Discovered if since.is_some_and(|since: Instant| since.elapsed() >= MATCHING) => {
                    return self.matches.assume(&self.request_topic(), &self.reply_topic());
                }
                Known::Discovered => _ = since.get_or_insert_with(Instant::now),
                Known::No => since = None,
            }
            _ = tokio::time::timeout(LOOK, changes.changed()).await;
        }
    }

    /// How far somebody who reads the requests and somebody who writes the answers are known.
    fn server_known(&self) -> Known {
        let requests = self.matches.reader(&self.request_topic(), None);
        requests.min(self.matches.writer(&self.reply_topic()))
    }

    fn request_topic(&self) -> String {
        format!("rq{}Request", self.name)
    }

    fn reply_topic(&self) -> String {
        format!("rr{}Reply", self.name)
    }
}

fn limit(of: Seconds) -> Duration {
    Duration::from_secs_f64(of.0.clamp(0.0, 3600.0))
}
