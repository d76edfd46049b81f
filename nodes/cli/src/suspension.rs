//! Ctrl-Z: what a terminal's SIGTSTP means is a command's own affair. (A node does not heed it: its printer goes on.)

use rustix::process::{Signal, getpid, kill_process};
use tokio::signal::unix::{Signal as Signals, SignalKind, signal};

/// Hears Ctrl-Z, which so no longer stops the process.
pub(crate) struct Suspension(Option<Signals>);

impl Suspension {
    /// Hears it from now on.
    #[must_use]
    pub(crate) fn listen() -> Self {
        Self(signal(SignalKind::from_raw(Signal::TSTP.as_raw())).ok())
    }

    /// Waits until a person asks for it; for ever where it cannot be heard.
    pub(crate) async fn asked(&mut self) {
        match &mut self.0 {
            Some(signals) => _ = signals.recv().await,
            None => std::future::pending().await,
        }
    }

    /// Stops this process until somebody lets it go on, as the shell's `fg` does.
    ///
    /// # Errors
    /// What the system says.
    pub(crate) fn stand_still() -> std::io::Result<()> {
        Ok(kill_process(getpid(), Signal::STOP)?)
    }
}
