//! A node's end of a serial line.

use super::reader::{PortEvent, SerialReader};
use crate::error::RuntimeError;
use crate::node::Node;
use models::params::SerialParams;
use models::units::Seconds;
use tokio::sync::mpsc;

/// Events of a serial line, dated on the node's clock when they were complete.
#[derive(Debug)]
pub struct SerialLine {
    // Dropped before the reader: its thread may wait for room.
    events: mpsc::Receiver<(Seconds, PortEvent)>,
    reader: SerialReader,
}

impl SerialLine {
    /// The next event; connections and losses are logged. Cancelling loses nothing.
    ///
    /// # Errors
    /// [`RuntimeError::System`] where the reader's thread has ended.
    pub async fn recv(&mut self) -> Result<(Seconds, PortEvent), RuntimeError> {
        let Some((stamp, event)) = self.events.recv().await else {
            let source = std::io::Error::other("its thread is gone");
            return Err(RuntimeError::System { what: "the serial reader has ended", source });
        };
        match &event {
            PortEvent::Connected => tracing::info!("serial line connected"),
            PortEvent::Lost { reason, retry } => {
                tracing::warn!("serial line lost: {reason}; next try in {} s", retry.as_secs_f64());
            }
            PortEvent::Line(_) | PortEvent::Overlong => {}
        }
        Ok((stamp, event))
    }

    /// Sends a line, its end added; false where too many wait. What waits when the device is lost is never sent.
    #[must_use]
    pub fn send(&self, line: &str) -> bool {
        self.reader.send(line)
    }
}

impl Node {
    /// Opens a serial line whose lines have at most `longest` bytes. `waiting` of them may wait for the shell; what
    /// finds no room is counted as `serial_dropped`. Connections and losses are never dropped.
    ///
    /// # Errors
    /// [`RuntimeError::System`] if no thread can be started; a device that is not there is a [`PortEvent::Lost`].
    pub fn serial_line(
        &self,
        params: &SerialParams,
        longest: usize,
        waiting: usize,
    ) -> Result<SerialLine, RuntimeError> {
        let (clock, diagnostics) = (self.clock(), self.diagnostics());
        let (sender, events) = mpsc::channel(waiting);
        let sink = move |event| {
            let dated = (clock.now(), event);
            match dated.1 {
                PortEvent::Line(_) | PortEvent::Overlong => {
                    if sender.try_send(dated).is_err() {
                        diagnostics.count("serial_dropped");
                    }
                }
                // Fails where the node is gone: the reader ends then.
                PortEvent::Connected | PortEvent::Lost { .. } => drop(sender.blocking_send(dated)),
            }
        };
        SerialReader::spawn(params.clone(), longest, sink)
            .map(|reader| SerialLine { events, reader })
            .map_err(|source| RuntimeError::System { what: "cannot start the serial reader", source })
    }
}
