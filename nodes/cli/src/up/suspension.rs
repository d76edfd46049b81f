//! Ctrl-Z: a print cannot stand still while its printer goes on. (The nodes do not heed it either.)

use rustix::process::Signal;
use tokio::signal::unix::{Signal as Signals, SignalKind, signal};

/// Hears Ctrl-Z, which so no longer stops the process.
pub(super) struct Suspension(Option<Signals>);

impl Suspension {
    /// Hears it from now on.
    #[must_use]
    pub(super) fn listen() -> Self {
        Self(signal(SignalKind::from_raw(Signal::TSTP.as_raw())).ok())
    }

    /// Waits until a person asks for it; for ever where it cannot be heard.
    pub(super) async fn asked(&mut self) {
        match &mut self.0 {
            Some(signals) => _ = signals.recv().await,
            None => std::future::pending().await,
        }
    }
}
