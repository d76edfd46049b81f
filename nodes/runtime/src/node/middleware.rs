//! What a node does about the middleware that it stands on.

use super::lock;
use crate::bounds;
use crate::error::RuntimeError;
use crate::participants::Participants;
use crate::self_loop::{Making, SelfLoop};
use crate::shutdown::{self, ShutdownSender};
use std::hash::{BuildHasher, Hasher};
use std::sync::{Arc, Mutex};

/// Two ways to call the same, once.
pub(super) fn once<F: FnOnce() + Send + 'static>(
    call: F,
) -> (impl FnOnce() + Send + 'static, impl FnOnce() + Send + 'static) {
    let shared = Arc::new(Mutex::new(Some(call)));
    let way = |shared: Arc<Mutex<Option<F>>>| {
        move || {
            let call = lock(&shared).take();
            call.into_iter().for_each(|call| call());
        }
    };
    (way(Arc::clone(&shared)), way(shared))
}

/// A random number that tells one run of a node from the next.
pub(super) fn random_session() -> u64 {
    // The standard library seeds its hash maps from the operating system's random source.
    std::collections::hash_map::RandomState::new().build_hasher().finish()
}

/// Watches over this process's middleware: what happens where it is deaf is told, and where it is overcrowded the process
/// leaves the graph.
pub(super) fn watch_middleware(
    (participants, making): (Participants, Making),
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
            // What is crowded may hang while it takes leave of the crowd, and nobody else would end it.
            shutdown::end_where_it_hangs(bounds::end_deaf);
        }
    };
    SelfLoop::start(participants, making, session, on_silence, on_crowd)
}
