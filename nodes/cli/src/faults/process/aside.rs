//! A participant of its own in a thread of its own: what observes must not wait for what it disturbs.

use anyhow::Context;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

/// The running thread; it is told to stop where this value ends.
pub(super) struct Aside<T> {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<anyhow::Result<T>>>,
}

impl<T: Send + 'static> Aside<T> {
    /// Starts the work, which looks now and then whether it has to stop.
    pub(super) fn start(work: impl FnOnce(&AtomicBool) -> anyhow::Result<T> + Send + 'static) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let told = Arc::clone(&stop);
        Self { stop, thread: Some(std::thread::spawn(move || work(&told))) }
    }

    /// Tells it to stop.
    pub(super) fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Whether it has stopped.
    pub(super) fn is_finished(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// What it found; waits for its end.
    pub(super) fn result(mut self) -> anyhow::Result<T> {
        let thread = self.thread.take().context("ended before")?;
        thread.join().ok().context("the thread ended early")?
    }
}

impl<T> Drop for Aside<T> {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}
