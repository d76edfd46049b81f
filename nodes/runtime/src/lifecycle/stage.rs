//! Between a shell and who drives it: ready, go, stop.

use crate::shutdown::{Shutdown, ShutdownSender};
use std::sync::Arc;
use tokio::sync::Notify;

/// One configuration of a shell, from `configure` to its end; clones are one.
#[derive(Debug, Clone)]
pub(crate) struct Stage {
    ready: Arc<Notify>,
    go: Arc<Notify>,
    pub(crate) stop: ShutdownSender,
    pub(crate) stopped: Shutdown,
    question: bool,
}

impl Stage {
    pub(crate) fn new() -> Self {
        let (stop, stopped) = Shutdown::channel();
        Self { ready: Arc::default(), go: Arc::default(), stop, stopped, question: false }
    }

    /// For a shell that only says how it checks its parameters.
    pub(crate) fn question() -> Self {
        Self { question: true, ..Self::new() }
    }

    /// Whether the shell is not to go on.
    pub(crate) fn is_question(&self) -> bool {
        self.question
    }

    /// The shell: everything is loaded and open. Waits for the leave to work.
    pub(crate) async fn activated(&self) {
        self.ready.notify_one();
        self.go.notified().await;
    }

    /// The driver: waits until the shell is ready.
    pub(crate) async fn ready(&self) {
        self.ready.notified().await;
    }

    /// The driver: gives the leave to work.
    pub(crate) fn go(&self) {
        self.go.notify_one();
    }
}
