//! Orderly end on SIGINT, SIGTERM, SIGHUP and, where asked for, with the parent process; an end at once after SIGSTOP and SIGCONT.

use crate::error::RuntimeError;
use crate::logging;
use rustix::process::Signal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};
use std::time::Duration;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::watch;

/// Time the shell and the middleware have to end before the process is ended: the promise is 2 s.
const GRACE: Duration = Duration::from_millis(1700);

/// What is sent with a SIGCONT to make a stopped process end in order arrives within this time.
const TOGETHER: Duration = Duration::from_millis(50);

/// A demand to stop; clones see the same.
#[derive(Debug, Clone)]
pub struct Shutdown {
    demanded: watch::Receiver<bool>,
}

/// The demanding end.
#[derive(Debug, Clone)]
pub(crate) struct ShutdownSender(watch::Sender<bool>);

impl ShutdownSender {
    /// Demands an orderly end.
    pub(crate) fn demand(&self) {
        self.0.send_replace(true);
    }
}

impl Shutdown {
    /// A pair of demand and its sender.
    pub(crate) fn channel() -> (ShutdownSender, Self) {
        let (sender, demanded) = watch::channel(false);
        (ShutdownSender(sender), Self { demanded })
    }

    /// Waits for the demand.
    pub async fn wait(&mut self) {
        // A sender that is gone means that the node is gone: that is an end too.
        _ = self.demanded.wait_for(|demanded| *demanded).await;
    }

    /// Whether the end was demanded.
    #[must_use]
    pub fn is_demanded(&self) -> bool {
        *self.demanded.borrow()
    }
}

/// Set in the environment of a process that must not outlive the one that started it, to that one's process id.
pub const STOP_WITH_PARENT: &str = "FDM_STOP_WITH_PARENT";

/// How often a process that must not outlive its parent looks for it.
const LOOK: Duration = Duration::from_millis(200);

/// Waits until the parent has died; for ever where [`STOP_WITH_PARENT`] is not set.
fn orphaned() -> impl Future<Output = ()> {
    // The id is told, not asked for: the parent may be dead before this line.
    let told = std::env::var(STOP_WITH_PARENT).ok();
    let parent = told.and_then(|pid| rustix::process::Pid::from_raw(pid.parse().ok()?));
    async move {
        if parent.is_none() {
            return std::future::pending().await;
        }
        while rustix::process::getppid() == parent {
            tokio::time::sleep(LOOK).await;
        }
    }
}

/// Whether an end that somebody demands now needs no more than the end of the process.
static STARTING: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// From here on until [`follow_signals`] a SIGINT, SIGTERM or SIGHUP ends the process at once, and well: nothing is open
/// yet that had to be closed.
pub(crate) fn end_while_starting() -> Result<(), RuntimeError> {
    let system = |source| RuntimeError::System { what: "cannot listen to signals", source };
    STARTING.store(true, Ordering::Relaxed);
    for signal in [Signal::INT, Signal::TERM, Signal::HUP] {
        signal_hook::flag::register_conditional_shutdown(signal.as_raw(), 0, Arc::clone(&STARTING))
            .map_err(system)?;
    }
    Ok(())
}

/// Turns SIGINT, SIGTERM and SIGHUP into a demand, and ends the process where the shell does not follow it in time.
pub(crate) fn follow_signals(sender: ShutdownSender) -> Result<(), RuntimeError> {
    let system = |source| RuntimeError::System { what: "cannot listen to signals", source };
    let mut interrupt = signal(SignalKind::interrupt()).map_err(system)?;
    let mut terminate = signal(SignalKind::terminate()).map_err(system)?;
    let mut hang_up = signal(SignalKind::hangup()).map_err(system)?;
    STARTING.store(false, Ordering::Relaxed);
    let orphaned = orphaned();
    tokio::spawn(async move {
        tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
            // The terminal was closed.
            _ = hang_up.recv() => {}
            () = orphaned => tracing::warn!("who started this process has died: ending"),
        }
        sender.demand();
        end_where_it_hangs(|| {
            logging::write_last_lines();
            std::process::exit(1)
        });
    });
    Ok(())
}

/// Gives the process the time for an orderly end that was demanded, and ends it by `end` where that does not come.
pub(crate) fn end_where_it_hangs(end: fn() -> !) {
    // A thread of its own: the executor may be what hangs. It never outlives the process.
    std::thread::spawn(move || {
        std::thread::sleep(GRACE);
        tracing::error!("not ended {} s after it was demanded: ending the process", GRACE.as_secs_f64());
        end()
    });
}

/// Set by the signal's own handler, before the executor knows: what a stopped process believed is past.
static CONTINUED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// Waits for ever in a process that was stopped and goes on: it is about to be ended, and judges by what is long past.
pub(crate) async fn unless_continued() {
    while CONTINUED.load(Ordering::Relaxed) {
        tokio::time::sleep(TOGETHER).await;
    }
}

/// Tells once where the process goes on after a stop. The interrupted poll has ended event loops of RustDDS 0.15.1, now
/// and then those of discovery alone: the self loop still turns, while the others forget the node half a minute later.
/// Who started the process starts it again; who is started by nobody takes a new node. (SIGCONT follows a SIGTERM too, to wake who is stopped: that end is orderly.)
pub(crate) fn when_continued(
    shutdown: Shutdown,
    on_continued: impl FnOnce() + Send + 'static,
) -> Result<(), RuntimeError> {
    let system = |source| RuntimeError::System { what: "cannot listen to signals", source };
    let mut continued = signal(SignalKind::from_raw(Signal::CONT.as_raw())).map_err(system)?;
    signal_hook::flag::register(Signal::CONT.as_raw(), Arc::clone(&CONTINUED)).map_err(system)?;
    // A terminal's Ctrl-Z reaches the whole graph; taken, it stops nobody, and nobody has to be started again.
    signal_hook::flag::register(Signal::TSTP.as_raw(), Arc::default()).map_err(system)?;
    tokio::spawn(async move {
        while continued.recv().await.is_some() {
            tokio::time::sleep(TOGETHER).await;
            CONTINUED.store(false, Ordering::Relaxed);
            if !shutdown.is_demanded() {
                return on_continued();
            }
        }
    });
    Ok(())
}
