//! Drivers beside the node's executor: a thread for what waits in calls of OpenCV or for files, a task for HTTP.

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use models::units::Seconds;
use runtime::{Node, RuntimeError};
use tokio::sync::mpsc;

use super::driver::DriverEvent;
use super::mjpeg::Mjpeg;

/// Events that may wait: a frame is worth less than the one after it.
const WAITING: usize = 2;
/// Longest wait for a thread to end `[s]`: what hangs in a device is left to the end of the process.
const PATIENCE_S: f64 = 0.5;

/// Who says when the next frame comes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pace {
    /// Whoever takes frames: the driver waits.
    Demand,
    /// The driver: a frame that finds no room is dropped, counted as `driver_dropped`.
    Own,
}

/// A driver in a thread of its own.
#[derive(Debug)]
pub(crate) struct Worker {
    events: mpsc::Receiver<(Seconds, DriverEvent)>,
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    pub(crate) fn spawn(
        node: &Node,
        pace: Pace,
        mut next: impl FnMut() -> DriverEvent + Send + 'static,
    ) -> Result<Self, RuntimeError> {
        let (clock, diagnostics) = (node.clock(), node.diagnostics());
        let (sender, events) = mpsc::channel(WAITING);
        let (stop, stopped) = channel::<()>();
        let work = move || loop {
            let event = next();
            let pause_s = match &event {
                DriverEvent::Lost { retry_s, .. } => *retry_s,
                _ => 0.0,
            };
            let ended = event == DriverEvent::Ended;
            let dated = (clock.now(), event);
            let open = match (pace, &dated.1) {
                (Pace::Own, DriverEvent::Frame(_)) => match sender.try_send(dated) {
                    Err(mpsc::error::TrySendError::Full(_)) => {
                        diagnostics.count("driver_dropped");
                        true
                    }
                    sent => sent.is_ok(),
                },
                _ => sender.blocking_send(dated).is_ok(),
            };
            let waited = stopped.recv_timeout(Duration::from_secs_f64(pause_s));
            if ended || !open || waited != Err(RecvTimeoutError::Timeout) {
                return;
            }
        };
        let thread = std::thread::Builder::new()
            .name("camera".into())
            .spawn(work)
            .map_err(|source| RuntimeError::System { what: "cannot start the camera's reader", source })?;
        Ok(Self { events, stop: Some(stop), thread: Some(thread) })
    }

    /// The next event; none comes after [`DriverEvent::Ended`]. Cancelling loses nothing.
    pub(crate) async fn recv(&mut self) -> (Seconds, DriverEvent) {
        match self.events.recv().await {
            Some(dated) => dated,
            None => std::future::pending().await,
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.events.close();
        drop(self.stop.take());
        let Some(thread) = self.thread.take() else { return };
        let begin = Instant::now();
        while !thread.is_finished() && begin.elapsed().as_secs_f64() < PATIENCE_S {
            std::thread::sleep(Duration::from_millis(5));
        }
        if thread.is_finished() {
            drop(thread.join());
        }
    }
}

/// An MJPEG stream in a task of its own.
#[derive(Debug)]
pub(crate) struct Stream {
    events: mpsc::Receiver<(Seconds, DriverEvent)>,
    task: tokio::task::JoinHandle<()>,
}

impl Stream {
    pub(crate) fn spawn(node: &Node, mut driver: Mjpeg) -> Self {
        let clock = node.clock();
        let (sender, events) = mpsc::channel(WAITING);
        let task = tokio::spawn(async move {
            loop {
                let event = driver.next().await;
                // A full queue holds the server back: its frames wait in the connection, not here.
                if sender.send((clock.now(), event)).await.is_err() {
                    return;
                }
            }
        });
        Self { events, task }
    }

    /// The next event. Cancelling loses nothing.
    pub(crate) async fn recv(&mut self) -> (Seconds, DriverEvent) {
        match self.events.recv().await {
            Some(dated) => dated,
            None => std::future::pending().await,
        }
    }
}

impl Drop for Stream {
    fn drop(&mut self) {
        self.task.abort();
    }
}
